//! The model of the house, for files that name no other. Metallic-roughness with the extensions of glTF, put together
//! of the parts that come nearest to a path tracer where the occluders of light are unknown.
//!
//! Source: no engine's. GGX with height-correlated shadowing (Heitz 2014) and Schlick's Fresnel term over Lambert;
//! sheen (Charlie, Estevez and Kulla 2017, with Neubelt's visibility), a thin film (Belcour and Barla 2017, as in
//! glTF's extension) and a coat of index 1.5 above. The layers are put together as in three.js r187 and in the
//! principled material of Blender's Cycles: the layers beneath one are dimmed by its directional albedo for the view.
//!
//! **Use.** [`surface`] once for a vector of fragments, then [`direct()`] for every light and [`indirect()`] for the
//! environment; the sum is the reflected radiance. What the material emits passes the coat:
//! [`Surface::above_coat`].
//!
//! **Radiometry.** The BRDF contains its 1/pi: a light's colour is the irradiance that it delivers at normal incidence.
//! The environment is radiance, its irradiance is given over pi.
//!
//! **Formula.** With E and G the albedos of GGX without weight and weighted with (1 - V.H)^5 for the view
//! ([`super::super::brdf::tables::ggx_albedo`]), F the mean of the Fresnel term over the hemisphere, F0 + (F90 - F0) / 21,
//! and M = 1 / (1 - F (1 - E)) what all bounces between the microfacets add (Turquin 2019, with the mean of Fdez-Aguera
//! 2019: a surface that absorbs nothing then reflects everything):
//!
//! ```text
//! lobe(f)  = M (f0 + (f90 - f0) S(v.h)) D V                   under lights
//!          = M (f0 E mean(L) + (f90 - f0) G mean_S(L))        under an environment
//! a(f)     = M (f0 (E - G) + f90 G)                           its albedo
//! base     = metallic lobe(color, 1) + (1 - metallic) (lobe(f0, f90) + color (1 - a(f0, f90)) irradiance / pi)
//! sheen    = color charlie + (1 - max(color) a_s) base
//! out      = coat lobe(0.04, 1) + (1 - coat + coat (1 - a(0.04, 1)) coat_color^(1 / V'.N)) (sheen + emission)
//! ```
//!
//! mean(L) is the radiance over the whole lobe, by three lookups of the prefiltered environment in place of one
//! (`lobe.rs`): the lobe of a view at an angle is longer in the plane of incidence than across it, and three round ones of a
//! smaller roughness in a row come nearer to it than sixteen samples of its visible normals, and three times as near as one
//! lookup in the mirrored direction. mean_S is weighted with Schlick's term. A brushed surface asks twelve
//! times more along the grain. Sheen takes its albedo times the irradiance at the normal: it is the widest of lobes. (What
//! Charlie's lobe sees about the normal is nearer to the integral of that lobe, and further from the path tracer, whose cloth
//! is another: FLIP 0.230 in place of 0.222 on SheenCloth. The albedo is the integral of the lobe; the fit that three.js has
//! is half of it at a roughness of 0.5.)
//!
//! **Physics.** Under white light from everywhere a surface that absorbs nothing shows 1 for every view, roughness and
//! metalness, with or without coat. Nothing is reciprocal: albedos look at the view only. The coat neither refracts
//! nor changes F0 or roughness of the base, as KHR_materials_clearcoat has it; if it has a colour, which glTF does not know, it absorbs
//! along the refracted way of the view.
//!
//! **Darkening.** With [`SurfaceData::coat_darkening`] at 1 the base's lobes are scaled to the albedo that the adding method of
//! [`super::stacklit_d`] gives them under white light, with all bounces between coat and base and what the coat takes of light on
//! its way in; at 0, the default of glTF, the coat returns nothing, as in Cycles' principled material and most engines. Under
//! lights the Lambertian lobe also has the coat's transmittance for the light over its mean. Lobes keep the shape that they
//! have without a coat.
//!
//! **Left out:** retroreflection, diffuse roughness, polarisation, refraction by the coat. Every result is
//! finite and not negative for inputs in range and unit vectors; of a thin film at most 1 counts.

mod direct;
mod indirect;
mod lobe;

pub use super::EnvironmentQuery;
pub use super::layers::{Anisotropy, Coat, Iridescence, Sheen};
use super::stacklit_d;
pub use direct::direct;
pub use indirect::{Environment, indirect};
pub use lobe::roughness_of_lookups;

use crate::brdf::table::Table;
use crate::brdf::thin_film::{SchlickWeight, ThinFilm, eval_iridescence};
use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_core::math::{ln, pow};
use overcoat_core::vec3;

/// Colour that the model expects of a light per unit of irradiance at normal incidence: the irradiance itself.
pub const LIGHT_COLOR_PER_IRRADIANCE: f32 = 1.0;

/// F0 of the coat: an index of 1.5.
pub const COAT_F0: f32 = 0.04;

/// Index of refraction of the coat.
const COAT_IOR: f32 = 1.5;

/// Least transmittance of a coloured coat whose optical thickness is asked for.
const LEAST_TRANSMITTANCE: f32 = 1e-4;

/// Mean of (1 - u)^5 over the hemisphere.
const MEAN_SCHLICK_WEIGHT: f32 = 1.0 / 21.0;

/// Least perceptual roughness under lights without extent, which a smoother surface would not show at all.
const LEAST_ROUGHNESS: f32 = 0.045;

/// Least perceptual roughness of sheen: Charlie divides by its square.
const LEAST_SHEEN_ROUGHNESS: f32 = 0.07;

/// Sixteen fragments' material. A feature that is `None` costs nothing and is one for all lanes.
#[derive(Clone, Copy)]
pub struct SurfaceData<L: Lanes> {
    /// Base colour, linear, 0 to 1.
    pub color: V3<L>,
    /// 0 dielectric to 1 metal.
    pub metallic: L::F,
    /// Perceptual, 0 to 1.
    pub roughness: L::F,
    /// F0 of the dielectric with its weight, linear, 0 to 1.
    pub dielectric_f0: V3<L>,
    /// Reflectance of the dielectric at grazing angles, 0 to 1: the weight.
    pub dielectric_f90: L::F,
    /// Clear coat.
    pub coat: Option<Coat<L>>,
    /// Transmittance of the coat's medium, down and up at normal incidence, linear, 0 to 1; `None` is clear.
    pub coat_color: Option<V3<L>>,
    /// Share of the darkening by reflection between coat and base, 0 to 1; `None` is 0.
    pub coat_darkening: Option<L::F>,
    /// Perceptual roughness of the base as light that the coat sends back to it meets it, 0 to 1, where that is another than of what
    /// is seen: all flakes are met by what one flake reflects. The base lies as the coat does then.
    pub trapped_roughness: Option<L::F>,
    /// Sheen.
    pub sheen: Option<Sheen<L>>,
    /// Thin film.
    pub iridescence: Option<Iridescence<L>>,
    /// Anisotropic highlights.
    pub anisotropy: Option<Anisotropy<L>>,
}

/// The pre-integrated tables of the model.
#[derive(Clone, Copy)]
pub struct Tables<'a> {
    /// [`super::super::brdf::tables::ggx_albedo`].
    pub ggx: &'a Table<3>,
    /// [`super::super::brdf::tables::filament_dfg`], of which the albedo of Charlie with Neubelt's visibility is read.
    pub cloth: &'a Table<3>,
}

/// A coat as [`surface`] prepares it.
#[derive(Clone, Copy)]
pub struct CoatSurface<L: Lanes> {
    /// 0 none to 1 full.
    pub factor: L::F,
    /// Perceptual, 0 to 1.
    pub roughness: L::F,
    /// Unit normal.
    pub normal: V3<L>,
    /// N.V, saturated.
    pub n_dot_v: L::F,
    /// Its reflection.
    pub reflectance: Reflectance<L>,
    /// Transmittance of the interface for light from beneath, without the medium's colour.
    pub transmittance: L::F,
    /// Transmittance with the medium's colour, if it has one.
    pub tinted: Option<V3<L>>,
    /// Share of the coat that darkens the base, if it does: factor times darkening.
    pub darkening: Option<L::F>,
}

impl<L: Lanes> CoatSurface<L> {
    /// Light from beneath as it leaves the coat towards the eye.
    #[inline(always)]
    fn above(&self, light: V3<L>) -> V3<L> {
        match self.tinted {
            Some(tinted) => light * tinted,
            None => light * self.transmittance,
        }
    }
}

/// Sheen as [`surface`] prepares it.
#[derive(Clone, Copy)]
pub struct SheenSurface<L: Lanes> {
    /// Linear.
    pub color: V3<L>,
    /// Perceptual, in the range of the model.
    pub roughness: L::F,
    /// Directional albedo for the view.
    pub albedo: L::F,
    /// Factor that limits the lobe's albedo to 1, for smooth sheen at grazing angles.
    pub scale: L::F,
    /// Transmittance for light from beneath.
    pub transmittance: L::F,
}

/// Anisotropy as [`surface`] prepares it.
#[derive(Clone, Copy)]
pub struct AnisotropySurface<L: Lanes> {
    /// Alpha along tangent and bitangent.
    pub alpha: [L::F; 2],
    /// Unit vector in the surface, along the larger roughness.
    pub tangent: V3<L>,
    /// Unit vector across both.
    pub bitangent: V3<L>,
    /// Share of the lobe along the grain, from isotropic (0) to half as rough across as along (1).
    pub share: L::F,
}

/// The Fresnel term of an interface, bounces between its facets included: `normal + grazing (1 - V.H)^5`; and the albedos
/// E and G of its facets.
#[derive(Clone, Copy)]
pub struct Reflectance<L: Lanes> {
    /// M F0.
    pub normal: V3<L>,
    /// M (F90 - F0).
    pub grazing: V3<L>,
    /// E.
    pub all: L::F,
    /// G.
    pub at_grazing: L::F,
}

impl<L: Lanes> Reflectance<L> {
    /// Energy-compensated term from F0, F90 and the albedos E and G.
    #[inline(always)]
    fn new(l: L, f0: V3<L>, f90: L::F, [all, at_grazing]: [L::F; 2]) -> Self {
        let to_grazing = Vec3::uniform(f90) - f0;
        let more = all_bounces(l, f0 + to_grazing * MEAN_SCHLICK_WEIGHT, all);
        Self { normal: f0 * more, grazing: to_grazing * more, all, at_grazing }
    }

    /// Albedo for the view.
    #[inline(always)]
    pub fn albedo(&self, _: L) -> V3<L> {
        self.normal * self.all + self.grazing * self.at_grazing
    }
}

/// 1 / (1 - F (1 - E)): all bounces over the first.
#[inline(always)]
fn all_bounces<L: Lanes>(_: L, mean: V3<L>, all: L::F) -> V3<L> {
    let lost = all.one_minus();
    vec3!(f in mean => (f * lost).one_minus().at_least(0.01).recip())
}

/// Everything about sixteen fragments that does not depend on a light.
#[derive(Clone, Copy)]
pub struct Surface<L: Lanes> {
    /// Unit normal of the base.
    pub normal: V3<L>,
    /// Unit vector to the eye.
    pub view: V3<L>,
    /// N.V of the base, saturated.
    pub n_dot_v: L::F,
    /// Perceptual, 0 to 1.
    pub roughness: L::F,
    /// Diffuse albedo: the base colour that specular reflection and metallic leave to Lambert's lobe.
    pub diffuse: V3<L>,
    /// The base's reflection.
    pub reflectance: Reflectance<L>,
    /// The coat, if any lane has one.
    pub coat: Option<CoatSurface<L>>,
    /// Sheen, if any lane has it.
    pub sheen: Option<SheenSurface<L>>,
    /// Anisotropy, if any lane has it.
    pub anisotropy: Option<AnisotropySurface<L>>,
}

impl<L: Lanes> Surface<L> {
    /// Light from beneath the coat, such as the material's emission, as it leaves the coat towards the eye.
    #[inline(always)]
    pub fn above_coat(&self, _: L, light: V3<L>) -> V3<L> {
        match &self.coat {
            Some(coat) => coat.above(light),
            None => light,
        }
    }
}

/// Reflected light by layer.
#[derive(Clone, Copy)]
struct Terms<L: Lanes> {
    /// Lambert and the base's reflection.
    base: V3<L>,
    sheen: V3<L>,
    /// For a factor of 1.
    coat: V3<L>,
}

/// Reflected light of all layers.
#[inline(always)]
fn color<L: Lanes>(_: L, surface: &Surface<L>, terms: &Terms<L>) -> V3<L> {
    let mut out = terms.base;
    if let Some(sheen) = &surface.sheen {
        out = out * sheen.transmittance + terms.sheen;
    }
    if let Some(coat) = &surface.coat {
        out = coat.above(out) + terms.coat * coat.factor;
    }
    out
}

/// E and G for N.V and a perceptual roughness.
#[inline(always)]
fn albedos<L: Lanes>(l: L, table: &Table<3>, n_dot_v: L::F, roughness: L::F) -> [L::F; 2] {
    let [grazing, all] = table.fetch_first(l, n_dot_v.sqrt(), roughness);
    [all, grazing]
}

/// Prepares sixteen fragments: the material and all that depends on the view only.
///
/// `normal` and `view` are unit vectors in one space; `view` points to the eye.
#[inline(always)]
pub fn surface<L: Lanes>(
    l: L,
    data: &SurfaceData<L>,
    normal: V3<L>,
    view: V3<L>,
    tables: Tables<'_>,
) -> Surface<L> {
    let table = tables.ggx;
    let n_dot_v = normal.dot(view).saturate();
    let roughness = data.roughness.saturate();
    let anisotropy = match &data.anisotropy {
        Some(anisotropy) => Some(anisotropy_surface(l, anisotropy, normal, roughness)),
        None => None,
    };
    // Grooves lose as much light as facets of the mean roughness.
    let mean_roughness = match &anisotropy {
        Some(AnisotropySurface { alpha: [along, across], .. }) => (*along * *across).sqrt().sqrt(),
        None => roughness,
    };
    let albedos_of_base = albedos(l, table, n_dot_v, mean_roughness);
    let (mut reflectance, mut left) = base(l, data, n_dot_v, albedos_of_base);
    let mut lambert = Vec3::uniform(data.metallic.saturate().one_minus());
    let sheen = match &data.sheen {
        Some(sheen) => {
            let roughness = sheen.roughness.clamp_to(LEAST_SHEEN_ROUGHNESS, 1.0);
            let [_, _, albedo] = tables.cloth.fetch(l, n_dot_v, roughness);
            let scale = albedo.at_least(1.0).recip();
            let albedo = albedo.clamp_to(0.0, 1.0);
            let transmittance = (sheen.color.max_component() * albedo).one_minus();
            Some(SheenSurface { color: sheen.color, roughness, albedo, scale, transmittance })
        }
        None => None,
    };
    let coat = match &data.coat {
        Some(coat) => {
            let n_dot_v = coat.normal.dot(view).saturate();
            let (factor, roughness) = (coat.factor.saturate(), coat.roughness.saturate());
            let f0 = Vec3::splat(l, [COAT_F0; 3]);
            let reflectance = Reflectance::new(l, f0, l.splat(1.0), albedos(l, table, n_dot_v, roughness));
            let transmittance = (factor * reflectance.albedo(l).x).one_minus().at_least(0.0);
            let tinted = match data.coat_color {
                Some(color) => Some(tinted(l, factor, reflectance.albedo(l).x, color, n_dot_v)),
                None => None,
            };
            let normal = coat.normal;
            let darkening = match data.coat_darkening {
                Some(darkening) => Some(darkening.saturate() * factor),
                None => None,
            };
            Some(CoatSurface {
                factor,
                roughness,
                normal,
                n_dot_v,
                reflectance,
                transmittance,
                tinted,
                darkening,
            })
        }
        None => None,
    };
    if let Some(coat) = &coat
        && let Some(strength) = coat.darkening
    {
        let (roughness, below) = match data.trapped_roughness {
            Some(roughness) => (roughness, coat.normal),
            None => (mean_roughness, normal),
        };
        let darkening = darkening(l, data, coat, roughness, (below, view), table);
        let one = Vec3::splat(l, [1.0; 3]);
        let specular = one.lerp(darkening.specular, strength);
        reflectance.normal *= specular;
        reflectance.grazing *= specular;
        lambert *= one.lerp(darkening.lambert, strength);
        // The colours of a film stay those of the view outside.
        if data.iridescence.is_none() {
            left = left.lerp(darkening.left, strength);
        }
    }
    let diffuse = vec3!(d in data.color * left * lambert => d.at_least(0.0));
    Surface { normal, view, n_dot_v, roughness, diffuse, reflectance, coat, sheen, anisotropy }
}

/// Reflection between coat and base, as [`super::stacklit_d`] sums it.
#[inline(always)]
fn darkening<L: Lanes>(
    l: L,
    data: &SurfaceData<L>,
    coat: &CoatSurface<L>,
    base_roughness: L::F,
    (normal, view): (V3<L>, V3<L>),
    table: &Table<3>,
) -> stacklit_d::Darkening<L> {
    let base = stacklit_d::SurfaceData {
        color: data.color,
        metallic: data.metallic,
        roughness: base_roughness,
        dielectric_f0: data.dielectric_f0,
        dielectric_f90: data.dielectric_f90,
        coat: None,
        anisotropy: None,
        trapped_roughness: None,
    };
    let above = stacklit_d::Coat {
        mask: coat.factor,
        roughness: coat.roughness,
        ior: l.splat(COAT_IOR),
        // The colour is that of a way down and up.
        depth: match data.coat_color {
            Some(color) => Some(vec3!(c in color => ln(l, c.at_least(LEAST_TRANSMITTANCE)) * -0.5)),
            None => None,
        },
        normal: coat.normal,
    };
    stacklit_d::Darkening::new(l, &base, &above, normal, view, table)
}

/// Transmittance of a coloured coat of this albedo: the colour to the power of the relative length of the refracted
/// path, out and, as an approximation, in.
#[inline(always)]
fn tinted<L: Lanes>(l: L, factor: L::F, albedo: L::F, color: V3<L>, n_dot_v: L::F) -> V3<L> {
    let sine2 = n_dot_v.squared().one_minus() * (1.0 / (COAT_IOR * COAT_IOR));
    let longer = sine2.one_minus().at_least(0.1).sqrt().recip();
    let passed = albedo.one_minus().at_least(0.0);
    vec3!(c in color => pow(l, c.saturate(), longer) * passed * factor + factor.one_minus())
}

/// The base's reflection, and the share that it leaves to the Lambertian lobe.
#[inline(always)]
fn base<L: Lanes>(l: L, data: &SurfaceData<L>, n_dot_v: L::F, albedos: [L::F; 2]) -> (Reflectance<L>, V3<L>) {
    let metallic = data.metallic.saturate();
    let mut dielectric = Reflectance::new(l, data.dielectric_f0, data.dielectric_f90, albedos);
    let mut metal = Reflectance::new(l, data.color, l.splat(1.0), albedos);
    let mut beneath = dielectric.albedo(l).one_minus();
    if let Some(film) = &data.iridescence {
        let factor = film.thickness.eq(l.zero()).select(l.zero(), film.factor.saturate());
        let film = ThinFilm { ior: film.ior, thickness: film.thickness };
        let bases = [data.dielectric_f0, data.color];
        let [on_dielectric, on_metal] = eval_iridescence(l, SchlickWeight::Power, &film, n_dot_v, &bases);
        dielectric = filmed(l, &dielectric, on_dielectric, factor);
        metal = filmed(l, &metal, on_metal, factor);
        // The share that no channel reflects: interference takes nothing away.
        let rest = Vec3::uniform(dielectric.albedo(l).max_component().one_minus());
        beneath = beneath.lerp(rest, factor);
    }
    let reflectance = Reflectance {
        normal: dielectric.normal.lerp(metal.normal, metallic),
        grazing: dielectric.grazing.lerp(metal.grazing, metallic),
        ..dielectric
    };
    (reflectance, beneath)
}

/// A reflectance with a film of this reflectance for the view.
#[inline(always)]
fn filmed<L: Lanes>(l: L, bare: &Reflectance<L>, film: V3<L>, factor: L::F) -> Reflectance<L> {
    let film = vec3!(f in film => f.saturate());
    let film = film * all_bounces(l, film, bare.all);
    Reflectance {
        normal: bare.normal.lerp(film, factor),
        grazing: bare.grazing * factor.one_minus(),
        ..*bare
    }
}

/// Alphas and axes; the tangent is brought into the surface.
#[inline(always)]
fn anisotropy_surface<L: Lanes>(
    l: L,
    anisotropy: &Anisotropy<L>,
    normal: V3<L>,
    roughness: L::F,
) -> AnisotropySurface<L> {
    let strength2 = anisotropy.strength.saturate().squared();
    let across = (roughness * roughness).at_least(LEAST_ROUGHNESS * LEAST_ROUGHNESS);
    let along = across * strength2.one_minus() + strength2;
    let flat = anisotropy.tangent - normal * anisotropy.tangent.dot(normal);
    let tangent = super::glsl::normalize_or(l, flat, anisotropy.tangent);
    let share = ((across / along).one_minus() * 2.0).saturate();
    AnisotropySurface { alpha: [along, across], tangent, bitangent: normal.cross(tangent), share }
}
