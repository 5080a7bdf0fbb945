//! Tools that the program `overcoat` does, each call in a process of its own that gives up its rights first.

use super::Server;
use super::pictures::text;
use crate::serve::error::{Kind, Problem};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use overcoat_worker::companion::program;
use rmcp::model::{CallToolResult, ContentBlock};
use serde_json::{Map, Value, json};
use std::ffi::OsString;
use std::path::PathBuf;
use std::process::{Output, Stdio};
use tokio::process::Command;

/// Exit code of pictures that differ.
const DIFFER: i32 = 4;

impl Server {
    /// `compare_models`
    pub(super) async fn compare_models(
        &self,
        arguments: &Map<String, Value>,
    ) -> Result<CallToolResult, Problem> {
        let size = match arguments.get("size") {
            None => 512,
            Some(size) => size
                .as_u64()
                .filter(|size| (16..=2048).contains(size))
                .ok_or_else(|| Problem::new(Kind::Options, "size: expected 16 to 2048"))?,
        };
        let [before, after] = self.two_files(arguments, ["before", "after"])?;
        let fixed =
            ["diff", "--exit-code", "--output-format", "png", "-o", "-", "--size"].map(OsString::from);
        let size = OsString::from(size.to_string());
        let output = self.run(fixed.into_iter().chain([size, before.into(), after.into()])).await?;
        let differ = output.status.code() == Some(DIFFER);
        if !differ && !output.status.success() {
            return Err(failure(&output));
        }
        let image = ContentBlock::image(STANDARD.encode(&output.stdout), "image/png");
        let mut result =
            CallToolResult::structured(json!({ "equal": !differ, "messages": messages(&output) }));
        result.content.insert(0, image);
        Ok(result)
    }

    /// `compare_pictures`
    pub(super) async fn compare_pictures(
        &self,
        arguments: &Map<String, Value>,
    ) -> Result<CallToolResult, Problem> {
        let preset = arguments.get("preset").map_or(Ok("exact"), |_| text(arguments, "preset"))?;
        if !["exact", "gpu"].contains(&preset) {
            return Err(Problem::new(Kind::Options, "preset: expected exact or gpu"));
        }
        let files = self.two_files(arguments, ["expected", "actual"])?;
        let fixed = ["golden", "check", "--preset", preset].map(OsString::from);
        let output = self.run(fixed.into_iter().chain(files.map(OsString::from))).await?;
        let passed = output.status.success();
        if !passed && output.status.code() != Some(DIFFER) {
            return Err(failure(&output));
        }
        let table = String::from_utf8_lossy(&output.stdout).into_owned();
        let told = json!({ "passed": passed, "table": table, "messages": messages(&output) });
        Ok(CallToolResult::structured(told))
    }

    fn two_files(&self, arguments: &Map<String, Value>, names: [&str; 2]) -> Result<[PathBuf; 2], Problem> {
        let [first, second] = names.map(|name| self.root.file(text(arguments, name)?));
        Ok([first?, second?])
    }

    /// Runs the program in its sandbox for as long as a model may take.
    async fn run(&self, arguments: impl IntoIterator<Item = OsString>) -> Result<Output, Problem> {
        let program = program("overcoat");
        let mut command = Command::new(&program);
        command.arg("--sandbox").args(arguments);
        command.stdin(Stdio::null()).kill_on_drop(true).current_dir(self.root.path());
        match tokio::time::timeout(self.wall, command.output()).await {
            Ok(Ok(output)) => Ok(output),
            Ok(Err(error)) if error.kind() == std::io::ErrorKind::NotFound => Err(Problem::new(
                Kind::NoWorker,
                "this tool is done by the program overcoat, which is neither beside this one nor on the path",
            )),
            Ok(Err(error)) => Err(Problem::new(Kind::NoWorker, format!("{}: {error}", program.display()))),
            Err(_) => {
                Err(Problem::new(Kind::Timeout, format!("took longer than {} s", self.wall.as_secs_f64())))
            }
        }
    }
}

/// Lines that the program has for its user.
fn messages(output: &Output) -> Vec<String> {
    String::from_utf8_lossy(&output.stderr).lines().map(str::to_owned).collect()
}

fn failure(output: &Output) -> Problem {
    let kind = match output.status.code() {
        Some(2) => Kind::Options,
        Some(3) => Kind::Limit,
        Some(_) => Kind::Model,
        None => Kind::Worker,
    };
    let lines = messages(output);
    let last = lines.last().map_or("the program ended without a word", String::as_str);
    Problem::new(kind, last.trim_start_matches("overcoat: "))
}
