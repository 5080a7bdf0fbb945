//! From a model to its picture: by its key from the cache, from an equal request that is being drawn, or from a
//! worker.

use super::app::{App, Outcome};
use super::body::Held;
use super::cache::Picture;
use super::error::{Kind, Problem};
use super::flight::{Lead, Part};
use super::gate::{Order, Place};
use super::trace::Trace;
use crate::files::{Files, Needed};
use crate::key::hash_of;
use crate::pool::DrawnPicture;
use bytes::Bytes;
use overcoat_worker::protocol::{Missing, PictureRequest, Work};
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;
use std::time::Instant;

/// Bytes that are hashed at once on a thread that has connections to serve.
const HASHED_AT_ONCE: usize = 4 << 20;

/// Number of attempts at work that other requests have given up.
const ATTEMPTS: u32 = 5;

/// A picture that is asked for.
pub struct Asked {
    /// The name of the model's file.
    pub name: String,
    /// Content of the model's file.
    pub model: Bytes,
    /// The files that it may refer to.
    pub files: Arc<dyn Files>,
    /// Identity of the files, which tells them from those of another request.
    pub identity: String,
    /// Options of the picture.
    pub request: PictureRequest,
    /// Turn in the queue.
    pub order: Order,
    /// Trace of the request.
    pub trace: Arc<Trace>,
    /// Its bytes, counted.
    #[expect(dead_code, reason = "kept, not looked at")]
    pub held: Arc<Held>,
}

/// Answer to a request.
pub enum Answer {
    /// The picture, and where it came from: `drawn`, `shared` with an equal request, or the `cache`.
    Picture(Arc<Picture>, &'static str),
    /// The client has the picture of this key.
    Known(String),
}

/// Finds or draws a picture, unless the client knows the one of its key already.
///
/// # Errors
/// [`Problem`].
pub async fn picture(
    app: &Arc<App>,
    asked: Asked,
    is_known: impl Fn(&str) -> bool,
) -> Result<Answer, Problem> {
    let hash = hash(&asked.model).await?;
    asked.trace.model(&hash);
    let of = name_of(app, &asked, &hash);
    if let Some(names) = app.cache.names(&of).await
        && let Some(needed) = needed(app, &asked, &names).await
    {
        let key = app.keys.of(&hash, &asked.name, &needed, &asked.request);
        if is_known(&key) {
            return Ok(Answer::Known(key));
        }
        if let Some(picture) = app.cache.picture(&key).await {
            return Ok(Answer::Picture(Arc::new(picture), "cache"));
        }
    }
    let flight = format!("{of}/{}", asked.identity);
    if let Some(problem) = app.failures.of(&flight, Instant::now()) {
        app.metrics.remembered();
        return Err(problem);
    }
    let asked = Arc::new(asked);
    let mut attempts = 0;
    let (outcome, shared) = loop {
        attempts += 1;
        if attempts > ATTEMPTS {
            return Err(Problem::new(Kind::Worker, "the work was given up several times"));
        }
        let (wait, shared) = match app.flights.join(&flight) {
            Part::Follow(wait) => (wait, true),
            Part::Lead(lead, wait) => {
                let place = app.enter(&asked.trace, &asked.order)?;
                let names = Names { hash: hash.clone(), of: of.clone(), flight: flight.clone() };
                let work = work(Arc::clone(app), Arc::clone(&asked), names, lead, place);
                // It goes on where the client goes away: others may wait, and a worker that is killed costs more.
                tokio::spawn(work);
                (wait, false)
            }
        };
        // Work that was given up when nobody waited is begun again.
        if let Some(outcome) = wait.result().await {
            break (outcome, shared);
        }
    };
    let (picture, from) = outcome?;
    if is_known(&picture.key) {
        return Ok(Answer::Known(picture.key.clone()));
    }
    Ok(Answer::Picture(picture, if shared { "shared" } else { from }))
}

/// BLAKE3 of a model.
///
/// # Errors
/// [`Kind::Worker`] if the thread that hashes ends.
pub(super) async fn hash(model: &Bytes) -> Result<String, Problem> {
    if model.len() <= HASHED_AT_ONCE {
        return Ok(hash_of(model));
    }
    let model = model.clone();
    let hashed = tokio::task::spawn_blocking(move || hash_of(&model)).await;
    hashed.map_err(|e| Problem::new(Kind::Worker, e.to_string()))
}

/// Name of the request as far as it is known without the files that the model refers to.
fn name_of(app: &App, asked: &Asked, hash: &str) -> String {
    let key = app.keys.of(hash, &asked.name, &[], &asked.request);
    // Some models look for files of their own name.
    hash_of(format!("{key}/{}", asked.name).as_bytes())
}

/// Hashes of the files that a model refers to; `None` if that takes a worker to find out.
async fn needed(app: &App, asked: &Asked, names: &[(String, bool)]) -> Option<Vec<Needed>> {
    let mut needed = Vec::with_capacity(names.len());
    for (name, alike) in names {
        needed.push(match asked.files.read(name, app.rules.limits.input_bytes, *alike).await {
            Ok(found) => Needed::found(name, *alike, &found.bytes),
            Err(Missing::TooLarge) => return None,
            Err(_) => Needed::missing(name, *alike),
        });
    }
    Some(needed)
}

/// Names of a piece of work.
struct Names {
    /// Hash of the model.
    hash: String,
    /// Name of the request as far as it is known without the files that the model refers to.
    of: String,
    /// Content key with the identity of the files.
    flight: String,
}

async fn work(app: Arc<App>, asked: Arc<Asked>, names: Names, lead: Lead<Outcome>, place: Place) {
    let begun = Instant::now();
    let outcome = match app.gate.turn(place).await {
        Err(problem) => {
            app.give_back(&asked.trace, &asked.order);
            Err(problem)
        }
        Ok(_) if !lead.is_wanted() => return app.give_back(&asked.trace, &asked.order),
        Ok(turn) => {
            asked.trace.queue(begun.elapsed());
            let queue = begun.elapsed().as_secs_f64() * 1000.0;
            app.metrics.units(asked.order.price);
            app.metrics.stage("queue", queue);
            let begun = Instant::now();
            let mut outcome = draw(&app, &asked, &names, queue).await;
            // Once: what kills workers from outside may do so for the model's sake.
            if matches!(&outcome, Err(problem) if problem.was_killed) {
                outcome = draw(&app, &asked, &names, queue).await;
            }
            app.failures.note(&names.flight, outcome.as_ref().err(), Instant::now());
            app.gate.note(begun.elapsed());
            app.metrics.worked(asked.trace.meter.time());
            asked.trace.worked();
            drop(turn);
            outcome
        }
    };
    let drawn = match &outcome {
        Ok((picture, "drawn")) => Some(Arc::clone(picture)),
        _ => None,
    };
    // The cache is written before the work is no longer under way, so that nobody finds neither; those who wait do not wait
    // for that.
    let landed = lead.tell(outcome);
    if let Some(picture) = drawn {
        app.cache.keep(&picture).await;
    }
    drop(landed);
}

/// Lets a worker draw.
async fn draw(app: &App, asked: &Asked, Names { hash, of, .. }: &Names, queue: f64) -> Outcome {
    let work = Work {
        name: asked.name.clone(),
        pictures: vec![asked.request.clone()],
        waits: true,
        ..Work::default()
    };
    let loaded = app.pool.load(&work, &asked.model, asked.files.as_ref(), &asked.trace.meter).await?;
    let needed = loaded.needed.clone();
    let key = app.keys.of(hash, &asked.name, &needed, &asked.request);
    let names = needed.into_iter().map(|file| (file.name, file.alike)).collect();
    if let Some(picture) = app.cache.picture(&key).await {
        // With nothing to draw the worker is free for others.
        loaded.draw(&[]).await?;
        app.cache.learn(of, names).await;
        return Ok((Arc::new(picture), "cache"));
    }
    let (drawn, _) = loaded.draw(&[0]).await?;
    let nothing = || Problem::new(Kind::Worker, "the worker has not drawn it");
    let (_, picture) = drawn.into_iter().next().ok_or_else(nothing)?;
    let picture = told(app, asked, key, queue, picture?).ok_or_else(nothing)?;
    app.cache.learn(of, names).await;
    app.ready.store(true, Relaxed);
    Ok((Arc::new(picture), "drawn"))
}

/// The file that is asked for, with its metadata.
fn told(app: &App, asked: &Asked, key: String, queue: f64, drawn: DrawnPicture) -> Option<Picture> {
    let DrawnPicture { files, told } = drawn;
    let stages: Vec<(String, f64)> = match &told.stages_ms {
        serde_json::Value::Object(stages) => {
            stages.iter().filter_map(|(name, time)| Some((name.clone(), time.as_f64()?))).collect()
        }
        _ => Vec::new(),
    };
    stages.iter().for_each(|(name, time)| app.metrics.stage(name, *time));
    let is_plane = !asked.request.aovs.is_empty() && asked.request.format != "exr";
    let mut files = files.into_iter();
    let file = if is_plane { files.find(|file| file.plane.is_some()) } else { files.next_back() }?;
    Some(Picture {
        key,
        media_type: file.media_type,
        width: told.width,
        height: told.height,
        warnings: told.warnings,
        stages: [("queue".to_owned(), queue)].into_iter().chain(stages).collect(),
        bytes: file.bytes.into(),
    })
}
