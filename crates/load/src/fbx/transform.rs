//! Transforms of models: pivots, orders of rotation, and what a model inherits from its parent (Autodesk, *FBX SDK Help*, "Computing
//! transformation matrices").

use super::document::Properties;
use overcoat_scene::{Axis, SceneError, Transform};

/// Place of a model in the world, and the parts of it that models below inherit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placement {
    pub(super) world: Transform,
    /// Rotations of the model and all above it.
    rotation: Transform,
    /// Scale of the model alone.
    scale: [f64; 3],
}

impl Placement {
    /// The world itself.
    pub(super) const ROOT: Self =
        Self { world: Transform::IDENTITY, rotation: Transform::IDENTITY, scale: [1.0; 3] };

    /// A model below this one.
    pub(super) fn child(&self, properties: &Properties<'_>) -> Result<Self, SceneError> {
        let zero = |name: &str| properties.vector(name).unwrap_or_default();
        // Without this the order is that of XYZ, and there are no rotations before and after.
        let is_on = |name: &str| properties.number(name).map(|v| v != 0.0);
        let is_active =
            is_on("RotationActive").unwrap_or(true) && !is_on("RotationSpaceForLimitOnly").unwrap_or(false);
        let order = properties.number("RotationOrder").filter(|_| is_active).unwrap_or(0.0);
        let turn = euler(zero("Lcl Rotation"), order)?;
        let turn = if is_active {
            let before = euler(zero("PreRotation"), 0.0)?;
            let after = euler(zero("PostRotation"), 0.0)?;
            before.after(&turn)?.after(&transposed(&after)?)?
        } else {
            turn
        };
        let scale = properties.vector("Lcl Scaling").unwrap_or([1.0; 3]);
        let (turn_pivot, scale_pivot) = (zero("RotationPivot"), zero("ScalingPivot"));
        // T * Roff * Rp * Rpre * R * Rpost^-1 * Rp^-1 * Soff * Sp * S * Sp^-1
        let local = moved(zero("Lcl Translation"))?
            .after(&moved(zero("RotationOffset"))?)?
            .after(&moved(turn_pivot)?)?
            .after(&turn)?
            .after(&moved(turn_pivot.map(|v| -v))?)?
            .after(&moved(zero("ScalingOffset"))?)?
            .after(&moved(scale_pivot)?)?
            .after(&scaled(scale)?)?
            .after(&moved(scale_pivot.map(|v| -v))?)?;
        let rotation = self.rotation.after(&turn)?;
        let world = match properties.number("InheritType") {
            Some(0.0) => self.with_scale(&turn, scale, self.own_scale()?, &local)?,
            Some(2.0) => {
                // Without the scale of the parent alone.
                let inverse = self.scale.map(|v| if v == 0.0 { 1.0 } else { 1.0 / v });
                self.with_scale(&turn, scale, self.own_scale()?.after(&scaled(inverse)?)?, &local)?
            }
            _ => self.world.after(&local)?,
        };
        Ok(Self { world, rotation, scale })
    }

    /// Scale and shear of the world, without its rotation and place.
    fn own_scale(&self) -> Result<Transform, SceneError> {
        transposed(&self.rotation)?.after(&linear(&self.world)?)
    }

    /// The place of a model whose rotation comes before the scale of its parent.
    fn with_scale(
        &self,
        turn: &Transform,
        scale: [f64; 3],
        inherited: Transform,
        local: &Transform,
    ) -> Result<Transform, SceneError> {
        let [x, y, z] =
            self.rotation.after(turn)?.after(&inherited)?.after(&scaled(scale)?)?.rows().to_owned();
        let [[_, _, _, a], [_, _, _, b], [_, _, _, c]] = *local.rows();
        let [tx, ty, tz] = self.world.point([a, b, c]);
        let row = |[p, q, r, _]: [f64; 4], t: f64| [p, q, r, t];
        Transform::from_rows([row(x, tx), row(y, ty), row(z, tz)])
    }
}

/// The transform of a model's geometry alone, which nothing inherits.
pub(super) fn geometric(properties: &Properties<'_>) -> Result<Transform, SceneError> {
    let zero = |name: &str| properties.vector(name).unwrap_or_default();
    moved(zero("GeometricTranslation"))?
        .after(&euler(zero("GeometricRotation"), 0.0)?)?
        .after(&scaled(properties.vector("GeometricScaling").unwrap_or([1.0; 3]))?)
}

/// A matrix of 16 numbers, column by column.
pub(super) fn matrix(numbers: &[f64]) -> Option<Transform> {
    Transform::from_columns(*numbers.first_chunk()?).ok()
}

fn moved(by: [f64; 3]) -> Result<Transform, SceneError> {
    Transform::translation(by)
}

fn scaled([x, y, z]: [f64; 3]) -> Result<Transform, SceneError> {
    Transform::from_rows([[x, 0.0, 0.0, 0.0], [0.0, y, 0.0, 0.0], [0.0, 0.0, z, 0.0]])
}

/// Without the place.
fn linear(of: &Transform) -> Result<Transform, SceneError> {
    Transform::from_rows(of.rows().map(|[a, b, c, _]| [a, b, c, 0.0]))
}

/// The inverse of a rotation.
fn transposed(of: &Transform) -> Result<Transform, SceneError> {
    let [[a, b, c, _], [d, e, f, _], [g, h, i, _]] = *of.rows();
    Transform::from_rows([[a, d, g, 0.0], [b, e, h, 0.0], [c, f, i, 0.0]])
}

/// The rotation by angles in degrees about the axes. The first axis of an order turns first; 6, which turns on a sphere,
/// is taken as 0.
fn euler(degrees: [f64; 3], order: f64) -> Result<Transform, SceneError> {
    let [x, y, z] = degrees.map(|v| v % 360.0 * (std::f64::consts::PI / 180.0));
    let turn = |axis: [f64; 3], by: f64| {
        if by == 0.0 { Ok(Transform::IDENTITY) } else { Transform::rotation(axis, by) }
    };
    let (x, y, z) = (turn([1.0, 0.0, 0.0], x)?, turn([0.0, 1.0, 0.0], y)?, turn([0.0, 0.0, 1.0], z)?);
    let [first, second, third] = match order as u8 {
        1 => [x, z, y],
        2 => [y, z, x],
        3 => [y, x, z],
        4 => [z, x, y],
        5 => [z, y, x],
        _ => [x, y, z],
    };
    third.after(&second)?.after(&first)
}

/// Axis of the file that is up, and the map to axes of which the others are as custom has them with that one. `None` of
/// settings that are none.
pub(super) fn axes(settings: &Properties<'_>) -> Option<(Axis, Transform)> {
    let axis = |name: &str, otherwise: f64| -> Option<[f64; 3]> {
        let sign = if settings.number(&format!("{name}Sign")).unwrap_or(1.0) < 0.0 { -1.0 } else { 1.0 };
        match settings.number(name).unwrap_or(otherwise) {
            0.0 => Some([sign, 0.0, 0.0]),
            1.0 => Some([0.0, sign, 0.0]),
            2.0 => Some([0.0, 0.0, sign]),
            _ => None,
        }
    };
    let (right, up, front) = (axis("CoordAxis", 0.0)?, axis("UpAxis", 1.0)?, axis("FrontAxis", 2.0)?);
    let named = Axis::ALL.iter().copied().find(|axis| direction(*axis) == up)?;
    let usual_front = direction(named.front());
    let [a, b, c] = [cross(up, usual_front), up, usual_front];
    // Columns of the inverse of what the scene does with an axis that is up, times rows of what the file means.
    let row = |k: usize| {
        let of = |v: &[f64; 3]| v.get(k).copied().unwrap_or_default();
        let column = |j: usize| {
            let from = |v: &[f64; 3]| v.get(j).copied().unwrap_or_default();
            of(&a) * from(&right) + of(&b) * from(&up) + of(&c) * from(&front)
        };
        [column(0), column(1), column(2), 0.0]
    };
    let map = Transform::from_rows([row(0), row(1), row(2)]).ok()?;
    // Two that are the same axis squeeze everything flat.
    (map.determinant() != 0.0).then_some((named, map))
}

fn direction(axis: Axis) -> [f64; 3] {
    match axis {
        Axis::PositiveX => [1.0, 0.0, 0.0],
        Axis::NegativeX => [-1.0, 0.0, 0.0],
        Axis::PositiveY => [0.0, 1.0, 0.0],
        Axis::NegativeY => [0.0, -1.0, 0.0],
        Axis::PositiveZ => [0.0, 0.0, 1.0],
        Axis::NegativeZ => [0.0, 0.0, -1.0],
        _ => [0.0; 3],
    }
}

fn cross([a, b, c]: [f64; 3], [x, y, z]: [f64; 3]) -> [f64; 3] {
    [b * z - c * y, c * x - a * z, a * y - b * x]
}
