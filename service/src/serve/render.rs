//! From a model to its pictures: by their keys from the cache, from equal requests that are being drawn, or from a worker, which loads the
//! model once for all of a request.

use super::app::{App, Outcome};
use super::body::Held;
use super::cache::Picture;
use super::error::{Kind, Problem};
use super::flight::{Lead, Part, Wait};
use super::gate::{Order, Place};
use super::price;
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

/// A model whose pictures are asked for.
pub struct Model {
    /// The name of its file.
    pub name: String,
    /// Content of the file.
    pub model: Bytes,
    /// The files that it may refer to.
    pub files: Arc<dyn Files>,
    /// Identity of the files, which tells them from those of another request.
    pub identity: String,
    /// Trace of the request.
    pub trace: Arc<Trace>,
    /// Its bytes, counted.
    #[expect(dead_code, reason = "kept, not looked at")]
    pub held: Arc<Held>,
}

/// A picture that is asked for.
pub struct Wanted {
    /// Options of the picture.
    pub request: PictureRequest,
    /// Turn in the queue.
    pub order: Order,
}

/// Answer to a request.
pub enum Answer {
    /// The picture, and where it came from: `drawn`, `shared` with an equal request, or the `cache`.
    Picture(Arc<Picture>, &'static str),
    /// The client has the picture of this key.
    Known(String),
}

/// A model with its hash.
struct Hashed {
    model: Model,
    hash: String,
}

/// A picture that is in no cache.
struct Piece {
    wanted: Wanted,
    /// Name of the request as far as it is known without the files that the model refers to.
    of: String,
    /// That name with the identity of the files.
    flight: String,
}

/// A picture that this request draws, for all that wait for it.
struct Led {
    piece: Arc<Piece>,
    lead: Lead<Outcome>,
}

/// Finds or draws a picture, unless the client knows the one of its key already.
///
/// # Errors
/// [`Problem`].
pub async fn picture(
    app: &Arc<App>,
    of: Model,
    wanted: Wanted,
    is_known: impl Fn(&str) -> bool,
) -> Result<Answer, Problem> {
    let answers = pictures(app, of, vec![wanted], is_known).await.map_err(|(_, problem)| problem)?;
    answers.into_iter().next().ok_or_else(undrawn)
}

/// Finds or draws pictures of one model, in their order, except for those whose keys the client knows already.
///
/// # Errors
/// [`Problem`] of one of them, with its number.
pub async fn pictures(
    app: &Arc<App>,
    of: Model,
    wanted: Vec<Wanted>,
    is_known: impl Fn(&str) -> bool,
) -> Result<Vec<Answer>, (usize, Problem)> {
    let hash = hash(&of.model).await.map_err(|problem| (0, problem))?;
    of.trace.model(&hash);
    let of = Arc::new(Hashed { model: of, hash });
    let mut answers: Vec<Option<Answer>> = Vec::with_capacity(wanted.len());
    let mut pieces = Vec::new();
    for (number, wanted) in wanted.into_iter().enumerate() {
        let piece = piece(app, &of, wanted);
        let answer = at_hand(app, &of, &piece, &is_known).await;
        let answer = answer.map_err(|problem| (number, problem))?;
        if answer.is_none() {
            pieces.push((number, Arc::new(piece)));
        }
        answers.push(answer);
    }
    let mut attempts = 0;
    while let Some((first, _)) = pieces.first() {
        attempts += 1;
        let begun = if attempts > ATTEMPTS {
            Err(Problem::new(Kind::Worker, "the work was given up several times"))
        } else {
            begin(app, &of, &pieces)
        };
        let waits = begun.map_err(|problem| (*first, problem))?;
        let mut again = Vec::new();
        for ((number, piece), (wait, shared)) in pieces.into_iter().zip(waits) {
            // Work that was given up when nobody waited is begun again.
            let Some(outcome) = wait.result().await else {
                again.push((number, piece));
                continue;
            };
            let (picture, from) = outcome.map_err(|problem| (number, problem))?;
            let answer = if is_known(&picture.key) {
                Answer::Known(picture.key.clone())
            } else {
                Answer::Picture(picture, if shared { "shared" } else { from })
            };
            answers[number] = Some(answer);
        }
        pieces = again;
    }
    Ok(answers.into_iter().flatten().collect())
}

fn piece(app: &App, of: &Hashed, wanted: Wanted) -> Piece {
    let key = app.keys.of(&of.hash, &of.model.name, &[], &wanted.request);
    // Some models look for files of their own name.
    let name = hash_of(format!("{key}/{}", of.model.name).as_bytes());
    Piece { flight: format!("{name}/{}", of.model.identity), of: name, wanted }
}

/// The answer that takes no worker, if there is one.
///
/// # Errors
/// [`Problem`] that is remembered of this work.
async fn at_hand(
    app: &App,
    of: &Hashed,
    piece: &Piece,
    is_known: &impl Fn(&str) -> bool,
) -> Result<Option<Answer>, Problem> {
    if let Some(names) = app.cache.names(&piece.of).await
        && let Some(needed) = needed(app, &of.model, &names).await
    {
        let key = app.keys.of(&of.hash, &of.model.name, &needed, &piece.wanted.request);
        if is_known(&key) {
            return Ok(Some(Answer::Known(key)));
        }
        if let Some(picture) = app.cache.picture(&key).await {
            return Ok(Some(Answer::Picture(Arc::new(picture), "cache")));
        }
    }
    match app.failures.of(&piece.flight, Instant::now()) {
        Some(problem) => {
            app.metrics.remembered();
            Err(problem)
        }
        None => Ok(None),
    }
}

/// Begins to draw those that nobody draws, as one work. Returns for each its result to come, and true if others have begun it.
///
/// # Errors
/// [`Problem`] of the queue.
fn begin(
    app: &Arc<App>,
    of: &Arc<Hashed>,
    pieces: &[(usize, Arc<Piece>)],
) -> Result<Vec<(Wait<Outcome>, bool)>, Problem> {
    let (mut waits, mut led) = (Vec::with_capacity(pieces.len()), Vec::new());
    for (_, piece) in pieces {
        waits.push(match app.flights.join(&piece.flight) {
            Part::Follow(wait) => (wait, true),
            Part::Lead(lead, wait) => {
                led.push(Led { piece: Arc::clone(piece), lead });
                (wait, false)
            }
        });
    }
    if let Some(order) = together(led.iter().map(|led| &led.piece.wanted.order)) {
        let place = app.enter(&of.model.trace, &order)?;
        // It goes on where the client goes away: others may wait, and a worker that is killed costs more.
        tokio::spawn(work(Arc::clone(app), Arc::clone(of), led, order, place));
    }
    Ok(waits)
}

/// One turn for several pictures of one client: their prices together, and the lowest of their priorities.
fn together<'a>(mut orders: impl Iterator<Item = &'a Order>) -> Option<Order> {
    let mut all = orders.next()?.clone();
    for order in orders {
        all.price = all.price.saturating_add(order.price);
        all.priority = all.priority.min(order.priority);
    }
    Some(all)
}

fn undrawn() -> Problem {
    Problem::new(Kind::Worker, "the worker has not drawn it")
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

/// Hashes of the files that a model refers to; `None` if that takes a worker to find out.
async fn needed(app: &App, of: &Model, names: &[(String, bool)]) -> Option<Vec<Needed>> {
    let mut needed = Vec::with_capacity(names.len());
    for (name, alike) in names {
        needed.push(match of.files.read(name, app.rules.limits.input_bytes, *alike).await {
            Ok(found) => Needed::found(name, *alike, &found.bytes),
            Err(Missing::TooLarge) => return None,
            Err(_) => Needed::missing(name, *alike),
        });
    }
    Some(needed)
}

async fn work(app: Arc<App>, of: Arc<Hashed>, mut led: Vec<Led>, order: Order, place: Place) {
    let trace = &of.model.trace;
    let begun = Instant::now();
    let turn = app.gate.turn(place).await;
    if turn.is_ok() {
        led.retain(|led| led.lead.is_wanted());
    }
    // Pictures that nobody waits for any more are not drawn.
    let wanted = price_of(&led);
    app.give_back(trace, order.price.saturating_sub(wanted));
    let outcomes = match turn {
        Err(problem) => {
            app.give_back(trace, wanted);
            vec![Err(problem); led.len()]
        }
        Ok(_) if led.is_empty() => return,
        Ok(turn) => {
            trace.queue(begun.elapsed());
            let queue = begun.elapsed().as_secs_f64() * 1000.0;
            app.metrics.units(wanted);
            app.metrics.stage("queue", queue);
            let begun = Instant::now();
            let mut drawn = draw(&app, &of, &led, queue).await;
            // Once: what kills workers from outside may do so for the model's sake.
            if matches!(&drawn, Err(problem) if problem.was_killed) {
                drawn = draw(&app, &of, &led, queue).await;
            }
            note(&app, &led, &drawn);
            app.give_back(trace, undrawn_price(&led, &drawn, trace.meter.pictures()));
            app.gate.note(wanted, begun.elapsed());
            app.metrics.worked(trace.meter.time());
            trace.worked();
            drop(turn);
            drawn.unwrap_or_else(|problem| vec![Err(problem); led.len()])
        }
    };
    for (led, outcome) in led.into_iter().zip(outcomes) {
        let drawn = match &outcome {
            Ok((picture, "drawn")) => Some(Arc::clone(picture)),
            _ => None,
        };
        // The cache is written before the work is no longer under way, so that nobody finds neither; those who wait do not wait
        // for that.
        let landed = led.lead.tell(outcome);
        if let Some(picture) = drawn {
            app.cache.keep(&picture).await;
        }
        drop(landed);
    }
}

/// Units of pictures together.
fn price_of<'a>(led: impl IntoIterator<Item = &'a Led>) -> u64 {
    let prices = led.into_iter().map(|led| led.piece.wanted.order.price);
    prices.fold(0, u64::saturating_add)
}

/// Units of pictures that the worker has not begun: they were in the cache, or the work failed before, after so many pictures. The one
/// that it failed in costs, and so does a model that was read for nothing.
fn undrawn_price(led: &[Led], drawn: &Result<Vec<Outcome>, Problem>, pictures: usize) -> u64 {
    let Ok(outcomes) = drawn else { return price_of(led.iter().skip(pictures.saturating_add(1))) };
    let is_cached = |outcome: &Outcome| matches!(outcome, Ok((_, "cache")));
    let all = led.iter().zip(outcomes);
    let cached = price_of(all.filter(|(_, outcome)| is_cached(outcome)).map(|(led, _)| led));
    if outcomes.iter().all(is_cached) { cached.saturating_sub(price::BASE) } else { cached }
}

/// Takes note of failures: of each picture, and of the whole work where it had one picture alone, since that of several does not say
/// which of them it came from.
fn note(app: &App, led: &[Led], drawn: &Result<Vec<Outcome>, Problem>) {
    let now = Instant::now();
    match (drawn, led) {
        (Ok(outcomes), led) => {
            for (led, outcome) in led.iter().zip(outcomes) {
                app.failures.note(&led.piece.flight, outcome.as_ref().err(), now);
            }
        }
        (Err(problem), [one]) => app.failures.note(&one.piece.flight, Some(problem), now),
        (Err(_), _) => {}
    }
}

/// Lets a worker load the model and draw what is not in the cache.
async fn draw(app: &App, of: &Hashed, led: &[Led], queue: f64) -> Result<Vec<Outcome>, Problem> {
    let Hashed { model, hash } = of;
    let pictures = led.iter().map(|led| led.piece.wanted.request.clone()).collect();
    let work = Work { name: model.name.clone(), pictures, waits: true, ..Work::default() };
    let time = app.pool.options().time.times(led.len() as u32);
    let loaded = app.pool.load_within(time, &work, &model.model, model.files.as_ref(), &model.trace.meter);
    let loaded = loaded.await?;
    let needed = loaded.needed.clone();
    let key = |led: &Led| app.keys.of(hash, &model.name, &needed, &led.piece.wanted.request);
    let (mut outcomes, mut missing) = (Vec::with_capacity(led.len()), Vec::new());
    for (number, led) in led.iter().enumerate() {
        let cached = app.cache.picture(&key(led)).await;
        if cached.is_none() {
            missing.push(number);
        }
        outcomes.push(cached.map_or_else(|| Err(undrawn()), |picture| Ok((Arc::new(picture), "cache"))));
    }
    // With nothing to draw the worker is free for others.
    let (drawn, _) = loaded.draw(&missing).await?;
    for (number, picture) in drawn {
        let (Some(led), Some(outcome)) = (led.get(number), outcomes.get_mut(number)) else { continue };
        let request = &led.piece.wanted.request;
        *outcome = picture.map_err(Problem::from).and_then(|picture| {
            let picture = told(app, request, key(led), queue, picture).ok_or_else(undrawn)?;
            app.ready.store(true, Relaxed);
            Ok((Arc::new(picture), "drawn"))
        });
    }
    let names: Vec<(String, bool)> = needed.iter().map(|file| (file.name.clone(), file.alike)).collect();
    for (led, outcome) in led.iter().zip(&outcomes) {
        if outcome.is_ok() {
            app.cache.learn(&led.piece.of, names.clone()).await;
        }
    }
    Ok(outcomes)
}

/// The file that is asked for, with its metadata.
fn told(
    app: &App,
    request: &PictureRequest,
    key: String,
    queue: f64,
    drawn: DrawnPicture,
) -> Option<Picture> {
    let DrawnPicture { files, told } = drawn;
    let stages: Vec<(String, f64)> = match &told.stages_ms {
        serde_json::Value::Object(stages) => {
            stages.iter().filter_map(|(name, time)| Some((name.clone(), time.as_f64()?))).collect()
        }
        _ => Vec::new(),
    };
    stages.iter().for_each(|(name, time)| app.metrics.stage(name, *time));
    let is_plane = !request.aovs.is_empty() && request.format != "exr";
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
