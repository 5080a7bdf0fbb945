//! Requests for pictures.

use super::accept;
use super::answer::{Wishes, respond};
use super::app::App;
use super::body::Held;
use super::bundle;
use super::error::{Kind, Problem};
use super::media;
use super::options::{Options, Priced, of_pairs};
use super::path;
use super::pipeline as operations;
use super::render::{Model, Wanted, picture};
use super::source::Source;
use super::trace::Trace;
use super::upload::Upload;
use axum::Extension;
use axum::body::Body;
use axum::extract::{Request, State};
use axum::http::{HeaderMap, Uri, header};
use axum::response::Response;
use overcoat::output::OutputFormat;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};
use url::form_urlencoded;

/// `POST /render`
///
/// # Errors
/// [`Problem`].
pub async fn render(
    State(app): State<Arc<App>>,
    Extension(trace): Extension<Arc<Trace>>,
    request: Request,
) -> Result<Response, Problem> {
    let options = of_query(&app, request.uri());
    answer_body(&app, trace, request, options).await
}

/// `POST /pipeline?operations=[...]`, as Imaginary has it.
///
/// # Errors
/// [`Problem`].
pub async fn pipeline(
    State(app): State<Arc<App>>,
    Extension(trace): Extension<Arc<Trace>>,
    request: Request,
) -> Result<Response, Problem> {
    let options = operations::read(request.uri().query().unwrap_or_default(), &app.rules);
    let mut response = answer_body(&app, trace, request, options).await?;
    operations::tell_size(response.headers_mut());
    Ok(response)
}

/// Options of a query.
pub(super) fn of_query(app: &App, uri: &Uri) -> Result<Options, Problem> {
    of_pairs(form_urlencoded::parse(uri.query().unwrap_or_default().as_bytes()), &app.rules)
}

/// The picture of a model that comes as a body.
async fn answer_body(
    app: &Arc<App>,
    trace: Arc<Trace>,
    request: Request,
    options: Result<Options, Problem>,
) -> Result<Response, Problem> {
    let (parts, body) = request.into_parts();
    // Errors in the options are told before the model is read.
    let checked = options.and_then(|options| checked(app, &trace, options, &parts.headers));
    let mut options = match checked {
        Ok(options) => options,
        Err(problem) => {
            app.bodies.turn_away(body, &parts.headers).await;
            return Err(problem);
        }
    };
    let mut upload = receive(app, body, &parts.headers).await?;
    for (key, text) in &upload.fields {
        options.set(key, text, &app.rules)?;
    }
    let mut wishes = Wishes {
        method: &parts.method,
        headers: &parts.headers,
        negotiated: false,
        price: 0,
        seconds: None,
        needs_key: app.needs_key(true),
    };
    if !options.several.is_empty() {
        settle(app, &trace, &mut upload, &options)?;
        return several(app, model_of(upload, trace), &options, wishes).await;
    }
    let (format, negotiated) = format(app, &options, &parts.headers)?;
    let Priced { request, price, priority } = options.priced(format, &app.rules)?;
    (wishes.negotiated, wishes.price) = (negotiated, price);
    trace.options(&options, &request, price);
    settle(app, &trace, &mut upload, &options)?;
    let wanted = Wanted { request, order: app.order(&trace, price, priority)? };
    let answer = picture(app, model_of(upload, trace), wanted, |key| wishes.has(key)).await?;
    Ok(respond(app, &wishes, &answer))
}

fn model_of(upload: Upload, trace: Arc<Trace>) -> Model {
    let identity = upload.identity();
    let (name, model, held) = (upload.name, upload.model, Arc::new(upload.held));
    Model { name, model, files: Arc::new(upload.files), identity, trace, held }
}

/// Options with which a picture, or several, can be drawn, as far as that is known without the model.
pub(super) fn checked(
    app: &App,
    trace: &Trace,
    options: Options,
    headers: &HeaderMap,
) -> Result<Options, Problem> {
    let (price, priority) = if options.several.is_empty() {
        let (format, _) = format(app, &options, headers)?;
        let priced = options.priced(format, &app.rules)?;
        (priced.price, priced.priority)
    } else {
        (options.several.parts(&options, &app.rules, app.args.max_pictures)?.price, None)
    };
    app.order(trace, price, priority).map(|_| options)
}

/// The pictures of the lists of a request.
async fn several(
    app: &Arc<App>,
    of: Model,
    options: &Options,
    mut wishes: Wishes<'_>,
) -> Result<Response, Problem> {
    let parts = options.several.parts(options, &app.rules, app.args.max_pictures)?;
    wishes.price = parts.price;
    of.trace.pictures(parts.all.len());
    if let Some(first) = parts.all.first() {
        of.trace.options(options, &first.priced.request, parts.price);
    }
    bundle::answer(app, of, parts, &wishes).await
}

/// Model of a body.
pub(super) async fn receive(app: &App, body: Body, headers: &HeaderMap) -> Result<Upload, Problem> {
    let (bytes, held) = app.bodies.read(body, headers).await?;
    Upload::new(headers, bytes, held).await
}

/// Checks that a body is a model, and settles the name of its file.
pub(super) fn settle(
    app: &App,
    trace: &Trace,
    upload: &mut Upload,
    options: &Options,
) -> Result<(), Problem> {
    let told = options.name.as_deref();
    trace.upload(told.unwrap_or(&upload.name));
    media::check(&upload.model, told.unwrap_or(&upload.name), upload.media_type.as_deref(), &app.converters)?;
    upload.settle_name(told, &app.converters);
    Ok(())
}

/// The format of the picture, and whether `Accept` chose it.
fn format(app: &App, options: &Options, headers: &HeaderMap) -> Result<(OutputFormat, bool), Problem> {
    match options.format {
        Some(format) => Ok((format, false)),
        None if options.has_format() => Ok((app.rules.format, false)),
        None => {
            let accept = headers.get(header::ACCEPT).and_then(|value| value.to_str().ok());
            Ok((accept::format(accept, app.rules.format)?, true))
        }
    }
}

/// `GET /{signature}/{options}/plain/{source}@{format}`
///
/// # Errors
/// [`Problem`].
pub async fn path(
    State(app): State<Arc<App>>,
    Extension(trace): Extension<Arc<Trace>>,
    request: Request,
) -> Result<Response, Problem> {
    let (parts, _) = request.into_parts();
    let asked = signed(&app, &parts.uri, "")?;
    if !asked.options.several.is_empty() {
        // Errors in the options are told before the model is read.
        asked.options.several.parts(&asked.options, &app.rules, app.args.max_pictures)?;
        let (Source { name, model, files }, held) = open(&app, &trace, &asked.source).await?;
        let wishes = Wishes {
            method: &parts.method,
            headers: &parts.headers,
            negotiated: false,
            price: 0,
            seconds: asked.expires.map(|end| end.saturating_sub(app.seconds())),
            needs_key: app.needs_key(false),
        };
        let (identity, held) = (asked.source, Arc::new(held));
        let of = Model { name, model, files, identity, trace, held };
        return several(&app, of, &asked.options, wishes).await;
    }
    let (format, negotiated) = format(&app, &asked.options, &parts.headers)?;
    let Priced { request, price, priority } = asked.options.priced(format, &app.rules)?;
    trace.options(&asked.options, &request, price);
    let (Source { name, model, files }, held) = open(&app, &trace, &asked.source).await?;
    let seconds = asked.expires.map(|end| end.saturating_sub(app.seconds()));
    let wishes = Wishes {
        method: &parts.method,
        headers: &parts.headers,
        negotiated,
        price,
        seconds,
        needs_key: app.needs_key(false),
    };
    let wanted = Wanted { request, order: app.order(&trace, price, priority)? };
    let (identity, held) = (asked.source, Arc::new(held));
    let of = Model { name, model, files, identity, trace, held };
    let answer = picture(&app, of, wanted, |key| wishes.has(key)).await?;
    Ok(respond(&app, &wishes, &answer))
}

/// Request of a path, if it is signed; `before` stands before the signature.
pub(super) fn signed(app: &App, uri: &Uri, before: &str) -> Result<path::Asked, Problem> {
    let whole = uri.path_and_query().map_or("", |path| path.as_str());
    let whole = whole.strip_prefix(before).unwrap_or(whole);
    let none = || Problem::new(Kind::NotFound, "there is nothing at this path");
    let (signature, signed) = path::signed_part(whole).ok_or_else(none)?;
    // A text that cannot be a path needs no signature to be told so.
    if !path::has_source(signed) {
        return Err(none());
    }
    app.signer.check(signature, signed)?;
    let asked = path::read(signed, &app.rules)?;
    match asked.expires {
        Some(end) if app.seconds() >= end => {
            Err(Problem::new(Kind::Expired, "the time of this path is over"))
        }
        _ => Ok(asked),
    }
}

/// Opens a source, unless it has failed a short while ago.
pub(super) async fn open(app: &App, trace: &Trace, source: &str) -> Result<(Source, Held), Problem> {
    trace.source(source);
    // No name of other work begins so.
    let name = format!("source {source}");
    if let Some(problem) = app.failures.of(&name, Instant::now()) {
        app.metrics.remembered();
        return Err(problem);
    }
    let opened = read(app, source).await;
    app.failures.note(&name, opened.as_ref().err(), Instant::now());
    if let Ok((source, _)) = &opened {
        trace.fetched(source.model.len());
    }
    opened
}

async fn read(app: &App, source: &str) -> Result<(Source, Held), Problem> {
    let patience = Duration::from_secs_f64(app.args.source_seconds);
    let open = async {
        let held = app.bodies.hold_largest().await;
        Ok::<_, Problem>((app.sources.open(source).await?, held))
    };
    let opened = tokio::time::timeout(patience, open).await;
    let (mut source, mut held) = opened.map_err(|_| {
        Problem::new(Kind::SourceTimeout, format!("the source took longer than {} s", patience.as_secs_f64()))
            .limited("source_seconds", "start the service with --source-seconds SECONDS")
    })??;
    media::check(&source.model, &source.name, None, &app.converters)?;
    let extension = media::extension(&source.name);
    // Only OBJ looks for files of its own name; a name that says no more than it must is the same for equal models.
    if !extension.starts_with("obj") {
        let known = overcoat::load::Format::from_extension(extension.split('.').next().unwrap_or_default());
        let is_converted = app.converters.of_name(Path::new(&source.name)).is_some();
        let says_something = known.is_some() || is_converted;
        source.name = if says_something { format!("model.{extension}") } else { "model".to_owned() };
    }
    held.shrink(source.model.len() as u64);
    Ok((source, held))
}
