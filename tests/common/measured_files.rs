//! Measurements that never were: files of MERL and of the RGL with the numbers of a formula.

use overcoat_core::math::double::{cos, sin_cos};
use std::f64::consts::{FRAC_1_PI, FRAC_PI_2, PI, TAU};

pub type Vector = [f64; 3];

/// A rough metal: GGX with height-correlated masking (Heitz 2014) and Schlick's term.
#[derive(Clone, Copy)]
pub struct Metal {
    pub alpha: [f64; 2],
    pub color: [f64; 3],
}

impl Metal {
    pub fn density(&self, m: Vector) -> f64 {
        let (x, y) = (m[0] / self.alpha[0], m[1] / self.alpha[1]);
        let length = x * x + y * y + m[2] * m[2];
        FRAC_1_PI / (self.alpha[0] * self.alpha[1] * length * length)
    }

    fn lambda(&self, w: Vector) -> f64 {
        let (x, y) = (self.alpha[0] * w[0] / w[2], self.alpha[1] * w[1] / w[2]);
        0.5 * ((1.0 + x * x + y * y).sqrt() - 1.0)
    }

    /// Area of facets that a direction sees.
    pub fn area(&self, w: Vector) -> f64 {
        let w = [w[0], w[1], w[2].max(1e-6)];
        w[2] * (1.0 + self.lambda(w))
    }

    pub fn brdf(&self, view: Vector, light: Vector) -> [f64; 3] {
        if view[2] <= 0.0 || light[2] <= 0.0 {
            return [0.0; 3];
        }
        let half = unit([view[0] + light[0], view[1] + light[1], view[2] + light[2]]);
        let smith = 1.0 / (1.0 + self.lambda(view) + self.lambda(light));
        let x = 1.0 - dot(view, half);
        let schlick = x * x * x * x * x;
        let lobe = self.density(half) * smith / (4.0 * view[2] * light[2]);
        self.color.map(|c| lobe * (c + (1.0 - c) * schlick))
    }
}

pub fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub fn unit(a: Vector) -> Vector {
    let length = dot(a, a).sqrt();
    a.map(|c| c / length)
}

pub fn direction(elevation: f64, azimuth: f64) -> Vector {
    let ((s, c), (y, x)) = (sin_cos(elevation), sin_cos(azimuth));
    [s * x, s * y, c]
}

fn mirrored(w: Vector, half: Vector) -> Vector {
    let along = 2.0 * dot(w, half);
    std::array::from_fn(|k| along * half[k] - w[k])
}

/// A MERL file with so many half angles, difference angles and azimuths; -1 where a direction is below the horizon.
pub fn merl(size: [usize; 3], brdf: impl Fn(Vector, Vector) -> [f64; 3]) -> Vec<u8> {
    let mut file: Vec<u8> = size.iter().flat_map(|n| (*n as i32).to_le_bytes()).collect();
    let [a, b, c] = size;
    let scale = [1500.0, 1500.0 / 1.15, 1500.0 / 1.66];
    let mut planes = [const { Vec::<u8>::new() }; 3];
    let middle = |k: usize, n: usize| (k as f64 + 0.5) / n as f64;
    for i in 0..a {
        let share = middle(i, a);
        let (sin, cos) = sin_cos(share * share * FRAC_PI_2);
        for j in 0..b {
            for k in 0..c {
                let [x, y, z] = direction(middle(j, b) * FRAC_PI_2, middle(k, c) * PI);
                // From about +Z to about the half vector in the plane of x and z.
                let light = [x * cos + z * sin, y, z * cos - x * sin];
                let view = mirrored(light, [sin, 0.0, cos]);
                let measured = view[2] > 0.0 && light[2] > 0.0;
                let color = brdf(view, light);
                for (channel, plane) in planes.iter_mut().enumerate() {
                    let number = if measured { color[channel] * scale[channel] } else { -1.0 };
                    plane.extend(number.to_le_bytes());
                }
            }
        }
    }
    file.extend(planes.concat());
    file
}

/// A field of a tensor file.
pub struct Field {
    pub name: &'static str,
    pub kind: u8,
    pub shape: Vec<u64>,
    pub bytes: Vec<u8>,
}

pub fn floats(name: &'static str, shape: &[usize], numbers: &[f64]) -> Field {
    assert_eq!(shape.iter().product::<usize>(), numbers.len(), "{name}");
    let bytes = numbers.iter().flat_map(|n| (*n as f32).to_le_bytes()).collect();
    Field { name, kind: 10, shape: shape.iter().map(|n| *n as u64).collect(), bytes }
}

pub fn tensor_file(fields: &[Field]) -> Vec<u8> {
    let mut file = b"tensor_file\0\x01\x00".to_vec();
    file.extend((fields.len() as u32).to_le_bytes());
    let header: usize = fields.iter().map(|f| 2 + f.name.len() + 2 + 1 + 8 + 8 * f.shape.len()).sum();
    let mut offset = file.len() + header;
    for field in fields {
        file.extend((field.name.len() as u16).to_le_bytes());
        file.extend(field.name.as_bytes());
        file.extend((field.shape.len() as u16).to_le_bytes());
        file.push(field.kind);
        file.extend((offset as u64).to_le_bytes());
        file.extend(field.shape.iter().flat_map(|n| n.to_le_bytes()));
        offset += field.bytes.len();
    }
    fields.iter().for_each(|field| file.extend(&field.bytes));
    file
}

/// Tables of an RGL file: rows and columns of the facets' tables, and the side of the BRDF's.
pub struct Tables {
    pub facets: [usize; 2],
    pub side: usize,
    pub elevations: usize,
    /// Azimuths of the tables; one for an isotropic material.
    pub azimuths: Vec<f64>,
}

/// Integral up to a share of its length of what is linear between evenly spaced numbers, in units of steps.
fn integral(numbers: &[f64], share: f64) -> f64 {
    let place = share * (numbers.len() - 1) as f64;
    let cell = (place as usize).min(numbers.len() - 2);
    let (x, low, high) = (place - cell as f64, numbers[cell], numbers[cell + 1]);
    let before: f64 = numbers[..=cell].windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).sum();
    before + x * (low + 0.5 * x * (high - low))
}

/// Position in the rising values of a function of 0 to 1.
fn solve(value: f64, of: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if of(middle) < value { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// An RGL file of a metal whose colour stands in the tables of red, green and blue.
pub fn rgl(metal: Metal, tables: &Tables) -> Vec<u8> {
    tensor_file(&rgl_fields(metal, tables))
}

pub fn rgl_fields(metal: Metal, tables: &Tables) -> Vec<Field> {
    let [rows, columns] = tables.facets;
    let place = |k: usize, n: usize| k as f64 / (n - 1) as f64;
    let half = |u: f64, v: f64, turn: f64| direction(u * u * FRAC_PI_2, (2.0 * v - 1.0) * PI + turn);
    let square = |of: &dyn Fn(f64, f64) -> f64| -> Vec<f64> {
        (0..rows * columns).map(|k| of(place(k % columns, columns), place(k / columns, rows))).collect()
    };
    let is_isotropic = tables.azimuths.len() == 1;
    let elevations: Vec<f64> = (0..tables.elevations).map(|k| 1.45 * place(k, tables.elevations)).collect();
    let (mut vndf, mut rgb, mut luminance) = (Vec::new(), Vec::new(), Vec::new());
    for azimuth in &tables.azimuths {
        for elevation in &elevations {
            let view = direction(*elevation, *azimuth);
            let turn = if is_isotropic { *azimuth } else { 0.0 };
            // Seen facets by area of the square: dm = sin t dt dp = 2 pi^2 u sin t du dv.
            let table = square(&|u, v| {
                let m = half(u, v, turn);
                let seen = dot(view, m).max(0.0);
                metal.density(m) * seen / metal.area(view) * TAU * PI * u * sin_cos(u * u * FRAC_PI_2).0
                    + 1e-4
            });
            let in_row = |row: &[f64], u: f64| integral(row, u);
            let sums: Vec<f64> = table.chunks(columns).map(|row| in_row(row, 1.0)).collect();
            let whole = integral(&sums, 1.0);
            let side = tables.side;
            let mut channels = [const { Vec::<f64>::new() }; 3];
            for k in 0..side * side {
                let (s, t) = (place(k % side, side), place(k / side, side));
                let v = solve(t, |v| integral(&sums, v) / whole);
                let at = v * (rows - 1) as f64;
                let above = (at as usize).min(rows - 2);
                let y = at - above as f64;
                let [a, b] = [above, above + 1].map(|r| &table[r * columns..(r + 1) * columns]);
                let row: Vec<f64> = a.iter().zip(b).map(|(a, b)| (1.0 - y) * a + y * b).collect();
                let u = solve(s, |u| in_row(&row, u) / in_row(&row, 1.0));
                let m = half(u, v, turn);
                let light = mirrored(view, m);
                // Below the horizon the last value above it goes on.
                let light = unit([light[0], light[1], light[2].max(1e-3)]);
                let color = metal.brdf(view, light);
                let between = unit([view[0] + light[0], view[1] + light[1], view[2] + light[2]]);
                let factor = 4.0 * metal.area(view) / metal.density(between);
                (0..3).for_each(|c| channels[c].push(color[c] * factor));
            }
            luminance.extend(
                (0..side * side)
                    .map(|k| 0.2126 * channels[0][k] + 0.7152 * channels[1][k] + 0.0722 * channels[2][k]),
            );
            vndf.extend(table);
            rgb.extend(channels.concat());
        }
    }
    let (n, m, side) = (tables.azimuths.len(), tables.elevations, tables.side);
    let byte =
        |name, bytes: &[u8]| Field { name, kind: 1, shape: vec![bytes.len() as u64], bytes: bytes.to_vec() };
    vec![
        byte("description", b"A metal that nobody made"),
        byte("jacobian", &[1]),
        floats("phi_i", &[n], &tables.azimuths),
        floats("theta_i", &[m], &elevations),
        floats("ndf", &[rows, columns], &square(&|u, v| metal.density(half(u, v, 0.0)))),
        floats("sigma", &[rows, columns], &square(&|u, v| metal.area(half(u, v, 0.0)))),
        floats("vndf", &[n, m, rows, columns], &vndf),
        floats("luminance", &[n, m, side, side], &luminance),
        floats("rgb", &[n, m, 3, side, side], &rgb),
    ]
}

/// Lacquer over a metal as three.js has it: a lobe of F0 0.04, and below it what its term lets through from the viewer.
pub fn coated(base: &Metal, coat_alpha: f64, view: Vector, light: Vector) -> [f64; 3] {
    let coat = Metal { alpha: [coat_alpha; 2], color: [0.04; 3] };
    let schlick = |w: Vector| {
        let x = 1.0 - w[2].clamp(0.0, 1.0);
        0.04 + 0.96 * x * x * x * x * x
    };
    let through = 1.0 - schlick(view);
    let (lobe, below) = (coat.brdf(view, light), base.brdf(view, light));
    std::array::from_fn(|c| lobe[c] + through * below[c])
}

/// Directions above the horizon from numbers that depend on their place alone.
pub fn pairs(count: u32) -> impl Iterator<Item = [Vector; 2]> {
    let number = |k: u32| {
        let mut x = k.wrapping_mul(0x9e37_79b9) ^ 0x85eb_ca6b;
        for (shift, factor) in [(16, 0x7feb_352d_u32), (15, 0x846c_a68b)] {
            x = (x ^ (x >> shift)).wrapping_mul(factor);
        }
        f64::from(x >> 8) / f64::from(1 << 24)
    };
    (0..count).map(move |k| {
        [0, 2].map(|at| {
            let z = 0.15 + 0.85 * number(4 * k + at);
            let (y, x) = sin_cos(TAU * number(4 * k + at + 1));
            let radius = (1.0 - z * z).sqrt();
            [radius * x, radius * y, z]
        })
    })
}

/// Cosine of an angle in degrees.
pub fn cosine(degrees: f64) -> f64 {
    cos(degrees.to_radians())
}
