//! Reads the textures of a material for a batch of fragments.

use super::ShadeContext;
use crate::gbuffer::texture::{Fetched, Footprint, MAX_TOGETHER, SamplePlan, ask_together, sample};
use crate::gbuffer::{Batch, Location};
use overcoat_core::each;
use overcoat_core::math::lanes::Lanes;
use overcoat_scene::{Texture, TextureRef, UvTransform};

/// Texture coordinates of a batch and their footprints, for the sets that the material uses.
pub(super) struct Coordinates<L: Lanes> {
    pub(super) uv: [[L::F; 2]; 2],
    derivatives: [[[L::F; 2]; 2]; 2],
}

impl<L: Lanes> Coordinates<L> {
    /// Coordinates of a material that reads no textures.
    #[inline(always)]
    pub(super) fn none(l: L) -> Self {
        let zero = [l.zero(); 2];
        Self { uv: [zero; 2], derivatives: [[zero; 2]; 2] }
    }
}

/// Reads textures for one batch.
pub(super) struct Reader<'a, L: Lanes> {
    l: L,
    context: &'a ShadeContext<'a>,
    coordinates: &'a Coordinates<L>,
    active: L::M,
}

impl<'a, L: Lanes> Reader<'a, L> {
    #[inline(always)]
    pub(super) fn new(
        l: L,
        context: &'a ShadeContext<'a>,
        coordinates: &'a Coordinates<L>,
        batch: &Batch,
    ) -> Self {
        Self { l, context, coordinates, active: l.mask(batch.active()) }
    }

    #[inline(always)]
    pub(super) fn read(&self, texture: &TextureRef) -> [L::F; 4] {
        let (uv, footprint) = self.place(texture);
        let of = &self.context.textures[texture.texture.index()];
        sample(self.l, of, uv, &footprint, self.context.anisotropy, self.active)
    }

    /// Plans how the textures of a plan are read, a group in each place of `samples`, and prefetches their texels.
    #[inline(always)]
    pub(super) fn plan_samples<const N: usize>(
        &self,
        plan: &ReadingPlan<'_, N>,
        samples: &mut [SamplePlan<L>; N],
    ) {
        let anisotropy = self.context.anisotropy;
        for (group, sample) in plan.groups.iter().flatten().zip(samples) {
            let (uv, footprint) = self.place(group.first);
            sample.make(self.l, group.textures[0], &uv, &footprint, anisotropy, self.active);
            sample.ask(&group.textures[..group.len], self.active);
            sample.prefetch(&group.textures[..group.len]);
        }
    }

    /// Requests the levels that [`Reader::read`] reads of a texture, and reads none.
    #[inline(always)]
    pub(super) fn ask(&self, texture: &TextureRef) {
        let of = &self.context.textures[texture.texture.index()];
        if of.bands().is_some() {
            let (uv, footprint) = self.place(texture);
            ask_together(self.l, &[of], &uv, &footprint, self.context.anisotropy, self.active);
        }
    }

    /// Requests the texels that [`ReadingPlan::read`] reads.
    #[inline(always)]
    pub(super) fn ask_for_plan<const N: usize>(&self, plan: &ReadingPlan<'_, N>) {
        for group in plan.groups.iter().flatten() {
            let (uv, footprint) = self.place(group.first);
            let textures = &group.textures[..group.len];
            ask_together(self.l, textures, &uv, &footprint, self.context.anisotropy, self.active);
        }
    }

    /// Coordinates at which a texture is read, and its footprint there.
    #[inline(always)]
    fn place(&self, texture: &TextureRef) -> ([L::F; 2], Footprint<L>) {
        let set = usize::from(texture.uv_set & 1);
        let mut uv = self.coordinates.uv[set];
        let [mut dx, mut dy] = self.coordinates.derivatives[set];
        if texture.transform != UvTransform::IDENTITY {
            let rows = texture.transform.rows;
            uv = each!(r in rows => uv[0] * r[0] + uv[1] * r[1] + r[2]);
            dx = each!(r in rows => dx[0] * r[0] + dx[1] * r[1]);
            dy = each!(r in rows => dy[0] * r[0] + dy[1] * r[1]);
        }
        (uv, Footprint { dx, dy })
    }

    /// A texture times its factors, or the factors alone.
    #[inline(always)]
    pub(super) fn factor<const N: usize>(
        &self,
        factors: [f32; N],
        texture: Option<&TextureRef>,
        channels: [usize; N],
    ) -> [L::F; N] {
        match texture {
            Some(texture) => {
                let texel = self.read(texture);
                each!(n => texel[channels[n]] * factors[n])
            }
            None => each!(f in factors => self.l.splat(f)),
        }
    }
}

/// Textures in places of a material, in groups that are read in one go: those that are read alike, each once if it stands
/// in several places. Found once for many batches.
#[derive(Debug)]
pub(super) struct ReadingPlan<'a, const N: usize> {
    groups: [Option<Group<'a>>; N],
    /// Slot of each place's texel; of places without a texture it has no meaning.
    pub(super) slots: [usize; N],
}

/// Textures that are read at the same places with the same weights.
#[derive(Clone, Copy, Debug)]
struct Group<'a> {
    first: &'a TextureRef,
    textures: [&'a Texture; MAX_TOGETHER],
    /// Number of textures, from 1.
    len: usize,
}

impl<'a, const N: usize> ReadingPlan<'a, N> {
    pub(super) fn new(places: [Option<&'a TextureRef>; N], textures: &'a [Texture]) -> Self {
        let mut rest = places;
        let mut plan = Self { groups: [None; N], slots: [0; N] };
        let mut used = 0;
        for group in &mut plan.groups {
            let Some(taken) = Group::take(&mut rest, textures, used, &mut plan.slots) else { break };
            used += taken.len;
            *group = Some(taken);
        }
        plan
    }

    /// All textures, as [`Reader::plan_samples`] found: the texel of place `k` goes to `slots[k]`.
    #[inline(always)]
    pub(super) fn read<L: Lanes>(
        &self,
        l: L,
        samples: &[SamplePlan<L>; N],
        fetched: &mut Fetched<L>,
        texels: &mut [[L::F; 4]; N],
    ) {
        let mut rest = &mut texels[..];
        for (group, sample) in self.groups.iter().flatten().zip(samples) {
            let (out, others) = rest.split_at_mut(group.len.min(rest.len()));
            sample.sample(l, &group.textures[..group.len], fetched, out);
            rest = others;
        }
    }
}

impl<'a> Group<'a> {
    /// Takes the first texture of the `rest` and those that are read like it; the first goes into slot `start`.
    fn take<const N: usize>(
        rest: &mut [Option<&'a TextureRef>; N],
        textures: &'a [Texture],
        start: usize,
        slots: &mut [usize; N],
    ) -> Option<Self> {
        let place = rest.iter().position(Option::is_some)?;
        let first = rest[place].take()?;
        slots[place] = start;
        let of_first = &textures[first.texture.index()];
        let mut group = Self { first, textures: [of_first; MAX_TOGETHER], len: 1 };
        for (place, slot) in rest.iter_mut().zip(slots).skip(place + 1) {
            let Some(other) = *place else { continue };
            let of_other = &textures[other.texture.index()];
            if (other.uv_set, other.transform) != (first.uv_set, first.transform)
                || !of_other.is_read_like(of_first)
            {
                continue;
            }
            let mut known = group.textures[..group.len].iter();
            let index = match known.position(|texture| std::ptr::eq(*texture, of_other)) {
                Some(index) => index,
                None if group.len < MAX_TOGETHER => {
                    group.textures[group.len] = of_other;
                    group.len += 1;
                    group.len - 1
                }
                None => continue,
            };
            (*place, *slot) = (None, start + index);
        }
        Some(group)
    }
}

/// Texture coordinates at the fragments; only the sets that the material reads are fetched.
#[inline(always)]
pub(super) fn coordinates<L: Lanes>(
    l: L,
    context: &ShadeContext<'_>,
    batch: &Batch,
    location: &Location<L>,
) -> Coordinates<L> {
    let mut out = Coordinates::none(l);
    // All lanes have one material.
    let sets = context.draws[batch.vertices.draw(0) as usize].uv_sets;
    for set in 0..2 {
        if sets[set] {
            let vertices = batch.vertices.attribute(
                l,
                context.draws,
                [0.0; 2],
                if set == 0 { |m| m.uvs(0) } else { |m| m.uvs(1) },
            );
            out.uv[set] = location.interpolate(&vertices);
            out.derivatives[set] = location.derivatives(&vertices);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use overcoat_scene::{AlphaUse, ColorSpace, Image, Sampler, TextureId, Wrap};
    use std::sync::Arc;

    fn texture(width: u32, wrap_u: Wrap) -> Texture {
        let image = Image::new(width, 2, vec![[9; 4]; 2 * width as usize]).unwrap();
        let sampler = Sampler { wrap_u, ..Sampler::default() };
        Texture::new(Arc::new(image), ColorSpace::Linear, AlphaUse::Data, sampler)
    }

    fn by(texture: u32) -> TextureRef {
        TextureRef { texture: TextureId::from_index(texture), uv_set: 0, transform: UvTransform::IDENTITY }
    }

    /// The slot and the number of the group of each place that has a texture. What stands in the slot is held to be the
    /// texture of the place.
    fn plan<const N: usize>(
        textures: &[Texture],
        places: [Option<TextureRef>; N],
    ) -> [Option<(usize, usize)>; N] {
        let plan = ReadingPlan::new(places.each_ref().map(Option::as_ref), textures);
        let mut in_slots = Vec::new();
        for (number, group) in plan.groups.iter().flatten().enumerate() {
            in_slots.extend(group.textures[..group.len].iter().map(|texture| (number, *texture)));
        }
        assert!(in_slots.len() <= N);
        std::array::from_fn(|k| {
            let place = places[k].as_ref()?;
            let (number, texture) = in_slots[plan.slots[k]];
            assert!(std::ptr::eq(texture, &textures[place.texture.index()]));
            Some((plan.slots[k], number))
        })
    }

    #[test]
    fn textures_of_one_size_sampler_and_place_are_one_group() {
        let textures = [texture(4, Wrap::Repeat), texture(4, Wrap::Repeat), texture(8, Wrap::Repeat)];
        let places = [Some(by(1)), None, Some(by(0)), Some(by(2)), Some(by(1))];
        assert_eq!(plan(&textures, places), [Some((0, 0)), None, Some((1, 0)), Some((2, 1)), Some((0, 0))]);
        assert_eq!(plan(&textures, [None; 3]), [None; 3]);
    }

    #[test]
    fn another_sampler_set_or_transform_is_another_group() {
        let textures = [texture(4, Wrap::Repeat), texture(4, Wrap::ClampToEdge)];
        let shifted = UvTransform { rows: [[1.0, 0.0, 0.5], [0.0, 1.0, 0.0]] };
        let places = [
            Some(by(0)),
            Some(by(1)),
            Some(TextureRef { uv_set: 1, ..by(0) }),
            Some(TextureRef { transform: shifted, ..by(0) }),
        ];
        assert_eq!(plan(&textures, places), [Some((0, 0)), Some((1, 1)), Some((2, 2)), Some((3, 3))]);
    }

    #[test]
    fn groups_are_limited_and_every_place_is_in_one() {
        let textures = [(); 6].map(|()| texture(4, Wrap::Repeat));
        let places = [0, 1, 2, 3, 4, 5, 5, 0].map(|k| Some(by(k)));
        let expected = [(0, 0), (1, 0), (2, 0), (3, 0), (4, 1), (5, 1), (5, 1), (0, 0)];
        assert_eq!(plan(&textures, places), expected.map(Some));
        // A transform that does not equal itself ends as well.
        let transform = UvTransform { rows: [[f32::NAN; 3]; 2] };
        let broken = [Some(TextureRef { transform, ..by(0) }); 3];
        assert_eq!(plan(&textures, broken), [Some((0, 0)), Some((1, 1)), Some((2, 2))]);
    }
}
