//! Prototypes of other files (EXTERNPROTO, ExternProtoDeclare), whose nodes are read for each use as those of the file are.

use super::node::Node;
use super::reading::Reading;
use super::{FORMAT, classic, is_xml, xml};
use crate::LoadError;
use crate::nearby::folder_of;
use crate::text::{percent_decode, quoted};
use crate::xml::text_of;
use std::collections::BTreeMap;
use std::rc::Rc;

/// Files with prototypes that one file may bring along.
const FILES: usize = 256;

/// Names of files with a prototype, best first.
#[derive(Clone, Debug)]
pub(super) struct Source {
    pub(super) urls: Vec<String>,
}

/// A file with prototypes: its text, and its folder by the place in the list of folders.
type Text = (Rc<str>, usize);

/// Files with prototypes that have been looked for, by folder and name in nodes.
pub(super) type Texts = BTreeMap<(usize, String), Option<Text>>;

/// Reads the nodes of a prototype of another file for a use of it within `around` others, with `work` bytes read for all of them.
pub(super) fn instance(
    reading: &mut Reading<'_>,
    source: &Source,
    own: Node,
    around: usize,
    work: &mut usize,
) -> Result<Option<usize>, LoadError> {
    if !reading.may_use(&own.kind, around, *work) {
        return Ok(None);
    }
    for url in source.urls.iter().take(16) {
        let (file, name) = url.split_once('#').unwrap_or((url, ""));
        let key = (reading.folder, file.to_owned());
        let text = match reading.nodes.texts.get(&key) {
            Some(known) => known.clone(),
            None => {
                let text = find(reading, file)?;
                reading.nodes.texts.insert(key, text.clone());
                text
            }
        };
        let Some((text, folder)) = text else { continue };
        *work = work.saturating_add(text.len());
        let before = reading.begin(folder);
        let around = around.saturating_add(1);
        let found = if is_xml(text.trim_start().as_bytes()) {
            xml::instance_of(&text, name, own, reading, (around, work))
        } else {
            classic::instance_of(&text, name, own, reading, (around, work))
        };
        reading.end(before);
        return match found {
            Err(error) if error.is_partial() => {
                let file = quoted(file.as_bytes());
                reading.warnings.add(|| format!("{FORMAT}: a prototype of file {file} is left out: {error}"));
                Ok(None)
            }
            found => found,
        };
    }
    Ok(None)
}

/// A file that is named; none, with a warning, if it cannot be had.
fn find(reading: &mut Reading<'_>, file: &str) -> Result<Option<Text>, LoadError> {
    let name = percent_decode(file.strip_prefix("file://").unwrap_or(file));
    let what = quoted(name.as_bytes());
    if reading.nodes.texts.len() >= FILES {
        reading
            .warnings
            .add(|| format!("{FORMAT}: of files with prototypes the first {FILES} are looked for"));
        return Ok(None);
    }
    let folder = reading.nodes.folders.get(reading.folder).cloned().unwrap_or_default();
    let left = reading.budget.left();
    let found = match reading.nearby.read(reading.context, &folder, [name.as_str()], left) {
        Ok(found) => found,
        Err(error) => {
            reading.warnings.add(|| format!("{FORMAT}: prototypes of file {what} are left out: {error}"));
            return Ok(None);
        }
    };
    reading.budget.charge(|| format!("{FORMAT}: file {what}"), found.bytes.len() as u64, 2)?;
    let text = text_of(&found.bytes, "", reading.budget)?;
    reading.nodes.folders.push(folder_of(&found.name).to_owned());
    Ok(Some((Rc::from(&*text), reading.nodes.folders.len().saturating_sub(1))))
}

/// Warns that a file lacks the prototype that was looked for.
pub(super) fn missing(reading: &mut Reading<'_>, name: &str) {
    let name = quoted(name.as_bytes());
    reading.warnings.add(|| format!("{FORMAT}: prototype {name} is not in the file that should have it"));
}
