//! Texture filtering: level of detail, trilinear and anisotropic, over sixteen fragments of one texture.
//!
//! The definitions are Vulkan's (1.3, chapter "Image Operations"), with level-of-detail bias 0 and the switch between
//! magnification and minification at level 0. Footprints come from analytic derivatives of the coordinates before
//! wrapping, so there is no seam line where coordinates wrap and no need of neighbouring fragments. Colours are
//! decoded from sRGB texel by texel, before any interpolation. See `footprint` for anisotropy
//! and its deviations.

mod footprint;
mod mips;
mod rows;
mod texels;

#[cfg(test)]
mod tests;

use footprint::Probes;
pub use mips::Fetched;
use mips::{Mips, Part, TOGETHER};
use overcoat_core::math::lanes::{Float, Lanes, Mask};
use overcoat_scene::Texture;
use texels::Corners;

/// Largest number of textures that [`sample_together`] reads at once.
pub const MAX_TOGETHER: usize = 4;

/// The change of texture coordinates from one pixel to the next.
#[derive(Clone, Copy)]
pub struct Footprint<L: Lanes> {
    /// Change of (u, v) per pixel to the right, before wrapping.
    pub dx: [L::F; 2],
    /// Change of (u, v) per pixel down.
    pub dy: [L::F; 2],
}

/// Linear RGBA, 0 to 1, of a texture at `uv` ((0, 0) is the outer corner of the first texel, v grows with the rows).
///
/// Colours of sRGB textures are decoded. `max_anisotropy` of 1 turns anisotropic filtering off; 16 is the most that
/// counts. Lanes that are not `active` give something finite and may be ignored. Coordinates may have any magnitude;
/// one that is NaN or infinite reads some texel.
#[inline(always)]
pub fn sample<L: Lanes>(
    l: L,
    texture: &Texture,
    uv: [L::F; 2],
    footprint: &Footprint<L>,
    max_anisotropy: u32,
    active: L::M,
) -> [L::F; 4] {
    let mut out = [[l.zero(); 4]];
    sample_together(l, &[texture], &uv, footprint, max_anisotropy, active, &mut out);
    out[0]
}

/// [`sample`] of up to [`MAX_TOGETHER`] textures that are read alike ([`Texture::is_read_like`]), with the same bits, each
/// into its place of `out`: where texels lie and what they weigh is found once. Textures beyond that number, and those
/// without a place, are left out. Lanes that are not `active` may keep what their place held.
#[inline(never)]
pub fn sample_together<L: Lanes>(
    l: L,
    textures: &[&Texture],
    uv: &[L::F; 2],
    footprint: &Footprint<L>,
    max_anisotropy: u32,
    active: L::M,
    out: &mut [[L::F; 4]],
) {
    let Some(&texture) = textures.first() else { return };
    l.run(
        #[inline(always)]
        || {
            let mut plan = SamplePlan::none(l);
            plan.make(l, texture, uv, footprint, max_anisotropy, active);
            plan.ask(textures, active);
            plan.sample(l, textures, &mut Fetched::none(l), out);
        },
    );
}

/// Requests the rows that [`sample_together`] reads, for textures that are read alike and of which only some rows are
/// resident.
#[inline(never)]
pub fn ask_together<L: Lanes>(
    l: L,
    textures: &[&Texture],
    uv: &[L::F; 2],
    footprint: &Footprint<L>,
    max_anisotropy: u32,
    active: L::M,
) {
    let Some(&texture) = textures.first() else { return };
    if texture.bands().is_none() {
        return;
    }
    l.run(
        #[inline(always)]
        || {
            let probes = Probes::new(l, texture, footprint, max_anisotropy, active);
            let mips = Mips::new(l, texture, probes.lambda, active);
            rows::ask(textures, &mips, (uv[1], probes.major[1].abs() * 0.5), active);
        },
    );
}

/// Lookup plan of sixteen fragments for textures that are read alike. It is made before they are read, so that texels
/// can arrive from memory in the meantime.
#[derive(Clone, Copy)]
pub struct SamplePlan<L: Lanes> {
    uv: [L::F; 2],
    probes: Probes<L>,
    mips: Mips<L>,
    /// Texels that the middle of the footprint needs first: usually all that it needs.
    corners: [Corners<L>; TOGETHER],
}

impl<L: Lanes> SamplePlan<L> {
    /// A plan that has no meaning yet.
    #[inline(always)]
    pub fn none(l: L) -> Self {
        Self {
            uv: [l.zero(); 2],
            probes: Probes::one(l, l.zero()),
            mips: Mips::none(l),
            corners: [Corners::none(l); TOGETHER],
        }
    }

    /// Plans how [`sample`] reads `texture`, and all textures that are read like it, in place of the earlier plan. The
    /// arguments are those of that function.
    ///
    /// Like [`SamplePlan::sample`] a function of its own for each instruction set, since it is large and called from many
    /// places.
    #[inline(never)]
    pub fn make(
        &mut self,
        l: L,
        texture: &Texture,
        uv: &[L::F; 2],
        footprint: &Footprint<L>,
        max_anisotropy: u32,
        active: L::M,
    ) {
        l.run(
            #[inline(always)]
            || {
                let probes = Probes::new(l, texture, footprint, max_anisotropy, active);
                let mips = Mips::new(l, texture, probes.lambda, active);
                (self.uv, self.probes, self.mips) = (*uv, probes, mips);
                let wrapped = texels::wrap(texture.sampler(), *uv);
                for (corners, part) in self.corners.iter_mut().zip(self.mips.parts()) {
                    *corners = mips.corners(l, texture, wrapped, *part);
                }
            },
        );
    }

    /// Requests the rows that are read, for textures of which only some are resident.
    #[inline(always)]
    pub fn ask(&self, textures: &[&Texture], active: L::M) {
        if textures.first().is_some_and(|texture| texture.bands().is_some()) {
            let reach = self.probes.major[1].abs() * 0.5;
            rows::ask(textures, &self.mips, (self.uv[1], reach), active);
        }
    }

    /// Texture coordinates of probe `k`. A single probe lies in the middle of the footprint.
    #[inline(always)]
    fn probe(&self, l: L, k: u32) -> [L::F; 2] {
        let Self { uv, probes, .. } = self;
        if probes.most == 1 {
            return *uv;
        }
        let counts = l.splat(k as f32).lt(probes.count);
        let spacing = (probes.count + 1.0).recip();
        // Probe k of N lies at (k + 1) / (N + 1) - 1/2 of the major axis (EXT_texture_filter_anisotropic).
        let along = counts.select(spacing * (k as f32 + 1.0) - 0.5, l.zero());
        [uv[0] + along * probes.major[0], uv[1] + along * probes.major[1]]
    }

    /// Prefetches texels. Changes no result.
    #[inline(always)]
    pub fn prefetch(&self, textures: &[&Texture]) {
        for (corners, &part) in self.corners.iter().zip(self.mips.parts()) {
            // Rows of the coarser level are no further apart than fragments: what is below one is above another.
            let rows = if part == Part::Coarser { 1 } else { 2 };
            corners.prefetch(textures, rows);
        }
    }

    /// Reads textures as [`sample_together`] does, with the texture that the plan was made for, or another that is read like
    /// it, as the first. What `fetched` holds does not matter.
    #[inline(never)]
    pub fn sample(&self, l: L, textures: &[&Texture], fetched: &mut Fetched<L>, out: &mut [[L::F; 4]]) {
        l.run(
            #[inline(always)]
            || self.filter(l, textures, fetched, out),
        );
    }

    #[inline(always)]
    fn filter(&self, l: L, textures: &[&Texture], fetched: &mut Fetched<L>, out: &mut [[L::F; 4]]) {
        let textures = &textures[..textures.len().min(MAX_TOGETHER)];
        let Self { uv, probes, mips, corners } = self;
        let Fetched { parts, probe } = fetched;
        if probes.most == 1 {
            mips.sample(l, textures, *uv, Some(corners), parts, out);
        } else {
            for sum in out.iter_mut() {
                *sum = [l.zero(); 4];
            }
            let weight = probes.count.recip();
            for k in 0..probes.most {
                let counts = l.splat(k as f32).lt(probes.count);
                mips.sample(l, textures, self.probe(l, k), None, parts, probe);
                let weight = counts.select(weight, l.zero());
                for (sum, texel) in out.iter_mut().zip(&*probe) {
                    for n in 0..4 {
                        sum[n] = sum[n] + texel[n] * weight;
                    }
                }
            }
        }
        for (texel, texture) in out.iter_mut().zip(textures) {
            *texel = texels::finish(texture.color_space(), *texel);
        }
    }
}
