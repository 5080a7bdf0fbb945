//! Several pictures as one answer: a ZIP archive with a list of them.

use super::answer::{Wishes, respond};
use super::app::App;
use super::cache::Picture;
use super::error::{Kind, Problem};
use super::options::Priced;
use super::render::{Answer, Model, Wanted, pictures};
use super::several::{Part, Parts};
use super::stored::Stored;
use crate::key::hash_of;
use axum::http::{HeaderValue, header};
use axum::response::Response;
use serde_json::{Value, json};
use std::sync::Arc;

/// Bytes of all pictures of an answer together.
const LARGEST: u64 = 256 << 20;
/// The list of the pictures.
const LIST: &str = "pictures.json";

/// Finds or draws the pictures, each with the bytes and the key that it has alone; one worker draws all that there is to draw, so that no
/// client has more workers by asking for more at once.
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
    let (mut told_of, mut wanted) = (Vec::new(), Vec::new());
    for Part { name, priced: Priced { request, price, priority } } in parts.all {
        wanted.push(Wanted { request, order: app.order(&of.trace, price, priority)? });
        told_of.push((name, price));
    }
    let name_of = |number: usize| told_of.get(number).map_or("", |(name, _)| name);
    let drawn = pictures(app, of, wanted, |_| false).await;
    let drawn = drawn.map_err(|(number, problem)| problem.of(name_of(number)))?;
    for ((name, price), drawn) in told_of.iter().zip(drawn) {
        let Answer::Picture(picture, from) = drawn else { continue };
        bytes += picture.bytes.len() as u64;
        if bytes > LARGEST || !archive.add(name, &picture.bytes) {
            let message = format!("the pictures have more than {LARGEST} bytes together");
            return Err(Problem::new(Kind::Limit, message));
        }
        app.metrics.bundled();
        keys += &format!("{name} {}\n", picture.key);
        warnings.extend(picture.warnings.iter().map(|warning| format!("{name}: {warning}")));
        came = if from == "drawn" || came == "drawn" { "drawn" } else { from };
        list.push(told(name, &picture, from, *price));
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
