//! Translations that are written into a copy of a glTF file.

use super::{Members, TranslateArgs, Written, told};
use crate::failure::Failure;
use crate::output_file::{Encoded, check_file, check_standard_output, is_standard_output};
use crate::progress::Progress;
use overcoat_core::limits::Limits;
use overcoat_lab::lab::{Translation, Translator};
use overcoat_load::{Format, OwnTextures, Put, Rewriter, has_folder, read_input};
use overcoat_scene::{Material, ShadingModel};
use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Textures that multiply no number, and stay whatever a surface is made of.
const SHAPES: [&str; 3] = ["normal_texture", "occlusion_texture", "coat_normal_texture"];

/// True of names of glTF files.
pub(super) fn is_model(path: &Path) -> bool {
    path.extension().is_some_and(|e| {
        e.to_str().and_then(Format::from_extension).is_some_and(|f| matches!(f, Format::Glb | Format::Gltf))
    })
}

/// A glTF file, its copy, and which of its materials are changed.
pub(super) struct ModelCopy {
    source: PathBuf,
    output: PathBuf,
    rewriter: Rewriter,
    chosen: Vec<usize>,
    names: Vec<String>,
    pub(super) written: Vec<Written>,
    pub(super) warnings: Vec<String>,
}

impl ModelCopy {
    /// Reads the file and finds out before the work what would fail after it. Materials are those that are named; `coated`
    /// says which are meant where none is.
    ///
    /// # Errors
    /// [`Failure`] if the file cannot be read, has no such materials, or the copy cannot be written or would not find the files
    /// that it refers to.
    pub(super) fn open(
        args: &TranslateArgs,
        source: &Path,
        others: &[PathBuf],
        wanted: &[String],
        limits: &Limits,
        coated: bool,
    ) -> Result<Self, Failure> {
        let Some(output) = args.output.clone() else {
            return Err(Failure::usage("name the copy of the glTF file with -o"));
        };
        let load = |e| Failure::load(&e).at(source);
        let (bytes, packed) = read_input(source, limits).map_err(load)?;
        let rewriter = Rewriter::new(bytes, limits).map_err(load)?;
        let warnings = packed.iter().chain(&rewriter.warnings()).map(ToString::to_string).collect();
        let names = rewriter.names();
        let mut copy = Self {
            source: source.to_owned(),
            output,
            rewriter,
            chosen: Vec::new(),
            names,
            written: Vec::new(),
            warnings,
        };
        copy.check_output(others, args.report.json)?;
        copy.chosen = copy.choose(wanted, coated)?;
        Ok(copy)
    }

    fn check_output(&self, others: &[PathBuf], json: bool) -> Result<(), Failure> {
        let output = &self.output;
        let to_standard_output = is_standard_output(output);
        if to_standard_output {
            check_standard_output(json, false)?;
        } else {
            let expected = if self.rewriter.is_container() { "glb" } else { "gltf" };
            if output.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case(expected)) {
                let what = format!("the copy of this file is a .{expected}");
                return Err(Failure::usage(what).at(output));
            }
            check_file(output, &[others, std::slice::from_ref(&self.source)].concat())?;
        }
        let Some(file) = self.rewriter.refers_to() else { return Ok(()) };
        let folder = |path: &Path| {
            let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
            folder.unwrap_or(Path::new(".")).canonicalize().ok()
        };
        if to_standard_output || !has_folder(&self.source) || folder(output) != folder(&self.source) {
            let what = format!("the file refers to '{file}' beside it: write the copy into its folder");
            return Err(Failure::usage(what).at(&self.source));
        }
        Ok(())
    }

    /// Materials by their names, in the order of the file.
    fn choose(&self, wanted: &[String], coated: bool) -> Result<Vec<usize>, Failure> {
        let usage = |what: String| Err(Failure::usage(what).at(&self.source));
        if self.names.is_empty() {
            return usage("it has no materials".to_owned());
        }
        let known: BTreeSet<&str> = self.names.iter().map(String::as_str).filter(|n| !n.is_empty()).collect();
        let mut list: Vec<&str> = known.iter().copied().take(20).collect();
        if known.len() > list.len() {
            list.push("...");
        }
        let list = if list.is_empty() { "none has a name".to_owned() } else { list.join(", ") };
        if let Some(name) = wanted.iter().find(|name| !known.contains(name.as_str())) {
            return usage(format!("it has no material '{name}'; there are: {list}"));
        }
        let all = 0..self.names.len();
        if !wanted.is_empty() {
            return Ok(all.filter(|&k| wanted.contains(&self.names[k])).collect());
        }
        if !coated {
            let several = format!("it has {} materials: say which by --material ({list})", self.names.len());
            return if self.names.len() == 1 { Ok(vec![0]) } else { usage(several) };
        }
        let mut chosen = Vec::new();
        for k in all {
            if self.material(k)?.coat > 0.0 {
                chosen.push(k);
            }
        }
        if chosen.is_empty() {
            return usage(format!("no material has a clear coat; --material takes any ({list})"));
        }
        Ok(chosen)
    }

    fn material(&self, index: usize) -> Result<Material, Failure> {
        self.rewriter.material(index).map_err(|e| Failure::load(&e).at(&self.source))
    }

    /// Puts one translated material in place of each that was chosen.
    ///
    /// # Errors
    /// [`Failure`] if a material cannot be changed.
    pub(super) fn paint(&mut self, found: &Translation) -> Result<(), Failure> {
        for index in self.chosen.clone() {
            self.put(index, found, OwnTextures::Replaced)?;
        }
        Ok(())
    }

    /// Translates the materials that were chosen, each by itself. Models: that of `--from` or of the default, and the other.
    ///
    /// # Errors
    /// [`Failure`] if a material cannot be translated or changed.
    pub(super) fn tune(&mut self, models: [ShadingModel; 2], progress: &Progress) -> Result<(), Failure> {
        let [from, to] = models;
        let of = u32::try_from(self.chosen.len()).unwrap_or(u32::MAX);
        let mut translator = Translator::new();
        for (done, index) in self.chosen.clone().into_iter().enumerate() {
            progress.step(format!("{} to {}", from.name(), to.name()), done as u32, of);
            let material = self.material(index)?;
            let found = translator.translate(&material, from, to).map_err(|e| Failure::lab(&e))?;
            let what = self.label(index);
            self.warnings.extend(unknown(to, &material).map(|unknown| format!("{what}: {unknown}")));
            self.put(index, &found, OwnTextures::Kept)?;
        }
        Ok(())
    }

    fn put(&mut self, index: usize, found: &Translation, textures: OwnTextures) -> Result<(), Failure> {
        let put = self.rewriter.put(index, &found.material, textures);
        let put = put.map_err(|e| Failure::load(&e).at(&self.source))?;
        let warnings = warnings(&self.label(index), &put, textures);
        self.warnings.extend(warnings);
        self.written.push(Written {
            index,
            name: self.names[index].clone(),
            before: found.before.into(),
            after: found.after.into(),
            members: Members(put.numbers),
        });
        Ok(())
    }

    fn label(&self, index: usize) -> String {
        let name: String = self.names[index].chars().take(48).collect();
        if name.is_empty() { format!("material {index}") } else { format!("material {index} '{name}'") }
    }

    /// Writes the copy, and says whether it went to standard output, where nothing else may go then.
    ///
    /// # Errors
    /// [`Failure`] naming the file.
    pub(super) fn write(&self) -> Result<bool, Failure> {
        let bytes = self.rewriter.bytes().map_err(|e| Failure::load(&e).at(&self.source))?;
        Encoded::new(self.output.clone(), bytes).write()?;
        Ok(is_standard_output(&self.output))
    }

    /// Report on the written materials, for people.
    pub(super) fn told(&self) -> String {
        let mut text = String::new();
        for written in &self.written {
            let Written { index, before, after, members, .. } = written;
            let _ = writeln!(text, "{}", self.label(*index));
            text += &told(before, after);
            for (path, value) in &members.0 {
                let _ = writeln!(text, "  {path} {value}");
            }
        }
        text
    }
}

/// Warnings about features of a material that a shading model does not have.
pub(super) fn unknown(to: ShadingModel, material: &Material) -> impl Iterator<Item = String> {
    let what = to.leaves_out(material);
    what.map(move |what| {
        format!("{} does not know {what}: what it looks like is approached by the rest", to.name())
    })
}

/// Warnings about textures and parameters of a material that could not be written as they were meant.
fn warnings(what: &str, put: &Put, textures: OwnTextures) -> Vec<String> {
    let (shapes, factors): (Vec<&str>, Vec<&str>) = put.kept.iter().partition(|name| SHAPES.contains(name));
    let mut all = Vec::new();
    let mut say = |names: &[&str], rest: &str| {
        if !names.is_empty() {
            all.push(format!("{what}: {} {rest}", names.join(", ")));
        }
    };
    if !put.numbers.is_empty() {
        say(&factors, "of the file stays and multiplies numbers that were found for where it is white");
    }
    if textures == OwnTextures::Replaced {
        say(&shapes, "of the file stays");
    }
    say(&put.dropped, "of the file is taken out: the numbers of the other material hold");
    say(&put.lost, "has no place in glTF, or none without further files, and is not written");
    all
}
