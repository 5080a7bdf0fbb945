//! Tools that draw: a model's pictures by workers without rights.

use super::Server;
use super::tools::VIEWS;
use crate::files::FolderFiles;
use crate::pool::{DrawnPicture, Meter};
use crate::serve::error::{Kind, Problem};
use crate::serve::options::Options;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use overcoat::output::OutputFormat;
use overcoat_worker::protocol::{PictureRequest, Work};
use rmcp::model::{CallToolResult, ContentBlock};
use serde_json::{Map, Value, json};
use std::path::Path;

/// Pictures of one call, at most.
const MOST_VIEWS: usize = 16;

/// An argument that is a text.
///
/// # Errors
/// [`Kind::Options`] if it is not there, or no text.
pub fn text<'a>(arguments: &'a Map<String, Value>, name: &str) -> Result<&'a str, Problem> {
    let value = arguments.get(name).and_then(Value::as_str);
    value.ok_or_else(|| Problem::new(Kind::Options, format!("{name}: expected a text")))
}

impl Server {
    /// `render`
    pub(super) async fn render(&self, arguments: &Map<String, Value>) -> Result<CallToolResult, Problem> {
        let save = arguments.get("save").map(|_| text(arguments, "save")).transpose()?;
        if save.is_some() && !self.may_write {
            return Err(Problem::new(Kind::NotOffered, "save: the server was started without --write"));
        }
        let request = self.request(arguments.get("options"), None)?;
        let model = text(arguments, "model")?;
        let mut drawn = self.draw(model, vec![request]).await?;
        let mut picture = drawn.pop().ok_or_else(|| Problem::new(Kind::Worker, "no picture came"))?;
        let mut report = picture.told.report.take().unwrap_or_default();
        let file = picture.files.pop().ok_or_else(|| Problem::new(Kind::Worker, "no picture came"))?;
        if let Some(name) = save {
            let path = self.root.save(name, &file.bytes)?;
            report["saved"] = json!(path.display().to_string());
        }
        let image = ContentBlock::image(STANDARD.encode(&file.bytes), file.media_type);
        let mut result = CallToolResult::structured(report);
        result.content.insert(0, image);
        Ok(result)
    }

    /// `views`
    pub(super) async fn views(&self, arguments: &Map<String, Value>) -> Result<CallToolResult, Problem> {
        let wrong = || Problem::new(Kind::Options, format!("views: expected 1 to {MOST_VIEWS} texts"));
        let views: Vec<&str> = match arguments.get("views") {
            None => VIEWS.to_vec(),
            Some(Value::Array(views)) if (1..=MOST_VIEWS).contains(&views.len()) => {
                views.iter().map(|view| view.as_str().ok_or_else(wrong)).collect::<Result<_, _>>()?
            }
            Some(_) => return Err(wrong()),
        };
        let request = |view: &&str| self.request(arguments.get("options"), Some(view));
        let requests = views.iter().map(request).collect::<Result<Vec<_>, _>>()?;
        let drawn = self.draw(text(arguments, "model")?, requests).await?;
        let mut content = Vec::new();
        for (view, picture) in views.iter().zip(drawn) {
            let warnings = picture.told.warnings.iter().map(|warning| format!("\nwarning: {warning}"));
            content.push(ContentBlock::text(format!("{view}:{}", warnings.collect::<String>())));
            let files = picture.files.into_iter().next_back();
            content
                .extend(files.map(|file| ContentBlock::image(STANDARD.encode(&file.bytes), file.media_type)));
        }
        Ok(CallToolResult::success(content))
    }

    /// `diagnose`
    pub(super) async fn diagnose(&self, arguments: &Map<String, Value>) -> Result<CallToolResult, Problem> {
        let request = self.request(arguments.get("options"), None)?;
        let request = PictureRequest { diagnose: true, ..request };
        let mut drawn = self.draw(text(arguments, "model")?, vec![request]).await?;
        let told = drawn.pop().and_then(|picture| picture.told.report);
        told.map(CallToolResult::structured).ok_or_else(|| Problem::new(Kind::Worker, "no diagnosis came"))
    }

    /// `info`
    pub(super) async fn info(&self, arguments: &Map<String, Value>) -> Result<CallToolResult, Problem> {
        let (name, bytes, files) = self.model(text(arguments, "model")?).await?;
        let told = self.pool.inspect(&name, &bytes, &files, &Meter::default()).await?;
        let contents = serde_json::from_slice(&told);
        contents.map(CallToolResult::structured).map_err(|e| Problem::new(Kind::Worker, e.to_string()))
    }

    /// The picture that options ask for, in the words of requests to the service.
    fn request(&self, options: Option<&Value>, view: Option<&str>) -> Result<PictureRequest, Problem> {
        let mut asked = Options::default();
        match options {
            None => {}
            Some(Value::Object(options)) => {
                for (key, value) in options {
                    asked.set(key, &plain(value), &self.rules)?;
                }
            }
            Some(_) => return Err(Problem::new(Kind::Options, "options: expected an object")),
        }
        if let Some(view) = view {
            asked.set("view", view, &self.rules)?;
        }
        let format = asked.format.unwrap_or(self.rules.format);
        if ![OutputFormat::Png, OutputFormat::WebP, OutputFormat::Jpeg].contains(&format) {
            return Err(Problem::new(Kind::Options, "format: expected png, webp or jpg"));
        }
        let priced = asked.priced(format, &self.rules)?;
        Ok(PictureRequest { report: view.is_none(), ..priced.request })
    }

    /// The pictures of a model; an error if one of them cannot be made.
    async fn draw(&self, model: &str, pictures: Vec<PictureRequest>) -> Result<Vec<DrawnPicture>, Problem> {
        let (name, bytes, files) = self.model(model).await?;
        let numbers: Vec<usize> = (0..pictures.len()).collect();
        let work = Work { name, pictures, waits: true, ..Work::default() };
        let meter = Meter::default();
        let loaded = self.pool.load(&work, &bytes, &files, &meter).await?;
        let (mut drawn, _) = loaded.draw(&numbers).await?;
        drawn.sort_by_key(|(number, _)| *number);
        drawn.into_iter().map(|(_, picture)| picture.map_err(Problem::from)).collect()
    }

    /// A model below the root: its name, its bytes, and the files beside it.
    async fn model(&self, name: &str) -> Result<(String, Vec<u8>, FolderFiles), Problem> {
        let path = self.root.file(name)?;
        let bytes = self.read(&path).await?;
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        Ok((name, bytes, FolderFiles::of_model(&path)))
    }

    async fn read(&self, path: &Path) -> Result<Vec<u8>, Problem> {
        let most = self.rules.limits.input_bytes;
        let about = |reason: String| Problem::new(Kind::NotFound, format!("{}: {reason}", path.display()));
        let size = tokio::fs::metadata(path).await.map_err(|e| about(e.to_string()))?.len();
        if size > most {
            let problem =
                Problem::new(Kind::TooLarge, format!("{}: {size} bytes exceed {most}", path.display()));
            return Err(problem.limited("input_bytes", "start the server with --limit input_bytes=N"));
        }
        tokio::fs::read(path).await.map_err(|e| about(e.to_string()))
    }
}

/// A value as the text of a query: numbers of a list with commas, what has parts in JSON.
fn plain(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Array(items) if items.iter().all(|item| item.is_number() || item.is_string()) => {
            items.iter().map(plain).collect::<Vec<_>>().join(",")
        }
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_told_as_queries_have_them() {
        for (value, text) in [
            (json!("front"), "front"),
            (json!(256), "256"),
            (json!(true), "true"),
            (json!([1, -2.5, 0]), "1,-2.5,0"),
            (json!([{"kind": "point"}]), r#"[{"kind":"point"}]"#),
        ] {
            assert_eq!(plain(&value), text);
        }
    }
}
