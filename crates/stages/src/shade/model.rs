//! Interface between shading models and the renderer, and the loops over lights and surroundings that all models share.
//!
//! A model reads a surface once ([`Model::layers`]) and then answers two questions: what it reflects of one light without
//! extent ([`Model::direct`]), and what of one of its surroundings ([`Model::indirect`]), which it asks for averages over lobes
//! by way of [`Source`]. Most are [`AdditiveModel`]s; those that compose diffuse and specular light apart have a sum of their own.

use super::incident::{Surroundings, arriving_light, sheen_radiance};
use super::lamps::LampOcclusion;
use super::occlusion::LightOcclusion;
use super::transmission::shaded_color;
use super::variation::{NormalFilter, NormalFiltering, shaded_roughness};
use super::{ShadeContext, Surface, paint};
use crate::gbuffer::layout::SurfacePlanes;
use crate::light::LightSample;
use overcoat_core::math::lanes::Lanes;
use overcoat_core::math::vec3::{V3, Vec3};
use overcoat_scene::Material;
use overcoat_shading::coat::EnvironmentQuery;
use std::f32::consts::PI;

/// One engine's formulas. Versions of an engine are values of one type: a copy of the kernel for each would be that many times
/// the code.
///
/// Lights come as irradiance E at normal incidence, the environment as radiance and as irradiance over pi; a white Lambert
/// surface that E falls on shows E / pi in every model.
pub(super) trait Model: Copy {
    /// The surface in the engine's terms, with what does not depend on light.
    type Layers<L: Lanes>;
    /// Light so far.
    type Sum<L: Lanes>;
    /// True if more is read of a material than base, coat and emission.
    const READS_LOBES: bool = true;
    /// Lights are added before surroundings; else after.
    const LIGHTS_FIRST: bool = false;

    /// Cost of a fragment, in units of about a nanosecond: of a base without layers under the environment, of one with
    /// coat, sheen, thin film and the rest, and what each light without extent adds to the one and to the other.
    fn cost(self) -> [u64; 4];

    /// Filter by which the roughness of base and coat grows where normals vary within a pixel.
    fn normal_filtering(self) -> NormalFiltering {
        NormalFiltering::Asked(NormalFilter::TOKUYOSHI)
    }

    /// Reads the material and the surface.
    fn layers<L: Lanes>(self, l: L, material: &Material, surface: &Surface<L>) -> Self::Layers<L>;

    /// Sum before any light: emission, where it is the first term.
    fn begin<L: Lanes>(self, l: L, layers: &Self::Layers<L>, surface: &Surface<L>) -> Self::Sum<L>;

    /// Adds what is reflected of one light without extent.
    fn direct<L: Lanes>(
        self,
        l: L,
        layers: &Self::Layers<L>,
        light: &LightSample<L>,
        sum: Self::Sum<L>,
    ) -> Self::Sum<L>;

    /// Adds what is reflected of one of the surroundings.
    fn indirect<L: Lanes>(
        self,
        l: L,
        layers: &Self::Layers<L>,
        source: &Source<'_, L>,
        sum: Self::Sum<L>,
    ) -> Self::Sum<L>;

    /// The radiance that all this comes to.
    fn finish<L: Lanes>(
        self,
        l: L,
        layers: &Self::Layers<L>,
        surface: &Surface<L>,
        sum: Self::Sum<L>,
    ) -> V3<L>;
}

/// A [`Model`] whose radiance is a plain sum: emission, then each of the surroundings, then each light.
pub(super) trait AdditiveModel: Copy {
    /// As [`Model::Layers`].
    type Layers<L: Lanes>;
    /// As [`Model::READS_LOBES`].
    const READS_LOBES: bool = true;
    /// Emission is the last of the sum and not the first: the order decides about the last bit.
    const EMISSION_LAST: bool = false;

    /// As [`Model::cost`].
    fn cost(self) -> [u64; 4];

    /// As [`Model::normal_filtering`].
    fn normal_filtering(self) -> NormalFiltering {
        NormalFiltering::Asked(NormalFilter::TOKUYOSHI)
    }

    /// As [`Model::layers`].
    fn layers<L: Lanes>(self, l: L, material: &Material, surface: &Surface<L>) -> Self::Layers<L>;

    /// Radiance that the surface emits, through its layers.
    #[inline(always)]
    fn emission<L: Lanes>(self, _: L, _: &Self::Layers<L>, surface: &Surface<L>) -> V3<L> {
        surface.emissive
    }

    /// Light reflected of one light without extent.
    fn direct<L: Lanes>(self, l: L, layers: &Self::Layers<L>, light: &LightSample<L>) -> V3<L>;

    /// Light reflected of one of the surroundings.
    fn indirect<L: Lanes>(self, l: L, layers: &Self::Layers<L>, source: &Source<'_, L>) -> V3<L>;
}

impl<A: AdditiveModel> Model for A {
    type Layers<L: Lanes> = A::Layers<L>;
    type Sum<L: Lanes> = V3<L>;
    const READS_LOBES: bool = A::READS_LOBES;

    fn cost(self) -> [u64; 4] {
        AdditiveModel::cost(self)
    }

    fn normal_filtering(self) -> NormalFiltering {
        AdditiveModel::normal_filtering(self)
    }

    #[inline(always)]
    fn layers<L: Lanes>(self, l: L, material: &Material, surface: &Surface<L>) -> A::Layers<L> {
        AdditiveModel::layers(self, l, material, surface)
    }

    #[inline(always)]
    fn begin<L: Lanes>(self, l: L, layers: &A::Layers<L>, surface: &Surface<L>) -> V3<L> {
        if A::EMISSION_LAST { Vec3::zero(l) } else { self.emission(l, layers, surface) }
    }

    #[inline(always)]
    fn direct<L: Lanes>(self, l: L, layers: &A::Layers<L>, light: &LightSample<L>, sum: V3<L>) -> V3<L> {
        sum + AdditiveModel::direct(self, l, layers, light)
    }

    #[inline(always)]
    fn indirect<L: Lanes>(self, l: L, layers: &A::Layers<L>, source: &Source<'_, L>, sum: V3<L>) -> V3<L> {
        sum + AdditiveModel::indirect(self, l, layers, source)
    }

    #[inline(always)]
    fn finish<L: Lanes>(self, l: L, layers: &A::Layers<L>, surface: &Surface<L>, sum: V3<L>) -> V3<L> {
        if A::EMISSION_LAST { sum + self.emission(l, layers, surface) } else { sum }
    }
}

/// One of what surrounds a surface, as a model asks about it.
pub(super) struct Source<'a, L: Lanes> {
    pub(super) surroundings: Surroundings,
    pub(super) context: &'a ShadeContext<'a>,
    pub(super) material: &'a Material,
    pub(super) surface: &'a Surface<L>,
    pub(super) planes: &'a SurfacePlanes,
}

impl<L: Lanes> Source<'_, L> {
    /// Light from afar; else rectangles and tubes.
    #[inline(always)]
    pub(super) fn is_environment(&self) -> bool {
        self.surroundings == Surroundings::Environment
    }

    /// True if its occlusion is known.
    #[inline(always)]
    fn is_blocked(&self) -> bool {
        if self.is_environment() { self.context.has_maps() } else { self.context.lamps.is_some() }
    }

    /// Irradiance over pi on a surface of this unit normal.
    #[inline(always)]
    pub(super) fn irradiance_over_pi(&self, l: L, normal: V3<L>) -> V3<L> {
        let unoccluded = self.surroundings.irradiance_over_pi(l, self.context, self.surface, normal);
        if !self.is_blocked() {
            unoccluded
        } else if self.is_environment() {
            LightOcclusion::irradiance(l, self.planes, unoccluded)
        } else {
            LampOcclusion::irradiance(l, self.planes, unoccluded)
        }
    }

    /// Irradiance on a surface of this unit normal.
    #[inline(always)]
    pub(super) fn irradiance(&self, l: L, normal: V3<L>) -> V3<L> {
        self.irradiance_over_pi(l, normal) * PI
    }

    /// The average of radiance over a lobe.
    #[inline(always)]
    pub(super) fn radiance(&self, l: L, query: EnvironmentQuery<L>) -> V3<L> {
        let unoccluded = self.surroundings.radiance(l, self.context, self.material, self.surface, query);
        if !self.is_blocked() {
            unoccluded
        } else if self.is_environment() {
            LightOcclusion::radiance(l, self.planes, self.material, &query, unoccluded)
        } else {
            LampOcclusion::radiance(l, self.planes, self.material, &query, unoccluded)
        }
    }

    /// [`Source::irradiance`] as models take it.
    #[inline(always)]
    pub(super) fn irradiance_lookup(&self, l: L) -> impl Fn(V3<L>) -> V3<L> {
        #[inline(always)]
        move |normal| self.irradiance(l, normal)
    }

    /// [`Source::radiance`] as models take it.
    #[inline(always)]
    pub(super) fn radiance_lookup(&self, l: L) -> impl Fn(EnvironmentQuery<L>) -> V3<L> {
        #[inline(always)]
        move |query| self.radiance(l, query)
    }

    /// The average of radiance over the lobe of cloth of a roughness, about a direction. As much of it is blocked as of the
    /// irradiance: it is nearly as wide.
    #[inline(always)]
    pub(super) fn sheen_radiance(&self, l: L, query: EnvironmentQuery<L>) -> V3<L> {
        if !self.is_environment() {
            return self.radiance(l, query);
        }
        let unoccluded = sheen_radiance(l, self.context, self.material, self.surface.vertex_normal, query);
        if self.is_blocked() { LightOcclusion::irradiance(l, self.planes, unoccluded) } else { unoccluded }
    }

    /// [`Source::sheen_radiance`] as models take it.
    #[inline(always)]
    pub(super) fn sheen_lookup(&self, l: L) -> impl Fn(EnvironmentQuery<L>) -> V3<L> {
        #[inline(always)]
        move |query| self.sheen_radiance(l, query)
    }

    /// Share of it that reaches the surface, 0 to 1.
    #[inline(always)]
    pub(super) fn occlusion(&self, l: L) -> L::F {
        self.surroundings.occlusion(l, self.surface)
    }

    /// The same, with reflections of area lights integrated over the lobe's facets.
    #[inline(always)]
    pub(super) fn by_facets(&self) -> Self {
        let surroundings =
            if self.is_environment() { self.surroundings } else { Surroundings::AreaLightsByFacets };
        Self { surroundings, ..*self }
    }
}

/// The radiance of sixteen fragments: one function for each model and instruction set.
#[inline(never)]
pub(super) fn radiance<L: Lanes, M: Model>(
    l: L,
    model: M,
    context: &ShadeContext<'_>,
    material: &Material,
    planes: &SurfacePlanes,
) -> V3<L> {
    l.run(
        #[inline(always)]
        || {
            let mixed = paint::is_mixed(material);
            let mix = if mixed { Some(paint::Mix::new(l, material, planes)) } else { None };
            let mut total = Vec3::zero(l);
            // Loops, so that a model's code is compiled once.
            for which in 0..paint::SURFACES {
                let part = match &mix {
                    Some(mix) => mix.part(l, which),
                    None => None,
                };
                if mixed && part.is_none() {
                    continue;
                }
                let [under_lamps, under_rest] = part.as_ref().map_or([true; 2], |part| part.is_seen(l));
                if mixed && !under_rest && context.lights.is_empty() {
                    continue;
                }
                let mut surface =
                    Surface::load_with(l, material, M::READS_LOBES, planes, shaded_color(material));
                if context.has_maps() {
                    // What occlusion textures guess is known.
                    surface.occlusion = l.splat(1.0);
                    surface.lobes.specular_occlusion = l.splat(1.0);
                    surface.bent_normal = surface.normal;
                }
                [surface.roughness, surface.coat_roughness] = shaded_roughness(l, context, material, planes);
                if let Some(part) = &part {
                    part.apply(l, planes, &mut surface);
                }
                let layers = model.layers(l, material, &surface);
                let mut sum = model.begin(l, &layers, &surface);
                if M::LIGHTS_FIRST && under_lamps {
                    sum = add_lights(l, model, context, (material, planes), &surface, &layers, sum);
                    if let Some(part) = &part {
                        total += of_lights(l, model, &surface, &layers, sum) * part.shares[0];
                        sum = model.begin(l, &layers, &surface);
                    }
                }
                if under_rest {
                    for &surroundings in Surroundings::of(context) {
                        let source = Source { surroundings, context, material, surface: &surface, planes };
                        sum = model.indirect(l, &layers, &source, sum);
                    }
                }
                if let Some(part) = &part {
                    total += model.finish(l, &layers, &surface, sum) * part.shares[1];
                    sum = model.begin(l, &layers, &surface);
                }
                if !M::LIGHTS_FIRST && under_lamps {
                    sum = add_lights(l, model, context, (material, planes), &surface, &layers, sum);
                    if let Some(part) = &part {
                        total += of_lights(l, model, &surface, &layers, sum) * part.shares[0];
                        continue;
                    }
                }
                if !mixed {
                    return model.finish(l, &layers, &surface, sum);
                }
            }
            total
        },
    )
}

/// Radiance of a sum that the lights without extent alone were added to, without emission.
#[inline(always)]
fn of_lights<L: Lanes, M: Model>(
    l: L,
    model: M,
    surface: &Surface<L>,
    layers: &M::Layers<L>,
    sum: M::Sum<L>,
) -> V3<L> {
    let emission = model.finish(l, layers, surface, model.begin(l, layers, surface));
    model.finish(l, layers, surface, sum) - emission
}

/// Adds the lights without extent, in their order.
#[inline(always)]
fn add_lights<L: Lanes, M: Model>(
    l: L,
    model: M,
    context: &ShadeContext<'_>,
    (material, planes): (&Material, &SurfacePlanes),
    surface: &Surface<L>,
    layers: &M::Layers<L>,
    mut sum: M::Sum<L>,
) -> M::Sum<L> {
    for light in context.lights {
        let sample = arriving_light(l, context, material, light, surface.position, planes);
        sum = model.direct(l, layers, &sample, sum);
    }
    sum
}
