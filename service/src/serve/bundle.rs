//! Several pictures as one answer: a ZIP archive with a list of them.

use super::answer::{Wishes, respond};
use super::app::App;
use super::body::Held;
use super::cache::Picture;
use super::error::{Kind, Problem};
use super::render::{Answer, Asked, picture};
use super::several::Parts;
use super::stored::Stored;
use super::trace::Trace;
use crate::files::Files;
use crate::key::hash_of;
use axum::http::{HeaderValue, header};
use axum::response::Response;
use bytes::Bytes;
use serde_json::{Value, json};
use std::sync::Arc;

/// Bytes of all pictures of an answer together.
const LARGEST: u64 = 256 << 20;
/// The list of the pictures.
const LIST: &str = "pictures.json";

/// A model whose pictures are asked for.
pub struct Model {
    /// The name of its file.
    pub name: String,
    /// Content of the file.
    pub model: Bytes,
    /// The files that it may refer to.
    pub files: Arc<dyn Files>,
    /// Identity of the files.
    pub identity: String,
    /// Trace of the request.
    pub trace: Arc<Trace>,
    /// Its bytes, counted.
    pub held: Arc<Held>,
}

/// Finds or draws the pictures, each as if it were asked for alone and one after the other, so that no client has more workers by asking
/// for more at once.
///
/// # Errors
/// [`Problem`] of the first picture that there is not, with its name.
pub async fn answer(
    app: &Arc<App>,
    of: Model,
    parts: Parts,
    wishes: &Wishes<'_>,
) -> Result<Response, Problem> {
    // A request that is too dear for its key as a whole has nothing drawn of it.
    app.order(&of.trace, parts.price, None)?;
    let (mut archive, mut list, mut keys, mut bytes) = (Stored::default(), Vec::new(), String::new(), 0);
    let (mut warnings, mut came) = (Vec::new(), "cache");
    for part in parts.all {
        let name = part.name;
        let order = app.order(&of.trace, part.priced.price, part.priced.priority)?;
        let asked = Asked {
            name: of.name.clone(),
            model: of.model.clone(),
            files: Arc::clone(&of.files),
            identity: of.identity.clone(),
            request: part.priced.request,
            order,
            trace: Arc::clone(&of.trace),
            held: Arc::clone(&of.held),
        };
        let drawn = picture(app, asked, |_| false).await.map_err(|problem| problem.of(&name))?;
        let Answer::Picture(picture, from) = drawn else { continue };
        bytes += picture.bytes.len() as u64;
        if bytes > LARGEST || !archive.add(&name, &picture.bytes) {
            let message = format!("the pictures have more than {LARGEST} bytes together");
            return Err(Problem::new(Kind::Limit, message));
        }
        app.metrics.bundled();
        keys += &format!("{name} {}\n", picture.key);
        warnings.extend(picture.warnings.iter().map(|warning| format!("{name}: {warning}")));
        came = if from == "drawn" || came == "drawn" { "drawn" } else { from };
        list.push(told(&name, &picture, from, part.priced.price));
    }
    let list = json!({ "pictures": list }).to_string();
    let fits = archive.add(LIST, list.as_bytes());
    debug_assert!(fits, "room for the list is kept");
    let whole = Picture {
        key: hash_of(keys.as_bytes()),
        media_type: "application/zip".to_owned(),
        width: 0,
        height: 0,
        warnings,
        stages: Vec::new(),
        bytes: archive.finish().into(),
    };
    if wishes.has(&whole.key) {
        return Ok(respond(app, wishes, &Answer::Known(whole.key)));
    }
    let mut response = respond(app, wishes, &Answer::Picture(Arc::new(whole), came));
    let name = HeaderValue::from_static("attachment; filename=\"pictures.zip\"");
    response.headers_mut().insert(header::CONTENT_DISPOSITION, name);
    Ok(response)
}

fn told(name: &str, picture: &Picture, from: &str, price: u64) -> Value {
    json!({
        "name": name,
        "key": picture.key,
        "media_type": picture.media_type,
        "width": picture.width,
        "height": picture.height,
        "bytes": picture.bytes.len(),
        "price": price,
        "from": from,
        "warnings": picture.warnings,
    })
}
