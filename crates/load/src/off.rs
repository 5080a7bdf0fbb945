//! OFF, the object file format of Geomview (its manual, "OFF"): text, and binary of big-endian numbers.
//!
//! The letters before the keyword say what vertices have beside their position: `ST` texture coordinates, `C` colours, `N` normals;
//! `4` stands for a fourth coordinate. Faces may end with a colour. Whole numbers are sRGB codes of 8 bits, fractions sRGB from 0 to 1.

use super::mesh_formats::{
    add_object, check_input, check_mesh, default_material, drawable, finish, of_corners, separate_triangles,
    white_material,
};
use super::normals::{add_missing_normals, add_smooth_normals};
use super::origin::{Region, load_about};
use super::point_clouds::{Points, add};
use super::polygon::Triangulator;
use super::text::{Tokens, double, integer, without_mark};
use super::warnings::{Warnings, counted};
use super::{Context, LoadError, Loaded};
use overcoat_core::color::srgb::{srgb_to_linear, srgb8_to_linear};
use overcoat_scene::{AlphaMode, CREASE_ANGLE, MeshData, Scene};

const FORMAT: &str = "OFF";

/// Parts of a vertex, by the keyword.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Kind {
    uvs: bool,
    colors: bool,
    normals: bool,
    four: bool,
}

impl Kind {
    /// The kind that a keyword stands for.
    fn of(word: &[u8]) -> Option<Self> {
        let mut rest = word.strip_suffix(b"OFF")?;
        let mut take = |letters: &[u8]| match rest.strip_prefix(letters) {
            Some(after) => {
                rest = after;
                true
            }
            None => false,
        };
        let kind = Self { uvs: take(b"ST"), colors: take(b"C"), normals: take(b"N"), four: take(b"4") };
        rest.is_empty().then_some(kind)
    }
}

/// True if a file begins with the keyword.
pub(crate) fn is_one(bytes: &[u8]) -> bool {
    let head = without_mark(bytes.get(..4096).unwrap_or(bytes));
    keyword(head).is_some()
}

/// The keyword of a file that is called one, and what follows it: it may be in small letters, or missing (Geomview has it
/// optional), which is too little to know a file by.
fn lenient_keyword(bytes: &[u8]) -> Option<(Kind, Words<'_>)> {
    keyword(bytes).or_else(|| {
        let mut words = Words::new(bytes);
        let all = words.clone();
        let word = words.next()?;
        // The longest has eight letters.
        match Kind::of(&word.get(..9).unwrap_or(word).to_ascii_uppercase()) {
            Some(kind) => Some((kind, words)),
            None => integer(word).map(|_| (Kind::default(), all)),
        }
    })
}

/// The keyword, and what follows it. The counts may follow without a blank, as in files of ModelNet.
fn keyword(bytes: &[u8]) -> Option<(Kind, Words<'_>)> {
    let mut words = Words::new(bytes);
    let word = words.next()?;
    if let Some(kind) = Kind::of(word) {
        return Some((kind, words));
    }
    let counts = bytes.trim_ascii_start().strip_prefix(b"OFF")?;
    counts.first().is_some_and(u8::is_ascii_digit).then_some((Kind::default(), Words::new(counts)))
}

/// Words of a text, without comments.
#[derive(Clone)]
struct Words<'a>(Tokens<'a>);

impl<'a> Words<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        Self(Tokens::new(bytes))
    }

    fn next(&mut self) -> Option<&'a [u8]> {
        loop {
            let before = self.0.clone();
            let word = self.0.next()?;
            let Some(at) = word.iter().position(|&b| b == b'#') else { return Some(word) };
            // The comment goes on to the end of the line.
            self.0 = before;
            let skipped = self.0.rest().iter().position(|&b| b == b'#').unwrap_or(0);
            self.0 = Tokens::new(self.0.rest().get(skipped..).unwrap_or_default());
            self.0.rest_of_line();
            if at > 0 {
                return word.get(..at);
            }
        }
    }

    /// The words up to the end of the line.
    fn line(&mut self) -> &'a [u8] {
        let line = self.0.rest_of_line();
        let end = line.iter().position(|&b| b == b'#').unwrap_or(line.len());
        line.get(..end).unwrap_or_default()
    }
}

impl Words<'_> {
    /// Skips the number of edges: the rest of the line, or one of its own; it may be missing.
    fn skip_edges(&mut self) {
        if !self.line().trim_ascii().is_empty() {
            return;
        }
        let before = self.0.clone();
        // Lines are blank, or comments, before there is one with words.
        while !self.0.rest().trim_ascii_start().is_empty() {
            self.0 = Tokens::new(self.0.rest().trim_ascii_start());
            let line = self.line().trim_ascii();
            if integer(line).is_some() {
                return;
            }
            if !line.is_empty() {
                break;
            }
        }
        self.0 = before;
    }
}

impl Words<'_> {
    /// True if so many lines have a colour behind a position: some programs leave it out of the keyword.
    fn have_colors(&self, lines: u64) -> bool {
        let mut words = self.clone();
        let mut is_colored = || {
            words.0 = Tokens::new(words.0.rest().trim_ascii_start());
            let mut numbers = Self::new(words.line());
            let mut count = 0_u32;
            while let Some(word) = numbers.next() {
                count = count.saturating_add(1);
                if count > 3 && !double(word).is_some_and(|part| (0.0..=255.0).contains(&part)) {
                    return false;
                }
            }
            matches!(count, 6 | 7)
        };
        lines > 0 && (0..lines).all(|_| is_colored())
    }
}

/// Values behind the counts.
enum Values<'a> {
    Text(Words<'a>),
    Binary(&'a [u8]),
}

impl Values<'_> {
    fn number(&mut self) -> Option<f64> {
        match self {
            Self::Text(words) => Some(double(words.next()?).unwrap_or(f64::NAN)),
            Self::Binary(bytes) => {
                let (value, rest) = bytes.split_first_chunk()?;
                *bytes = rest;
                Some(f32::from_be_bytes(*value).into())
            }
        }
    }

    fn integer(&mut self) -> Option<i64> {
        match self {
            Self::Text(words) => integer(words.next()?),
            Self::Binary(bytes) => {
                let (value, rest) = bytes.split_first_chunk()?;
                *bytes = rest;
                Some(i32::from_be_bytes(*value).into())
            }
        }
    }

    /// The colour at the end of a vertex or face; the outer `None` where the file ends.
    fn color(&mut self, of_vertex: bool) -> Option<Option<[f32; 4]>> {
        match self {
            Self::Text(words) => Some(color(words.line())),
            Self::Binary(_) => {
                let count = if of_vertex { 4 } else { usize::try_from(self.integer()?).ok()? };
                let mut parts = [0.0, 0.0, 0.0, 1.0];
                let Self::Binary(bytes) = self else { return None };
                let (own, rest) = bytes.split_at_checked(count.checked_mul(4)?)?;
                *bytes = rest;
                for (part, value) in parts.iter_mut().zip(own.as_chunks().0) {
                    *part = f32::from_be_bytes(*value);
                }
                Some((count >= 3).then(|| linear(parts, 1.0)))
            }
        }
    }
}

/// Linear colour of sRGB codes.
fn linear([r, g, b, a]: [f32; 4], range: f32) -> [f32; 4] {
    let part = |v: f32| if v > 0.0 { if v < range { v / range } else { 1.0 } } else { 0.0 };
    let own = |v: f32| if range == 255.0 { srgb8_to_linear(v as u8) } else { srgb_to_linear(part(v)) };
    [own(r), own(g), own(b), part(a)]
}

/// Colour of three or four numbers; one alone is a place of a colour map, which no file brings along.
fn color(line: &[u8]) -> Option<[f32; 4]> {
    let mut words = line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
    let rgb = [words.next()?, words.next()?, words.next()?];
    let alpha = words.next();
    let is_whole = rgb.iter().chain(&alpha).all(|word| integer(word).is_some());
    let range = if is_whole { 255.0 } else { 1.0 };
    let [r, g, b] = rgb.map(|word| double(word).map(|v| v as f32));
    let a = alpha.map_or(Some(range), |word| double(word).map(|v| v as f32));
    Some(linear([r?, g?, b?, a?], range))
}

/// Contents of a file.
#[derive(Default)]
struct Model {
    positions: Vec<[f64; 3]>,
    normals: Vec<[f32; 3]>,
    uvs: Vec<[f32; 2]>,
    colors: Vec<[f32; 4]>,
    /// Corners of all faces, and how many of each and its colour.
    corners: Vec<u32>,
    faces: Vec<(u32, Option<[f32; 4]>)>,
}

/// Reads a file. One that ends early is drawn as far as it goes, with a warning.
pub(crate) fn load(bytes: &[u8], context: &Context<'_>) -> Result<Loaded, LoadError> {
    check_input(context, bytes)?;
    load_about(|region| load_in(without_mark(bytes), region, context))
}

fn load_in(bytes: &[u8], region: Option<&Region>, context: &Context<'_>) -> Result<Loaded, LoadError> {
    let mut warnings = Warnings::default();
    let model = read(bytes, context, &mut warnings)?;
    let mut scene = Scene::new();
    let origin = region.map(|region| region.origin(model.positions.iter().copied())).unwrap_or_default();
    scene.set_origin(origin.0);
    let positions: Vec<[f32; 3]> = model.positions.iter().map(|&p| origin.relative(p)).collect();
    if model.faces.is_empty() {
        let Model { normals, uvs, colors, .. } = model;
        let points = Points { positions, normals, uvs, colors, ..Points::default() };
        add(&mut scene, FORMAT, points, 0, &mut warnings)?;
        return Ok(finish(scene, warnings.finish()));
    }
    let mut data = build(model, positions, context, &mut warnings)?;
    if data.triangles.is_empty() {
        return Ok(finish(scene, warnings.finish()));
    }
    let missing: Vec<bool> = data.normals.iter().map(|n| n.iter().all(|&v| v == 0.0)).collect();
    if missing.iter().all(|&missing| missing) {
        add_smooth_normals(&mut data, CREASE_ANGLE, context.jobs);
    } else if missing.contains(&true) {
        add_missing_normals(&mut data, CREASE_ANGLE, |v| missing.get(v) == Some(&true), context.jobs);
    }
    let mut material = if data.colors.is_empty() { default_material() } else { white_material() };
    if data.colors.iter().any(|c| c[3] > 0.0) && data.colors.iter().any(|c| c[3] < 1.0) {
        material.alpha_mode = AlphaMode::Blend;
    } else {
        data.colors.iter_mut().for_each(|c| c[3] = 1.0);
    }
    let material = scene.add_material(material).map_err(LoadError::scene("OFF: material"))?;
    add_object(&mut scene, "OFF: mesh", data, material, 0)?;
    Ok(finish(scene, warnings.finish()))
}

/// Reads the keyword, the counts, and as many vertices and faces as there are.
fn read(bytes: &[u8], context: &Context<'_>, warnings: &mut Warnings) -> Result<Model, LoadError> {
    let malformed = |message: String| LoadError::malformed(FORMAT, message);
    let Some((mut kind, words)) = lenient_keyword(bytes) else {
        return Err(malformed("it does not begin with OFF".to_owned()));
    };
    let mut ahead = words.clone();
    let is_binary = ahead.next() == Some(b"BINARY");
    let mut values = Values::Text(words);
    if is_binary {
        let rest = ahead.0.rest();
        let line = rest.iter().position(|&b| b == b'\n').and_then(|end| rest.get(end.saturating_add(1)..));
        values = Values::Binary(line.unwrap_or_default());
    }
    let mut count = |what: &str| {
        let count = values.integer().and_then(|count| u64::try_from(count).ok());
        count.ok_or_else(|| malformed(format!("the number of {what} is missing")))
    };
    let (vertices, faces) = (count("vertices")?, count("faces")?);
    // Edges are not stored, and often are not counted either, or missing.
    match &mut values {
        Values::Text(words) => {
            words.skip_edges();
            kind.colors |= kind == Kind::default() && words.have_colors(vertices);
        }
        Values::Binary(_) => _ = values.integer(),
    }
    // No more than the file can hold.
    let held = bytes.len() as u64 / 6;
    check_mesh(context, 0, vertices.min(held))?;
    let mut model = Model::default();
    let cut = read_vertices(&mut values, kind, vertices, &mut model);
    if let Some(number) = cut {
        if faces > 0 || number == 0 {
            return Err(malformed(format!("the file ends within vertex {number} of {vertices}")));
        }
        warnings.add(|| format!("{FORMAT}: the file ends after {number} of {vertices} vertices"));
    }
    let read = read_faces(&mut values, faces, &mut model, context)?;
    if read < faces {
        if read == 0 {
            return Err(malformed(format!("the file ends within the first of {faces} faces")));
        }
        warnings.add(|| format!("{FORMAT}: the file ends after {read} of {faces} faces"));
    }
    Ok(model)
}

/// Reads vertices; the number of the first that is not complete, if there is one.
fn read_vertices(values: &mut Values<'_>, kind: Kind, count: u64, model: &mut Model) -> Option<u64> {
    for number in 0..count {
        let mut read = || -> Option<()> {
            let mut position = [values.number()?, values.number()?, values.number()?];
            if kind.four {
                let w = values.number()?;
                position = position.map(|v| v / w);
            }
            if kind.normals {
                let normal = [values.number()?, values.number()?, values.number()?].map(|v| v as f32);
                model.normals.push(if normal.iter().all(|v| v.is_finite()) { normal } else { [0.0; 3] });
            }
            if kind.uvs && !kind.colors {
                let [u, v] = [values.number()?, values.number()?].map(|v| v as f32);
                model.uvs.push(if u.is_finite() && v.is_finite() { [u, 1.0 - v] } else { [0.0; 2] });
            }
            if kind.colors {
                // Coordinates of textures behind them are left out.
                model.colors.push(values.color(true)?.unwrap_or([1.0; 4]));
                if kind.uvs && matches!(values, Values::Binary(_)) {
                    values.number()?;
                    values.number()?;
                }
            }
            model.positions.push(position);
            Some(())
        };
        if read().is_none() {
            let whole = model.positions.len();
            model.normals.truncate(whole);
            model.uvs.truncate(whole);
            model.colors.truncate(whole);
            return Some(number);
        }
    }
    None
}

/// Reads faces; how many are complete.
fn read_faces(
    values: &mut Values<'_>,
    count: u64,
    model: &mut Model,
    context: &Context<'_>,
) -> Result<u64, LoadError> {
    for number in 0..count {
        let start = model.corners.len();
        let mut read = || -> Option<()> {
            let corners = u32::try_from(values.integer()?).ok()?;
            for _ in 0..corners {
                // Negative ones do not exist either.
                let corner = values.integer()?;
                model.corners.push(u32::try_from(corner).unwrap_or(u32::MAX));
            }
            let color = values.color(false)?;
            model.faces.push((corners, color));
            Some(())
        };
        if read().is_none() {
            model.corners.truncate(start);
            return Ok(number);
        }
        if number.is_multiple_of(1024) {
            check_mesh(context, model.corners.len() as u64, 0)?;
        }
    }
    Ok(count)
}

/// One mesh, with vertices of their own for each triangle where faces have colours.
fn build(
    model: Model,
    mut positions: Vec<[f32; 3]>,
    context: &Context<'_>,
    warnings: &mut Warnings,
) -> Result<MeshData, LoadError> {
    let mut triangulator = Triangulator::default();
    let (mut triangles, mut colors): (Vec<[u32; 3]>, Vec<Option<[f32; 4]>>) = (Vec::new(), Vec::new());
    let (mut rest, mut bad, mut short) = (model.corners.as_slice(), 0_u64, 0_u64);
    let there = |corner: &u32| positions.get(*corner as usize).is_some_and(|&p| drawable(p));
    for &(count, color) in &model.faces {
        let Some((corners, after)) = rest.split_at_checked(count as usize) else { break };
        rest = after;
        if count < 3 {
            short = short.saturating_add(1);
        } else if !corners.iter().all(there) {
            bad = bad.saturating_add(1);
        } else {
            let position = |corner: u32| positions.get(corner as usize).copied().unwrap_or_default();
            triangulator.triangulate(corners, position, |triangle| {
                triangles.push(triangle);
                colors.push(color);
            });
        }
    }
    check_mesh(context, triangles.len() as u64, positions.len() as u64)?;
    if bad > 0 {
        let faces = counted(bad, "face");
        warnings.add(|| format!("{FORMAT}: {faces} left out: vertices missing, not finite or beyond 1e15"));
    }
    if short > 0 {
        let faces = counted(short, "face");
        warnings.add(|| format!("{FORMAT}: {faces} of less than three vertices left out"));
    }
    if triangulator.given_up > 0 {
        let polygons = counted(triangulator.given_up, "concave polygon");
        warnings.add(|| format!("{FORMAT}: {polygons} with too many corners may be drawn wrongly"));
    }
    // Vertices that cannot be drawn have lost their faces; they stand where another one does.
    let other = positions.iter().copied().find(|&position| drawable(position)).unwrap_or_default();
    positions.iter_mut().filter(|position| !drawable(**position)).for_each(|position| *position = other);
    let Model { normals, uvs, colors: own, .. } = model;
    if colors.iter().all(Option::is_none) {
        return Ok(MeshData::default().with(|d| {
            d.positions = positions;
            d.normals = normals;
            d.uvs = [uvs, Vec::new()];
            d.colors = own;
            d.triangles = triangles;
        }));
    }
    check_mesh(context, triangles.len() as u64, (triangles.len() as u64).saturating_mul(3))?;
    let without = default_material().base_color;
    Ok(MeshData::default().with(|d| {
        d.positions = of_corners(&positions, &triangles);
        d.normals = of_corners(&normals, &triangles);
        d.uvs = [of_corners(&uvs, &triangles), Vec::new()];
        d.colors = colors.iter().flat_map(|color| [color.unwrap_or(without); 3]).collect();
        d.triangles = separate_triangles(triangles.len());
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Format;
    use crate::hostile::{attack, load, warnings};

    const PYRAMID: &str = "# by hand\n5 5 8 # counts\n0 0 0\n2 0 0 # a comment\n2 2 0\n0 2 0\n1 1 1\n\n\
                           4 3 2 1 0\n3 0 1 4\n3 1 2 4\n3 2 3 4\n3 3 0 4\n";

    #[test]
    fn keywords_tell() {
        let all = Kind { uvs: true, colors: true, normals: true, four: true };
        assert_eq!(Kind::of(b"STCN4OFF"), Some(all));
        assert_eq!(Kind::of(b"OFF"), Some(Kind::default()));
        assert_eq!(Kind::of(b"NCOFF"), None);
        for (text, expected) in
            [("OFF\n", true), ("# x\n COFF 3", true), ("OFF4 4 0", true), ("OFFICE", false), ("off", false)]
        {
            let found = Format::detect(text.as_bytes()) == Some(Format::Off);
            assert_eq!(found, expected, "{text}");
        }
    }

    #[test]
    fn text_and_binary_read_the_same() {
        let mut binary = b"OFF BINARY\n".to_vec();
        let integers = |list: &[i32]| list.iter().flat_map(|v| v.to_be_bytes()).collect::<Vec<_>>();
        binary.extend(integers(&[5, 5, 8]));
        for v in [[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0], [1, 1, 1]].as_flattened() {
            binary.extend((*v as f32).to_be_bytes());
        }
        binary.extend(integers(&[
            4, 3, 2, 1, 0, 0, 3, 0, 1, 4, 0, 3, 1, 2, 4, 0, 3, 2, 3, 4, 0, 3, 3, 0, 4, 0,
        ]));
        for bytes in [format!("OFF\n{PYRAMID}").into_bytes(), format!("OFF {PYRAMID}").into_bytes(), binary] {
            let loaded = load(&bytes, Format::Off).unwrap();
            assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
            assert_eq!(loaded.scene.triangle_count(), 6);
            let mesh = &loaded.scene.meshes()[0];
            let third = mesh.triangles()[2].map(|v| mesh.positions()[v as usize]);
            assert_eq!(third, [[0.0; 3], [2.0, 0.0, 0.0], [1.0; 3]]);
            attack(&bytes, Format::Off);
        }
    }

    #[test]
    fn the_number_of_edges_may_be_missing() {
        let body = "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
        for counts in
            ["3 1", "3 1 0", "3 1 x", "3 1\n0", "3 1 # none\n\n# of them\n0", "3 1\n# none\n", "3\n1\n"]
        {
            let loaded = load(format!("OFF\n{counts}\n{body}").as_bytes(), Format::Off).unwrap();
            let mesh = &loaded.scene.meshes()[0];
            assert_eq!(
                (mesh.triangles().len(), loaded.warnings.len()),
                (1, 0),
                "{counts}: {:?}",
                loaded.warnings
            );
        }
    }

    #[test]
    fn the_keyword_may_be_small_or_missing() {
        for keyword in ["off\n", "Off ", "stcn4off\n", ""] {
            let parts = if keyword.starts_with('s') { " 1 0 0 1 255 0 0 255 0 0" } else { "" };
            let text = format!("{keyword}3 1 0\n0 0 0{parts}\n1 0 0{parts}\n0 1 0{parts}\n3 0 1 2\n");
            assert_eq!(load(text.as_bytes(), Format::Off).unwrap().scene.triangle_count(), 1, "{keyword}");
            attack(text.as_bytes(), Format::Off);
        }
        for text in ["office 3 1 0\n", "stcn4offx 3 1 0\n", "x"] {
            let error = load(text.as_bytes(), Format::Off).unwrap_err().to_string();
            assert!(error.contains("does not begin with OFF"), "{error}");
        }
    }

    #[test]
    fn vertices_and_faces_have_colours() {
        let text = "COFF\n3 1 0\n0 0 0 255 0 0 255\n1 0 0 0 255 0 255\n0 1 0 0 0 128\n3 0 1 2\n";
        let loaded = load(text.as_bytes(), Format::Off).unwrap();
        let blue = [0.0, 0.0, srgb8_to_linear(128), 1.0];
        assert_eq!(loaded.scene.meshes()[0].colors(), [[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1.0], blue]);
        let text = "OFF\n4 3 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 1 2 1.0 0 0\n3 0 1 3 0 255 0\n3 1 2 3\n";
        let mesh = load(text.as_bytes(), Format::Off).unwrap().scene.meshes()[0].clone();
        let colors: Vec<_> = mesh.triangles().iter().map(|t| mesh.colors()[t[0] as usize]).collect();
        let clay = default_material().base_color;
        assert_eq!(colors, [[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1.0], clay]);
    }

    #[test]
    fn colours_that_the_keyword_does_not_state_are_read() {
        let red =
            |rest: &str| format!("OFF\n3 1 0\n0 0 0 1 0 0\n\n1 0 0 1 0 0 # red\n0 1 0 {rest}\n3 0 1 2\n");
        let colors = |text: &str| {
            let scene = load(text.as_bytes(), Format::Off).unwrap().scene;
            scene.meshes().first().map(|mesh| mesh.colors().to_vec()).unwrap_or_default()
        };
        assert_eq!(colors(&red("1 0 0")), colors(&red("1 0 0").replace("OFF", "COFF")));
        assert_eq!(colors(&red("1 0 0")).len(), 3);
        // Two positions on each line.
        let two = "OFF\n4 2 0\n0 0 0 1 0 0\n1 1 0 0 1 0\n3 0 1 2\n3 0 2 3\n";
        assert!(colors(two).is_empty());
        assert!(colors(&red("-1 0 0")).is_empty());
        attack(red("1 0 0").as_bytes(), Format::Off);
    }

    #[test]
    fn normals_and_texture_coordinates_are_read() {
        let text = "STNOFF 3 1 0\n0 0 0 0 0 1 0 0\n1 0 0 0 0 1 1 0\n0 1 0 0 0 1 0 1\n3 0 1 2\n";
        let mesh = load(text.as_bytes(), Format::Off).unwrap().scene.meshes()[0].clone();
        assert_eq!(mesh.uvs(0), [[0.0, 1.0], [1.0, 1.0], [0.0, 0.0]]);
        assert_eq!(mesh.normals(), [[0.0, 0.0, 1.0]; 3]);
        let points = load(b"4OFF 2 0 0\n2 4 6 2\n1 1 1 1", Format::Off).unwrap().scene.meshes()[0].clone();
        assert_eq!(points.positions(), [[1.0, 2.0, 3.0], [1.0, 1.0, 1.0]]);
    }

    #[test]
    fn what_is_missing_is_said() {
        let cases = [
            ("OFF 3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 0 1", "OFF: the file ends after 1 of 2 faces"),
            (
                "OFF 3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 0 1 3\n",
                "OFF: 1 face left out: vertices missing, not finite or beyond 1e15",
            ),
            (
                "OFF 3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n2 0 1\n",
                "OFF: 1 face of less than three vertices left out",
            ),
        ];
        for (text, expected) in cases {
            assert_eq!(warnings(&load(text.as_bytes(), Format::Off).unwrap()), [expected]);
        }
        for (text, expected) in [
            ("OFF 9 1 0\n0 0 0\n", "the file ends within vertex 1 of 9"),
            ("OFF\nx 1 0\n", "the number of vertices is missing"),
        ] {
            let error = load(text.as_bytes(), Format::Off).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        }
    }

    #[test]
    fn models_far_away_keep_their_shape() {
        let text = "OFF 3 1 0\n500000.1 4600000.2 0\n500001.1 4600000.2 0\n500000.1 4600001.2 0\n3 0 1 2\n";
        let scene = load(text.as_bytes(), Format::Off).unwrap().scene;
        let [a, b, c] = *scene.meshes()[0].positions().first_chunk().unwrap();
        assert_eq!((b[0] - a[0], c[1] - a[1]), (1.0, 1.0));
    }
}
