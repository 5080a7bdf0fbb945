//! Requests for descriptions of models: `/info`.

use super::app::App;
use super::body::Held;
use super::error::{Kind, Problem};
use super::gate::Order;
use super::handlers::{of_query, open, receive, settle, signed};
use super::price;
use super::render::hash;
use super::rules::PRICE;
use super::source::Source;
use super::trace::Trace;
use super::upload::Upload;
use crate::files::Files;
use axum::Extension;
use axum::extract::{Request, State};
use axum::http::{HeaderValue, header};
use axum::response::{IntoResponse, Response};
use bytes::Bytes;
use std::sync::Arc;
use std::time::Instant;

/// A model that is asked about.
struct Inspected {
    /// The name of its file.
    name: String,
    /// Content of the file.
    model: Bytes,
    /// The files that it may refer to.
    files: Arc<dyn Files>,
    /// Identity of the files, which tells them from those of another request.
    identity: String,
    /// Turn in the queue.
    order: Order,
    /// Trace of the request.
    trace: Arc<Trace>,
    /// Bytes of the model, counted.
    #[expect(dead_code, reason = "kept, not looked at")]
    held: Held,
}

/// `POST /info`
///
/// # Errors
/// [`Problem`].
pub async fn of_body(
    State(app): State<Arc<App>>,
    Extension(trace): Extension<Arc<Trace>>,
    request: Request,
) -> Result<Response, Problem> {
    let (parts, body) = request.into_parts();
    let options = match of_query(&app, &parts.uri) {
        Ok(options) => options,
        Err(problem) => {
            app.bodies.turn_away(body, &parts.headers).await;
            return Err(problem);
        }
    };
    let mut upload = receive(&app, body, &parts.headers).await?;
    settle(&app, &trace, &mut upload, &options)?;
    let identity = upload.identity();
    let files = Arc::new(std::mem::take(&mut upload.files));
    let Upload { name, model, held, .. } = upload;
    let order = app.order(&trace, price::BASE, None)?;
    let asked = Inspected { name, model, files, identity, order, trace, held };
    inspect(&app, asked).await
}

/// `GET /info/{signature}/plain/{source}`
///
/// # Errors
/// [`Problem`].
pub async fn of_path(
    State(app): State<Arc<App>>,
    Extension(trace): Extension<Arc<Trace>>,
    request: Request,
) -> Result<Response, Problem> {
    let asked = signed(&app, request.uri(), "/info")?;
    let (Source { name, model, files }, held) = open(&app, &trace, &asked.source).await?;
    let order = app.order(&trace, price::BASE, None)?;
    inspect(&app, Inspected { name, model, files, identity: asked.source, order, trace, held }).await
}

/// Lets a worker describe a model, unless that has failed a short while ago.
async fn inspect(app: &Arc<App>, asked: Inspected) -> Result<Response, Problem> {
    let hash = hash(&asked.model).await?;
    asked.trace.model(&hash);
    asked.trace.price(asked.order.price);
    // No name of other work begins so. Without files beside it the name of a model says its format alone.
    let work = format!("info {hash}/{}/{}", asked.name, asked.identity);
    if let Some(problem) = app.failures.of(&work, Instant::now()) {
        app.metrics.remembered();
        return Err(problem);
    }
    let place = app.enter(&asked.trace, &asked.order)?;
    let app = Arc::clone(app);
    // A worker finishes its work, as for pictures.
    let contents = tokio::spawn(async move {
        let begun = Instant::now();
        let turn = app.gate.turn(place).await;
        let turn = turn.inspect_err(|_| app.give_back(&asked.trace, asked.order.price))?;
        app.metrics.units(asked.order.price);
        asked.trace.queue(begun.elapsed());
        app.metrics.stage("queue", begun.elapsed().as_secs_f64() * 1000.0);
        let mut contents = describe(&app, &asked).await;
        // Once, as for pictures.
        if matches!(&contents, Err(problem) if problem.was_killed) {
            contents = describe(&app, &asked).await;
        }
        app.failures.note(&work, contents.as_ref().err(), Instant::now());
        app.metrics.worked(asked.trace.meter.time());
        asked.trace.worked();
        drop(turn);
        contents
    });
    let contents = contents.await.map_err(|e| Problem::new(Kind::Worker, e.to_string()))??;
    let json = HeaderValue::from_static("application/json");
    Ok(([(header::CONTENT_TYPE, json), (PRICE, price::BASE.into())], contents).into_response())
}

async fn describe(app: &App, asked: &Inspected) -> Result<Vec<u8>, Problem> {
    Ok(app.pool.inspect(&asked.name, &asked.model, asked.files.as_ref(), &asked.trace.meter).await?)
}
