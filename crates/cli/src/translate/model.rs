//! Translations that are written into a copy of a glTF file.

use super::seen::{self, Flip};
use super::{Members, TranslateArgs, Written, told};
use crate::failure::{self, Failure};
use crate::output_file::{Encoded, check_file, check_standard_output, is_standard_output};
use crate::progress::Progress;
use overcoat_core::limits::Limits;
use overcoat_lab::lab::{Goal, Translation, Translator, untextured};
use overcoat_load::{
    Context, Format, LoadOptions, Loaded, MaterialFile, OwnTextures, Put, Rewriter, has_folder,
    load_named_bytes, read_input,
};
use overcoat_render::Renderer;
use overcoat_scene::parameters::{Parameter, slots};
use overcoat_scene::{Material, MaterialId, Scene, ShadingModel};
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
    /// The materials that were chosen, as they were.
    originals: Vec<Material>,
    /// The file as it was, packed or not.
    bytes: Vec<u8>,
    names: Vec<String>,
    pub(super) written: Vec<Written>,
    pub(super) warnings: Vec<String>,
    /// Names of what the translated materials have and the copy has not.
    pub(super) lacks: Vec<&'static str>,
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
        let rewriter = Rewriter::new(bytes.clone(), limits).map_err(load)?;
        let warnings = packed.iter().chain(&rewriter.warnings()).map(ToString::to_string).collect();
        let names = rewriter.names();
        let mut copy = Self {
            source: source.to_owned(),
            output,
            rewriter,
            chosen: Vec::new(),
            originals: Vec::new(),
            bytes,
            names,
            written: Vec::new(),
            warnings,
            lacks: Vec::new(),
        };
        copy.check_output(others, args.report.json)?;
        copy.chosen = copy.choose(wanted, coated)?;
        copy.originals = copy.chosen.iter().map(|&k| copy.material(k)).collect::<Result<_, _>>()?;
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
    pub(super) fn tune(
        &mut self,
        models: [ShadingModel; 2],
        context: &Context<'_>,
        progress: &Progress,
    ) -> Result<(), Failure> {
        let [from, to] = models;
        let of = u32::try_from(self.chosen.len()).unwrap_or(u32::MAX);
        let scene = self.scene(&self.bytes, context)?.scene;
        let mut translator = Translator::new();
        let goal = goal_in_a_file(to, OwnTextures::Kept);
        for (done, index) in self.chosen.clone().into_iter().enumerate() {
            progress.step(format!("{} to {}", from.name(), to.name()), done as u32, of);
            let original = &self.originals[done];
            // With its textures, where the scene has it.
            let there = scene.materials().iter().find(|material| untextured(material) == *original);
            let material = there.unwrap_or(original).clone();
            let found = translator.translate_for(&material, scene.textures(), from, &goal);
            let found = found.map_err(|e| failure::lab(&e))?;
            let what = self.label(index);
            let lacks = goal.lacks(&material);
            self.lacks
                .extend(lacks.into_iter().filter(|name| !self.lacks.contains(name)).collect::<Vec<_>>());
            self.warnings.extend(unknown(&goal, &material).map(|unknown| format!("{what}: {unknown}")));
            self.put(index, &found, OwnTextures::Kept)?;
        }
        Ok(())
    }

    fn scene(&self, bytes: &[u8], context: &Context<'_>) -> Result<Loaded, Failure> {
        let load = |e| Failure::load(&e).at(&self.source);
        load_named_bytes(bytes, &self.source, &LoadOptions::default(), context).map_err(load)
    }

    /// FLIP between what was meant and the copy, read again. `meant` is the material file that took the place of those of the
    /// file; without one those of the file are meant.
    ///
    /// # Errors
    /// [`Failure`] if the copy cannot be read or drawn.
    pub(super) fn seen(
        &mut self,
        meant: Option<&MaterialFile>,
        [from, to]: [ShadingModel; 2],
        context: &Context<'_>,
        renderer: &mut Renderer,
    ) -> Result<Flip, Failure> {
        let limits = context.limits;
        let bytes = self.rewriter.bytes().map_err(|e| Failure::load(&e).at(&self.source))?;
        let (mut before, mut after) = (self.scene(&self.bytes, context)?, self.scene(&bytes, context)?);
        let own: Vec<Material> = before.scene.materials().to_vec();
        let place = |original: &Material| own.iter().position(|material| untextured(material) == *original);
        let mut worst = 0.0_f64;
        for ((&index, original), written) in self.chosen.iter().zip(&self.originals).zip(&mut self.written) {
            let at = place(original);
            let new = self.rewriter.material(index).map_err(|e| Failure::load(&e).at(&self.source))?;
            let spheres = match (meant, at) {
                (Some(file), _) => {
                    [seen::sphere_of_file(file, from, limits)?, seen::sphere_of(&new, &[], to)?]
                }
                (None, Some(k)) => {
                    let of = |loaded: &Loaded, model| {
                        seen::sphere_of(&loaded.scene.materials()[k], loaded.scene.textures(), model)
                    };
                    [of(&before, from)?, of(&after, to)?]
                }
                (None, None) => [seen::sphere_of(original, &[], from)?, seen::sphere_of(&new, &[], to)?],
            };
            written.flip = seen::between_spheres(spheres, renderer, limits)?;
            worst = worst.max(written.flip);
        }
        let chosen: Vec<bool> =
            own.iter().map(|material| self.originals.contains(&untextured(material))).collect();
        if !chosen.contains(&true) {
            return Ok(Flip::new(worst, None));
        }
        if let Some(file) = meant {
            let mut names: Vec<&str> = self.originals.iter().map(|material| material.name.as_str()).collect();
            names.dedup();
            for name in names {
                let name = (!name.is_empty()).then_some(name);
                file.assign(&mut before.scene, name, limits).map_err(|e| Failure::assign(&e))?;
            }
            keep_shapes(&mut before.scene, &own, &chosen)?;
        }
        seen::shade(&mut before.scene, |k| if chosen[k] { from } else { to })?;
        seen::shade(&mut after.scene, |_| to)?;
        Ok(Flip::new(worst, seen::between_files([before, after], renderer, limits)?))
    }

    fn put(&mut self, index: usize, found: &Translation, textures: OwnTextures) -> Result<(), Failure> {
        let put = self.rewriter.put(index, &found.material, textures);
        let put = put.map_err(|e| Failure::load(&e).at(&self.source))?;
        let warnings = warnings(&self.label(index), &put, textures);
        self.warnings.extend(warnings);
        self.written.push(Written {
            index,
            name: self.names[index].clone(),
            flip: 0.0,
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
            text += &Flip::new(written.flip, None).told();
            for (path, value) in &members.0 {
                let _ = writeln!(text, "  {path} {value}");
            }
        }
        text
    }
}

/// Model of a material in a copy of a glTF file.
pub(super) fn goal_in_a_file(model: ShadingModel, textures: OwnTextures) -> Goal<'static> {
    let holds: &dyn Fn(&Parameter) -> bool = match textures {
        OwnTextures::Kept => &|parameter| Rewriter::holds(parameter, OwnTextures::Kept),
        OwnTextures::Replaced => &|parameter| Rewriter::holds(parameter, OwnTextures::Replaced),
    };
    Goal { model, holds }
}

/// Gives materials that were laid over those of a file its maps of normals and occlusion, and the way it treats edges.
fn keep_shapes(scene: &mut Scene, own: &[Material], chosen: &[bool]) -> Result<(), Failure> {
    for (k, own) in own.iter().enumerate().filter(|(k, _)| chosen[*k]) {
        let mut material = scene.materials()[k].clone();
        for (parameter, slot) in slots().filter(|(parameter, _)| SHAPES.contains(&parameter.name)) {
            let texture = slot.get(own).filter(|_| slot.get(&material).is_none()).copied();
            if let Some(texture) = texture.filter(|_| parameter.is_in(&material)) {
                slot.set(&mut material, Some(texture));
            }
        }
        (material.alpha_mode, material.double_sided) = (own.alpha_mode, own.double_sided);
        material.base_color[3] = own.base_color[3];
        let id = MaterialId::from_index(k as u32);
        scene.replace_material(id, material).map_err(|e| Failure::scene(&e))?;
    }
    Ok(())
}

/// Warnings about features of a material that a goal has no place for.
pub(super) fn unknown(goal: &Goal<'_>, material: &Material) -> impl Iterator<Item = String> {
    let name = goal.model.name();
    goal.lacks(material).into_iter().map(move |what| match what {
        "textures" => "textures of the material are not in the copy, which has their means".to_owned(),
        _ => format!("{name} does not know {what}: what it looks like is approached by the rest"),
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
        say(&factors, "of the file stays and multiplies numbers that were found for its texels");
    }
    if textures == OwnTextures::Replaced {
        say(&shapes, "of the file stays");
    }
    say(&put.dropped, "of the file is taken out: the numbers of the other material hold");
    say(&put.lost, "has no place in glTF, or none without further files, and is not written");
    all
}
