//! BRDFs of the RGL: tables over half vectors, spread evenly over the facets that are seen.
//!
//! Dupuy and Jakob 2018, "An Adaptive Parameterization for Efficient Material Acquisition and Rendering", equation 12 and section
//! 4.1; the layout is that of the authors' reader (<https://github.com/rgl-epfl/brdf-loader>). A half vector at elevation t and
//! azimuth p stands at `(sqrt(2 t / pi), p / 2 pi + 1 / 2)` in the unit square; `vndf` warps it to where `rgb` has
//! the BRDF times 4 sigma / D, where D is the density of normals (`ndf`) and sigma the area that facets show (`sigma`). Tables of
//! isotropic materials are for azimuths relative to the direction that they are made for. Tables for a half or a quarter of
//! all azimuths stand for materials that look the same turned by half a turn, or mirrored as well.
//!
//! *Negative values* of `rgb`, of colours beyond the gamut of sRGB, are 0 as in the authors' reader.

use super::tensor::{Field, Tensors, plain};
use super::warp::{Directions, Grid, Warp};
use super::{MeasuredError, halfway, spherical};
use std::f64::consts::{FRAC_2_PI, PI, TAU};

#[derive(Clone, Debug)]
pub(super) struct Rgl {
    description: String,
    directions: Directions,
    /// Share of all azimuths that tables are for: 1, 2 or 4 parts. 1 for isotropic materials.
    parts: u32,
    ndf: Grid,
    sigma: Grid,
    vndf: Warp,
    rgb: Grid,
    /// `rgb` is the BRDF times 4 sigma / D; otherwise it is the BRDF.
    is_divided: bool,
}

impl Rgl {
    pub(super) fn new(bytes: &[u8]) -> Result<Self, MeasuredError> {
        let tensors = Tensors::new(bytes)?;
        if tensors.has("spectra") && !tensors.has("rgb") {
            return Err(MeasuredError::Spectral);
        }
        let directions =
            Directions { azimuths: angles(&tensors, "phi_i")?, elevations: angles(&tensors, "theta_i")? };
        let parts = parts(&directions)?;
        let of = [directions.azimuths.len() as u64, directions.elevations.len() as u64];
        let ndf = grid(&tensors, "ndf", &[], 1)?;
        let sigma = grid(&tensors, "sigma", &[], 1)?;
        let vndf = Warp::new("vndf", grid(&tensors, "vndf", &of, 1)?)?;
        let rgb = grid(&tensors, "rgb", &[of[0], of[1], 3], 3)?;
        let jacobian = tensors.bytes("jacobian")?;
        let [flag] = jacobian else {
            let found = vec![jacobian.len() as u64];
            return Err(MeasuredError::Shape { field: "jacobian", found, expected: "1".to_owned() });
        };
        let description = plain(tensors.bytes("description")?);
        Ok(Self { description, directions, parts, ndf, sigma, vndf, rgb, is_divided: *flag != 0 })
    }

    pub(super) fn description(&self) -> &str {
        &self.description
    }

    /// Tables for more than two azimuths are those of an anisotropic material, as in the authors' reader.
    pub(super) fn is_anisotropic(&self) -> bool {
        self.directions.azimuths.len() > 2
    }

    pub(super) fn evaluate(&self, view: [f64; 3], light: [f64; 3]) -> Option<[f64; 3]> {
        let [view, light] = self.folded(view, light);
        let [elevation, azimuth] = spherical(view);
        let [half_elevation, half_azimuth] = spherical(halfway(view, light));
        let unit = |elevation: f64, azimuth: f64| {
            let turns = azimuth / TAU + 0.5;
            [(elevation * FRAC_2_PI).sqrt(), turns - turns.floor()]
        };
        let relative = if self.is_anisotropic() { 0.0 } else { azimuth };
        let half = unit(half_elevation, half_azimuth - relative);
        let slices = self.directions.slices(azimuth, elevation);
        let only = [(0, 1.0), (0, 0.0), (0, 0.0), (0, 0.0)];
        let factor = if self.is_divided {
            let area = self.sigma.value(&only, 0, unit(elevation, azimuth));
            // Nothing is known of a view that sees no facet.
            if area <= 0.0 {
                return None;
            }
            self.ndf.value(&only, 0, half) / (4.0 * area)
        } else {
            1.0
        };
        let position = self.vndf.invert(&slices, half);
        Some(std::array::from_fn(|channel| {
            let value = self.rgb.value(&slices, channel, position) * factor;
            if value > 0.0 { value } else { 0.0 }
        }))
    }

    /// Both directions turned and mirrored to where the tables are: azimuths below 0, as in Mitsuba 3's `measured.cpp`.
    fn folded(&self, view: [f64; 3], light: [f64; 3]) -> [[f64; 3]; 2] {
        let y = self.parts >= 2 && view[1] > 0.0;
        let x = match self.parts {
            4 => view[0] > 0.0,
            _ => y,
        };
        let sign = |is_turned: bool, c: f64| if is_turned { -c } else { c };
        [view, light].map(|w| [sign(x, w[0]), sign(y, w[1]), w[2]])
    }
}

/// Rising angles in radians.
fn angles(tensors: &Tensors<'_>, name: &'static str) -> Result<Vec<f32>, MeasuredError> {
    let (field, numbers) = tensors.floats(name)?;
    if field.shape.len() != 1 || numbers.is_empty() {
        return Err(wrong(name, field, "one dimension, 1 or more"));
    }
    if let Some(k) = numbers.windows(2).position(|pair| pair[0] >= pair[1]) {
        let value = f64::from(numbers[k + 1]);
        let expected = "more than the number before it";
        return Err(MeasuredError::Number { what: name, index: k as u64 + 1, value, expected });
    }
    Ok(numbers)
}

/// Parts of all azimuths that the tables are for.
fn parts(directions: &Directions) -> Result<u32, MeasuredError> {
    let [first, .., last] = directions.azimuths[..] else { return Ok(1) };
    if directions.azimuths.len() <= 2 {
        return Ok(1);
    }
    let extent = f64::from(last) - f64::from(first);
    let found = [1, 2, 4].into_iter().find(|n| (TAU / extent - f64::from(*n)).abs() < 0.5);
    found.ok_or(MeasuredError::Number {
        what: "phi_i",
        index: directions.azimuths.len() as u64 - 1,
        value: extent / PI * 180.0,
        expected: "azimuths over 360, 180 or 90 degrees",
    })
}

/// Tables whose shape begins as given; the last two dimensions are rows and columns.
fn grid(
    tensors: &Tensors<'_>,
    name: &'static str,
    leading: &[u64],
    channels: usize,
) -> Result<Grid, MeasuredError> {
    let (field, numbers) = tensors.floats(name)?;
    let (before, size) = field.shape.split_at(leading.len().min(field.shape.len()));
    let sides = |n: &u64| (2..=u64::from(u32::MAX)).contains(n);
    match size {
        [rows, columns] if before == leading && sides(rows) && sides(columns) => {
            Ok(Grid { size: [*columns as usize, *rows as usize], channels, numbers })
        }
        _ => {
            let leading: Vec<String> = leading.iter().map(|n| format!("{n} x ")).collect();
            Err(wrong(name, field, &format!("{}rows x columns, 2 or more of each", leading.concat())))
        }
    }
}

fn wrong(name: &'static str, field: &Field<'_>, expected: &str) -> MeasuredError {
    MeasuredError::Shape { field: name, found: field.shape.clone(), expected: expected.to_owned() }
}
