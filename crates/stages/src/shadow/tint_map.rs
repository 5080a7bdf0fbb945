//! Tinted surfaces into the texels of a map.
//!
//! Every crossing multiplies the transmittance of a texel, beside the depth of the outermost (Filion and McNaughton 2008,
//! "StarCraft II: Effects and techniques", on translucent shadows): a product needs no order. A volume absorbs along the way
//! between fronts and backs. With signs for the sides, the sum of their depths is the length of that way, in any order, where
//! there are as many fronts as backs (Oat and Scheuermann 2008, "Computing per-pixel object thickness in a single render pass",
//! ShaderX 6); else the thickness of the material counts for each front.

use super::bounds::corners_of;
use super::clip::{Corner, clipped};
use super::depth_map::{DEEPEST, DepthMap, OUTERMOST};
use super::draw::{candidates, for_each_covered, mean, texels_of};
use super::slab::Sixteen;
use super::tint_body::{Body, Reflected, Side};
use super::tinted::{Crossing, Filter, Tinted};
use overcoat_core::each;
use overcoat_core::math::lanes::{LANES, Lanes};
use overcoat_core::math::scalar::exp_transmittance;
use overcoat_core::math::triple::dot;

/// Words of a texel: depth in steps (0 where nothing tints) with red above it, then green with blue above it; colours in parts
/// of [`WHOLE`].
pub(super) const WORDS: usize = 2;

/// Number that stands for a transmittance of 1.
pub(super) const WHOLE: f32 = 65535.0;

/// Transmittances above this leave no mark: there is nothing.
const CLEAR: f32 = 0.999;

/// Light that a map looks at.
#[derive(Clone, Copy, Debug)]
pub(super) enum Source {
    /// In the direction of a unit vector, with the length of a step of depth.
    Distant { towards: [f32; 3], step: f32 },
    /// At a point, with the distance at which depth is least and the length of a texel at a distance of 1.
    Near { position: [f32; 3], far: f32, texel: f32 },
}

/// Crossings of a texel.
#[derive(Clone, Copy, Debug)]
struct Texel {
    /// The outermost, as maps are drawn.
    depth: f32,
    transmittance: [f32; 3],
    /// Sum of extinction times depth in units of the world, fronts less backs, and times what reflected light goes beyond that.
    path: [f32; 3],
    /// Sum of extinction times thickness over fronts.
    thickness: [f32; 3],
    /// Fronts of volumes less backs.
    balance: i32,
}

impl Texel {
    const EMPTY: Self =
        Self { depth: 0.0, transmittance: [1.0; 3], path: [0.0; 3], thickness: [0.0; 3], balance: 0 };

    /// Counts light that is reflected within a body.
    fn reflect(&mut self, reflected: Option<Reflected>) {
        if let Some(Reflected { kept, path }) = reflected {
            self.transmittance = self.transmittance.map(|t| t * kept);
            self.path = each!(k => self.path[k] + path[k]);
        }
    }

    /// The transmittance of all crossings and of the volumes between them.
    fn all(&self) -> [f32; 3] {
        let sums = if self.balance == 0 { self.path } else { self.thickness };
        each!(k => {
            let absorbed = if sums[k] > 0.0 { exp_transmittance(-sums[k]) } else { 1.0 };
            self.transmittance[k] * absorbed
        })
    }
}

/// A map that is being drawn.
struct Drawing<'a> {
    tinted: &'a Tinted,
    frame: &'a DepthMap,
    source: Source,
    size: usize,
    texels: Vec<Texel>,
    /// For each texel, 1 more than its place among the bodies, 0 without any; empty where no volume bends light.
    places: Vec<u32>,
    /// Sides of the volume that is being drawn.
    bodies: Vec<Body>,
}

/// A triangle of a filter.
struct Triangle<'a> {
    filter: &'a Filter,
    number: usize,
    /// Its corners in world space.
    places: &'a [[f32; 3]; 3],
    /// Side that it shows, where that is the same all over it but for the depth.
    flat: Option<Side>,
    /// Side and transmittance, likewise.
    everywhere: Option<(Side, [f32; 3])>,
}

impl<'a> Triangle<'a> {
    fn new(filter: &'a Filter, number: usize, places: &'a [[f32; 3]; 3], source: Source) -> Self {
        let mut triangle = Self { filter, number, places, flat: None, everywhere: None };
        if matches!(source, Source::Distant { .. }) {
            triangle.flat = Some(triangle.side(source, [1.0, 0.0, 0.0]));
            if filter.is_uniform() {
                triangle.everywhere = Some(triangle.crossed(source, [1.0, 0.0, 0.0]));
            }
        }
        triangle
    }

    /// Side and transmittance at a place.
    fn crossed(&self, source: Source, barycentrics: [f32; 3]) -> (Side, [f32; 3]) {
        let side = match self.flat {
            Some(side) => side,
            None => self.side(source, barycentrics),
        };
        let facing = side.facing;
        let crossing = Crossing {
            triangle: self.number,
            barycentrics,
            cosine: if facing.abs() < 1.0 { facing.abs() } else { 1.0 },
            is_front: facing > 0.0,
        };
        (side, self.filter.transmittance(&crossing))
    }

    /// Normal and light at a place: their cosine is negative where light falls on the back.
    fn side(&self, source: Source, barycentrics: [f32; 3]) -> Side {
        let [a, b, c] = self.places;
        let [u, v] = [relative(*a, *b), relative(*a, *c)];
        let normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        let towards = match source {
            Source::Distant { towards, .. } => towards,
            Source::Near { position, .. } => {
                let w = barycentrics;
                each!(k => position[k] - ((a[k] * w[0] + b[k] * w[1]) + c[k] * w[2]))
            }
        };
        let squares = [dot(normal, normal), dot(towards, towards)];
        let lengths = (squares[0] * squares[1]).sqrt();
        let facing = if lengths > 0.0 { dot(normal, towards) / lengths } else { 0.0 };
        let unit = |v: [f32; 3], square: f32| {
            if square > 0.0 { v.map(|c| c / square.sqrt()) } else { [0.0; 3] }
        };
        let is_flat = self.filter.facets.get(self.number).is_some_and(|is_flat| *is_flat);
        let (normal, towards) = (unit(normal, squares[0]), unit(towards, squares[1]));
        Side { normal, towards, facing, along: 0.0, is_flat }
    }
}

/// The direction from one point to another, its largest coordinate 1: products of small triangles' sides would be 0.
fn relative(from: [f32; 3], to: [f32; 3]) -> [f32; 3] {
    let way: [f32; 3] = each!(k => to[k] - from[k]);
    let largest = way.iter().fold(0.0_f32, |most, c| if c.abs() > most { c.abs() } else { most });
    if largest > 0.0 { way.map(|c| c / largest) } else { way }
}

/// Draws everything into the words of a map, which are 0. Counts the sixteens of triangles and the rows of texels that are
/// looked at; once they are more than `most`, the map stays empty.
#[inline(always)]
pub(super) fn draw<L: Lanes>(
    l: L,
    tinted: &Tinted,
    (frame, source): (&DepthMap, Source),
    (size, most): (usize, u64),
    words: &mut [u32],
) -> u64 {
    let bends = tinted.filters.iter().any(|filter| !filter.facets.is_empty());
    let places = vec![0; if bends { size * size } else { 0 }];
    let texels = vec![Texel::EMPTY; size * size];
    let mut drawing = Drawing { tinted, frame, source, size, texels, places, bodies: Vec::new() };
    let mut work = 0_u64;
    for (of, filter) in tinted.filters.iter().enumerate() {
        for first in (0..filter.triangles.len()).step_by(LANES) {
            let mut sixteen = Sixteen([[0.0; LANES]; 9]);
            for (k, triangle) in filter.triangles[first..].iter().take(LANES).enumerate() {
                let corners = corners_of(&tinted.positions, triangle).unwrap_or_default();
                for (place, number) in corners.as_flattened().iter().enumerate() {
                    sixteen.0[place][k] = *number;
                }
            }
            work += 1;
            let mut bits = candidates(l, frame, &sixteen, size);
            while bits != 0 {
                let k = bits.trailing_zeros() as usize % LANES;
                bits &= bits - 1;
                work = work.saturating_add(drawing.triangle((of, filter), first + k));
            }
            if work > most {
                return work;
            }
        }
    }
    drawing.pack(words);
    work
}

impl Drawing<'_> {
    /// Draws one triangle of a filter.
    fn triangle(&mut self, (of, filter): (usize, &Filter), number: usize) -> u64 {
        let Some(triangle) = filter.triangles.get(number) else { return 0 };
        let Some(places) = corners_of(&self.tinted.positions, triangle) else { return 0 };
        // Barycentrics of a corner travel as its texture coordinates through clipping.
        let corner = |k: usize| {
            let uv = [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]][k];
            Corner { place: self.frame.project_one(&places[k]), uv, alpha: 0.0 }
        };
        let corners = [corner(0), corner(1), corner(2)];
        let triangle = Triangle::new(filter, number, &places, self.source);
        if self.frame.near > 0.0 {
            clipped(corners, self.frame.near).map(|corners| self.part(of, &triangle, &corners)).sum()
        } else {
            self.part(of, &triangle, &corners)
        }
    }

    /// Draws a part of a triangle that lies where the map is drawn.
    fn part(&mut self, of: usize, triangle: &Triangle<'_>, part: &[Corner; 3]) -> u64 {
        let filter = triangle.filter;
        let corners = part.map(|corner| self.frame.seen(corner.place));
        let Some(ranges) = texels_of(&corners, self.size) else { return 0 };
        let (frame, source, size, tinted) = (self.frame, self.source, self.size, self.tinted);
        let nearness = if frame.near > 0.0 { corners.map(|corner| corner[2]) } else { [1.0; 3] };
        let (texels, places, bodies) = (&mut self.texels, &mut self.places, &mut self.bodies);
        for_each_covered(&corners, ranges, |[column, row], w| {
            if !is_owner(&corners, w) {
                return;
            }
            let depth = mean(w, each!(k => corners[k][2]));
            let (side, left) = triangle.everywhere.unwrap_or_else(|| {
                let own: [f32; 3] = each!(k => w[k] * nearness[k]);
                let u = mean(own, each!(k => part[k].uv[0]));
                let v = mean(own, each!(k => part[k].uv[1]));
                triangle.crossed(source, [u, v, (1.0 - u) - v])
            });
            let texel = &mut texels[row * size + column];
            if left.iter().any(|left| *left < CLEAR) || filter.extinction.is_some() {
                texel.depth = if depth > texel.depth { depth } else { texel.depth };
            }
            texel.transmittance = each!(k => texel.transmittance[k] * left[k]);
            let along = source.towards_light(frame, size, [column, row], depth);
            if let Some(place) = places.get_mut(row * size + column).filter(|_| !filter.facets.is_empty()) {
                if *place == 0 {
                    bodies.push(Body::NONE);
                    *place = bodies.len() as u32;
                }
                let body = &mut bodies[*place as usize - 1];
                texel.reflect(body.cross(tinted, of, Side { along, ..side }));
            }
            if let Some(extinction) = filter.extinction {
                let is_front = side.facing > 0.0;
                let sign = if is_front { 1 } else { -1 };
                texel.balance += sign;
                texel.path = each!(k => texel.path[k] + extinction[k] * (along * sign as f32));
                if is_front {
                    texel.thickness = each!(k => texel.thickness[k] + extinction[k] * filter.thickness);
                }
            }
        })
    }

    fn pack(&mut self, words: &mut [u32]) {
        for (texel, place) in self.texels.iter_mut().zip(&self.places) {
            let body = (*place as usize).checked_sub(1).and_then(|place| self.bodies.get(place));
            texel.reflect(body.and_then(|body| body.reflected(self.tinted)));
        }
        for (texel, words) in self.texels.iter().zip(words.chunks_exact_mut(WORDS)) {
            if texel.depth > 0.0 {
                let [r, g, b] = texel.all().map(|c| (c * WHOLE + 0.5) as u32);
                words[0] = self.source.steps(self.frame, texel.depth) | r << 16;
                words[1] = g | b << 16;
            }
        }
    }
}

/// True of one of the triangles that have a point in common, which has these weights in it: a crossing must count once. On an
/// edge it is the one that lies on the side of a point that is moved by a little down, and by less to the right.
fn is_owner(corners: &[[f32; 3]; 3], w: [f32; 3]) -> bool {
    let is_clockwise = (w[0] + w[1]) + w[2] > 0.0;
    (0..3).all(|k| {
        let ([px, py, _], [qx, qy, _]) = (corners[(k + 1) % 3], corners[(k + 2) % 3]);
        let ahead = if px == qx { py > qy } else { px < qx };
        w[k] != 0.0 || ahead == is_clockwise
    })
}

impl Source {
    /// A depth as maps are drawn, as a length that grows towards the light along the ray through a texel.
    fn towards_light(self, frame: &DepthMap, size: usize, [column, row]: [usize; 2], depth: f32) -> f32 {
        match self {
            Self::Distant { step, .. } => depth * step,
            Self::Near { texel, .. } => {
                let middle = (size - 1) as f32 * 0.5;
                let [x, y] = [column, row].map(|c| (c as f32 - middle) * texel);
                -(frame.nearest() / depth) * (1.0 + (x * x + y * y)).sqrt()
            }
        }
    }

    /// A depth as maps are drawn, in steps.
    fn steps(self, frame: &DepthMap, depth: f32) -> u32 {
        let depth = match self {
            Self::Distant { .. } => depth,
            Self::Near { far, .. } => {
                let scale = (OUTERMOST - DEEPEST) / (far - frame.near);
                (far - frame.nearest() / depth) * scale + DEEPEST
            }
        };
        let depth = if depth > DEEPEST { depth } else { DEEPEST };
        (if depth < OUTERMOST { depth } else { OUTERMOST }) as u32
    }
}
