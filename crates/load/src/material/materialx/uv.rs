//! Texture coordinates that a graph transforms.

use super::document::Element;
use super::graph::{Graph, Scope};
use overcoat_core::math::double::{atan2, sin_cos};

/// An affine transform of texture coordinates as MaterialX has them, v upwards: `rows` times (u, v, 1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Affine {
    rows: [[f64; 3]; 2],
}

/// The transform as material files have it (KHR_texture_transform, v downwards).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Placed {
    pub(super) offset: [f64; 2],
    /// Degrees.
    pub(super) rotation: f64,
    pub(super) scale: [f64; 2],
}

impl Placed {
    pub(super) const IDENTITY: Self = Self { offset: [0.0; 2], rotation: 0.0, scale: [1.0; 2] };
}

impl Affine {
    pub(super) const IDENTITY: Self = Self { rows: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]] };

    /// The transform of coordinates with v downwards.
    pub(super) fn of_rows(rows: [[f32; 3]; 2]) -> Self {
        let [[a, b, e], [c, d, f]] = rows.map(|row| row.map(f64::from));
        Self { rows: [[a, -b, e + b], [-c, d, 1.0 - d - f]] }
    }

    fn scale([x, y]: [f64; 2]) -> Self {
        Self { rows: [[x, 0.0, 0.0], [0.0, y, 0.0]] }
    }

    fn offset([x, y]: [f64; 2]) -> Self {
        Self { rows: [[1.0, 0.0, x], [0.0, 1.0, y]] }
    }

    /// `rotate2d`: anti-clockwise for a positive angle.
    fn rotation(degrees: f64) -> Self {
        let (sin, cos) = sin_cos(degrees * (std::f64::consts::PI / 180.0));
        Self { rows: [[cos, sin, 0.0], [-sin, cos, 0.0]] }
    }

    /// This one first, then the other.
    fn then(self, next: Self) -> Self {
        let [[a, b, e], [c, d, f]] = self.rows;
        Self { rows: next.rows.map(|[p, q, r]| [p * a + q * c, p * b + q * d, p * e + q * f + r]) }
    }

    /// The same for coordinates with v downwards, by parts; `None` if a texture transform cannot say it: shear, or
    /// numbers out of all measure.
    pub(super) fn placed(self) -> Option<Placed> {
        let [[a, b, e], [c, d, f]] = self.rows;
        // (u, 1 - v) goes in and comes out.
        let [[a, b, e], [c, d, f]] = [[a, -b, e + b], [-c, d, 1.0 - d - f]];
        let length = (a * a + c * c).sqrt();
        if !(length > 1e-6 && length < 1e4) {
            return None;
        }
        let (cos, sin) = (a / length, -c / length);
        // Scaled, then turned: [[cos x, sin y], [-sin x, cos y]].
        let y = b * sin + d * cos;
        let shear = (b - sin * y).abs() + (d - cos * y).abs();
        let (x, y, cos, sin) =
            if sin == 0.0 && cos < 0.0 { (-length, -y, 1.0, 0.0) } else { (length, y, cos, sin) };
        if shear > 1e-4 * length || !(y.abs() > 1e-6 && y.abs() < 1e4) || e.abs().max(f.abs()) > 1e4 {
            return None;
        }
        Some(Placed {
            offset: [e, f],
            rotation: atan2(sin, cos) * (180.0 / std::f64::consts::PI),
            scale: [x, y],
        })
    }
}

/// Coordinates of a texture: the set, and what becomes of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Coordinates {
    pub(super) set: u8,
    pub(super) transform: Affine,
}

impl Coordinates {
    pub(super) const FIRST: Self = Self { set: 0, transform: Affine::IDENTITY };

    fn then(self, next: Affine) -> Self {
        Self { transform: self.transform.then(next), ..self }
    }
}

/// Two numbers of an input, one for both; `or` without.
fn pair<'a>(graph: &mut Graph<'a>, node: &'a Element, scope: Scope<'a>, name: &str, or: f64) -> [f64; 2] {
    match graph.constant(node, scope, name).as_deref() {
        Some([one]) => [f64::from(*one); 2],
        Some([x, y, ..]) => [f64::from(*x), f64::from(*y)],
        _ => [or; 2],
    }
}

fn single<'a>(graph: &mut Graph<'a>, node: &'a Element, scope: Scope<'a>, name: &str, or: f64) -> f64 {
    pair(graph, node, scope, name, or)[0]
}

/// Division that leaves what it cannot divide.
fn inverse(v: [f64; 2]) -> [f64; 2] {
    v.map(|v| if v.abs() > 1e-9 { 1.0 / v } else { 1.0 })
}

/// The coordinates that an image node reads; `None` if they are made by nodes that are not read.
pub(super) fn of_image<'a>(
    graph: &mut Graph<'a>,
    node: &'a Element,
    scope: Scope<'a>,
) -> Option<Coordinates> {
    let input = if node.category == "UsdUVTexture" { "st" } else { "texcoord" };
    let from = of_input(graph, node, scope, input)?;
    Some(match node.category.as_str() {
        // stdlib_ng.mtlx, NG_tiledimage.
        "tiledimage" => {
            let [tiling, offset, image, tile] = [
                ("uvtiling", 1.0),
                ("uvoffset", 0.0),
                ("realworldimagesize", 1.0),
                ("realworldtilesize", 1.0),
            ]
            .map(|(name, or)| pair(graph, node, scope, name, or));
            from.then(Affine::scale(tiling))
                .then(Affine::offset(offset.map(|v| -v)))
                .then(Affine::scale(inverse(image)))
                .then(Affine::scale(tile))
        }
        // gltf_pbr.mtlx, NG_gltf_image: place2d by the inverse scale, turned and moved the other way.
        "gltf_image" | "gltf_colorimage" | "gltf_normalmap" | "gltf_iridescence_thickness" => {
            let set = single(graph, node, scope, "uvindex", f64::from(from.set));
            let pivot = match graph.constant(node, scope, "pivot").as_deref() {
                Some([x, y, ..]) => [f64::from(*x), f64::from(*y)],
                _ => [0.0, 1.0],
            };
            let scale = inverse(pair(graph, node, scope, "scale", 1.0));
            let rotate = -single(graph, node, scope, "rotate", 0.0);
            let [x, y] = pair(graph, node, scope, "offset", 0.0);
            let scale_first = single(graph, node, scope, "operationorder", 0.0) == 0.0;
            let from = Coordinates { set: u8::from(set == 1.0), ..from };
            place2d(from, pivot, scale, rotate, [-x, y], scale_first)
        }
        _ => from,
    })
}

/// stdlib_ng.mtlx, NG_place2d.
fn place2d(
    from: Coordinates,
    pivot: [f64; 2],
    scale: [f64; 2],
    rotate: f64,
    offset: [f64; 2],
    scale_first: bool,
) -> Coordinates {
    let back = Affine::offset(pivot);
    let (scale, rotate) = (Affine::scale(inverse(scale)), Affine::rotation(rotate));
    let offset = Affine::offset(offset.map(|v| -v));
    let from = from.then(Affine::offset(pivot.map(|v| -v)));
    let [first, second, third] = if scale_first { [scale, rotate, offset] } else { [offset, rotate, scale] };
    from.then(first).then(second).then(third).then(back)
}

fn of_input<'a>(
    graph: &mut Graph<'a>,
    node: &'a Element,
    scope: Scope<'a>,
    name: &str,
) -> Option<Coordinates> {
    let Some(input) = node.input(name) else { return Some(Coordinates::FIRST) };
    let Some((source, scope)) = graph.source(input, scope) else {
        // A constant, or the default of the input.
        return input.attribute("value").is_empty().then_some(Coordinates::FIRST);
    };
    graph.visit(|graph| of_node(graph, source, scope))?
}

fn of_node<'a>(graph: &mut Graph<'a>, node: &'a Element, scope: Scope<'a>) -> Option<Coordinates> {
    match node.category.as_str() {
        "texcoord" => Some(Coordinates {
            set: u8::from(single(graph, node, scope, "index", 0.0) == 1.0),
            ..Coordinates::FIRST
        }),
        "geompropvalue" | "geompropvalueuniform" | "UsdPrimvarReader" => {
            let name = node.text(if node.category == "UsdPrimvarReader" { "varname" } else { "geomprop" });
            let second = matches!(name, "UV1" | "st1" | "map2" | "uv1" | "TEXCOORD_1");
            Some(Coordinates { set: u8::from(second), ..Coordinates::FIRST })
        }
        "place2d" | "UsdTransform2d" => {
            let is_usd = node.category == "UsdTransform2d";
            let from = of_input(graph, node, scope, if is_usd { "in" } else { "texcoord" })?;
            let scale = pair(graph, node, scope, "scale", 1.0);
            if is_usd {
                let rotation = single(graph, node, scope, "rotation", 0.0);
                let offset = pair(graph, node, scope, "translation", 0.0);
                // UsdTransform2d turns anti-clockwise what it moves: the coordinates.
                return Some(
                    from.then(Affine::scale(scale))
                        .then(Affine::rotation(-rotation))
                        .then(Affine::offset(offset)),
                );
            }
            let pivot = pair(graph, node, scope, "pivot", 0.0);
            let rotate = single(graph, node, scope, "rotate", 0.0);
            let offset = pair(graph, node, scope, "offset", 0.0);
            let scale_first = single(graph, node, scope, "operationorder", 0.0) == 0.0;
            Some(place2d(from, pivot, scale, rotate, offset, scale_first))
        }
        "rotate2d" => {
            let amount = single(graph, node, scope, "amount", 0.0);
            Some(of_input(graph, node, scope, "in")?.then(Affine::rotation(amount)))
        }
        "multiply" | "divide" | "add" | "subtract" => {
            let from = of_input(graph, node, scope, "in1")?;
            let is_factor = matches!(node.category.as_str(), "multiply" | "divide");
            let by = pair(graph, node, scope, "in2", if is_factor { 1.0 } else { 0.0 });
            Some(from.then(match node.category.as_str() {
                "multiply" => Affine::scale(by),
                "divide" => Affine::scale(inverse(by)),
                "add" => Affine::offset(by),
                _ => Affine::offset(by.map(|v| -v)),
            }))
        }
        "dot" | "convert" => of_input(graph, node, scope, "in"),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiling_and_turning_are_what_they_are_with_v_downwards() {
        // Three by two tiles: the first texel above stays where v downwards has its zero, but for whole tiles.
        let tiled = Affine::scale([3.0, 2.0]).placed().unwrap();
        assert_eq!(tiled, Placed { offset: [0.0, -1.0], rotation: 0.0, scale: [3.0, 2.0] });
        let turned = Affine::rotation(30.0).placed().unwrap();
        assert!((turned.rotation + 30.0).abs() < 1e-9, "{turned:?}");
        let moved = Affine::offset([0.25, 0.25]).placed().unwrap();
        assert_eq!(moved, Placed { offset: [0.25, -0.25], rotation: 0.0, scale: [1.0, 1.0] });
        let mirrored = Affine::scale([-1.0, 1.0]).placed().unwrap();
        assert_eq!(mirrored.scale, [-1.0, 1.0]);
        // Turned, then scaled otherwise each way.
        assert_eq!(Affine::rotation(30.0).then(Affine::scale([1.0, 2.0])).placed(), None);
        assert_eq!(Affine::scale([f64::NAN, 1.0]).placed(), None);
    }

    #[test]
    fn a_transform_of_gltf_comes_back_as_it_was() {
        // NG_gltf_image of scale (2, 3), rotation 20 degrees, offset (.1, .2).
        let placed = place2d(Coordinates::FIRST, [0.0, 1.0], [0.5, 1.0 / 3.0], -20.0, [-0.1, 0.2], true);
        let Placed { offset, rotation, scale } = placed.transform.placed().unwrap();
        let found = [offset[0], offset[1], rotation, scale[0], scale[1]];
        let expected = [0.1, 0.2, 20.0, 2.0, 3.0];
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9), "{found:?}");
    }
}
