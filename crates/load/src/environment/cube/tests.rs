use super::*;
use overcoat_core::formats;

/// Light of a world in which right, up and ahead are +1 on an axis each: no two directions are alike.
fn world([right, up, ahead]: [f64; 3]) -> [f32; 3] {
    let length = (right * right + up * up + ahead * ahead).sqrt();
    [right, up, ahead].map(|v| (1.5 + v / length) as f32)
}

fn picture(width: usize, height: usize, light: impl Fn(usize, usize) -> [f32; 3]) -> Picture {
    let pixels = (0..width * height).map(|k| light(k % width, k / width)).collect();
    let [width, height] = [width as u32, height as u32];
    let (format, warnings) = (formats::HDR.name, Vec::new());
    Picture { format, width, height, pixels, projection: None, has_noise: false, warnings }
}

/// Spreads a picture, and returns the largest difference from the world.
fn error(picture: &mut Picture) -> f32 {
    let layout = Layout::of(picture).unwrap().unwrap();
    layout.spread(picture, &Limits::default(), &Jobs::new(2)).unwrap();
    let [width, height] = [picture.width, picture.height].map(f64::from);
    assert_eq!(width, 2.0 * height);
    let mut most: f32 = 0.0;
    for (k, pixel) in picture.pixels.iter().enumerate() {
        let (x, y) = ((k as f64 % width).floor() + 0.5, (k as f64 / width).floor() + 0.5);
        let (sin, cos) = sin_cos((x / width - 0.5) * TAU);
        let (across, up) = sin_cos(y / height * PI);
        for (a, b) in pixel.iter().zip(world([across * sin, up, across * cos])) {
            most = most.max((a - b).abs());
        }
    }
    most
}

const SIDE: usize = 24;

/// -1 to 1 over the centres of the pixels of a face.
fn place(k: usize) -> f64 {
    (2 * k + 1) as f64 / SIDE as f64 - 1.0
}

/// The picture that is seen of one face, by how far right and down: ahead, to the right, and so on.
fn seen(face: char, s: f64, t: f64) -> [f32; 3] {
    world(match face {
        'f' => [s, -t, 1.0],
        'r' => [1.0, -t, -s],
        'l' => [-1.0, -t, s],
        'b' => [-s, -t, -1.0],
        // The lower edge of what is above touches what is ahead.
        'u' => [s, 1.0, t],
        'd' => [s, -1.0, -t],
        _ => return [0.0; 3],
    })
}

fn of_faces(rows: &[&str]) -> Picture {
    picture(SIDE * rows[0].len(), SIDE * rows.len(), |x, y| {
        let face = char::from(rows[y / SIDE].as_bytes()[x / SIDE]);
        let (s, t) = (place(x % SIDE), place(y % SIDE));
        // Capital letters stand on their heads.
        if face.is_uppercase() { seen(face.to_ascii_lowercase(), -s, -t) } else { seen(face, s, t) }
    })
}

#[test]
fn crosses_and_strips_show_what_is_around() {
    let row = "rludfb";
    let column: Vec<&str> = (0..6).map(|k| &row[k..k + 1]).collect();
    for (rows, warnings) in
        [(&["-u--", "lfrb", "-d--"][..], 0), (&["-u-", "lfr", "-d-", "-B-"], 0), (&[row], 1), (&column, 1)]
    {
        let mut picture = of_faces(rows);
        assert!(error(&mut picture) < 0.1, "{rows:?}");
        assert_eq!(picture.warnings.len(), warnings, "{rows:?}");
    }
}

/// The pictures of `ImfEnvmap.h`, with the directions that it gives its corners. A panorama of its kind has +Z at the centre
/// and +X at a quarter.
#[test]
fn faces_of_openexr_are_where_its_documentation_has_them() {
    let direction = |face: usize, column: f64, row: f64| {
        let [x, y, z] = match face {
            0 => [1.0, -row, column],
            1 => [-1.0, -row, -column],
            2 => [column, 1.0, -row],
            3 => [column, -1.0, row],
            4 => [-column, -row, 1.0],
            _ => [column, -row, -1.0],
        };
        [-x, y, z]
    };
    let on_edges = |k: usize| 2.0 * k as f64 / (SIDE - 1) as f64 - 1.0;
    let mut picture =
        picture(SIDE, SIDE * 6, |x, y| world(direction(y / SIDE, on_edges(x), on_edges(y % SIDE))));
    picture.projection = Some(Projection::Cube);
    assert!(error(&mut picture) < 0.05);
    assert!(picture.warnings.is_empty());
}

#[test]
fn what_is_no_cube_is_a_panorama_or_refused() {
    let colours = |x: usize, y: usize| [x as f32, y as f32, 1.0];
    for (size, warned) in [([8, 4], 0), ([7, 6], 0), ([8, 6], 1)] {
        let mut picture = picture(size[0], size[1], colours);
        assert_eq!(Layout::of(&mut picture).unwrap(), None);
        assert_eq!(picture.warnings.len(), warned, "{size:?}");
    }
    let mut column = picture(2, 12, colours);
    column.projection = Some(Projection::LatitudeLongitude);
    assert_eq!(Layout::of(&mut column).unwrap(), None);
    let message = Layout::of(&mut picture(6, 8, colours)).unwrap_err().to_string();
    assert!(message.contains("6 x 8 pixels, neither a panorama nor the cross"), "{message}");
    let mut wide = picture(8, 4, colours);
    wide.projection = Some(Projection::Cube);
    let message = Layout::of(&mut wide).unwrap_err().to_string();
    assert!(message.contains("8 x 4 pixels, which is a cube by its attribute envmap"), "{message}");
}

#[test]
fn noise_of_compression_is_no_picture_and_the_panorama_is_within_limits() {
    let mut cross = of_faces(&["-u--", "lfrb", "-d--"]);
    cross.pixels[0] = [0.01; 3];
    let mut exact = of_faces(&["-u--", "lfrb", "-d--"]);
    exact.pixels[0] = [0.01; 3];
    cross.has_noise = true;
    assert!(Layout::of(&mut cross).unwrap().is_some());
    assert_eq!(Layout::of(&mut exact).unwrap(), None);
    let layout = Layout::of(&mut cross).unwrap().unwrap();
    let most = (8 * SIDE * SIDE) as u64;
    for (pixels, fits) in [(most, true), (most - 1, false)] {
        let limits = Limits::default().with_texture_pixels(pixels);
        assert_eq!(layout.spread(&mut cross, &limits, &Jobs::new(1)).is_ok(), fits);
        cross = of_faces(&["-u--", "lfrb", "-d--"]);
    }
}
