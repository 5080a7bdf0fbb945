//! `overcoat batch`: many models, their pictures and a report of each.

pub mod args;
pub mod catalogue;
pub mod items;
pub mod manifest;
pub mod parquet;
pub mod report;
mod run;
pub mod shard;
pub mod since;
pub mod watch;

use crate::common::Common;
use crate::place::{Listed, Place, is_url};
use crate::pool::{Pool, PoolOptions};
use crate::serve::rules::Rules;
use args::BatchArgs;
use catalogue::CatalogueFormat;
use futures_util::StreamExt;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use items::{Defaults, Item, Presets, is_model};
use manifest::{Manifest, is_manifest};
use overcoat_worker::converters::Registry;
use overcoat_worker::protocol::PictureRequest;
use report::Report;
use run::{Batch, Ledger, Tally};
use serde_json::json;
use shard::Shard;
use std::path::{Path, PathBuf};
use std::sync::PoisonError;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant, SystemTime};
use watch::Watch;

/// Does a batch. Returns the exit code: 0, 1 if a picture was not made (unless that is allowed). A batch whose pictures were not
/// the same when drawn again ends with 4.
///
/// # Errors
/// Exit code and one line, where the batch as a whole cannot be done.
pub async fn run(args: &BatchArgs) -> Result<u8, (u8, String)> {
    let begun = Instant::now();
    let usage = |message: String| (2, message);
    let converters = args.converters.usual().map_err(usage)?;
    let common = Common::new(&args.draw, converters).map_err(usage)?;
    let shard = match &args.shard {
        Some(text) => {
            Shard::new(text, |name| std::env::var(name).ok()).map_err(|e| (2, format!("--shard: {e}")))?
        }
        None => Shard::default(),
    };
    let to = Place::new(&args.output).map_err(usage)?;
    let presets = presets(args, &common).map_err(usage)?;
    let since = match &args.changed_since {
        Some(text) => {
            Some(since::time_of(text, SystemTime::now()).map_err(|e| usage(format!("--changed-since {e}")))?)
        }
        None => None,
    };
    let catalogue = args.catalogue.as_ref().map(|path| {
        let format = CatalogueFormat::of(path).ok_or("expected a name that ends in .parquet or .csv")?;
        Ok((path, format))
    });
    let catalogue = catalogue.transpose().map_err(|e: &str| usage(format!("--catalogue {e}")))?;
    let page = match args.status {
        Some(address) => Some(watch::listen(address).await.map_err(|message| (1, message))?),
        None => None,
    };
    let items = Source::open(args, presets, &common.converters).await.map_err(|message| (1, message))?;
    let report_path = report_path(args, &to, shard)?;
    let (report, previous) = Report::open(&report_path, args.resume).map_err(|message| (1, message))?;
    let pool = |common: &Common, other: bool| pool_options(args, common, other).map(Pool::new);
    let batch = Batch {
        pool: pool(&common, false)?,
        other: pool(&common, true)?,
        largest_input: args.draw.input.limits.limits().input_bytes,
        keys: common.keys,
        to,
        report,
        previous,
        verify: args.verify,
        since,
        watch: Arc::new(Watch::new(items.count)),
        ledger: Ledger::default(),
    };
    if let Some(listener) = page {
        if let (false, Ok(address)) = (args.draw.report.quiet, listener.local_addr()) {
            eprintln!("progress at http://{address}/");
        }
        tokio::spawn(watch::serve(listener, Arc::clone(&batch.watch), Arc::clone(&batch.ledger.tally)));
    }
    let stopped = stop_on_signals();
    let bar = progress(args, items.count);
    let failure = Mutex::new(None);
    let ended = || stopped.load(Relaxed) || failure.lock().unwrap_or_else(PoisonError::into_inner).is_some();
    let fail = |message: String| {
        let mut first = failure.lock().unwrap_or_else(PoisonError::into_inner);
        first.get_or_insert(message);
    };
    let mut items = items;
    let rows =
        futures_util::stream::poll_fn(|_| std::task::Poll::Ready(if ended() { None } else { items.next() }));
    // Two more than there are workers: their files are read meanwhile.
    rows.for_each_concurrent(args.workers() + 2, |item| async {
        let done = match item {
            Ok(item) if shard.has(&item.shown) => batch.item(&item).await,
            Ok(_) => Ok(()),
            Err(message) => Err(message),
        };
        if let Err(message) = done {
            fail(message);
        }
        batch.watch.model_done();
        bar.set_message(told(&batch.ledger.tally));
        bar.inc(1);
    })
    .await;
    bar.finish_and_clear();
    batch.pool.end_idle();
    if let Some((path, format)) = catalogue {
        let records = report::last_records(&report_path);
        records
            .and_then(|records| catalogue::write(path, format, &records))
            .map_err(|message| (1, message))?;
    }
    if let Some(message) = failure.into_inner().unwrap_or_else(PoisonError::into_inner) {
        return Err((1, message));
    }
    summary(args, &batch.ledger.tally, begun.elapsed(), stopped.load(Relaxed))
}

/// Requested pictures, one after the other.
struct Source {
    defaults: Defaults,
    rows: Rows,
    /// Number of pictures, where that is known.
    count: Option<u64>,
}

enum Rows {
    Listed(Place, std::vec::IntoIter<Listed>),
    Manifest(Manifest),
}

impl Source {
    async fn open(args: &BatchArgs, presets: Presets, converters: &Registry) -> Result<Self, String> {
        let request = PictureRequest {
            format: args.encoding.output_format.unwrap_or_default().extension().to_owned(),
            jpeg_quality: args.encoding.jpeg_quality,
            aovs: args.aov.iter().map(|aov| aov.name().to_owned()).collect(),
            report: args.sidecars,
            ..PictureRequest::default()
        };
        let defaults = Defaults { request, sizes: args.sizes.clone(), views: args.views.clone(), presets };
        let path = Path::new(&args.input);
        if args.input == "-" || (!is_url(&args.input) && is_manifest(path)) {
            let count = count_lines(path, args.input == "-")?;
            return Ok(Self { defaults, rows: Rows::Manifest(Manifest::open(path)?), count });
        }
        if let Some((folder, name)) = model_of(args, converters) {
            let rows = Rows::Listed(
                Place::new(folder)?,
                vec![Listed { name: name.to_owned(), modified: None }].into_iter(),
            );
            return Ok(Self { defaults, rows, count: Some(1) });
        }
        if !is_url(&args.input) && !path.is_dir() {
            let what = if path.exists() {
                "neither a folder nor a model nor a manifest (.jsonl, .csv)"
            } else {
                "does not exist"
            };
            return Err(format!("{}: {what}", args.input));
        }
        let place = Place::new(&args.input)?;
        let is_one =
            |Listed { name, .. }: &Listed| is_model(name) || converters.of_name(Path::new(name)).is_some();
        let names: Vec<Listed> = place.list().await?.into_iter().filter(is_one).collect();
        if names.is_empty() {
            return Err(format!("{}: no models are in it", args.input));
        }
        let count = Some(names.len() as u64);
        Ok(Self { defaults, rows: Rows::Listed(place, names.into_iter()), count })
    }

    fn next(&mut self) -> Option<Result<Item, String>> {
        match &mut self.rows {
            Rows::Listed(place, names) => Some(Ok(self.defaults.item(place, &names.next()?))),
            Rows::Manifest(manifest) => manifest.next(&self.defaults),
        }
    }
}

/// Presets of the file, those that are asked for among them.
fn presets(args: &BatchArgs, common: &Common) -> Result<Presets, String> {
    let Some(path) = &args.presets else { return Ok(Presets::default()) };
    let mut rules = Rules::new(&common.start.description, args.draw.input.limits.limits(), &args.encoding);
    rules.add_file(path).map_err(|e| format!("--presets {e}"))?;
    let picture = |name: &String| {
        let picture = rules.picture_of_preset(name).map_err(|problem| problem.message)?;
        let own_planes = args.aov.iter().map(|aov| aov.name().to_owned()).collect();
        let aovs = if picture.aovs.is_empty() { own_planes } else { picture.aovs };
        Ok::<_, String>((name.clone(), PictureRequest { aovs, report: args.sidecars, ..picture }))
    };
    let known = rules.presets.keys().map(picture).collect::<Result<_, _>>()?;
    let presets = Presets { known, chosen: Vec::new() };
    presets.choose(&args.preset.join(",")).map_err(|e| format!("--preset: {e}"))
}

/// Folder and name of a single model.
fn model_of<'a>(args: &'a BatchArgs, converters: &Registry) -> Option<(&'a str, &'a str)> {
    let path = Path::new(&args.input);
    let name = path.file_name()?.to_str()?;
    let folder = path.parent()?.to_str()?;
    let is_one =
        !is_url(&args.input) && path.is_file() && (is_model(name) || converters.of_name(path).is_some());
    is_one.then_some((if folder.is_empty() { "." } else { folder }, name))
}

/// Estimated number of rows of a manifest, for the progress bar. The end of a pipe is not known.
fn count_lines(path: &Path, is_pipe: bool) -> Result<Option<u64>, String> {
    use std::io::BufRead;
    if is_pipe || !path.is_file() {
        return Ok(None);
    }
    let about = |e: std::io::Error| format!("{}: {e}", path.display());
    let mut lines = std::io::BufReader::new(std::fs::File::open(path).map_err(about)?);
    let mut count = 0;
    loop {
        let part = lines.fill_buf().map_err(about)?;
        if part.is_empty() {
            return Ok(Some(count));
        }
        count += part.iter().filter(|byte| **byte == b'\n').count() as u64;
        let length = part.len();
        lines.consume(length);
    }
}

fn pool_options(args: &BatchArgs, common: &Common, other: bool) -> Result<PoolOptions, (u8, String)> {
    let program = std::env::current_exe().map_err(|e| (1, format!("this program's own file: {e}")))?;
    let mut start = args.limits.start(&common.start);
    // Elsewhere: a process for each picture, and as many threads as the others have not.
    if other {
        start.threads = if start.threads == 1 { 2 } else { 1 };
    }
    Ok(PoolOptions {
        program,
        start,
        workers: if other { 1 } else { args.workers() },
        spare: 0,
        time: args.limits.time(),
        works_of_one: if other { 1 } else { args.models_of_worker },
        most_output: 1 << 31,
        converters: Arc::clone(&common.converters),
    })
}

fn report_path(args: &BatchArgs, to: &Place, shard: Shard) -> Result<PathBuf, (u8, String)> {
    if let Some(path) = &args.report {
        // Several processes have one command line.
        return Ok(match path.to_str() {
            Some(text) => PathBuf::from(text.replace("{shard}", &name_of_part(shard))),
            None => path.clone(),
        });
    }
    let Place::Folder(folder) = to else {
        return Err((
            2,
            "--report FILE says where the report goes when the pictures go to a store".to_owned(),
        ));
    };
    let name = match shard.count {
        1 => "report.jsonl".to_owned(),
        _ => format!("report-{}.jsonl", name_of_part(shard)),
    };
    Ok(folder.join(name))
}

fn name_of_part(Shard { index, count }: Shard) -> String {
    format!("{index}-of-{count}")
}

/// A flag that termination signals raise: work that is begun is finished.
fn stop_on_signals() -> &'static AtomicBool {
    static STOPPED: AtomicBool = AtomicBool::new(false);
    tokio::spawn(async {
        #[cfg(unix)]
        {
            use tokio::signal::unix::{SignalKind, signal};
            let (Ok(mut interrupt), Ok(mut terminate)) =
                (signal(SignalKind::interrupt()), signal(SignalKind::terminate()))
            else {
                return;
            };
            tokio::select! { _ = interrupt.recv() => {}, _ = terminate.recv() => {} }
        }
        #[cfg(not(unix))]
        if tokio::signal::ctrl_c().await.is_err() {
            return;
        }
        STOPPED.store(true, Relaxed);
    });
    &STOPPED
}

fn progress(args: &BatchArgs, count: Option<u64>) -> ProgressBar {
    let quiet = args.draw.report.quiet;
    let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
    let bar = ProgressBar::with_draw_target(count, target);
    let template = match count {
        Some(_) => "{bar:30} {pos}/{len} models, {per_sec}, {eta} left {msg}",
        None => "{spinner} {pos} models, {per_sec} {msg}",
    };
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style);
    }
    bar
}

fn told(tally: &Tally) -> String {
    match tally.failed.load(Relaxed) {
        0 => String::new(),
        failed => format!("({failed} failed)"),
    }
}

fn summary(args: &BatchArgs, tally: &Tally, time: Duration, stopped: bool) -> Result<u8, (u8, String)> {
    let of = |count: &std::sync::atomic::AtomicU64| count.load(Relaxed);
    let (drawn, copied, kept) = (of(&tally.drawn), of(&tally.copied), of(&tally.kept));
    let unchanged = of(&tally.unchanged);
    let (failed, verified, differ, warned) =
        (of(&tally.failed), of(&tally.verified), of(&tally.differ), of(&tally.warned));
    if args.draw.report.json {
        let summary = json!({
            "drawn": drawn, "copied": copied, "kept": kept, "unchanged": unchanged, "failed": failed, "warned": warned,
            "verified": verified, "differ": differ, "stopped": stopped, "seconds": time.as_secs_f64(),
        });
        println!("{summary:#}");
    } else if !args.draw.report.quiet {
        let mut parts = vec![format!("{drawn} drawn")];
        for (count, what) in [
            (copied, "copied from their like"),
            (kept, "kept"),
            (unchanged, "of models that have not changed"),
            (verified, "drawn twice"),
            (warned, "with warnings"),
            (failed, "failed"),
        ] {
            if count > 0 {
                parts.push(format!("{count} {what}"));
            }
        }
        eprintln!("{} in {:.1} s", parts.join(", "), time.as_secs_f64());
    }
    match (differ, failed, stopped) {
        (1.., _, _) => Err((4, format!("{differ} pictures were not the same when drawn again"))),
        (_, _, true) => Err((1, "stopped before the end; --resume goes on from there".to_owned())),
        (_, 1.., _) if !args.allow_failures || of(&tally.of_surroundings) > 0 => Ok(1),
        _ => Ok(0),
    }
}
