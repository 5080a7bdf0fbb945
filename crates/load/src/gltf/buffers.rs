//! Access to binary data: buffers, buffer views and URIs.

use super::FORMAT;
use super::list::Index;
use super::meshopt;
use super::model::{BufferView, Compressed, Root};
use super::source::Source;
use crate::budget::Budget;
use crate::nearby::Nearby;
use crate::text::{percent_decode, percent_decode_bytes, quoted};
use crate::warnings::Warnings;
use crate::{Context, LoadError};
use base64::Engine;
use base64::engine::DecodePaddingMode;
use base64::engine::general_purpose::{GeneralPurpose, GeneralPurposeConfig};
use overcoat_core::formats::LEFT_OUT;
use overcoat_core::jobs::Jobs;
use std::collections::BTreeMap;
use std::fmt;

/// Longest URI of a file, in bytes.
const LONGEST_PATH: usize = 4096;
/// Most messages about bytes that are not there.
const MOST_SHORT: usize = 20;

/// The buffers that something needs, each read once.
pub(super) struct Buffers<'a> {
    root: &'a Root,
    binary: Option<Source<'a>>,
    loaded: Vec<Loaded<'a>>,
    /// Runs of the binary chunk that have been read from the file, with their first bytes' places, in order.
    held: Vec<(u64, Vec<u8>)>,
    /// Compressed views that something needs.
    compressed: BTreeMap<Index, Decompressed>,
    /// Compressed views that have not been decompressed so far.
    pending: Vec<Index>,
    /// Warnings about buffers that are shorter than they say, and about views that reach beyond their buffer.
    short: Vec<String>,
    nearby: Nearby,
    /// Warnings about files that were found at another place than the document names.
    pub(super) notes: Vec<String>,
}

/// A view that is stored compressed.
struct Decompressed {
    layout: meshopt::Layout,
    /// Empty until [`Buffers::decompress`].
    bytes: Vec<u8>,
    /// Reason why there are none after that.
    damage: Option<String>,
}

enum Loaded<'a> {
    /// Not needed so far.
    Not,
    Own(Vec<u8>),
    Binary(Source<'a>),
}

impl<'a> Buffers<'a> {
    /// `binary` is the binary chunk of a GLB file: the first buffer if that has no URI.
    pub(super) fn new(root: &'a Root, binary: Option<Source<'a>>) -> Self {
        Self {
            root,
            binary,
            loaded: root.buffers.iter().map(|_| Loaded::Not).collect(),
            held: Vec::new(),
            compressed: BTreeMap::new(),
            pending: Vec::new(),
            short: Vec::new(),
            nearby: Nearby::default(),
            notes: Vec::new(),
        }
    }

    /// Reads the buffer behind a view, unless that has been done. What a compressed view holds is there only after
    /// [`Buffers::decompress`]; its memory is charged here.
    ///
    /// # Errors
    /// [`LoadError`] naming the view or the buffer.
    pub(super) fn require(
        &mut self,
        view: Index,
        context: &Context<'_>,
        budget: &mut Budget,
    ) -> Result<(), LoadError> {
        let Some(given) = self.compression(view) else {
            let (given, index) = self.plain(view)?;
            self.require_buffer(index, context, budget)?;
            let (start, length) = (given.byte_offset.0, given.byte_length.0);
            let there = self.source(index).len();
            let declared = self.root.buffers.get(index).map_or(0, |buffer| buffer.byte_length.0);
            // A short buffer has been warned of already, and a view that begins behind the buffer is an error.
            if start.saturating_add(length) > there
                && start <= there
                && declared <= there
                && self.short.len() < MOST_SHORT
            {
                let message = format!("bufferView {view} reaches beyond the {there} bytes of buffer {index}");
                if !self.short.contains(&message) {
                    self.short.push(message);
                }
            }
            return Ok(());
        };
        if self.compressed.contains_key(&view) {
            return Ok(());
        }
        let fail = |message: &dyn fmt::Display| malformed(format!("bufferView {view}: {message}"));
        let layout = meshopt::Layout::new(given.mode, given.filter, given.count.0, given.byte_stride.0)
            .map_err(|message| fail(&message))?;
        let plain = self.root.buffer_views.at(view.get())?;
        let (stride, compressed) = (plain.byte_stride.map_or(0, |stride| stride.0), given.byte_stride.0);
        if given.mode == meshopt::Mode::Attributes && stride != 0 && stride != compressed {
            let message = format!("its byteStride is {stride}, that of its compressed data {compressed}");
            return Err(fail(&message));
        }
        let length = plain.byte_length.0;
        if length > layout.decoded() {
            return Err(fail(&format_args!("its {length} bytes are more than its compressed data holds")));
        }
        if given.byte_length.0 > layout.longest() {
            return Err(fail(&"its compressed data is longer than its elements can be"));
        }
        let index = self.compressed_buffer(view, given)?;
        self.require_buffer(index, context, budget)?;
        self.compressed_source(view, given)?;
        budget.charge(|| format!("bufferView {view}"), layout.decoded(), 1)?;
        self.compressed.insert(view, Decompressed { layout, bytes: Vec::new(), damage: None });
        self.pending.push(view);
        Ok(())
    }

    /// Compression of a view, if it has any. The uncompressed fallback of such a view is never read.
    fn compression(&self, view: Index) -> Option<&'a Compressed> {
        let extensions = self.root.buffer_views.get(view.get())?.extensions.as_deref()?;
        extensions.khr_meshopt.as_ref().or(extensions.ext_meshopt.as_ref())
    }

    /// Bytes from one element of a compressed view of attributes to the next.
    pub(super) fn compressed_stride(&self, view: Index) -> Option<u64> {
        self.compression(view).filter(|c| c.mode == meshopt::Mode::Attributes).map(|c| c.byte_stride.0)
    }

    fn compressed_buffer(&self, view: Index, given: &Compressed) -> Result<usize, LoadError> {
        let found = given.buffer.filter(|buffer| buffer.get() < self.root.buffers.len());
        found.map(Index::get).ok_or_else(|| {
            malformed(format!("bufferView {view}: there is no such buffer with its compressed data"))
        })
    }

    /// The compressed bytes of a view.
    fn compressed_source(&self, view: Index, given: &Compressed) -> Result<Source<'_>, LoadError> {
        let buffer = self.compressed_buffer(view, given)?;
        let (start, length) = (given.byte_offset.0, given.byte_length.0);
        let bytes = self.source(buffer);
        bytes.slice(start, length).ok_or_else(|| {
            malformed(format!(
                "bufferView {view}: {length} compressed bytes from offset {start} lie outside buffer {buffer} of {} \
                 bytes",
                bytes.len()
            ))
        })
    }

    /// Decompresses all views that have been required since the last time. Of one that is damaged [`Buffers::view`] says so.
    ///
    /// # Errors
    /// [`LoadError::Limit`].
    pub(super) fn decompress(&mut self, jobs: &Jobs) -> Result<(), LoadError> {
        let pending = std::mem::take(&mut self.pending);
        let decode = |view: Index| -> Result<Vec<u8>, LoadError> {
            let (Some(given), Some(known)) = (self.compression(view), self.compressed.get(&view)) else {
                return Ok(Vec::new());
            };
            if cfg!(not(feature = "compression")) {
                let message = format!("its data are compressed with meshopt: {LEFT_OUT}");
                return Err(malformed(format!("bufferView {view}: {message}")));
            }
            let stream = self.compressed_source(view, given)?.bytes()?;
            let decoded = known.layout.decode(&stream);
            decoded.map_err(|message| malformed(format!("bufferView {view}: {message}")))
        };
        let results = jobs.map_each(&pending, |view| decode(*view));
        for (view, bytes) in pending.into_iter().zip(results) {
            let Some(known) = self.compressed.get_mut(&view) else { continue };
            match bytes {
                Err(error) if error.is_partial() => known.damage = Some(error.reason()),
                result => known.bytes = result?,
            }
        }
        Ok(())
    }

    /// A warning for each buffer and view that has fewer bytes than it says.
    pub(super) fn warn_of_short(&mut self, warnings: &mut Warnings) {
        for message in std::mem::take(&mut self.short) {
            warnings.add(|| message);
        }
    }

    fn require_buffer(
        &mut self,
        index: usize,
        context: &Context<'_>,
        budget: &mut Budget,
    ) -> Result<(), LoadError> {
        let buffer = self.root.buffers.at(index)?;
        let Some(loaded @ &mut Loaded::Not) = self.loaded.get_mut(index) else { return Ok(()) };
        let length = buffer.byte_length.0;
        let bytes = match &buffer.uri {
            Some(uri) => {
                let what = format!("buffer {index}");
                Loaded::Own(read_uri(uri, &what, context, budget, (&mut self.nearby, &mut self.notes))?)
            }
            None => match self.binary {
                Some(binary) if index == 0 => Loaded::Binary(binary),
                _ => return Err(malformed(format!("buffer {index} has neither a URI nor a binary chunk"))),
            },
        };
        // The missing bytes may be padding; if not, the data in them is not drawn.
        let found = bytes.source().len();
        if found < length {
            self.short.push(format!("buffer {index} has {found} bytes where its byteLength says {length}"));
        }
        *loaded = bytes;
        Ok(())
    }

    /// Reads views of the binary chunk into memory, each byte of it once at most; what is not a view of it is passed
    /// over. For bytes that are looked at more than once, as those of images are.
    ///
    /// # Errors
    /// [`LoadError::Io`].
    pub(super) fn hold(&mut self, views: impl Iterator<Item = Index>) -> Result<(), LoadError> {
        let Some(binary @ Source::File(_)) = self.binary else { return Ok(()) };
        let mut runs = Vec::new();
        for view in views {
            let own = self.root.buffers.first().is_some_and(|buffer| buffer.uri.is_none());
            let Ok((found, 0)) = self.plain(view) else { continue };
            if !own || self.compression(view).is_some() {
                continue;
            }
            let (start, length) = (found.byte_offset.0, found.byte_length.0);
            if length > 0 && binary.slice(start, length).is_some() {
                runs.extend(start.checked_add(length).map(|end| (start, end)));
            }
        }
        runs.sort_unstable();
        let mut merged: Vec<(u64, u64)> = Vec::new();
        for (start, end) in runs {
            match merged.last_mut() {
                Some(last) if start < last.1 => last.1 = last.1.max(end),
                _ => merged.push((start, end)),
            }
        }
        for (start, end) in merged {
            if let Some(run) = end.checked_sub(start).and_then(|length| binary.slice(start, length)) {
                self.held.push((start, run.bytes()?.into_owned()));
            }
        }
        Ok(())
    }

    /// The bytes of a view whose buffer has been required, and which has been decompressed if it needs it.
    ///
    /// # Errors
    /// [`LoadError::Malformed`] if the view lies outside its buffer.
    pub(super) fn view(&self, index: Index) -> Result<Source<'_>, LoadError> {
        if let Some(known) = self.compressed.get(&index) {
            if let Some(damage) = &known.damage {
                return Err(malformed(damage.clone()));
            }
            let length = self.root.buffer_views.at(index.get())?.byte_length.0;
            let bytes = Source::Memory(&known.bytes).slice(0, length);
            return bytes.ok_or_else(|| malformed(format!("bufferView {index} has not been decompressed")));
        }
        let (view, buffer) = self.plain(index)?;
        let bytes = self.source(buffer);
        let (start, length) = (view.byte_offset.0, view.byte_length.0);
        // A view that reaches beyond its buffer may still have all that is asked of it.
        let there = bytes.len().checked_sub(start).map(|rest| rest.min(length));
        let Some(found) = there.and_then(|length| bytes.slice(start, length)) else {
            return Err(malformed(format!(
                "bufferView {index}: {length} bytes from offset {start} lie outside buffer {buffer} of {} bytes",
                bytes.len()
            )));
        };
        let length = found.len();
        match found {
            Source::File(_) => Ok(self.held(start, length).unwrap_or(found)),
            Source::Memory(_) => Ok(found),
        }
    }

    /// The bytes of a view: out of what was read for it alone, if it was; it is read again if something else asks for them.
    ///
    /// # Errors
    /// As [`Buffers::view`], or [`LoadError::Io`].
    pub(super) fn take(&mut self, index: Index) -> Result<Vec<u8>, LoadError> {
        let is_of_binary = self.root.buffers.first().is_some_and(|first| first.uri.is_none());
        if is_of_binary
            && !self.compressed.contains_key(&index)
            && let Ok((view, 0)) = self.plain(index)
        {
            let (start, length) = (view.byte_offset.0, view.byte_length.0);
            let is_own = |(first, bytes): &(u64, Vec<u8>)| *first == start && bytes.len() as u64 == length;
            if let Some(place) = self.held.iter().position(is_own) {
                return Ok(self.held.remove(place).1);
            }
        }
        Ok(self.view(index)?.bytes()?.into_owned())
    }

    /// A part of the binary chunk that has been read already.
    fn held(&self, start: u64, length: u64) -> Option<Source<'_>> {
        let after = self.held.partition_point(|(first, _)| *first <= start);
        let (first, bytes) = self.held.get(after.checked_sub(1)?)?;
        Source::Memory(bytes).slice(start.checked_sub(*first)?, length)
    }

    /// A view that is not compressed, and the number of its buffer.
    fn plain(&self, view: Index) -> Result<(&'a BufferView, usize), LoadError> {
        let found = self.root.buffer_views.at(view.get())?;
        match found.buffer {
            Some(buffer) if buffer.get() < self.root.buffers.len() => Ok((found, buffer.get())),
            Some(buffer) => Err(malformed(format!("bufferView {view}: there is no buffer {buffer}"))),
            None => Err(malformed(format!("bufferView {view} names no buffer"))),
        }
    }

    /// The bytes of a buffer; none of one that has not been needed so far.
    fn source(&self, buffer: usize) -> Source<'_> {
        self.loaded.get(buffer).map_or(Source::Memory(&[]), Loaded::source)
    }
}

impl Loaded<'_> {
    fn source(&self) -> Source<'_> {
        match self {
            Self::Not => Source::Memory(&[]),
            Self::Own(bytes) => Source::Memory(bytes),
            Self::Binary(source) => *source,
        }
    }
}

fn malformed(message: String) -> LoadError {
    LoadError::malformed(FORMAT, message)
}

/// The bytes behind a data URI or a relative path, charged to the budget. Notes say where another file has been taken.
///
/// # Errors
/// [`LoadError`] that begins with `what`.
fn read_uri(
    uri: &str,
    what: &str,
    context: &Context<'_>,
    budget: &mut Budget,
    (nearby, notes): (&mut Nearby, &mut Vec<String>),
) -> Result<Vec<u8>, LoadError> {
    if let Some((scheme, rest)) = uri.split_at_checked(5)
        && scheme.eq_ignore_ascii_case("data:")
    {
        return data_uri(rest, what, budget);
    }
    if uri.len() > LONGEST_PATH {
        return Err(malformed(format!("{what}: its URI has {} bytes", uri.len())));
    }
    let limit = context.limits.input_bytes.min(budget.left());
    let name = percent_decode(uri);
    // Some writers do not encode: then a percent sign is one. Others add what a server is asked for, or encode what is not
    // UTF-8.
    let bytes = percent_decode_bytes(uri);
    let bare = name.split(['?', '#']).next().unwrap_or_default();
    let names = [&name, uri, bare, &String::from_utf8_lossy(&bytes)];
    let names =
        names.into_iter().enumerate().filter(|(k, name)| *k == 0 || !name.is_empty()).map(|(_, name)| name);
    let found = nearby.read(context, "", names, limit)?;
    if let Some(note) = found.note {
        notes.push(format!("{what}: {} does not exist; {note}", quoted(name.as_bytes())));
    }
    budget.charge(|| what.to_owned(), found.bytes.len() as u64, 1)?;
    Ok(found.bytes)
}

impl Buffers<'_> {
    /// The bytes behind the URI of something else than a buffer.
    ///
    /// # Errors
    /// [`LoadError`] that begins with `what`.
    pub(super) fn read_uri(
        &mut self,
        uri: &str,
        what: &str,
        context: &Context<'_>,
        budget: &mut Budget,
    ) -> Result<Vec<u8>, LoadError> {
        read_uri(uri, what, context, budget, (&mut self.nearby, &mut self.notes))
    }
}

/// The part of a data URI after `data:`.
fn data_uri(rest: &str, what: &str, budget: &mut Budget) -> Result<Vec<u8>, LoadError> {
    /// Padding may be missing.
    const BASE64: GeneralPurpose = GeneralPurpose::new(
        &base64::alphabet::STANDARD,
        GeneralPurposeConfig::new()
            .with_decode_padding_mode(DecodePaddingMode::Indifferent)
            .with_decode_allow_trailing_bits(true),
    );
    let Some((header, data)) = rest.split_once(',') else {
        return Err(malformed(format!("{what}: its data URI has no comma")));
    };
    budget.charge(|| what.to_owned(), data.len() as u64, 1)?;
    // Some writers leave the semicolon out with the type.
    let header = header.trim().to_ascii_lowercase();
    if header.rsplit(';').next().is_none_or(|last| last.trim() != "base64") {
        return Ok(percent_decode_bytes(data));
    }
    BASE64.decode(data).or_else(|error| {
        // With line ends, percent signs, or letters for URLs.
        let mut plain = percent_decode_bytes(data);
        plain.retain(|b| !b.is_ascii_whitespace());
        for b in &mut plain {
            *b = match *b {
                b'-' => b'+',
                b'_' => b'/',
                other => other,
            };
        }
        BASE64.decode(plain).map_err(|_| malformed(format!("{what}: its data URI is not base64: {error}")))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use overcoat_core::limits::Limits;

    #[test]
    fn percent_signs() {
        assert_eq!(percent_decode("a%20b%2Fc"), "a b/c");
        assert_eq!(percent_decode("100%"), "100%");
        assert_eq!(percent_decode("%zz%4"), "%zz%4");
        assert_eq!(percent_decode("%ff"), "%ff");
        assert_eq!(percent_decode("%C3%A4"), "ä");
    }

    #[test]
    fn data_uris() {
        let read = |uri: &str| data_uri(uri, "buffer 0", &mut Budget::new(&Limits::default()));
        assert_eq!(read("application/octet-stream;base64,AAEC/w==").unwrap(), [0, 1, 2, 255]);
        for other in [
            ";base64,AAEC/w",
            "base64,AAEC/w==",
            ";BASE64,AA\r\nEC\r\n/w==",
            ";base64,AA EC\n/w==",
            "x/y; base64,AAEC%2Fw%3D%3D",
            ";base64,AAEC_w",
        ] {
            assert_eq!(read(other).unwrap(), [0, 1, 2, 255], "{other}");
        }
        assert_eq!(read("text/plain,a%20b").unwrap(), b"a b");
        assert!(
            read(";base64,A*").unwrap_err().to_string().starts_with("glTF: buffer 0: its data URI is not")
        );
        assert!(read("nothing").unwrap_err().to_string().contains("no comma"));
    }
}
