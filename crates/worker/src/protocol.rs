//! Protocol between a worker and its parent, over the worker's standard streams.
//!
//! A message is a header in JSON and bytes that follow it: 4 bytes with the length of the header, 8 with that of the rest (both
//! little-endian), then both. A worker's parent parses nothing but headers, which are bounded.

use crate::failure::Failure;
use crate::model_facts::ModelFacts;
use crate::turning::Turn;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use std::collections::BTreeMap;
use std::io::{self, Read, Write};
use std::path::PathBuf;

/// Bytes of a header at most.
pub const LARGEST_HEADER: usize = 1 << 20;
/// Bytes of the two lengths before a message.
pub const PREFIX: usize = 12;

/// From the parent.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum ToWorker {
    /// Settings of all work; the first message.
    Start(Box<Start>),
    /// A model to draw: its bytes follow.
    Work(Work),
    /// A model to tell of: its bytes follow.
    Inspect {
        /// The name of the model's file, as in [`Work`].
        name: String,
        /// Converter that has made the model of another file.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        converter: Option<String>,
        /// Warnings of that converter.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        warnings: Vec<String>,
    },
    /// File that [`FromWorker::Need`] asked for: its bytes follow.
    File {
        /// Its name as it can be shown, where it is another than what was asked for.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        found: Option<String>,
    },
    /// It is not to be had.
    Missing(Missing),
    /// After [`FromWorker::Loaded`]: draw the pictures of these numbers.
    Draw {
        /// In the order in which they are drawn.
        pictures: Vec<usize>,
    },
}

/// Settings of all work of a worker.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Start {
    /// A scene file as JSON, whose paths are absolute: what pictures have in common, without a model.
    pub description: Value,
    /// A material variant of models.
    #[serde(default)]
    pub variant: Option<String>,
    /// Limits that are not the default ones.
    #[serde(default)]
    pub limits: Vec<(String, u64)>,
    /// Bytes of memory that the worker may take for data; it ends where it needs more.
    #[serde(default)]
    pub memory: Option<u64>,
    /// Threads that render.
    pub threads: u16,
    /// Give up every right first.
    pub sandbox: bool,
    /// Pictures may show nothing.
    #[serde(default)]
    pub allow_empty: bool,
    /// Files of environments by the names that pictures may ask for them by, beside that of the description.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub environments: BTreeMap<String, PathBuf>,
}

/// One model and its pictures.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Work {
    /// The name of the model's file: its extension says what the content does not.
    pub name: String,
    /// Pictures to draw, as long as one load serves for the scenes of all.
    pub pictures: Vec<PictureRequest>,
    /// Converter that has made the model of another file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub converter: Option<String>,
    /// Warnings of that converter.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
    /// Tell counts, size and colours of the model with each picture.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub facts: bool,
    /// True if the worker waits for [`ToWorker::Draw`] when it has loaded the model. Else it draws all.
    pub waits: bool,
}

/// One picture.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct PictureRequest {
    /// Keys of a scene file that are laid over those of [`Start::description`].
    pub keys: Map<String, Value>,
    /// Extension of the file: png, webp, jpg, exr, hdr; of a moving picture png, webp, gif.
    pub format: String,
    /// 1 to 100.
    #[serde(default)]
    pub jpeg_quality: Option<u8>,
    /// Planes of the G-buffer, by name: layers of an .exr, files beside others.
    #[serde(default)]
    pub aovs: Vec<String>,
    /// Tell all that `overcoat render --json` tells.
    #[serde(default)]
    pub report: bool,
    /// A moving picture of the model once around.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub turntable: Option<Turntable>,
    /// Tell what `overcoat diagnose --json` tells as the report of a picture without files.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub diagnose: bool,
}

/// A moving picture of a model once around.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Turntable {
    /// Frames of the turn, at least 1.
    pub frames: u32,
    /// Frames a second.
    pub fps: f64,
    /// Choice of what turns.
    #[serde(default)]
    pub turn: Turn,
}

/// Why a file is not to be had.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "why", rename_all = "snake_case")]
pub enum Missing {
    /// It is larger than was asked for.
    TooLarge,
    /// It lies outside of what the model may read.
    Outside,
    /// Models may not refer to files here.
    NotAllowed,
    /// There is none, or it cannot be read.
    Unreadable {
        /// Message of the operating system.
        reason: String,
    },
}

/// From the worker.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum FromWorker {
    /// After [`ToWorker::Start`].
    Ready,
    /// The model refers to a file.
    Need {
        /// A path relative to the model.
        name: String,
        /// Bytes at most.
        limit: u64,
        /// A file is meant whose name differs in the case of letters, or in what is not UTF-8.
        alike: bool,
    },
    /// The model of [`Work::waits`] is loaded.
    Loaded,
    /// After [`ToWorker::Inspect`]: what `overcoat info --json` tells of the model follows.
    Contents,
    /// A file of a picture: its bytes follow. That of the picture itself comes after those of its planes.
    File {
        /// Number of the picture.
        picture: usize,
        /// Name of the plane; none of the picture itself.
        plane: Option<String>,
        /// Media type.
        media_type: String,
    },
    /// A picture is whole.
    Picture {
        /// Its number.
        picture: usize,
        /// Report on the picture.
        told: Box<Told>,
    },
    /// A picture cannot be made.
    PictureFailed {
        /// Its number.
        picture: usize,
        /// Why.
        failure: FailureReport,
    },
    /// The work is done, as far as it went.
    Done,
    /// Nothing can be made of the model.
    Failed {
        /// Why.
        failure: FailureReport,
    },
}

/// Report on a picture.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Told {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Warnings about the picture.
    pub warnings: Vec<String>,
    /// Milliseconds by stage.
    pub stages_ms: Value,
    /// Facts of the model, if they were asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub facts: Option<ModelFacts>,
    /// Largest memory of the worker so far.
    pub peak_rss_bytes: Option<u64>,
    /// Report as `overcoat render --json` prints it, if it was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub report: Option<Value>,
}

/// Why something was not done.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FailureReport {
    /// Class of the failure.
    pub class: FailureClass,
    /// One line.
    pub message: String,
    /// The limit that was passed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limit: Option<String>,
}

/// Kinds of failures, as the exit codes of the program have them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FailureClass {
    /// The file is wrong: exit code 1.
    Failed,
    /// The request makes no sense: exit code 2.
    Usage,
    /// It would cost more than is allowed: exit code 3.
    Limit,
}

impl From<&Failure> for FailureReport {
    fn from(failure: &Failure) -> Self {
        let class = match failure.exit_code() {
            2 => FailureClass::Usage,
            3 => FailureClass::Limit,
            _ => FailureClass::Failed,
        };
        Self { class, message: failure.to_string(), limit: failure.limit_name().map(str::to_owned) }
    }
}

/// The bytes of a message up to those that follow its header, of which there are `following`.
#[must_use]
pub fn head_of_message(header: &impl Serialize, following: usize) -> Vec<u8> {
    // Maps whose keys are strings always become JSON.
    let header = serde_json::to_vec(header).unwrap_or_default();
    let mut message = Vec::with_capacity(PREFIX + header.len());
    message.extend((header.len() as u32).to_le_bytes());
    message.extend((following as u64).to_le_bytes());
    message.extend(header);
    message
}

/// The lengths of header and rest, if both are within bounds.
#[must_use]
pub fn lengths(prefix: [u8; PREFIX], most: u64) -> Option<(usize, usize)> {
    let [a, b, c, d, rest @ ..] = prefix;
    let header = u32::from_le_bytes([a, b, c, d]) as usize;
    let following = u64::from_le_bytes(rest);
    let fits = header <= LARGEST_HEADER && following <= most;
    fits.then_some((header, usize::try_from(following).ok()?))
}

/// Writes a message.
///
/// # Errors
/// Those of the stream.
pub fn send(out: &mut impl Write, header: &impl Serialize, following: &[u8]) -> io::Result<()> {
    out.write_all(&head_of_message(header, following.len()))?;
    out.write_all(following)?;
    out.flush()
}

/// Reads a message and what follows it; `None` at the end of the stream.
///
/// # Errors
/// Those of the stream, and [`io::ErrorKind::InvalidData`] of what is no message.
pub fn receive<T: DeserializeOwned>(from: &mut impl Read) -> io::Result<Option<(T, Vec<u8>)>> {
    let mut prefix = [0; PREFIX];
    match from.read_exact(&mut prefix) {
        Err(e) if e.kind() == io::ErrorKind::UnexpectedEof => return Ok(None),
        done => done?,
    }
    let invalid = || io::Error::from(io::ErrorKind::InvalidData);
    let (header, following) = lengths(prefix, u64::MAX).ok_or_else(invalid)?;
    let mut bytes = vec![0; header];
    from.read_exact(&mut bytes)?;
    let message = serde_json::from_slice(&bytes).map_err(|_| invalid())?;
    let mut rest = Vec::new();
    rest.try_reserve_exact(following).map_err(|_| io::Error::from(io::ErrorKind::OutOfMemory))?;
    from.take(following as u64).read_to_end(&mut rest)?;
    if rest.len() == following { Ok(Some((message, rest))) } else { Err(invalid()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_come_back_as_they_were() {
        let mut stream = Vec::new();
        let work = Work {
            name: "a.glb".to_owned(),
            pictures: vec![PictureRequest::default()],
            waits: true,
            ..Work::default()
        };
        send(&mut stream, &ToWorker::Work(work), b"glTF").unwrap();
        send(&mut stream, &ToWorker::Draw { pictures: vec![0] }, &[]).unwrap();
        send(&mut stream, &ToWorker::Missing(Missing::Unreadable { reason: "x".to_owned() }), &[]).unwrap();
        let mut from = &stream[..];
        let (first, bytes) = receive::<ToWorker>(&mut from).unwrap().unwrap();
        assert!(matches!(first, ToWorker::Work(Work { waits: true, pictures, .. }) if pictures.len() == 1));
        assert_eq!(bytes, b"glTF");
        let second = receive::<ToWorker>(&mut from).unwrap().unwrap();
        assert!(matches!(second, (ToWorker::Draw { pictures }, rest) if pictures == [0] && rest.is_empty()));
        let (third, _) = receive::<ToWorker>(&mut from).unwrap().unwrap();
        assert!(matches!(third, ToWorker::Missing(Missing::Unreadable { .. })));
        assert!(receive::<ToWorker>(&mut from).unwrap().is_none());
    }

    #[test]
    fn what_is_no_message_is_an_error() {
        let mut stream = Vec::new();
        send(&mut stream, &FromWorker::Done, b"rest").unwrap();
        for cut in [PREFIX, PREFIX + 3, stream.len() - 1] {
            assert!(receive::<FromWorker>(&mut &stream[..cut]).is_err(), "{cut}");
        }
        assert!(receive::<ToWorker>(&mut &stream[..]).is_err());
        let mut prefix = [0; PREFIX];
        prefix[3] = 1;
        assert_eq!(lengths(prefix, 10), None);
        prefix[3] = 0;
        prefix[4] = 11;
        assert_eq!(lengths(prefix, 10), None);
        assert_eq!(lengths(prefix, 11), Some((0, 11)));
        // A length that no memory has is an error before memory is touched.
        prefix[11] = 0x7f;
        assert!(receive::<FromWorker>(&mut &prefix[..]).is_err());
    }
}
