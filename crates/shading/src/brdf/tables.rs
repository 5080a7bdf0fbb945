//! The pre-integrated tables that belong to the program: `assets/tables`, made by `examples/make-assets` from
//! [`super::integrate`] and from nothing else.
//!
//! Each is unpacked when it is first asked for (0.1 ms at most) and then shared: a picture whose materials need none
//! pays for none.
//!
//! **Formats.** Numbers are stored as 32-bit floats unless the engine itself ships half floats (Filament, three.js):
//! then theirs are the numbers that users see. Unity stores its table with 10 bits a channel in 0 to 1, an error of up to
//! 4.9e-4, and loses the slightly negative diffuse term of smooth surfaces (-0.029 at least) to the clamp; that is a limit
//! of its texture and no part of the model, so the integral itself is stored.

use super::integrate;
use super::linearly_transformed_cosine::fit;
use super::table::{Table, TexelFormat, TexelGrid};
use overcoat_assets::tables;
use std::sync::OnceLock;

/// Definition of a pre-integrated table, for the program that writes the files.
pub struct Definition<const N: usize> {
    /// File name in `assets/tables`.
    pub file: &'static str,
    /// Texels along the first parameter, and number of rows.
    pub size: [usize; 2],
    /// Mapping of the parameters to texels.
    pub grid: TexelGrid,
    /// Number format, to which the texels are rounded.
    pub format: TexelFormat,
    /// The texels of one row, of `size`. Rows are independent of each other.
    pub row: fn([usize; 2], usize) -> Vec<[f64; N]>,
}

impl<const N: usize> Definition<N> {
    /// The bytes of the file from all rows in order; empty if there are too many or too few.
    #[must_use]
    pub fn bytes(&self, rows: &[Vec<[f64; N]>]) -> Vec<u8> {
        // Values too small to matter become 0: subnormal numbers are slow to compute with.
        let stored = |v: f64| if v.abs() < 1e-30 { 0.0 } else { v as f32 };
        let texels: Vec<[f32; N]> = rows.iter().flatten().map(|texel| texel.map(stored)).collect();
        let table = Table::new(self.size[0], self.size[1], self.grid, &texels);
        table.and_then(|table| table.to_bytes(self.format)).unwrap_or_default()
    }
}

/// Middles of equal cells.
fn centers(size: usize) -> Vec<f64> {
    (0..size).map(|k| (k as f64 + 0.5) / size as f64).collect()
}

/// Place k of `size` from 0 to 1.
fn corner(k: usize, size: usize) -> f64 {
    k as f64 / (size - 1) as f64
}

/// The squares of all places from 0 to 1: cosines, denser at grazing angles.
fn squared_corners(size: usize) -> Vec<f64> {
    (0..size).map(|k| corner(k, size) * corner(k, size)).collect()
}

/// See [`unity_fgd`].
pub const UNITY_FGD: Definition<3> = Definition {
    file: "unity-fgd.bin",
    size: [64, 64],
    grid: TexelGrid::Corners,
    format: TexelFormat::Single,
    row: |[width, height], y| integrate::unity_fgd(corner(y, height), &squared_corners(width)),
};

/// See [`filament_dfg`].
pub const FILAMENT_DFG: Definition<3> = Definition {
    file: "filament-dfg.bin",
    size: [128, 128],
    grid: TexelGrid::Centers,
    format: TexelFormat::Half,
    row: |[width, height], y| integrate::filament_dfg(integrate::filament_row(y, height), &centers(width)),
};

/// See [`three_dfg`].
pub const THREE_DFG: Definition<2> = Definition {
    file: "three-dfg.bin",
    size: [16, 16],
    grid: TexelGrid::Centers,
    format: TexelFormat::Half,
    // Roughness runs along the rows here, so a row takes one texel of each integral.
    row: |[width, height], y| {
        let cosine = [centers(height)[y]];
        centers(width).iter().flat_map(|&p| integrate::three_dfg(p, &cosine)).collect()
    },
};

/// See [`khronos`].
pub const KHRONOS: Definition<3> = Definition {
    file: "khronos.bin",
    size: [64, 64],
    grid: TexelGrid::Centers,
    format: TexelFormat::Single,
    row: |[width, height], y| integrate::khronos(centers(height)[y], &centers(width)),
};

/// See [`sheen_albedo`].
pub const SHEEN_ALBEDO: Definition<1> = Definition {
    file: "sheen-albedo.bin",
    size: [32, 32],
    grid: TexelGrid::Centers,
    format: TexelFormat::Single,
    row: |[width, height], y| {
        let albedo = integrate::sheen_albedo(centers(height)[y], &centers(width));
        albedo.into_iter().map(|v| [v]).collect()
    },
};

/// See [`ggx_albedo`].
pub const GGX_ALBEDO: Definition<3> = Definition {
    file: "ggx-albedo.bin",
    size: [32, 32],
    grid: TexelGrid::Corners,
    format: TexelFormat::Single,
    row: |[width, height], y| integrate::ggx_albedo(corner(y, height), &squared_corners(width)),
};

/// See [`linearly_transformed_ggx`].
pub const LINEARLY_TRANSFORMED_GGX: Definition<4> = Definition {
    file: "ltc-ggx.bin",
    size: [64, 64],
    grid: TexelGrid::Corners,
    format: TexelFormat::Half,
    row: |[width, height], y| {
        let cosine = 1.0 - corner(y, height) * corner(y, height);
        let roughnesses: Vec<f64> = (0..width).map(|x| corner(x, width)).collect();
        fit::ggx(cosine, &roughnesses)
    },
};

/// The table in a file of `assets/tables`, unpacked once. The files are made by this crate and compared by a test; zero
/// stands in for what cannot happen.
fn unpacked<const N: usize>(table: &'static OnceLock<Table<N>>, bytes: &[u8]) -> &'static Table<N> {
    table.get_or_init(|| Table::from_bytes(bytes).unwrap_or_else(|| Table::constant([0.0; N])))
}

/// Unity's pre-integrated FGD of GGX and Disney's diffuse, read at (sqrt(N.V), perceptual roughness): x weighted with
/// (1 - V.H)^5, y without (albedo for F = 1), z the diffuse albedo less 0.5. Specular = lerp(x, y, F0), diffuse = z + 0.5.
#[must_use]
pub fn unity_fgd() -> &'static Table<3> {
    static TABLE: OnceLock<Table<3>> = OnceLock::new();
    unpacked(&TABLE, tables::UNITY_FGD)
}

/// Filament's DFG, read at (N.V, perceptual roughness): x weighted with (1 - V.H)^5, y without, z the albedo of cloth.
/// Specular = lerp(x, y, F0). As in the engine, 128 rows, each for a roughness 1/128 above its place.
#[must_use]
pub fn filament_dfg() -> &'static Table<3> {
    static TABLE: OnceLock<Table<3>> = OnceLock::new();
    unpacked(&TABLE, tables::FILAMENT_DFG)
}

/// The DFG of three.js, read at (perceptual roughness, N.V), roughness first: scale and bias. Specular = F0 x + F90 y.
#[must_use]
pub fn three_dfg() -> &'static Table<2> {
    static TABLE: OnceLock<Table<2>> = OnceLock::new();
    unpacked(&TABLE, tables::THREE_DFG)
}

/// The tables of the Khronos renderer, read at (N.V, perceptual roughness of the base or of the sheen): scale and bias of
/// GGX, and z its sheen lobe.
#[must_use]
pub fn khronos() -> &'static Table<3> {
    static TABLE: OnceLock<Table<3>> = OnceLock::new();
    unpacked(&TABLE, tables::KHRONOS)
}

/// Directional albedo of the Khronos renderer's sheen for a white sheen colour, read at (cosine, sheen roughness); above
/// 1 at grazing angles of smooth sheen (1.5 at most), as the lobe itself.
#[must_use]
pub fn sheen_albedo() -> &'static Table<1> {
    static TABLE: OnceLock<Table<1>> = OnceLock::new();
    unpacked(&TABLE, tables::SHEEN_ALBEDO)
}

/// Albedos of GGX, read at (sqrt(N.V), perceptual roughness): x weighted with (1 - V.H)^5, y without weight, z weighted
/// with V.H (1 - V.H)^6. As the first two of [`unity_fgd`], without the noise of its samples.
#[must_use]
pub fn ggx_albedo() -> &'static Table<3> {
    static TABLE: OnceLock<Table<3>> = OnceLock::new();
    unpacked(&TABLE, tables::GGX_ALBEDO)
}

/// Matrices of linearly transformed cosines for GGX, read at (perceptual roughness, sqrt(1 - N.V)): see
/// [`super::linearly_transformed_cosine::Lobe::ggx`].
#[must_use]
pub fn linearly_transformed_ggx() -> &'static Table<4> {
    static TABLE: OnceLock<Table<4>> = OnceLock::new();
    unpacked(&TABLE, tables::LTC_GGX)
}
