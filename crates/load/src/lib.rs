//! Bytes to scenes. Every reference to another file goes through one [`Resolver`], every count through
//! [`Limits`]. `load` ends where `scene` begins: what comes out is valid.
//!
//! Partial loss (an extension that is not known, a texture that cannot be read) is a [`Warning`] that names what was
//! dropped; a file that cannot be drawn as meant is a [`LoadError`].
//!
//! [`model`] and [`environment`] are the short way, with every choice left to its default. The functions with `load` in their
//! names take what a program that loads more than one file, or files of strangers, wants to choose: [`Limits`] of its own,
//! threads that it has already (`Renderer::jobs`), [`LoadOptions`], a [`Resolver`].
//!
//! Nothing here can panic, whatever a file says: no index, no slice and no arithmetic on integers without a check.

#![cfg_attr(
    not(test),
    deny(
        clippy::indexing_slicing,
        clippy::arithmetic_side_effects,
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic,
        clippy::unreachable
    )
)]
// Helpers of several parts have no user where these are left out.
#![cfg_attr(
    not(all(
        feature = "3mf",
        feature = "more-models",
        feature = "obj",
        feature = "ply-stl",
        feature = "material-files"
    )),
    allow(dead_code, unused_imports)
)]

#[cfg(feature = "more-models")]
mod amf;
mod animated;
#[cfg_attr(not(feature = "3mf"), path = "without_archive.rs")]
mod archive;
mod budget;
mod clay;
mod clusters;
#[cfg(feature = "more-models")]
mod collada;
#[cfg(any(feature = "more-models", feature = "obj"))]
mod derived_images;
#[cfg(all(feature = "more-models", feature = "compression"))]
mod draco;
#[cfg(feature = "3mf")]
mod embedded;
mod encoded_image;
mod environment;
mod error;
#[cfg(feature = "more-models")]
mod fbx;
mod foreign;
mod format;
mod gltf;
mod grouped;
#[cfg(test)]
mod hostile;
mod image;
mod input;
#[cfg(feature = "material-files")]
mod material;
mod mesh_formats;
mod named_environment;
mod names;
mod nearby;
mod nonnumber;
mod normals;
#[cfg(feature = "obj")]
mod obj;
#[cfg(feature = "more-models")]
mod off;
mod options;
mod origin;
mod packed;
#[cfg(feature = "ply-stl")]
mod ply;
mod point_clouds;
mod polygon;
mod resolver;
#[cfg(feature = "more-models")]
mod scans;
mod shares;
mod splat_clouds;
#[cfg(feature = "more-models")]
mod splats;
mod splitting;
#[cfg(feature = "ply-stl")]
mod stl;
mod tangents;
mod text;
#[cfg(feature = "more-models")]
mod three_ds;
#[cfg(feature = "3mf")]
mod threemf;
#[cfg(feature = "more-models")]
mod tiles;
#[cfg(any(feature = "more-models", feature = "obj"))]
mod udim;
mod upright;
#[cfg(feature = "more-models")]
mod usd;
mod utf16;
mod vertices;
#[cfg(feature = "more-models")]
mod vox;
mod warnings;
mod weld;
#[cfg(feature = "more-models")]
mod x3d;
#[cfg(feature = "3mf")]
mod xml;
#[cfg(feature = "3mf")]
mod zipped;

pub use animated::{AnimatedModel, AnimationInfo};
#[cfg(feature = "3mf")]
pub use embedded::{EmbeddedPicture, embedded_picture};
pub use environment::{
    FORMATS as ENVIRONMENT_FORMATS, LoadedEnvironment, load as load_environment,
    load_file as load_environment_file,
};
pub use error::{LoadError, Warning};
pub use format::Format;
pub use gltf::{OwnTextures, Put, Rewriter};
pub use image::FORMATS as TEXTURE_FORMATS;
pub use input::resolver_beside;
pub use input::{has_folder, read_input};
#[cfg(feature = "material-files")]
pub use material::{
    AssignError, BuiltinMaterial, GivenPictures, MaterialError, MaterialErrorReason, MaterialFile,
    MaterialKey, MaterialValueKind, material_keys, material_value,
};
pub use named_environment::NamedEnvironment;
pub use normals::add_smooth_normals;
pub use options::{AnimationChoice, LoadOptions, TextureLoading};
pub use packed::inner_extension;
pub use resolver::{DirectoryResolver, MemoryResolver, NoResolver, ResolveError, Resolver};
pub use tangents::add_tangents;

use gltf::Purpose;
use input::Input;
use overcoat_core::files::check_size;
use overcoat_core::jobs::Jobs;
use overcoat_core::limits::Limits;
use overcoat_scene::{Axis, Scene};
use packed::Unpacked;
#[cfg(feature = "ply-stl")]
use std::io::{Read, Seek};
use std::path::Path;

/// A scene and what was lost on the way.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Loaded {
    /// The scene.
    pub scene: Scene,
    /// Features of the file that the scene lacks, in the order of finding.
    pub warnings: Vec<Warning>,
    /// The axis that is up by what the file says; `None`: the one of its format.
    up: Option<Axis>,
    /// The model faces away from the front that goes with that axis.
    is_turned: bool,
    /// Plates of a 3MF project, in the order of their numbers.
    plates: Vec<Plate>,
}

/// Plate of a 3MF project, by what the slicer's settings say.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Plate {
    /// Number by which [`LoadOptions::plate`] chooses it, from 1.
    pub number: u32,
    /// Name that the file gives it, which may be empty.
    pub name: String,
    /// Items of the file that lie on it.
    pub items: usize,
}

impl Loaded {
    /// Plates of a 3MF project, in the order of their numbers; none of other files.
    #[must_use]
    pub fn plates(&self) -> &[Plate] {
        &self.plates
    }
}

impl From<Scene> for Loaded {
    /// A scene that was made by hand: nothing is lost.
    fn from(scene: Scene) -> Self {
        Self { scene, warnings: Vec::new(), up: None, is_turned: false, plates: Vec::new() }
    }
}

/// Resources of every loader.
#[derive(Clone, Copy)]
pub struct Context<'a> {
    /// The only way to other files.
    pub resolver: &'a dyn Resolver,
    /// Bounds on every count.
    pub limits: &'a Limits,
    /// Threads for decoding images and the like.
    pub jobs: &'a Jobs,
}

/// Loads a model file as [`load_file`] does, within the default [`Limits`] and with a thread per processor, which are started
/// for it.
///
/// ```no_run
/// # mod overcoat { pub use overcoat_load as load; }
/// let loaded = overcoat::load::model("chair.glb")?;
/// loaded.warnings.iter().for_each(|warning| eprintln!("{warning}"));
/// let scene = loaded.scene;
/// # Ok::<(), overcoat::load::LoadError>(())
/// ```
///
/// # Errors
/// As [`load_file`].
pub fn model(path: impl AsRef<Path>) -> Result<Loaded, LoadError> {
    load_file(path.as_ref(), &Limits::default(), &Jobs::default())
}

/// Loads a model from memory as [`load_bytes`] does, as [`model`] does from a file. Its content tells the format; other files
/// that it refers to are not looked for.
///
/// # Errors
/// As [`load_bytes`].
pub fn model_from_memory(bytes: &[u8]) -> Result<Loaded, LoadError> {
    let (limits, jobs) = (Limits::default(), Jobs::default());
    load_bytes(bytes, None, &Context { resolver: &NoResolver, limits: &limits, jobs: &jobs })
}

/// Loads an environment file as [`load_environment_file`] does, within the default [`Limits`].
///
/// # Errors
/// As [`load_environment_file`].
pub fn environment(path: impl AsRef<Path>) -> Result<LoadedEnvironment, LoadError> {
    // Its formats are read by one thread.
    load_environment_file(path.as_ref(), &Limits::default(), &Jobs::new(1))
}

/// Loads a model file of any known format, told by its content and, where that says nothing, by its extension; gzip or
/// Zstandard around it is unpacked. Of a ZIP archive the one model in it is read, or that which lies least deep, with the files
/// that it refers to from the archive. Files that it refers to are read from its folder and the folders in it, from nowhere
/// else. A pipe is read to its end, and has no folder.
///
/// # Errors
/// [`LoadError`]; its message does not contain the path.
pub fn load_file(path: &Path, limits: &Limits, jobs: &Jobs) -> Result<Loaded, LoadError> {
    load_file_with(path, &LoadOptions::default(), limits, jobs)
}

/// [`load_file`] with a choice of what is loaded.
///
/// # Errors
/// As [`load_file`], and [`LoadError::NoSuch`] if the file does not have what is chosen.
pub fn load_file_with(
    path: &Path,
    options: &LoadOptions,
    limits: &Limits,
    jobs: &Jobs,
) -> Result<Loaded, LoadError> {
    load_file_with_format(path, options, limits, jobs).map(|(loaded, _)| loaded)
}

/// [`load_file_with`], and the format that the file was found to have.
///
/// # Errors
/// As [`load_file_with`].
pub fn load_file_with_format(
    path: &Path,
    options: &LoadOptions,
    limits: &Limits,
    jobs: &Jobs,
) -> Result<(Loaded, Option<Format>), LoadError> {
    let (model, format) = read_path(path, options, Purpose::Pictures, limits, jobs)?;
    Ok((model.finish(options, jobs)?, format))
}

/// A file as read.
enum Model {
    /// A scene that never changes.
    Still(Box<Loaded>),
    /// A scene for any time.
    Rig(Box<gltf::Rig>),
}

impl Model {
    /// Adds to what is lost.
    fn warn(&mut self, warning: Warning) {
        match self {
            Self::Still(loaded) => loaded.warnings.push(warning),
            Self::Rig(rig) => rig.warn(warning),
        }
    }

    /// The scene that the options choose.
    fn finish(self, options: &LoadOptions, jobs: &Jobs) -> Result<Loaded, LoadError> {
        match self {
            Self::Still(loaded) => Ok(*loaded),
            Self::Rig(rig) => {
                let (time, repeat) = options.animation.as_ref().map_or((0.0, false), |a| (a.time, a.repeat));
                rig.at(time, repeat, jobs)
            }
        }
    }
}

/// Reads a file, and tells its format.
fn read_path(
    path: &Path,
    options: &LoadOptions,
    purpose: Purpose,
    limits: &Limits,
    jobs: &Jobs,
) -> Result<(Model, Option<Format>), LoadError> {
    let resolver = resolver_beside(path);
    let context = Context { resolver: resolver.as_ref(), limits, jobs };
    #[cfg(feature = "ply-stl")]
    if let Some((loaded, format)) = read_large(path, &context)? {
        options.refuse()?;
        options.refuse_plate(Some(format))?;
        return Ok((still(loaded, Some(format), options), Some(format)));
    }
    let input = Input::open(path, limits)?;
    if let Input::File(file) = &input {
        let size = file.metadata()?.len();
        if (READ_IN_PARTS..=limits.input_bytes).contains(&size)
            && let Some(rig) = gltf::read_file(file, size, options, purpose, &context)?
        {
            return Ok((Model::Rig(Box::new(rig)), Some(Format::Glb)));
        }
    }
    let bytes = input.read(limits)?;
    let named = inner_extension(path).and_then(|extension| Format::from_extension(&extension));
    read_bytes(&bytes, Claim { said: None, named }, options, purpose, &context)
}

/// A file beyond the limits that is reduced while it is read, and its format.
#[cfg(feature = "ply-stl")]
fn read_large(path: &Path, context: &Context<'_>) -> Result<Option<(Loaded, Format)>, LoadError> {
    let Some(mut file) = input::open_large(path)? else { return Ok(None) };
    let mut mark = [0; 3];
    file.read_exact(&mut mark)?;
    file.rewind()?;
    Ok(if mark.eq_ignore_ascii_case(b"ply") {
        ply::load_file(file, context)?.map(|loaded| (loaded, Format::Ply))
    } else {
        stl::load_file(file, context)?.map(|loaded| (loaded, Format::Stl))
    })
}

/// Format that a file claims to have.
#[derive(Clone, Copy, Default)]
struct Claim {
    /// By who gives it.
    said: Option<Format>,
    /// By its name, which counts for less than its content.
    named: Option<Format>,
}

impl Claim {
    /// The format of a file that has no mark, if it claims to be of one and may be: its first bytes are those of numbers, which
    /// can be taken for the beginning of a text.
    fn without_mark(self, bytes: &[u8]) -> Option<Format> {
        let is_splat = self.said.or(self.named) == Some(Format::Splat);
        (is_splat && format::is_likely_splat(bytes)).then_some(Format::Splat)
    }
}

/// Bytes from which on a file that allows it is read in parts: below, having it in memory twice is no matter.
const READ_IN_PARTS: u64 = 1 << 20;

/// The end of the message for all others.
fn read_formats() -> String {
    let mut names: Vec<&str> = Format::ALL.iter().copied().map(Format::name).collect();
    names.dedup();
    let last = names.pop().unwrap_or_default();
    format!("models are read from {} and {last}", names.join(", "))
}

/// Loads a model from memory. Without a format, its content tells.
///
/// # Errors
/// [`LoadError`].
pub fn load_bytes(bytes: &[u8], format: Option<Format>, context: &Context<'_>) -> Result<Loaded, LoadError> {
    load_bytes_with(bytes, format, &LoadOptions::default(), context)
}

/// [`load_bytes`] with a choice of what is loaded.
///
/// # Errors
/// As [`load_bytes`], and [`LoadError::NoSuch`] if the file does not have what is chosen.
pub fn load_bytes_with(
    bytes: &[u8],
    format: Option<Format>,
    options: &LoadOptions,
    context: &Context<'_>,
) -> Result<Loaded, LoadError> {
    load_bytes_with_format(bytes, format, options, context).map(|(loaded, _)| loaded)
}

/// [`load_bytes_with`], and the format that the bytes were found to have.
///
/// # Errors
/// As [`load_bytes_with`].
pub fn load_bytes_with_format(
    bytes: &[u8],
    format: Option<Format>,
    options: &LoadOptions,
    context: &Context<'_>,
) -> Result<(Loaded, Option<Format>), LoadError> {
    let claim = Claim { said: format, named: None };
    let (model, format) = read_bytes(bytes, claim, options, Purpose::Pictures, context)?;
    Ok((model.finish(options, context.jobs)?, format))
}

/// [`load_bytes_with`] of a file whose name says what its content does not.
///
/// # Errors
/// As [`load_bytes_with`].
pub fn load_named_bytes(
    bytes: &[u8],
    name: &Path,
    options: &LoadOptions,
    context: &Context<'_>,
) -> Result<Loaded, LoadError> {
    let claim = Claim { said: None, named: format_of_name(name) };
    read_bytes(bytes, claim, options, Purpose::Pictures, context)?.0.finish(options, context.jobs)
}

/// The format that a file has by its name.
fn format_of_name(name: &Path) -> Option<Format> {
    inner_extension(name).and_then(|extension| Format::from_extension(&extension))
}

/// Reads a file in memory, unpacked if it is packed.
fn read_bytes(
    bytes: &[u8],
    claim: Claim,
    options: &LoadOptions,
    purpose: Purpose,
    context: &Context<'_>,
) -> Result<(Model, Option<Format>), LoadError> {
    check_size(bytes.len() as u64, context.limits)?;
    let Some(Unpacked { bytes, warning }) = packed::unpack(bytes, context.limits)? else {
        return read_unpacked(bytes, claim, options, purpose, context);
    };
    let (mut model, format) = read_unpacked(&bytes, claim, options, purpose, context)?;
    if let Some(warning) = warning {
        model.warn(warning);
    }
    Ok((model, format))
}

/// Reads a file of which nothing is packed as a whole.
fn read_unpacked(
    bytes: &[u8],
    claim: Claim,
    options: &LoadOptions,
    purpose: Purpose,
    context: &Context<'_>,
) -> Result<(Model, Option<Format>), LoadError> {
    if bytes.is_empty() {
        return Err(LoadError::UnknownFormat("the file is empty".to_owned()));
    }
    if let Some(format) = claim.without_mark(bytes) {
        options.refuse()?;
        options.refuse_plate(Some(format))?;
        return Ok((
            still(read_meshes(bytes, format, options, context)?, Some(format), options),
            Some(format),
        ));
    }
    let detected = Format::detect(bytes);
    if detected.is_none()
        && let Some(text) = utf16::to_utf8(bytes)
        && Format::detect(&text).is_some()
    {
        return read_unpacked(&text, claim, options, purpose, context);
    }
    #[cfg(feature = "3mf")]
    if detected.is_none()
        && let Some(found) = zipped::read(bytes, options, purpose, context)?
    {
        return Ok(found);
    }
    // Contents known to be of another format are refused, whatever the caller or the name of the file says.
    if detected.is_none()
        && let Some(what) = foreign::what_it_is(bytes)
    {
        return Err(LoadError::UnknownFormat(format!("it is {what}; {}", read_formats())));
    }
    let format = claim.said.or(detected).or(claim.named);
    if !matches!(format, Some(Format::Gltf | Format::Glb) | None) {
        options.refuse()?;
    }
    options.refuse_plate(format)?;
    let loaded = match format {
        Some(Format::Gltf | Format::Glb) => {
            let rig = gltf::read(bytes, options, purpose, context)?;
            return Ok((Model::Rig(Box::new(rig)), format));
        }
        Some(format) => read_meshes(bytes, format, options, context),
        None => Err(LoadError::UnknownFormat(format!("the format is not known; {}", read_formats()))),
    };
    Ok((still(loaded?, format, options), format))
}

/// A model that never changes, on its feet.
fn still(mut loaded: Loaded, format: Option<Format>, options: &LoadOptions) -> Model {
    let orientation = upright::orientation(&loaded, format, options);
    loaded.scene.stand_up(orientation);
    Model::Still(Box::new(loaded))
}

/// Reads a file of a format whose models never change.
fn read_meshes(
    bytes: &[u8],
    format: Format,
    options: &LoadOptions,
    context: &Context<'_>,
) -> Result<Loaded, LoadError> {
    shares::read(context.limits, |shares| read_once(bytes, format, options, context, shares))
}

/// Reads such a file with shares for its textures, where it names them one by one.
fn read_once(
    bytes: &[u8],
    format: Format,
    options: &LoadOptions,
    context: &Context<'_>,
    shares: &shares::Shares,
) -> Result<Loaded, LoadError> {
    match format {
        #[cfg(feature = "obj")]
        Format::Obj => obj::load(bytes, context, options.textures),
        #[cfg(feature = "ply-stl")]
        Format::Stl => stl::load(bytes, context),
        #[cfg(feature = "ply-stl")]
        Format::Ply => ply::load(bytes, context, options.textures, shares),
        #[cfg(feature = "3mf")]
        Format::ThreeMf => threemf::load(bytes, context, options, shares),
        #[cfg(feature = "more-models")]
        Format::Splat => splats::splat::load(bytes, context),
        #[cfg(feature = "more-models")]
        Format::Spz => splats::spz::load(bytes, context),
        #[cfg(feature = "more-models")]
        Format::Ksplat => splats::ksplat::load(bytes, context),
        #[cfg(feature = "more-models")]
        Format::Off => off::load(bytes, context),
        #[cfg(feature = "more-models")]
        Format::Pcd => scans::pcd::load(bytes, context),
        #[cfg(feature = "more-models")]
        Format::Xyz => scans::xyz::load(bytes, context),
        #[cfg(feature = "more-models")]
        Format::Las => scans::las::load(bytes, context),
        #[cfg(feature = "more-models")]
        Format::Ptx => scans::ptx::load(bytes, context),
        #[cfg(feature = "more-models")]
        Format::Collada => collada::load(bytes, context, options.textures, shares),
        #[cfg(feature = "more-models")]
        Format::Sog => splats::sog::load(bytes, context),
        #[cfg(feature = "more-models")]
        Format::Amf => amf::load(bytes, context, shares),
        #[cfg(feature = "more-models")]
        Format::Vox => vox::load(bytes, context),
        #[cfg(feature = "more-models")]
        Format::Fbx => fbx::load(bytes, context, options.textures, shares),
        #[cfg(feature = "more-models")]
        Format::ThreeDs => three_ds::load(bytes, context, options.textures, shares),
        #[cfg(feature = "more-models")]
        Format::Usd => usd::load(bytes, context, options.textures, shares),
        #[cfg(feature = "more-models")]
        Format::E57 => scans::e57::load(bytes, context),
        #[cfg(all(feature = "more-models", feature = "compression"))]
        Format::Draco => draco::load(bytes, context),
        #[cfg(feature = "more-models")]
        Format::Tile => tiles::load(bytes, context, options.textures),
        #[cfg(feature = "more-models")]
        Format::Vrml => x3d::load(bytes, context, options.textures, shares),
        #[cfg(feature = "more-models")]
        Format::X3d => x3d::load(bytes, context, options.textures, shares),
        _ => {
            let _ = (bytes, options, context, shares);
            Err(LoadError::unsupported(format.name(), overcoat_core::formats::LEFT_OUT))
        }
    }
}
