//! `overcoat mcp`: tools for programs that speak the Model Context Protocol (revision 2025-06-18 and later), over standard streams.
//!
//! Files are read below one folder, models are parsed in workers without rights, and errors have a kind, one line and what helps.

pub mod args;
mod pictures;
mod program;
mod root;
mod tools;

use crate::common::Common;
use crate::pool::{Pool, PoolOptions};
use crate::serve::error::{Kind, Problem};
use crate::serve::rules::Rules;
use args::McpArgs;
use overcoat::load::BuiltinMaterial;
use rmcp::handler::server::ServerHandler;
use rmcp::model::{
    CallToolRequestParams, CallToolResponse, CallToolResult, ContentBlock, Implementation, ListToolsResult,
    PaginatedRequestParams, ServerCapabilities, ServerConfig, Tool,
};
use rmcp::service::{RequestContext, RoleServer, ServiceExt};
use rmcp::transport::stdio;
use root::Root;
use serde_json::{Map, Value};
use std::sync::Arc;
use std::time::Duration;

/// One page for programs that use the tools.
const GUIDE: &str = include_str!("guide.md");

/// State of all calls.
struct Server {
    root: Root,
    may_write: bool,
    tools: Vec<Tool>,
    pool: Pool,
    rules: Rules,
    /// Time of the wall for one call of the program.
    wall: Duration,
}

/// Serves the client at the other end of the standard streams until it closes them. Returns the exit code.
///
/// # Errors
/// Exit code and one line.
pub async fn run(args: &McpArgs) -> Result<u8, (u8, String)> {
    let server = Server::new(args).map_err(|message| (2, message))?;
    let failed = |message: String| (1, message);
    let running =
        server.serve(stdio()).await.map_err(|e| failed(format!("the client's first message: {e}")))?;
    running.waiting().await.map_err(|e| failed(e.to_string()))?;
    Ok(0)
}

impl Server {
    fn new(args: &McpArgs) -> Result<Self, String> {
        let common = Common::new(&args.draw, args.converters.named()?)?;
        let limits = args.draw.input.limits.limits();
        let rules = Rules::new(&common.start.description, limits, &args.encoding);
        let program = std::env::current_exe().map_err(|e| format!("this program's own file: {e}"))?;
        let (start, time) = (args.limits.start(&common.start), args.limits.time());
        let pool = Pool::new(PoolOptions {
            program,
            start,
            workers: args.workers,
            spare: 0,
            time,
            works_of_one: 100,
            most_output: 1 << 28,
            converters: Arc::clone(&common.converters),
        });
        let (root, tools) = (Root::new(&args.root)?, tools::all());
        Ok(Self { root, may_write: args.write, tools, pool, rules, wall: time.wall })
    }

    async fn call(&self, name: &str, arguments: &Map<String, Value>) -> Result<CallToolResult, Problem> {
        let Some(tool) = self.tools.iter().find(|tool| tool.name == name) else {
            return Err(Problem::new(Kind::Options, format!("there is no tool '{name}'")));
        };
        let names = tool.input_schema.get("properties").and_then(Value::as_object);
        if let Some(unknown) =
            arguments.keys().find(|key| names.is_none_or(|names| !names.contains_key(*key)))
        {
            return Err(Problem::new(Kind::Options, format!("{name} has no argument '{unknown}'")));
        }
        match name {
            "render" => self.render(arguments).await,
            "views" => self.views(arguments).await,
            "diagnose" => self.diagnose(arguments).await,
            "info" => self.info(arguments).await,
            "compare_models" => self.compare_models(arguments).await,
            "compare_pictures" => self.compare_pictures(arguments).await,
            _ => materials(arguments),
        }
    }
}

/// `materials`
fn materials(arguments: &Map<String, Value>) -> Result<CallToolResult, Problem> {
    let text = match arguments.get("name") {
        None => BuiltinMaterial::all().iter().map(|material| format!("{}\n", material.name)).collect(),
        Some(_) => {
            let name = pictures::text(arguments, "name")?;
            let material = BuiltinMaterial::named(name);
            let none = || Problem::new(Kind::Options, format!("name: there is no material '{name}'"));
            material.ok_or_else(none)?.text.to_owned()
        }
    };
    Ok(CallToolResult::success(vec![ContentBlock::text(text)]))
}

impl ServerHandler for Server {
    fn get_info(&self) -> ServerConfig {
        let tools = ServerCapabilities::builder().enable_tools().build();
        let own = Implementation::new("overcoat", env!("CARGO_PKG_VERSION"));
        ServerConfig::new(tools).with_server_info(own).with_instructions(GUIDE)
    }

    async fn list_tools(
        &self,
        _: Option<PaginatedRequestParams>,
        _: RequestContext<RoleServer>,
    ) -> Result<ListToolsResult, rmcp::ErrorData> {
        Ok(ListToolsResult::with_all_items(self.tools.clone()))
    }

    async fn call_tool(
        &self,
        request: CallToolRequestParams,
        _: RequestContext<RoleServer>,
    ) -> Result<CallToolResponse, rmcp::ErrorData> {
        let arguments = request.arguments.unwrap_or_default();
        let done = self.call(&request.name, &arguments).await;
        Ok(done
            .unwrap_or_else(|problem| CallToolResult::structured_error(problem.json()["error"].take()))
            .into())
    }
}
