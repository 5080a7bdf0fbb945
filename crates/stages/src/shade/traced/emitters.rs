//! Surfaces that shine: light that is looked for where it comes from. A lamp that is small beside what it lights is met by few of
//! a lobe's rays, and each of those outshines all others; rays to points of it are all of the same worth.

use super::{TraceScratch, TracedLight};
use crate::bvh::Ray;
use crate::shade::ShadeContext;
use overcoat_core::math::lanes::Lanes;
use overcoat_core::math::triple::{difference, dot};
use overcoat_scene::Material;
use std::f32::consts::{FRAC_1_PI, TAU};

/// More triangles than these are left to the rays of lobes: there is light everywhere then.
const MOST: usize = 1024;

/// Surfaces of one material that are together larger than this part of the box around the scene are left to them as well: they are
/// met often, and much of them cannot be seen from one place.
const LARGEST: f32 = 0.02;

/// Largest radiance that a ray of a wide reflection brings of a lamp: diffuse light has all of it, and a few such rays
/// would show as single bright pixels.
const BRIGHTEST: f32 = 4.0;

/// Fractional parts of multiples of the inverse powers of the root of x^4 = x + 1, in units of 2^-32: points of low discrepancy in
/// three dimensions (Roberts 2018, "The unreasonable effectiveness of quasirandom sequences").
const STEPS: [u32; 3] = [0xd1b5_4a33, 0xabc9_8389, 0x8cb9_2ba7];

/// Triangles that shine, with the sums of their powers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Emitters {
    triangles: Vec<Emitter>,
    /// Sum of all powers.
    power: f32,
    /// For each material, the area of its surfaces as long as they are counted, and then whether it is looked for: 1 or 0.
    materials: Vec<f32>,
}

/// A triangle that shines.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Emitter {
    corner: [f32; 3],
    edges: [[f32; 3]; 2],
    /// Unit normal, on the side that shines.
    normal: [f32; 3],
    area: f32,
    two_sided: bool,
    /// Radiance in units of its largest part.
    color: [f32; 3],
    /// Sum of largest radiance times area up to here.
    power: f32,
}

impl Emitters {
    /// True if a material shines all over alike.
    #[must_use]
    pub fn shines(material: &Material) -> bool {
        material.emissive != [0.0; 3] && material.emissive_texture.is_none() && !material.unlit
    }

    /// Forgets all, for a scene of so many materials.
    pub fn clear(&mut self, materials: usize) {
        self.power = 0.0;
        self.triangles.clear();
        self.materials.clear();
        self.materials.resize(materials, 0.0);
    }

    /// True if nothing is looked for.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    /// True if surfaces of a material are looked for.
    #[inline(always)]
    pub(super) fn has(&self, material: u32) -> bool {
        !self.is_empty() && self.materials[material as usize] > 0.0
    }

    /// Counts the area of a triangle of a material that shines.
    pub fn count(&mut self, corners: &[[f32; 3]; 3], material: usize) {
        self.materials[material] += 0.5 * cross(corners).1;
    }

    /// Leaves out materials whose surfaces are large beside a box of this area.
    pub fn choose(&mut self, box_area: f32) {
        for area in &mut self.materials {
            *area = if *area > 0.0 && *area <= LARGEST * box_area { 1.0 } else { 0.0 };
        }
    }

    /// Adds a triangle of a material that is not left out, whose corners are counter-clockwise seen from the side that shines. False
    /// if there are too many: none is listed then.
    pub fn add(&mut self, corners: &[[f32; 3]; 3], number: usize, material: &Material) -> bool {
        let (edges, length, cross) = {
            let (cross, length) = cross(corners);
            let [a, b, c] = *corners;
            ([difference(b, a), difference(c, a)], length, cross)
        };
        let largest = material.emissive.iter().fold(0.0_f32, |m, v| if *v > m { *v } else { m });
        let power = self.power + 0.5 * length * largest;
        // Nothing that has no side, and no sum that is no number.
        let counts = length > 0.0 && power > self.power && power < f32::MAX;
        if self.materials[number] == 0.0 || !counts {
            return true;
        }
        if self.triangles.len() == MOST {
            self.clear(self.materials.len());
            return false;
        }
        self.power = power;
        self.triangles.push(Emitter {
            corner: corners[0],
            edges,
            normal: cross.map(|v| v / length),
            area: 0.5 * length,
            two_sided: material.double_sided,
            color: material.emissive.map(|v| v / largest),
            power,
        });
        true
    }

    /// Radiance of a hit on a surface that is looked for, without the emission that is counted there: for diffuse rays
    /// without all of its own light, for wide reflections without what exceeds [`BRIGHTEST`].
    #[inline(always)]
    pub(super) fn without_own(radiance: [f32; 3], material: &Material, is_diffuse: bool) -> [f32; 3] {
        let most = if is_diffuse { 0.0 } else { BRIGHTEST };
        std::array::from_fn(|k| {
            let own = material.emissive[k];
            let rest = radiance[k] - if own > most { own - most } else { 0.0 };
            if rest > 0.0 { rest } else { 0.0 }
        })
    }

    /// A point for the number of a ray: the triangle's light in units that make the mean over all points the whole, where it is.
    #[inline(always)]
    fn point(&self, number: u32) -> (&Emitter, [f32; 3]) {
        let along =
            |step: u32| (number.wrapping_add(1).wrapping_mul(step) >> 8) as f32 * (1.0 / 16_777_216.0);
        let [which, u, v] = STEPS.map(along);
        let which = self.triangles.partition_point(|emitter| emitter.power <= which * self.power);
        let emitter = &self.triangles[which.min(self.triangles.len() - 1)];
        let root = u.sqrt();
        let (s, t) = (1.0 - root, v * root);
        let [e, f] = emitter.edges;
        (emitter, std::array::from_fn(|k| emitter.corner[k] + (e[k] * s + f[k] * t)))
    }
}

/// Pixels along a side of the square after which points repeat: of a larger one the pattern would show.
const SIDE: u32 = 2;

/// A place that light arrives at.
#[derive(Clone, Copy)]
pub(super) struct LitPlace {
    /// Off the surface.
    pub(super) start: [f32; 3],
    pub(super) face: [f32; 3],
    pub(super) normal: [f32; 3],
    pub(super) pixel: [u32; 2],
}

/// Rays of a fragment, at least: it has no others than its own, so that the edges of shadows are where they belong.
const FEWEST: u32 = 16;

impl TracedLight<'_> {
    /// Number of rays that a fragment sends to what shines.
    #[must_use]
    pub fn emitter_rays(&self) -> u32 {
        let count = (self.samples.len() as u32).max(FEWEST);
        if self.emitters.is_empty() { 0 } else { count }
    }

    /// The light that arrives from all that shines, over pi: as the mean radiance of diffuse rays.
    #[inline(always)]
    pub(super) fn light_of_emitters<L: Lanes>(
        &self,
        l: L,
        context: &ShadeContext<'_>,
        at: &LitPlace,
        scratch: &mut TraceScratch,
    ) -> [f32; 3] {
        let count = self.emitter_rays();
        let [x, y] = at.pixel.map(|v| v % SIDE);
        let first = (SIDE * y + (x ^ y)) * count;
        let mut sum = [0.0; 3];
        for number in first..first + count {
            let (emitter, point) = self.emitters.point(number);
            let to = difference(point, at.start);
            let square = dot(to, to);
            let distance = square.sqrt();
            let direction = to.map(|v| v / distance);
            let (cosine, above) = (dot(at.normal, direction), dot(at.face, direction));
            let own = -dot(emitter.normal, direction);
            let own = if emitter.two_sided { own.abs() } else { own };
            // Also false of what is no number: a place on the lamp itself.
            if !(cosine > 0.0 && above > 0.0 && own > 0.0) {
                continue;
            }
            let ray = Ray { origin: at.start, direction, near: 0.0, far: distance - 2.0 * self.epsilon };
            let TraceScratch { traversal, batch, .. } = scratch;
            // An occluder is a surface whose front the light sees.
            let along = direction.map(|v| -v);
            let blocked = self.hierarchy.is_blocked(
                l,
                &ray,
                traversal,
                #[inline(always)]
                |hit| self.is_seen(l, context, (hit, along), batch),
            );
            if blocked {
                continue;
            }
            let tint = match self.clear.hierarchy.is_empty() {
                true => [1.0; 3],
                false => self.through(l, context, &ray, scratch).tint,
            };
            // No triangle fills more than the half of space.
            let (near, most) = (own / square, TAU / emitter.area);
            let part = cosine * if near < most { near } else { most };
            for k in 0..3 {
                sum[k] += emitter.color[k] * (part * tint[k]);
            }
        }
        sum.map(|sum| sum * (self.emitters.power * FRAC_1_PI / count as f32))
    }
}

/// The product of two edges of a triangle, and its length.
pub(super) fn cross([a, b, c]: &[[f32; 3]; 3]) -> ([f32; 3], f32) {
    let [[ax, ay, az], [bx, by, bz]] = [difference(*b, *a), difference(*c, *a)];
    let cross = [ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx];
    (cross, dot(cross, cross).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRIANGLE: [[f32; 3]; 3] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

    /// For materials that are all looked for.
    fn emitters(materials: usize) -> Emitters {
        let mut emitters = Emitters::default();
        emitters.clear(materials);
        (0..materials).for_each(|material| emitters.count(&TRIANGLE, material));
        emitters.choose(100.0);
        emitters
    }

    #[test]
    fn points_are_spread_by_power() {
        let mut emitters = emitters(2);
        let dim = Material::default().with(|m| m.emissive = [1.0, 0.5, 0.0]);
        let bright = Material::default().with(|m| m.emissive = [3.0, 3.0, 3.0]);
        let at = |x: f32| TRIANGLE.map(|[u, v, w]| [u + x, v, w]);
        assert!(emitters.add(&at(0.0), 0, &dim) && emitters.add(&at(5.0), 1, &bright));
        // Without a side nothing shines.
        assert!(emitters.add(&[[1.0; 3]; 3], 1, &bright));
        assert_eq!((emitters.triangles.len(), emitters.power), (2, 2.0));
        let mut counts = [0; 2];
        let mut middle = [0.0; 2];
        for number in 0..4096 {
            let (emitter, [x, y, z]) = emitters.point(number);
            let which = usize::from(emitter.color == [1.0; 3]);
            counts[which] += 1;
            let x = x - 5.0 * which as f32;
            assert!(x >= 0.0 && y >= 0.0 && x + y <= 1.0 && z == 0.0, "{x} {y} {z}");
            middle[which] += x;
        }
        assert!((counts[1] as f32 / 4096.0 - 0.75).abs() < 0.01, "{counts:?}");
        for k in 0..2 {
            assert!((middle[k] / counts[k] as f32 - 1.0 / 3.0).abs() < 0.02, "{middle:?}");
        }
    }

    #[test]
    fn too_many_are_none_and_large_ones_are_left_out() {
        let bright = Material::default().with(|m| m.emissive = [1.0; 3]);
        let mut all = emitters(1);
        assert!((0..MOST).all(|_| all.add(&TRIANGLE, 0, &bright)));
        assert!(all.has(0) && !all.add(&TRIANGLE, 0, &bright) && all.is_empty() && !all.has(0));
        let mut large = emitters(2);
        large.clear(2);
        (0..3).for_each(|_| large.count(&TRIANGLE, 1));
        large.count(&TRIANGLE, 0);
        large.choose(50.0);
        assert!(large.add(&TRIANGLE, 0, &bright) && large.add(&TRIANGLE, 1, &bright));
        assert_eq!((large.triangles.len(), large.has(0), large.has(1)), (1, true, false));
    }

    #[test]
    fn diffuse_rays_leave_the_light_of_lamps_alone() {
        let lamp = Material::default().with(|m| m.emissive = [100.0, 2.0, 0.0]);
        assert_eq!(Emitters::without_own([101.0, 2.5, 0.25], &lamp, true), [1.0, 0.5, 0.25]);
        assert_eq!(Emitters::without_own([101.0, 2.5, 0.25], &lamp, false), [5.0, 2.5, 0.25]);
    }
}
