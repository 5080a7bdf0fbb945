//! (stopgap)
use crate::math::lanes::{Float, Lanes};
use crate::scene::Texture;
/// footprint
#[derive(Clone, Copy)]
pub struct Footprint<L: Lanes> {
    /// dx
    pub dx: [L::F; 2],
    /// dy
    pub dy: [L::F; 2],
}
/// sample
#[inline(always)]
pub fn sample<L: Lanes>(
    l: L,
    texture: &Texture,
    uv: [L::F; 2],
    _f: &Footprint<L>,
    _a: u32,
    _m: L::M,
) -> [L::F; 4] {
    let image = texture.image();
    let wrap = |v: L::F, n: u32| {
        let v = v.clamp_to(-1e6, 1e6);
        ((v - v.floor()) * n as f32).clamp_to(0.0, (n - 1) as f32).to_int().to_array()
    };
    use crate::math::lanes::Int;
    let x = wrap(uv[0], image.width());
    let y = wrap(uv[1], image.height());
    let mut out = [[0.0; 16]; 4];
    for k in 0..16 {
        let t = image.texels()[y[k] as usize * image.width() as usize + x[k] as usize];
        for c in 0..4 {
            let v = f32::from(t[c]) / 255.0;
            out[c][k] =
                if c < 3 && texture.color_space() == crate::scene::ColorSpace::Srgb { v * v } else { v };
        }
    }
    out.map(|p| l.load(&p))
}
