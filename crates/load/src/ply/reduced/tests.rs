//! Files beyond the limits, whole and damaged.

use crate::{Context, LoadError, LoadOptions, Loaded, NoResolver, load_bytes, load_file_with};
use overcoat_core::jobs::Jobs;
use overcoat_core::limits::Limits;
use overcoat_scene::Axis;
use std::io::Write;

/// Order of bytes, or text.
#[derive(Clone, Copy)]
enum Kind {
    Little,
    Big,
    Text,
}

/// A parabolic relief of n x n squares over the unit square, in some place: red where x is low, green where it is high. Its
/// colours and its corners may be fractions.
fn relief(n: u32, kind: Kind, far: f64) -> Vec<u8> {
    let name = match kind {
        Kind::Little => "binary_little_endian",
        Kind::Big => "binary_big_endian",
        Kind::Text => "ascii",
    };
    let vertices = (n + 1) * (n + 1);
    let mut out = format!(
        "ply\nformat {name} 1.0\nelement vertex {vertices}\nproperty double x\nproperty double y\nproperty float z\n\
         property uchar red\nproperty uchar green\nproperty uchar blue\nelement face {}\n\
         property list uchar int vertex_indices\nproperty uchar flags\nend_header\n",
        n * n
    )
    .into_bytes();
    for (i, j) in (0..=n).flat_map(|j| (0..=n).map(move |i| (i, j))) {
        let [x, y] = [i, j].map(|k| f64::from(k) / f64::from(n));
        let z = (0.25 * (x * (1.0 - x) + y * (1.0 - y))) as f32;
        let color: [u8; 3] = if x < 0.5 { [255, 0, 0] } else { [0, 255, 0] };
        let (x, y) = (x + far, y + far);
        match kind {
            Kind::Little => {
                out.extend(x.to_le_bytes().into_iter().chain(y.to_le_bytes()).chain(z.to_le_bytes()));
            }
            Kind::Big => {
                out.extend(x.to_be_bytes().into_iter().chain(y.to_be_bytes()).chain(z.to_be_bytes()));
            }
            Kind::Text => {
                let [r, g, b] = color;
                out.extend(format!("{x} {y} {z} {r} {g} {b}\r\n").into_bytes());
                continue;
            }
        }
        out.extend(color);
    }
    for (i, j) in (0..n).flat_map(|j| (0..n).map(move |i| (i, j))) {
        let first = j * (n + 1) + i;
        let corners = [first, first + 1, first + n + 2, first + n + 1];
        match kind {
            Kind::Little => out.extend([4].into_iter().chain(corners.into_iter().flat_map(u32::to_le_bytes))),
            Kind::Big => out.extend([4].into_iter().chain(corners.into_iter().flat_map(u32::to_be_bytes))),
            Kind::Text => {
                let [a, b, c, d] = corners;
                out.extend(format!("\n4 {a} {b} {c} {d} 7\n").into_bytes());
                continue;
            }
        }
        out.push(7);
    }
    out
}

fn in_memory(bytes: &[u8], limits: &Limits) -> Result<Loaded, LoadError> {
    load_bytes(bytes, None, &Context { resolver: &NoResolver, limits, jobs: &Jobs::new(2) })
}

fn from_file(bytes: &[u8], limits: &Limits) -> Result<Loaded, LoadError> {
    let mut file = tempfile::Builder::new().suffix(".ply").tempfile().unwrap();
    file.write_all(bytes).unwrap();
    // A relief is upright along Z, and would be turned.
    let options = LoadOptions::default().with_up(Axis::PositiveY);
    load_file_with(file.path(), &options, limits, &Jobs::new(1))
}

/// Area seen from above, and the largest distance from the relief.
fn measured(loaded: &Loaded) -> (f64, f64) {
    let mesh = &loaded.scene.meshes()[0];
    let mut area = 0.0;
    for triangle in mesh.triangles() {
        let [a, b, c] = triangle.map(|v| mesh.positions()[v as usize].map(f64::from));
        area += 0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]));
    }
    let mut off = 0.0_f64;
    let [ox, oy, oz] = loaded.scene.origin();
    for [x, y, z] in mesh.positions().iter().map(|p| p.map(f64::from)) {
        let [x, y] = [x + ox, y + oy].map(|v| v - v.floor());
        off = off.max((z + oz - 0.25 * (x * (1.0 - x) + y * (1.0 - y))).abs());
    }
    (area, off)
}

#[test]
fn a_large_mesh_is_read_in_parts_and_stays_whole() {
    let limits = Limits::default().with_triangles(8000);
    let mut all = Vec::new();
    for kind in [Kind::Little, Kind::Big, Kind::Text] {
        let bytes = relief(128, kind, 0.0);
        let loaded = from_file(&bytes, &limits).unwrap();
        let mesh = &loaded.scene.meshes()[0];
        assert!((1500..=8000).contains(&mesh.triangles().len()), "{}", mesh.triangles().len());
        let (area, off) = measured(&loaded);
        assert!((area - 1.0).abs() < 0.1 && off < 1e-3, "{area} {off}");
        // Between red and green lies no more than the clusters in the middle.
        let mixed = mesh.colors().iter().filter(|c| c[0] > 0.01 && c[1] > 0.01).count();
        assert!(mesh.colors().len() == mesh.positions().len() && mixed < 40, "{mixed}");
        for (color, position) in mesh.colors().iter().zip(mesh.positions()) {
            assert!(
                color[if position[0] < 0.45 { 0 } else { 1 }] > 0.99 || (0.45..0.55).contains(&position[0])
            );
        }
        assert_eq!(
            loaded.warnings[0].message,
            format!(
                "PLY: 32768 triangles are drawn as {}, with vertices joined within 1/32 of the model's size: the limits \
                 allow no more (triangles, vertices, input_bytes, decoded_bytes)",
                mesh.triangles().len()
            )
        );
        assert_eq!(loaded.warnings.len(), 1);
        // The limit that is passed is no matter, nor is memory in place of a file.
        let small = limits.clone().with_input_bytes(1000);
        let by_size = from_file(&bytes, &small).unwrap();
        assert_eq!(by_size.scene.meshes()[0].positions(), mesh.positions());
        let here = in_memory(&bytes, &limits).unwrap();
        assert_eq!(here.scene.meshes()[0].positions(), mesh.positions());
        assert_eq!(from_file(&bytes, &Limits::default()).unwrap().scene.triangle_count(), 32768);
        all.push((mesh.positions().to_vec(), mesh.triangles().to_vec(), mesh.colors().to_vec()));
    }
    assert!(all.iter().all(|one| *one == all[0]));
}

#[test]
fn a_large_mesh_far_away_keeps_its_shape() {
    let loaded =
        from_file(&relief(128, Kind::Little, 4_000_000.0), &Limits::default().with_triangles(8000)).unwrap();
    let (area, off) = measured(&loaded);
    assert!((area - 1.0).abs() < 0.1 && off < 1e-3, "{area} {off}");
    assert!(loaded.scene.origin()[0] >= 4_000_000.0);
}

#[test]
fn colours_of_faces_and_codes_with_a_point_are_those_of_clusters() {
    let head =
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n";
    let corners = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
    let text = format!(
        "{head}element face 1\nproperty list uchar int vertex_indices\nproperty float red\nproperty float green\n\
         property float blue\nend_header\n{corners}4 0 1 2 3 0.5 0.25 1\n"
    );
    let of = |text: &str| {
        // A thousand equal faces.
        let (start, face) = text.trim_end().rsplit_once('\n').unwrap();
        let many = format!("{}\n", start.replace("face 1", "face 1000")) + &format!("{face}\n").repeat(1000);
        in_memory(many.as_bytes(), &Limits::default().with_triangles(64)).unwrap()
    };
    let loaded = of(&text);
    let colors = loaded.scene.meshes()[0].colors();
    assert!(
        colors.len() == 4
            && colors.iter().all(|c| (c[0] - 0.214).abs() < 1e-3 && (c[1] - 0.0509).abs() < 1e-3)
    );
    let codes = text.replace("0.5 0.25 1", "255.0 0.0 128.0");
    let codes = codes.replace("end_header", "property uchar flags\nend_header").replace("128.0", "128.0 9");
    let loaded = of(&codes);
    let colors = loaded.scene.meshes()[0].colors();
    assert!(colors.iter().all(|c| c[0] > 0.999 && c[1] < 1e-3 && (c[2] - 0.216).abs() < 1e-3), "{colors:?}");
}

#[test]
fn of_a_large_cloud_every_so_many_points_are_drawn() {
    let limits = Limits::default().with_vertices(1000);
    for kind in [Kind::Little, Kind::Big, Kind::Text] {
        let bytes = relief(63, kind, 0.0);
        let end = b"property uchar blue\n";
        let at = bytes.windows(end.len()).position(|w| w == end).unwrap() + end.len();
        let rest = bytes.windows(11).position(|w| w == b"end_header\n").unwrap();
        let cloud = [&bytes[..at], &bytes[rest..]].concat();
        let loaded = in_memory(&cloud, &limits).unwrap();
        let mesh = &loaded.scene.meshes()[0];
        assert_eq!(mesh.positions().len(), 64 * 64 / 5 + 1);
        assert_eq!(mesh.positions()[1][0], 5.0 / 63.0);
        assert_eq!(mesh.colors()[1], [1.0, 0.0, 0.0, 1.0]);
        assert!(
            loaded.warnings[0].message.contains("of 4096 points one in 5 is drawn"),
            "{:?}",
            loaded.warnings
        );
    }
}

#[test]
fn what_ends_early_is_drawn_as_far_as_it_goes_and_the_rest_is_left_to_the_limits() {
    let limits = Limits::default().with_triangles(8000);
    let bytes = relief(128, Kind::Little, 0.0);
    let loaded = from_file(&bytes[..bytes.len() - 18 * 4000 - 5], &limits).unwrap();
    assert!(loaded.warnings[0].message.contains("the file ends within element 'face', item 12383 of 16384"));
    let (area, _) = measured(&loaded);
    assert!((area - 0.755).abs() < 0.1, "{area}");
    // Only vertices.
    let error = from_file(&bytes[..100_000], &limits).unwrap_err().to_string();
    assert!(error.contains("ends within element 'vertex'"), "{error}");
    // Vertices that are missing or not finite take their faces away.
    let mut broken = bytes.clone();
    let at = broken.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
    broken[at..at + 8].copy_from_slice(&f64::NAN.to_le_bytes());
    let last = broken.len() - 17;
    broken[last..last + 4].copy_from_slice(&999_999_u32.to_le_bytes());
    let loaded = from_file(&broken, &limits).unwrap();
    assert!(loaded.warnings[1].message.starts_with("PLY: 2 faces left out"), "{:?}", loaded.warnings);
    // A list that claims to be without end, and strips.
    let mut endless = bytes.clone();
    let list = endless.windows(15).position(|w| w == b"list uchar int ").unwrap();
    endless.splice(list..list + 15, *b"list uint int ");
    assert!(from_file(&endless, &limits).is_err());
    let text =
        String::from_utf8(relief(64, Kind::Text, 0.0)).unwrap().replace("element face", "element tristrips");
    assert!(matches!(from_file(text.as_bytes(), &limits), Err(LoadError::Limit(_)) | Ok(_)));
}

#[test]
fn items_of_nothing_take_no_time() {
    let mut bytes = relief(128, Kind::Little, 0.0);
    let at = bytes.windows(12).position(|w| w == b"element face").unwrap();
    bytes.splice(at..at, *b"element nothing 999999999999999999\n");
    let loaded = from_file(&bytes, &Limits::default().with_triangles(8000)).unwrap();
    assert!(loaded.scene.triangle_count() > 1500 && loaded.warnings.len() == 1, "{:?}", loaded.warnings);
}
