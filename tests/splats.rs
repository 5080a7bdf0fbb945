//! Gaussian splats: what a pixel shows of them, by the formulas of Kerbl et al. 2023, and the files that hold them.

use base64::Engine;
use overcoat::color::srgb::linear_to_srgb;
use overcoat::frame::{Aov, Frame};
use overcoat::jobs::Jobs;
use overcoat::limits::Limits;
use overcoat::load::{Context, Format, LoadOptions, Loaded, NoResolver, load_bytes, load_bytes_with};
use overcoat::render::{Background, RenderOptions, Renderer};
use overcoat::scene::{
    AlphaMode, Axis, Camera, Framing, Instance, Material, Mesh, MeshData, Projection, Scene, Splat,
    SplatCloudBuilder, SplatColorSpace, SplatInstance, SplatOrder, Transform,
};
use overcoat_core::math::scalar::{exp, ln};
use serde_json::{Value, json};

const SIZE: u32 = 64;

const ROUND: Splat = Splat {
    position: [0.0; 3],
    scale: [0.1; 3],
    rotation: [0.0, 0.0, 0.0, 1.0],
    opacity: 0.8,
    color: [0.25, 0.5, 0.75],
};

/// 32 pixels a metre, the origin in the middle.
fn parallel() -> Camera {
    Camera::new([0.0, 0.0, 10.0], [0.0; 3], [0.0, 1.0, 0.0], Projection::Orthographic { height: 2.0 }, 0.01)
}

fn options() -> RenderOptions {
    RenderOptions::draft(SIZE, SIZE)
}

fn add(scene: &mut Scene, splats: &[Splat], transform: Transform) {
    let mut builder = SplatCloudBuilder::new(0, SplatColorSpace::Srgb, SplatOrder::Depth).unwrap();
    splats.iter().for_each(|splat| builder.push(splat, &[]).unwrap());
    let cloud = scene.add_splats(builder.finish()).unwrap();
    scene.add_splat_instance(SplatInstance::new(cloud, transform).with_object(6)).unwrap();
}

fn cloud(splats: &[Splat]) -> Scene {
    let mut scene = Scene::new();
    add(&mut scene, splats, Transform::IDENTITY);
    scene
}

fn render(scene: &Scene, camera: &Camera) -> Frame {
    Renderer::new(1).render(scene, camera, &options()).unwrap().frame
}

fn pixel(frame: &Frame, x: u32, y: u32) -> [f32; 4] {
    frame.pixels[(y * frame.width + x) as usize]
}

/// Straight colour of a pixel as a screen shows it, and its opacity.
fn shown(frame: &Frame, x: u32, y: u32) -> [f32; 4] {
    let [r, g, b, a] = pixel(frame, x, y);
    [linear_to_srgb(r / a), linear_to_srgb(g / a), linear_to_srgb(b / a), a]
}

fn near(found: f32, expected: f32, tolerance: f32, what: &str) {
    assert!((found - expected).abs() <= tolerance, "{what}: {found}, expected {expected}");
}

/// The opacity that the Gaussian has at a pixel, for a covariance in pixels squared that lacks the pixel's own.
fn gaussian(opacity: f32, [a, b, c]: [f32; 3], [x, y]: [f32; 2]) -> f32 {
    let (a, c) = (a + 0.3, c + 0.3);
    let alpha = opacity * exp(-0.5 * (c * x * x - 2.0 * b * x * y + a * y * y) / (a * c - b * b));
    if alpha < 1.0 / 255.0 { 0.0 } else { alpha }
}

#[test]
fn one_splat_is_its_gaussian() {
    // A needle turned by 30 degrees, off the middle.
    let (sin, cos) = (0.258_819_04, 0.965_925_8);
    let splat = Splat {
        position: [0.2, -0.1, 0.0],
        scale: [0.3, 0.05, 0.1],
        rotation: [0.0, 0.0, sin, cos],
        ..ROUND
    };
    let frame = render(&cloud(&[splat]), &parallel());
    let (c, s) = (cos * cos - sin * sin, 2.0 * sin * cos);
    // In pixels, with y down.
    let (long, short) = ((0.3_f32 * 32.0) * (0.3 * 32.0), (0.05_f32 * 32.0) * (0.05 * 32.0));
    let covariance = [c * c * long + s * s * short, -(c * s) * (long - short), s * s * long + c * c * short];
    let mut seen = 0;
    for y in 0..SIZE {
        for x in 0..SIZE {
            let at = [x as f32 + 0.5 - 32.0 - 0.2 * 32.0, y as f32 + 0.5 - 32.0 - 0.1 * 32.0];
            let expected = gaussian(splat.opacity, covariance, at);
            let found = pixel(&frame, x, y)[3];
            // At the cut either side is right.
            if (expected - 1.0 / 255.0).abs() > 1e-4 || found != 0.0 {
                near(found, expected, 4e-3 * (1.0 - f32::from(u8::from(expected > 0.01))) + 2e-5, "opacity");
            }
            if found > 0.0 {
                seen += 1;
                let [r, g, b, _] = shown(&frame, x, y);
                for (found, expected) in [r, g, b].into_iter().zip(splat.color) {
                    near(found, expected, 1e-5, "colour");
                }
            }
        }
    }
    assert!(seen > 300, "{seen}");
}

#[test]
fn a_perspective_view_has_the_jacobian_of_its_projection() {
    let splat = Splat { position: [0.8, 0.0, 0.0], scale: [0.02, 0.02, 0.4], opacity: 1.0, ..ROUND };
    let mut camera = parallel();
    (camera.eye, camera.projection) = ([0.0, 0.0, 4.0], Projection::Perspective { fov_y: 0.8 });
    let frame = render(&cloud(&[splat]), &camera);
    // tan(0.4)
    let focal = 32.0 / 0.422_793_22_f32;
    let (per_unit, at) = (focal / 4.0, 0.2);
    let variance = |v: f32| v * v * per_unit * per_unit;
    let covariance = [variance(0.02) + variance(0.4 * at), 0.0, variance(0.02)];
    for x in 40..58 {
        let offset = [x as f32 + 0.5 - 32.0 - 0.8 * per_unit, -0.5];
        near(pixel(&frame, x, 31)[3], gaussian(1.0, covariance, offset), 2e-4, "opacity");
    }
}

#[test]
fn colours_are_blended_as_a_screen_shows_them_the_nearest_in_front() {
    let front =
        Splat { position: [0.0, 0.0, 1.0], color: [1.0, 0.0, 0.5], opacity: 0.5, scale: [9.0; 3], ..ROUND };
    let back =
        Splat { position: [0.0, 0.0, -1.0], color: [0.0, 1.0, 0.5], opacity: 0.8, scale: [9.0; 3], ..ROUND };
    for list in [[front, back], [back, front]] {
        let found = shown(&render(&cloud(&list), &parallel()), 32, 32);
        let opacity = 0.5 + 0.5 * 0.8;
        for (found, expected) in found.into_iter().zip([0.5 / opacity, 0.4 / opacity, 0.5, opacity]) {
            near(found, expected, 1e-4, "blended");
        }
    }
}

#[test]
fn the_order_in_the_file_does_not_show() {
    let splat = |k: u32| {
        let at = |n: u32| ((k * 7 + n * 13) % 41) as f32 / 20.0 - 1.0;
        let color = [at(5).abs(), at(6).abs(), 0.5];
        Splat { position: [at(1), at(2), k as f32 * 0.01], color, scale: [0.2, 0.1, 0.1], ..ROUND }
    };
    let forwards: Vec<Splat> = (0..200).map(splat).collect();
    let backwards: Vec<Splat> = forwards.iter().rev().copied().collect();
    let hash = |list: &[Splat]| render(&cloud(list), &parallel()).frame_hash();
    assert_eq!(hash(&forwards), hash(&backwards));
    assert_ne!(hash(&forwards), hash(&forwards[1..]));
}

#[test]
fn a_cloud_is_moved_turned_and_scaled_as_a_whole() {
    let list = [Splat { position: [0.3, 0.1, 0.2], scale: [0.3, 0.05, 0.1], ..ROUND }];
    let (sin, cos) = (0.5, 0.75_f64.sqrt());
    let turned = Transform::from_parts([0.1, 0.2, 0.0], [0.0, 0.0, sin, cos], [1.5; 3]).unwrap();
    let mut placed = Scene::new();
    add(&mut placed, &list, turned);
    let position = turned.point(list[0].position.map(f64::from)).map(|v| v as f32);
    let rotation = [0.0, 0.0, sin as f32, cos as f32];
    let same = cloud(&[Splat { position, rotation, scale: list[0].scale.map(|v| v * 1.5), ..list[0] }]);
    let (a, b) = (render(&placed, &parallel()), render(&same, &parallel()));
    for (a, b) in a.pixels.as_flattened().iter().zip(b.pixels.as_flattened()) {
        // A pixel at the cut may fall to either side.
        assert!((a - b).abs() < 5e-3, "{a} {b}");
    }
}

#[test]
fn harmonics_are_those_of_the_direction_from_the_camera() {
    let mut builder = SplatCloudBuilder::new(1, SplatColorSpace::Srgb, SplatOrder::Depth).unwrap();
    // -y of red, z of green, -x of blue.
    let coefficients = [[0.5, 0.0, 0.0], [0.0, 0.5, 0.0], [0.0, 0.0, 0.5]];
    builder.push(&Splat { color: [0.5; 3], opacity: 1.0, ..ROUND }, &coefficients).unwrap();
    let mut scene = Scene::new();
    let cloud = scene.add_splats(builder.finish()).unwrap();
    scene.add_splat_instance(SplatInstance::new(cloud, Transform::IDENTITY)).unwrap();
    let part = 0.5 * 0.488_602_5;
    for (eye, expected) in [
        ([0.0, 0.0, 5.0], [0.5, 0.5 - part, 0.5]),
        ([0.0, 0.0, -5.0], [0.5, 0.5 + part, 0.5]),
        ([5.0, 0.0, 0.0], [0.5, 0.5, 0.5 + part]),
        ([0.0, -5.0, 0.0], [0.5 - part, 0.5, 0.5]),
    ] {
        let mut camera = parallel();
        (camera.eye, camera.up) = (eye, [0.1, 0.2, 0.3]);
        camera.projection = Projection::Perspective { fov_y: 0.3 };
        let found = shown(&render(&scene, &camera), 32, 32);
        for (found, expected) in found.into_iter().zip(expected) {
            near(found, expected, 1e-3, "colour");
        }
    }
}

/// A square of side 2 at a depth.
fn sheet(scene: &mut Scene, z: f32, material: Material) {
    let positions = vec![[-1.0, -1.0, z], [1.0, -1.0, z], [1.0, 1.0, z], [-1.0, 1.0, z]];
    let data = MeshData::new(positions, vec![[0, 1, 2], [0, 2, 3]]);
    let mesh = scene.add_mesh(Mesh::new(data).unwrap()).unwrap();
    let material = scene.add_material(material.with(|m| m.unlit = true)).unwrap();
    scene.add_instance(Instance::new(mesh, material, Transform::IDENTITY).with_object(2)).unwrap();
}

#[test]
fn surfaces_hide_splats_behind_and_show_through_those_before() {
    let splat = |z: f32| Splat {
        position: [0.0, 0.0, z],
        scale: [9.0; 3],
        opacity: 0.5,
        color: [1.0, 0.0, 0.0],
        ..ROUND
    };
    let blue = Material::default().with(|m| m.base_color = [0.0, 0.0, 1.0, 1.0]);
    for (z, expected) in [(-1.0, [0.0, 0.0, 1.0, 1.0]), (1.0, [0.5, 0.0, 0.5, 1.0])] {
        let mut scene = cloud(&[splat(z)]);
        sheet(&mut scene, 0.0, blue.clone());
        let frame = render(&scene, &parallel());
        for (found, expected) in pixel(&frame, 20, 40).into_iter().zip(expected) {
            near(found, expected, 1e-3, "over an opaque surface");
        }
    }
    // Red, blue, red: each lets half of the light through.
    let mut scene = cloud(&[splat(-1.0), splat(1.0)]);
    let half = blue.with(|m| {
        m.base_color = [0.0, 0.0, 1.0, 0.5];
        m.alpha_mode = AlphaMode::Blend;
    });
    sheet(&mut scene, 0.0, half);
    for (found, expected) in
        pixel(&render(&scene, &parallel()), 20, 40).into_iter().zip([0.625, 0.0, 0.25, 0.875])
    {
        near(found, expected, 1e-3, "around a blended surface");
    }
}

#[test]
fn opacity_backgrounds_and_planes() {
    let list = [Splat { opacity: 0.7, scale: [0.3; 3], ..ROUND }];
    let scene = cloud(&list);
    let aovs = vec![Aov::Depth, Aov::ObjectId, Aov::Coverage];
    let with = options().with_aovs(aovs);
    let frame = Renderer::new(1).render(&scene, &parallel(), &with).unwrap().frame;
    let (middle, edge) = ((32 * SIZE + 32) as usize, (32 * SIZE + 45) as usize);
    let ([depth, coverage], object) = ([0, 2].map(|k| &frame.aovs[k].data), &frame.aovs[1].ids);
    near(depth[middle], 10.0, 1e-5, "distance");
    assert_eq!((object[middle], depth[0], object[0], coverage[0]), (7, 0.0, 0, 0.0));
    assert_eq!(coverage[middle], frame.pixels[middle][3]);
    // Less than half covered: no distance, but some coverage.
    assert!(depth[edge] == 0.0 && coverage[edge] > 0.05 && coverage[edge] < 0.5, "{}", coverage[edge]);
    let background = options().with_background(Background::Environment);
    let full = Renderer::new(1).render(&scene, &parallel(), &background).unwrap().frame;
    assert!(full.pixels.iter().all(|p| p[3] == 1.0));
}

#[test]
fn work_and_memory_are_limited() {
    let scene = cloud(&vec![Splat { scale: [9.0; 3], opacity: 0.01, ..ROUND }; 5000]);
    for (limits, field) in [
        (Limits::default().with_blocks(10_000), "blocks"),
        (Limits::default().with_frame_bytes(100_000), "frame_bytes"),
        (Limits::default().with_vertices(4999), "vertices"),
    ] {
        for threads in [1, 3] {
            let with = options().with_limits(limits.clone());
            let error = Renderer::new(threads).render(&scene, &parallel(), &with).unwrap_err().to_string();
            assert!(error.contains(field), "{error}");
        }
    }
    let mut scene = scene;
    sheet(&mut scene, -1.0, Material::default());
    let with = options().with_limits(Limits::default().with_blend_entries(50_000));
    let error = Renderer::new(2).render(&scene, &parallel(), &with).unwrap_err().to_string();
    assert!(error.contains("blend_entries"), "{error}");
}

fn load(bytes: impl AsRef<[u8]>) -> Loaded {
    try_load(bytes.as_ref()).unwrap()
}

fn try_load(bytes: &[u8]) -> Result<Loaded, String> {
    let (limits, jobs) = (Limits::default(), Jobs::new(1));
    let context = Context { resolver: &NoResolver, limits: &limits, jobs: &jobs };
    load_bytes(bytes, Some(Format::Ply), &context).map_err(|error| error.to_string())
}

/// The header of a file of splats in the order of trainers.
fn header(encoding: &str, scalar: &str, count: usize, rest: usize, more: &str) -> String {
    let rest = (0..rest).map(|k| format!("f_rest_{k}"));
    let names =
        ["x", "y", "z", "nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2"].map(str::to_owned).into_iter();
    let last =
        ["opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"].map(str::to_owned);
    let properties: String =
        names.chain(rest).chain(last).map(|name| format!("property {scalar} {name}\n")).collect();
    format!("ply\nformat {encoding} 1.0\n{more}element vertex {count}\n{properties}end_header\n")
}

/// x y z, no normal, colour, opacity, scale, rotation about z by 90 degrees.
const PLAIN: [f32; 17] =
    [1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 1.0, 0.0, -1.0, 0.0, -1.0, -2.0, -3.0, 0.5, 0.0, 0.0, 0.5];

fn binary(rows: &[&[f32]], rest: usize, more: &str) -> Vec<u8> {
    let mut bytes = header("binary_little_endian", "float", rows.len(), rest, more).into_bytes();
    bytes.extend(rows.iter().flat_map(|row| row.iter()).flat_map(|v| v.to_le_bytes()));
    bytes
}

#[test]
fn files_of_every_encoding_are_the_same_splats() {
    let text: String = PLAIN.iter().map(|v| format!("{v} ")).collect();
    let double = |big: bool| -> Vec<u8> {
        let encoding = if big { "binary_big_endian" } else { "binary_little_endian" };
        let mut bytes = header(encoding, "double", 1, 0, "").into_bytes();
        let encode = |v: f32| if big { f64::from(v).to_be_bytes() } else { f64::from(v).to_le_bytes() };
        bytes.extend(PLAIN.iter().flat_map(|&v| encode(v)));
        bytes
    };
    let ascii = [header("ascii", "float", 1, 0, ""), text].concat().into_bytes();
    for bytes in [binary(&[&PLAIN], 0, ""), ascii, double(false), double(true)] {
        let loaded = load(bytes);
        assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
        let splat = loaded.scene.splats()[0].splat(0).unwrap();
        assert_eq!(splat.position, [1.0, 2.0, 3.0]);
        near(splat.opacity, 0.5, 1e-6, "opacity");
        // Colours of degree 0 are 0.5 + 0.28209479 dc.
        for (found, expected) in splat.color.into_iter().zip([0.782_094_8, 0.5, 0.217_905_2]) {
            near(found, expected, 1e-6, "colour");
        }
        for (found, expected) in splat.scale.into_iter().zip([-1.0, -2.0, -3.0]) {
            near(ln(found), expected, 1e-6, "scale");
        }
        let half = std::f32::consts::FRAC_1_SQRT_2;
        for (found, expected) in splat.rotation.into_iter().zip([0.0, 0.0, half, half]) {
            near(found, expected, 1e-6, "rotation");
        }
    }
}

#[test]
fn minus_y_is_up_unless_a_comment_says_otherwise() {
    for (more, up) in [
        ("", [0.0, -1.0, 0.0]),
        ("comment Vertical Axis: z\n", [0.0, 0.0, 1.0]),
        ("comment vertical axis: Y\n", [0.0, 1.0, 0.0]),
    ] {
        let scene = load(binary(&[&PLAIN], 0, more)).scene;
        let transform = &scene.splat_instances()[0].transform;
        assert_eq!(transform.direction(up), [0.0, 1.0, 0.0], "{more}");
        assert!((transform.determinant() - 1.0).abs() < 1e-12);
    }
}

#[test]
fn an_axis_that_is_chosen_counts_for_more_than_the_usual_one() {
    let bytes = binary(&[&PLAIN], 0, "comment Vertical Axis: y\n");
    let (limits, jobs) = (Limits::default(), Jobs::new(1));
    let context = Context { resolver: &NoResolver, limits: &limits, jobs: &jobs };
    for &up in Axis::ALL {
        let options = LoadOptions::default().with_up(up);
        let scene = load_bytes_with(&bytes, Some(Format::Ply), &options, &context).unwrap().scene;
        assert_eq!(scene.orientation().up, up);
        let transform = &scene.splat_instances()[0].transform;
        let (sign, letter) = up.name().split_at(1);
        let along = if sign == "-" { -1.0 } else { 1.0 };
        let axis = ["x", "y", "z"].map(|name| if name == letter { along } else { 0.0 });
        assert_eq!(transform.direction(axis), [0.0, 1.0, 0.0], "{up:?}");
    }
}

#[test]
fn harmonics_are_stored_colour_by_colour() {
    for (degree, each) in [(1_u8, 3_usize), (2, 8), (3, 15)] {
        let mut row = PLAIN[..9].to_vec();
        row.extend((0..3 * each).map(|k| k as f32));
        row.extend(&PLAIN[9..]);
        let scene = load(binary(&[&row], 3 * each, "")).scene;
        let cloud = &scene.splats()[0];
        assert_eq!(cloud.degree(), degree);
        let second = cloud.harmonics(0)[1].map(|bits| half::f16::from_bits(bits).to_f32());
        assert_eq!(second, [1.0, 1.0 + each as f32, 1.0 + 2.0 * each as f32]);
    }
    // Nine and one more.
    let mut row = PLAIN[..9].to_vec();
    row.extend([0.0; 10]);
    row.extend(&PLAIN[9..]);
    let loaded = load(binary(&[&row], 10, ""));
    assert!(loaded.warnings[0].message.contains("of 10 properties 'f_rest_*' those of degree 1"));
}

#[test]
fn damaged_splats_are_left_out_and_counted() {
    let with = |place: usize, value: f32| {
        let mut row = PLAIN;
        row[place] = value;
        row
    };
    let mut unturned = PLAIN;
    unturned[13..].fill(0.0);
    let rows = [PLAIN, with(0, f32::NAN), with(9, f32::NAN), with(10, 60.0), with(2, 1e20), unturned];
    let rows: Vec<&[f32]> = rows.iter().map(|row| &row[..]).collect();
    let loaded = load(binary(&rows, 0, ""));
    assert_eq!(loaded.scene.splat_count(), 2);
    let messages: Vec<&str> = loaded.warnings.iter().map(|w| w.message.as_str()).collect();
    assert_eq!(messages.len(), 2, "{messages:?}");
    assert!(messages[0].starts_with("PLY: 4 splats left out: not finite"), "{messages:?}");
    assert!(messages[1].contains("1 splat with a rotation of zeros"), "{messages:?}");
    // A file that ends in the middle of its third splat.
    let whole = binary(&rows[..1].repeat(4), 0, "");
    let loaded = load(&whole[..whole.len() - 17 * 4 - 5]);
    assert_eq!(loaded.scene.splat_count(), 2);
    assert!(
        loaded.warnings[0].message.contains("the file ends after 2 of 4 splats"),
        "{:?}",
        loaded.warnings
    );
    let error = try_load(&whole[..whole.len() - 4 * 17 * 4]).unwrap_err();
    assert!(error.contains("the file ends within"), "{error}");
    // More splats than bytes cost nothing.
    let many = header("binary_little_endian", "float", 4_000_000_000, 45, "");
    assert!(try_load(many.as_bytes()).is_err());
}

/// Words of a chunk from 0 to 1 in x, 0 to 2 in y, 0 to 4 in z.
fn packed(harmonics: &[u8]) -> Vec<u8> {
    let bounds = ["x", "y", "z", "scale_x", "scale_y", "scale_z"];
    let names = ["min", "max"].into_iter().flat_map(|end| bounds.map(|name| format!("{end}_{name}")));
    let floats: String = names.map(|name| format!("property float {name}\n")).collect();
    let words: String =
        ["position", "rotation", "scale", "color"].map(|n| format!("property uint packed_{n}\n")).concat();
    let mut text =
        format!("ply\nformat binary_little_endian 1.0\nelement chunk 1\n{floats}element vertex 1\n{words}");
    if !harmonics.is_empty() {
        text += "element sh 1\n";
        text.extend((0..harmonics.len()).map(|k| format!("property uchar f_rest_{k}\n")));
    }
    text += "end_header\n";
    let mut bytes = text.into_bytes();
    let chunk = [0.0, 0.0, 0.0, -3.0, -3.0, -3.0, 1.0, 2.0, 4.0, -1.0, -1.0, -1.0_f32];
    bytes.extend(chunk.iter().flat_map(|v| v.to_le_bytes()));
    // The largest of the four is the second (x); the others are 0.
    let middle = 511 << 20 | 512 << 10 | 511;
    let words: [u32; 4] = [2047 << 21 | 512 << 11, 1 << 30 | middle, 2047 << 11 & 0x1f_f800, 0xff80_0040];
    bytes.extend(words.iter().flat_map(|v| v.to_le_bytes()));
    bytes.extend(harmonics);
    bytes
}

#[test]
fn packed_splats_are_unpacked() {
    let loaded = load(packed(&[]));
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    let splat = loaded.scene.splats()[0].splat(0).unwrap();
    for (found, expected) in splat.position.into_iter().zip([1.0, 1.0, 0.0]) {
        near(found, expected, 1e-3, "position");
    }
    for (found, expected) in splat.scale.into_iter().zip([-3.0, -1.0, -3.0]) {
        near(ln(found), expected, 1e-5, "scale");
    }
    near(splat.rotation[0], 1.0, 1e-5, "rotation");
    near(splat.opacity, 64.0 / 255.0, 1e-6, "opacity");
    assert_eq!([splat.color[0], splat.color[2]], [1.0, 0.0]);
    let codes: Vec<u8> = (0..9).map(|k| if k == 0 { 255 } else { 128 + k }).collect();
    let loaded = load(packed(&codes));
    let cloud = &loaded.scene.splats()[0];
    assert_eq!(cloud.degree(), 1);
    let first = cloud.harmonics(0)[0].map(|bits| half::f16::from_bits(bits).to_f32());
    for (found, expected) in first.into_iter().zip([4.0, 3.5 / 32.0, 6.5 / 32.0]) {
        near(found, expected, 2e-3, "harmonics");
    }
    // Boxes are missing.
    let text = String::from_utf8_lossy(&packed(&[])).replace("element chunk 1", "element chunk 0");
    assert!(try_load(text.as_bytes()).is_err());
}

/// A document of two splats with harmonics of degree 1: names and numbers of attributes, and what the extension says.
fn document(change: impl Fn(&mut Value)) -> Result<Loaded, String> {
    let attributes: [(&str, &str, &[f32]); 8] = [
        ("POSITION", "VEC3", &[0.0, 0.0, 0.0, 1.0, 2.0, 3.0]),
        ("KHR_gaussian_splatting:ROTATION", "VEC4", &[0.0, 0.0, 0.0, 1.0, 0.6, 0.0, 0.0, 0.8]),
        ("KHR_gaussian_splatting:SCALE", "VEC3", &[0.1, 0.1, 0.1, 0.1, 0.2, 0.3]),
        ("KHR_gaussian_splatting:OPACITY", "SCALAR", &[1.0, 0.25]),
        ("KHR_gaussian_splatting:SH_DEGREE_0_COEF_0", "VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, -1.0]),
        ("KHR_gaussian_splatting:SH_DEGREE_1_COEF_0", "VEC3", &[0.0, 0.0, 0.0, 1.0, 2.0, 3.0]),
        ("KHR_gaussian_splatting:SH_DEGREE_1_COEF_1", "VEC3", &[0.0; 6]),
        ("KHR_gaussian_splatting:SH_DEGREE_1_COEF_2", "VEC3", &[0.0; 6]),
    ];
    let mut bytes: Vec<u8> = Vec::new();
    let (mut views, mut accessors, mut names) = (Vec::new(), Vec::new(), serde_json::Map::new());
    for (k, (name, kind, numbers)) in attributes.into_iter().enumerate() {
        views.push(json!({"buffer": 0, "byteOffset": bytes.len(), "byteLength": 4 * numbers.len()}));
        accessors.push(json!({"bufferView": k, "componentType": 5126, "count": 2, "type": kind}));
        names.insert(name.to_owned(), json!(k));
        bytes.extend(numbers.iter().flat_map(|v| v.to_le_bytes()));
    }
    let mut document = json!({
        "asset": {"version": "2.0"}, "extensionsUsed": ["KHR_gaussian_splatting"],
        "extensionsRequired": ["KHR_gaussian_splatting"],
        "scenes": [{"nodes": [0, 1]}], "nodes": [{"mesh": 0}, {"mesh": 0, "translation": [5, 0, 0]}],
        "meshes": [{"primitives": [{"mode": 0, "attributes": names, "extensions": {"KHR_gaussian_splatting": {
            "kernel": "ellipse", "colorSpace": "srgb_rec709_display",
        }}}]}],
        "accessors": accessors, "bufferViews": views,
        "buffers": [{"byteLength": bytes.len(), "uri": format!(
            "data:application/octet-stream;base64,{}", base64::engine::general_purpose::STANDARD.encode(&bytes)
        )}],
    });
    change(&mut document);
    let (limits, jobs) = (Limits::default(), Jobs::new(1));
    let context = Context { resolver: &NoResolver, limits: &limits, jobs: &jobs };
    load_bytes(document.to_string().as_bytes(), Some(Format::Gltf), &context)
        .map_err(|error| error.to_string())
}

#[test]
fn splats_of_gltf_are_read_and_placed_by_their_nodes() {
    let loaded = document(|_| {}).unwrap();
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    let scene = &loaded.scene;
    assert_eq!((scene.splats().len(), scene.splat_count(), scene.triangle_count()), (1, 4, 0));
    assert!(scene.is_display_referred());
    assert_eq!(scene.splat_instances()[1].transform.point([0.0; 3]), [5.0, 0.0, 0.0]);
    let cloud = &scene.splats()[0];
    assert_eq!(
        (cloud.degree(), cloud.order(), cloud.color_space()),
        (1, SplatOrder::Distance, SplatColorSpace::Srgb)
    );
    let splat = cloud.splat(1).unwrap();
    assert_eq!((splat.position, splat.scale), ([1.0, 2.0, 3.0], [0.1, 0.2, 0.3]));
    assert_eq!((splat.rotation, splat.opacity), ([0.6, 0.0, 0.0, 0.8], 0.25));
    near(splat.color[0], 0.782_094_8, 1e-6, "colour");
    let first = cloud.harmonics(1)[0].map(|bits| half::f16::from_bits(bits).to_f32());
    assert_eq!(first, [1.0, 2.0, 3.0]);
}

#[test]
fn what_is_not_known_of_splats_in_gltf_is_named() {
    const EXTENSION: &str = "/meshes/0/primitives/0/extensions/KHR_gaussian_splatting";
    let with = |key: &str, value: &str| {
        let loaded = document(|d| d.pointer_mut(EXTENSION).unwrap()[key] = json!(value)).unwrap();
        (loaded.scene, loaded.warnings.iter().map(|w| w.message.clone()).collect::<Vec<_>>())
    };
    for (key, value) in
        [("kernel", "box"), ("colorSpace", "p3"), ("projection", "fisheye"), ("sortingMethod", "random")]
    {
        let (scene, warnings) = with(key, value);
        assert!(warnings.len() == 1 && warnings[0].contains(&format!("{key} '{value}'")), "{warnings:?}");
        assert_eq!(scene.splat_count(), 4);
    }
    let (scene, warnings) = with("colorSpace", "lin_rec709_display");
    assert_eq!((scene.splats()[0].color_space(), warnings.len()), (SplatColorSpace::Linear, 0));
    // A coefficient is missing.
    const ATTRIBUTES: &str = "/meshes/0/primitives/0/attributes";
    let loaded = document(|d| {
        d.pointer_mut(ATTRIBUTES)
            .unwrap()
            .as_object_mut()
            .unwrap()
            .remove("KHR_gaussian_splatting:SH_DEGREE_1_COEF_1");
    });
    let loaded = loaded.unwrap();
    assert_eq!(loaded.scene.splats()[0].degree(), 0);
    assert!(loaded.warnings[0].message.contains("those of degree 0"), "{:?}", loaded.warnings);
    // No opacity: points.
    let loaded = document(|d| {
        d.pointer_mut(ATTRIBUTES).unwrap().as_object_mut().unwrap().remove("KHR_gaussian_splatting:OPACITY");
    });
    let loaded = loaded.unwrap();
    assert_eq!(loaded.scene.splat_count(), 0);
    assert!(loaded.warnings[0].message.contains("drawn as points"), "{:?}", loaded.warnings);
    // Scales from the wrong list, of which some are negative.
    let loaded =
        document(|d| d.pointer_mut(ATTRIBUTES).unwrap()["KHR_gaussian_splatting:SCALE"] = json!(4)).unwrap();
    assert!(loaded.warnings[0].message.contains("read as logarithms"), "{:?}", loaded.warnings);
    near(loaded.scene.splats()[0].splat(1).unwrap().scale[0], std::f32::consts::E, 1e-5, "scale");
    let error = document(|d| d["accessors"][3]["count"] = json!(1)).unwrap_err();
    assert!(error.contains("1 elements of accessor 3 for 2 splats"), "{error}");
    let error = document(|d| d.pointer_mut(ATTRIBUTES).unwrap()["KHR_gaussian_splatting:SCALE"] = json!(3))
        .unwrap_err();
    assert!(error.contains("wrong type"), "{error}");
}

#[test]
fn faint_and_lost_splats_do_not_decide_the_frame() {
    let list: Vec<Splat> = (0..60)
        .map(|k| Splat {
            position: [(k % 5) as f32 * 0.1, (k / 5) as f32 * 0.05, 0.0],
            scale: [0.02; 3],
            ..ROUND
        })
        .collect();
    let plain = Framing::default().camera(&cloud(&list));
    let mut more = list;
    more.push(Splat { position: [500.0, 0.0, 0.0], ..ROUND });
    more.push(Splat { position: [0.0, 80.0, 0.0], opacity: 0.02, ..ROUND });
    let framed = Framing::default().camera(&cloud(&more));
    for (a, b) in plain.eye.into_iter().zip(framed.eye) {
        near(a, b, 1e-3, "eye");
    }
    // All of it is in the picture, with room at its edges.
    let frame = render(&cloud(&more[..60]), &plain);
    let border = (0..SIZE).flat_map(|k| [(k, 0), (k, SIZE - 1), (0, k), (SIZE - 1, k)]);
    assert!(border.into_iter().all(|(x, y)| pixel(&frame, x, y)[3] < 0.1));
    assert!(frame.pixels.iter().filter(|p| p[3] > 0.3).count() > 200);
}
