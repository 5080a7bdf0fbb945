//! The options of `overcoat lab`.

use crate::args::{ReportArgs, ThreadArgs};
use crate::failure::Failure;
use crate::translate::is_measured;
use crate::value_parsers;
use clap::Args;
use overcoat_core::suggest::suggestion;
use overcoat_description::MaterialChoice;
use overcoat_lab::lab::{Base, Light, Quantity, Slice, Specimen};
use overcoat_lab::truth::Samples;
use overcoat_scene::ShadingModel;
use std::path::{Path, PathBuf};

/// One model of each engine, and those of the house.
pub(crate) const DEFAULT_MODELS: &[ShadingModel] = &[
    ShadingModel::Urp17,
    ShadingModel::HdrpLit,
    ShadingModel::StackLit,
    ShadingModel::Filament,
    ShadingModel::Three,
    ShadingModel::Gltf,
    ShadingModel::OpenPbr,
    ShadingModel::Babylon,
    ShadingModel::Standard,
    ShadingModel::StackLitD,
];

/// `overcoat lab`
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  overcoat lab --specular 0 --color 0.18,0.18,0.18
  overcoat lab --over light --light 45 --coat-roughness 0.2 -o lobes.svg
  overcoat lab --over thickness --extinction 0.1,0.4,1 --metal -o thickness.csv
  overcoat lab --over coat-roughness --by base-roughness --metal --models stacklit -o errors.svg
  overcoat lab --summary
  overcoat lab --summary --base convention
  overcoat lab --paint silver-metallic
  overcoat lab --measured gold.binary --material gold.toml --over light -o lobes.svg

Values are radiance: under --light white the directional albedo, under light from one direction the BRDF times its cosine.
The referee is a random walk through the layers; its column comes with its standard error. Means of --summary come with intervals of
95 percent confidence: of the grids by the noise of the walks, with --random by the choice of coats.

Plastic has several truths, which --base names. lambert: a matt surface. interface: a matt surface of --color below a dielectric
interface of --base-ior, which below a coat of the same index is none. seen: the same interface over what makes --color that
which one sees without a coat. convention: a layer of F0 0.04 that bends no light, with or without a coat, as engines have it.

With --paint light falls at 45 degrees, and colours are L*a*b* (D65) at aspecular angles of 15 to 110 degrees; the flop index is
Alman's. Sparkle is counted on a plate of 25.6 mm in pixels of 0.1 mm, seen from above: the share of pixels at least twice as bright
as the mean under one lamp, their mean brightness over the plate's, and both multiplied. Graininess is standard deviation over
mean under the soft box of --light overhead. Neither is what an instrument shows.

With --measured the BRDF of a file takes the place of the referee (MERL's .binary, the RGL's _rgb.bsdf), and materials that
of the specimen: as overcoat translate finds them, for example.")]
pub struct LabArgs {
    /// Plot to write (.svg), or table (.csv), or - for a table as .csv on standard output [default: a table to read]
    #[arg(short, long, value_name = "OUT")]
    pub output: Option<PathBuf>,

    /// Quantity that varies: view, light, coat, coat-roughness, coat-ior, thickness, base-roughness, base-ior, color or specular
    #[arg(long, value_name = "WHAT", default_value = "view", value_parser = quantity)]
    pub over: Quantity,

    /// First value of what varies [default: by what it is]
    #[arg(long, value_name = "VALUE", allow_negative_numbers = true)]
    pub from: Option<f64>,

    /// Last value of what varies [default: by what it is]
    #[arg(long, value_name = "VALUE", allow_negative_numbers = true)]
    pub to: Option<f64>,

    /// Values of what varies, 2 to 1000
    #[arg(long, value_name = "N", default_value_t = 18, value_parser = value_parsers::within::<u32>(2, 1000))]
    pub steps: u32,

    /// What varies down a map of errors (.svg) of each model
    #[arg(long, value_name = "WHAT", value_parser = quantity)]
    pub by: Option<Quantity>,

    /// Tell how far each model is off over a grid of coats instead
    #[arg(long, conflicts_with_all = ["over", "from", "to", "steps", "by", "output"])]
    pub summary: bool,

    /// Tell the colours, flop, sparkle and graininess of a paint instead: a material file (.toml, .mtlx) or a built-in material
    #[arg(long, value_name = "FILE|BUILT-IN", value_parser = value_parsers::MaterialParser, hide_possible_values = true,
          conflicts_with_all = ["over", "from", "to", "steps", "by", "output", "summary", "samples", "seed", "view", "light", "coat",
                                "coat_roughness", "coat_ior", "thickness", "extinction", "base", "base_ior", "base_roughness", "metal", "color",
                                "specular"])]
    pub paint: Option<MaterialChoice>,

    /// Compare a measured BRDF (.binary, .bsdf) with materials instead, over view or light
    #[arg(long, value_name = "FILE", value_parser = measured,
          conflicts_with_all = ["by", "summary", "paint", "models", "samples", "coat", "coat_roughness", "coat_ior", "thickness",
                                "extinction", "base", "base_ior", "base_roughness", "metal", "color", "specular"])]
    pub measured: Option<PathBuf>,

    /// With --measured: a material beside it, by its own model: a material file (.toml, .mtlx) or a built-in material (repeatable)
    #[arg(long, value_name = "FILE|BUILT-IN", value_parser = value_parsers::MaterialParser, hide_possible_values = true,
          requires = "measured")]
    pub material: Vec<MaterialChoice>,

    /// With --summary: also coats that absorb or have another index, which not every engine knows
    #[arg(long, requires = "summary")]
    pub all: bool,

    /// With --summary: so many coats anywhere in the ranges in place of the grid, 1 to 10000
    #[arg(long, value_name = "N", requires = "summary", conflicts_with = "all", value_parser = value_parsers::within::<u32>(1, 10_000))]
    pub random: Option<u32>,

    /// Shading models, comma-separated [default: one of each engine; of a paint its own]
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = value_parsers::shading)]
    pub models: Vec<ShadingModel>,

    /// Samples of the referee for each value, 256 to 16777216
    #[arg(long, value_name = "N", default_value_t = 4096, value_parser = value_parsers::within::<u32>(256, 1 << 24))]
    pub samples: u32,

    /// Seed of the referee: another one is another, independent series of walks
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u64,

    #[command(flatten)]
    #[allow(missing_docs, reason = "clap would take it for a heading of the help")]
    pub specimen: SpecimenArgs,
    #[command(flatten)]
    #[allow(missing_docs, reason = "clap would take it for a heading of the help")]
    pub workers: ThreadArgs,
    #[command(flatten)]
    #[allow(missing_docs, reason = "clap would take it for a heading of the help")]
    pub report: ReportArgs,
}

/// What is looked at, and how.
#[derive(Debug, Args)]
#[command(next_help_heading = "Specimen")]
pub struct SpecimenArgs {
    /// Angle of the view from the normal in degrees, -89 to 89
    #[arg(long, value_name = "DEGREES", default_value_t = 30.0, allow_negative_numbers = true,
          value_parser = value_parsers::within::<f64>(-89.0, 89.0))]
    pub view: f64,

    /// white (from everywhere), overhead (a soft box of 37.5 degrees around the normal), or the angle of light from one direction in degrees, below 0 on the viewer's side
    #[arg(long, value_name = "white|overhead|DEGREES", default_value = "white", value_parser = light, allow_negative_numbers = true)]
    pub light: Light,

    /// Share of the surface that has a coat, 0 to 1
    #[arg(long, value_name = "SHARE", default_value_t = 1.0, allow_negative_numbers = true,
          value_parser = value_parsers::within::<f64>(0.0, 1.0))]
    pub coat: f64,

    /// Perceptual roughness of the coat, 0 to 1
    #[arg(long, value_name = "ROUGHNESS", default_value_t = 0.1, allow_negative_numbers = true,
          value_parser = value_parsers::within::<f64>(0.0, 1.0))]
    pub coat_roughness: f64,

    /// Index of refraction of the coat, 1 to 3
    #[arg(long, value_name = "INDEX", default_value_t = 1.5, allow_negative_numbers = true,
          value_parser = value_parsers::within::<f64>(1.0, 3.0))]
    pub coat_ior: f64,

    /// Thickness of the coat in units of length [default: 1 with --extinction, else 0]
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true,
          value_parser = value_parsers::within::<f64>(0.0, 1e6))]
    pub thickness: Option<f64>,

    /// Extinction of the coat per unit of length: red, green and blue
    #[arg(long, value_name = "R,G,B", default_value = "0,0,0", value_parser = value_parsers::position)]
    pub extinction: [f64; 3],

    /// Perceptual roughness of what is beneath, 0 to 1
    #[arg(long, value_name = "ROUGHNESS", default_value_t = 0.5, allow_negative_numbers = true,
          value_parser = value_parsers::within::<f64>(0.0, 1.0))]
    pub base_roughness: f64,

    /// What is beneath is a metal
    #[arg(long)]
    pub metal: bool,

    /// Layers of what is no metal: lambert, interface, seen or convention
    #[arg(long, value_name = "NAME", default_value = Base::default().name(), value_parser = base, conflicts_with = "metal")]
    pub base: Base,

    /// Index of refraction of --base interface and seen, 1 to 3 [default: 1.5]
    #[arg(long, value_name = "INDEX", allow_negative_numbers = true, conflicts_with = "metal",
          value_parser = value_parsers::within::<f64>(1.0, 3.0))]
    pub base_ior: Option<f64>,

    /// Reflectance of a metal, else albedo of the diffuse part as --base has it, linear
    #[arg(long, value_name = "R,G,B", default_value = "0.5,0.5,0.5", value_parser = value_parsers::position)]
    pub color: [f64; 3],

    /// Strength of the specular part of what is no metal, 0 to 1; 0 leaves a matt surface
    #[arg(long, value_name = "STRENGTH", default_value_t = 1.0, allow_negative_numbers = true,
          value_parser = value_parsers::within::<f64>(0.0, 1.0))]
    pub specular: f64,
}

impl SpecimenArgs {
    /// Specimen that the options describe.
    pub(super) fn specimen(&self) -> Specimen {
        let absorbs = self.extinction != [0.0; 3];
        Specimen {
            coat: self.coat,
            coat_roughness: self.coat_roughness,
            coat_ior: self.coat_ior,
            thickness: self.thickness.unwrap_or(if absorbs { 1.0 } else { 0.0 }),
            extinction: self.extinction,
            base_roughness: self.base_roughness,
            metal: self.metal,
            base: self.base,
            base_ior: self.base_ior.unwrap_or(Specimen::default().base_ior),
            color: self.color,
            specular: self.specular,
        }
    }
}

impl LabArgs {
    /// The files that are read.
    pub(crate) fn inputs(&self) -> impl Iterator<Item = &Path> {
        let materials = self.paint.iter().chain(&self.material).filter_map(|choice| choice.source.file());
        materials.chain(self.measured.as_deref())
    }

    /// Refuses an index for a base that has none.
    ///
    /// # Errors
    /// [`Failure`] of usage.
    pub(super) fn check(&self) -> Result<(), Failure> {
        let SpecimenArgs { base, base_ior, .. } = self.specimen;
        let varies = [Some(self.over), self.by].contains(&Some(Quantity::BaseIor));
        let option = if varies { "base-ior" } else { "--base-ior" };
        if !base.has_index() && (base_ior.is_some() || varies) {
            let name = base.name();
            return Err(Failure::usage(format!(
                "{option} is that of --base interface or seen; {name} has no index"
            )));
        }
        Ok(())
    }

    /// The models that are asked for.
    pub(super) fn models(&self) -> Vec<ShadingModel> {
        let all = if self.models.is_empty() { DEFAULT_MODELS } else { &self.models };
        all.iter().copied().filter(|model| !self.models.is_empty() || model.is_built()).collect()
    }

    /// Walks of the referee for each value.
    pub(super) fn samples(&self) -> Samples {
        Samples { seed: self.seed, ..Samples::new(self.samples.into()) }
    }

    /// Slice to be measured.
    pub(super) fn slice(&self) -> Slice {
        let [first, last] = self.over.range();
        // What varies needs a light that has it.
        let light = match self.specimen.light {
            Light::White if self.over == Quantity::Light || self.by == Some(Quantity::Light) => {
                Light::Direct(0.0)
            }
            light => light,
        };
        Slice {
            specimen: self.specimen.specimen(),
            view: self.specimen.view,
            light,
            over: self.over,
            range: [self.from.unwrap_or(first), self.to.unwrap_or(last)],
            steps: self.steps as usize,
            models: self.models(),
            samples: self.samples(),
        }
    }
}

fn measured(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    let expected = "expected a measured BRDF: a .binary or .bsdf file".to_owned();
    if is_measured(&path) { Ok(path) } else { Err(expected) }
}

fn quantity(text: &str) -> Result<Quantity, String> {
    let named = Quantity::ALL.iter().find(|quantity| quantity.name() == text);
    named.copied().ok_or_else(|| {
        let names = Quantity::ALL.iter().map(|quantity| quantity.name());
        format!("nothing that can vary{}", suggestion(overcoat_core::suggest::nearest_name(text, names)))
    })
}

fn base(text: &str) -> Result<Base, String> {
    let names = || Base::ALL.iter().map(|base| base.name());
    Base::ALL.iter().copied().find(|base| base.name() == text).ok_or_else(|| {
        let list = names().collect::<Vec<_>>().join(", ");
        format!(
            "no base; there are {list}{}",
            suggestion(overcoat_core::suggest::nearest_name(text, names()))
        )
    })
}

fn light(text: &str) -> Result<Light, String> {
    match text {
        "white" => return Ok(Light::White),
        "overhead" => return Ok(Light::Overhead),
        _ => {}
    }
    let degrees = text.parse().map_err(|_| "neither white, overhead nor a number of degrees".to_owned())?;
    if (-89.0..=89.0).contains(&degrees) {
        Ok(Light::Direct(degrees))
    } else {
        Err("not within -89 to 89 degrees".to_owned())
    }
}
