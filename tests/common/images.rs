//! Textures and environments made by formula.

use overcoat::scene::{EquirectImage, Image, SceneError};

/// An image whose texels come from their column and row.
pub fn image(width: u32, height: u32, f: impl Fn(u32, u32) -> [u8; 4]) -> Result<Image, SceneError> {
    Image::new(width, height, (0..width * height).map(|k| f(k % width, k / width)).collect())
}

/// `cells * cells` fields of two colours.
pub fn checker(side: u32, cells: u32, colors: [[u8; 3]; 2]) -> Result<Image, SceneError> {
    image(side, side, |x, y| {
        let [r, g, b] = colors[((x * cells / side + y * cells / side) % 2) as usize];
        [r, g, b, 255]
    })
}

/// 16 x 16 texels with a letter F, red at the left edge, green on top: shows every turn and mirroring.
pub fn letter_f() -> Result<Image, SceneError> {
    image(16, 16, |x, y| match (x, y) {
        (0, _) => [220, 30, 30, 255],
        (_, 0) => [30, 200, 30, 255],
        (5..=6, 3..=13) | (7..=11, 3..=4) | (7..=10, 7..=8) => [20, 20, 20, 255],
        _ => [235, 235, 225, 255],
    })
}

/// A normal map, +Y up: `cells * cells` round bumps.
pub fn bumps(side: u32, cells: u32) -> Result<Image, SceneError> {
    image(side, side, |x, y| {
        let cell = (side / cells) as f32;
        let [dx, dy] = [x, y].map(|v| (v % (side / cells)) as f32 / cell * 2.0 - 1.0 + 1.0 / cell);
        let square = (dx * dx + dy * dy) / 0.81;
        // Green points up, rows run down.
        let normal = if square < 1.0 {
            let [nx, ny] = [0.75 * dx / 0.9, -0.75 * dy / 0.9];
            [nx, ny, (1.0 - nx * nx - ny * ny).sqrt()]
        } else {
            [0.0, 0.0, 1.0]
        };
        let [r, g, b] = normal.map(|n| ((n * 0.5 + 0.5) * 255.0 + 0.5) as u8);
        [r, g, b, 255]
    })
}

/// A white disc of full alpha whose rim fades to 0.
pub fn soft_disc(side: u32) -> Result<Image, SceneError> {
    image(side, side, |x, y| {
        let [dx, dy] = [x, y].map(|v| (v as f32 + 0.5) / side as f32 * 2.0 - 1.0);
        let alpha = 1.25 * (1.0 - (dx * dx + dy * dy).sqrt());
        [255, 255, 255, (alpha.clamp(0.0, 1.0) * 255.0 + 0.5) as u8]
    })
}

/// Columns of value 0 to 255 in all channels.
pub fn ramp(width: u32) -> Result<Image, SceneError> {
    image(width, 4, |x, _| [(x * 255 / (width - 1)) as u8; 4])
}

/// An environment: bright above, dim below, a soft box, and another colour on the horizon towards each axis (+X red,
/// +Z blue, -X green, -Z yellow).
pub fn sky() -> Result<EquirectImage, SceneError> {
    const WIDTH: u32 = 64;
    const HEIGHT: u32 = 32;
    let pixels = (0..WIDTH * HEIGHT)
        .map(|k| {
            let [x, y] = [k % WIDTH, k / WIDTH];
            let up = 1.0 - (y as f32 + 0.5) / HEIGHT as f32;
            if (36..44).contains(&x) && (6..11).contains(&y) {
                return [7.0, 6.8, 6.4];
            }
            let base = [0.16 + 0.44 * up, 0.15 + 0.5 * up, 0.13 + 0.62 * up];
            // Column 0 is -X, 16 -Z, 32 +X, 48 +Z.
            let tint = match x {
                0..4 | 60..64 => [0.1, 0.9, 0.1],
                12..20 => [0.9, 0.8, 0.1],
                28..36 => [0.9, 0.1, 0.1],
                44..52 => [0.1, 0.15, 0.9],
                _ => return base,
            };
            if (13..19).contains(&y) { tint } else { base }
        })
        .collect();
    EquirectImage::new(WIDTH, HEIGHT, pixels)
}

/// Black but for a strong light in one octant: its irradiance in bands up to the second falls below 0 on the far
/// side.
pub fn spotlight() -> Result<EquirectImage, SceneError> {
    let pixels =
        (0..64 * 32_u32)
            .map(|k| {
                if (38..42).contains(&(k % 64)) && (9..12).contains(&(k / 64)) { [60.0; 3] } else { [0.0; 3] }
            })
            .collect();
    EquirectImage::new(64, 32, pixels)
}
