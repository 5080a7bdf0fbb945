//! OBJ, STL, PLY and 3MF files with all that they can say about colours and shapes.

use super::Entry;
use crate::common::files::package::stored_zip;
use crate::common::files::{load, png};
use crate::common::images::{bumps, image, letter_f, soft_disc};
use crate::common::shapes::{gutter, sphere, square};
use crate::common::stage::{Built, Stage, flat_view};
use overcoat::load::{Format, LoadOptions, MemoryResolver};
use overcoat::scene::{MeshData, Projection, Scene, Transform};
use std::error::Error;
use std::fmt::Write as _;

pub const SCENES: &[Entry] = &[("obj", obj), ("stl", stl), ("ply", ply), ("3mf", three_mf)];

fn read(bytes: &[u8], format: Format, beside: &MemoryResolver) -> Result<Scene, Box<dyn Error>> {
    // Half a tube may stand on either axis.
    load(bytes, format, beside, &LoadOptions::default().with_up(format.orientation().up))
}

/// An OBJ file that is being written.
#[derive(Default)]
struct Obj {
    text: String,
    /// Vertices and texture coordinates so far.
    count: usize,
}

impl Obj {
    /// Adds an object of one material, with texture coordinates whose v runs up.
    fn shape(&mut self, mesh: &MeshData, material: &str, at: [f32; 2], scale: f32) {
        let _ = writeln!(self.text, "o {material}\nusemtl {material}");
        for (p, [u, v]) in mesh.positions.iter().zip(&mesh.uvs[0]) {
            let [x, y, z] = p.map(|c| c * scale);
            let _ = writeln!(self.text, "v {} {} {z}\nvt {u} {}", x + at[0], y + at[1], 1.0 - v);
        }
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|v| v as usize + 1 + self.count);
            let _ = writeln!(self.text, "f {a}/{a} {b}/{b} {c}/{c}");
        }
        self.count += mesh.positions.len();
    }
}

/// Upper row, balls: Phong with a low and a high exponent, `Pr` and `Pm`, a coat of `Pc` and `Pcr`, `Ke`, `d`. Middle row,
/// squares: `map_Kd`, with `-s` and `-o`, with `-clamp`, `map_d`, `norm`, `map_Bump` with `-bm`. Lower row: a concave
/// polygon of one statement, vertex colours, `map_Pr` and `map_Pm`, `map_Ke`, a face by indices from the end, and one
/// without a material.
fn obj() -> Built {
    let library = "newmtl dull\nKd 0.7 0.2 0.1\nKs 0.5 0.5 0.5\nNs 4\n\
        newmtl shiny\nKd 0.7 0.2 0.1\nKs 0.5 0.5 0.5\nNs 400\n\
        newmtl metal\nKd 0.9 0.7 0.35\nPr 0.3\nPm 1\n\
        newmtl coated\nKd 0.02 0.05 0.4\nPr 0.9\nPc 1\nPcr 0.1\n\
        newmtl glowing\nKd 0 0 0\nPr 1\nKe 0.1 0.6 0.2\n\
        newmtl faint\nKd 0.2 0.6 0.9\nNs 30\nd 0.4\n\
        newmtl picture\nKd 1 1 1\nKs 0 0 0\nmap_Kd f.png\n\
        newmtl moved\nKd 1 1 1\nKs 0 0 0\nmap_Kd -s 2 3 1 -o 0.25 0.125 0 maps\\my letter.png\n\
        newmtl clamped\nKd 1 1 1\nKs 0 0 0\nmap_Kd -clamp on -s 2 2 1 -o -0.5 -0.5 0 f.png\n\
        newmtl holes\nKd 0.3 0.7 0.3\nKs 0 0 0\nmap_d disc.png\n\
        newmtl bumpy\nKd 0.9 0.7 0.35\nPr 0.3\nPm 1\nnorm bumps.png\n\
        newmtl heights\nKd 0.9 0.7 0.35\nPr 0.3\nPm 1\nmap_Bump -bm 16 hill.png\n\
        newmtl star\nKd 0.9 0.6 0.1\nKs 0 0 0\n\
        newmtl white\nKd 1 1 1\nKs 0 0 0\n\
        newmtl maps\nKd 0.9 0.7 0.35\nPr 1\nPm 1\nmap_Pr half.png\nmap_Pm halves.png\n\
        newmtl lamp\nKd 0 0 0\nPr 1\nKe 1 1 1\nmap_Ke f.png\n";
    let letter = png(&letter_f()?)?;
    let mut beside = MemoryResolver::default();
    beside.files.insert("scene.mtl".to_owned(), library.as_bytes().to_vec());
    beside.files.insert("maps/my letter.png".to_owned(), letter.clone());
    beside.files.insert("f.png".to_owned(), letter);
    beside.files.insert("disc.png".to_owned(), png(&soft_disc(32)?)?);
    let hill = soft_disc(32)?;
    let hill = image(32, 32, |x, y| [hill.texels()[(x + 32 * y) as usize][3]; 4].map(|v| v.max(1)))?;
    beside.files.insert("hill.png".to_owned(), png(&hill)?);
    beside.files.insert("bumps.png".to_owned(), png(&bumps(32, 2)?)?);
    beside.files.insert(
        "half.png".to_owned(),
        png(&image(8, 8, |x, _| if x < 4 { [60, 60, 60, 255] } else { [255; 4] })?)?,
    );
    beside.files.insert(
        "halves.png".to_owned(),
        png(&image(8, 8, |_, y| if y < 4 { [255; 4] } else { [0, 0, 0, 255] })?)?,
    );
    let mut file = Obj { text: "# made by hand\nmtllib scene.mtl\n".to_owned(), count: 0 };
    let (ball, flat) = (sphere(24), square(1));
    for (k, name) in ["dull", "shiny", "metal", "coated", "glowing", "faint"].into_iter().enumerate() {
        file.shape(&ball, name, [k as f32 - 2.5, 1.0], 0.45);
    }
    for (k, name) in ["picture", "moved", "clamped", "holes", "bumpy", "heights"].into_iter().enumerate() {
        file.shape(&flat, name, [k as f32 - 2.5, 0.0], 0.45);
    }
    file.shape(&flat, "maps", [-0.5, -1.0], 0.45);
    file.shape(&flat, "lamp", [0.5, -1.0], 0.45);
    // Corners of a star, the outer ones on a square's middles and the inner ones near its centre, around (-2.5, -1).
    let mut text = std::mem::take(&mut file.text);
    text += "o star\nusemtl star\n";
    let star = [[0, 45], [10, 10], [45, 0], [10, -10], [0, -45], [-10, -10], [-45, 0], [-10, 10]];
    for [x, y] in star {
        let _ = writeln!(text, "v {} {} 0", -2.5 + f64::from(x) * 0.01, -1.0 + f64::from(y) * 0.01);
    }
    let corners: Vec<String> = (0..8).rev().map(|k| (file.count + 1 + k).to_string()).collect();
    let _ = writeln!(text, "f {} \\\n {}", corners[..5].join(" "), corners[5..].join(" "));
    text += "o painted\nusemtl white\ns off\nv -1.95 -1.45 0 1 0 0\nv -1.05 -1.45 0 0 1 0\nv -1.05 -0.55 0 0 0 1\n\
        v -1.95 -0.55 0 1 1 0\nf -4 -3 -2 -1\n\
        o last\nusemtl star\nv 1.05 -1.45 0\nv 1.95 -1.45 0\nv 1.5 -0.55 0\nf -3 -2 -1\n";
    let plain = "v 2.05 -1.45 0\nv 2.95 -1.45 0\nv 2.95 -0.55 0\nv 2.05 -0.55 0\nf 1 2 3 4\n";
    let mut s = Stage::new()?;
    let sky = s.scene.environment().clone();
    s.scene = read(text.as_bytes(), Format::Obj, &beside)?;
    s.scene.set_environment(sky)?;
    s.key_light(2.0)?;
    s.add(&read(plain.as_bytes(), Format::Obj, &beside)?, Transform::translation([0.0; 3])?)?;
    let mut camera = flat_view();
    camera.projection = Projection::Orthographic { height: 3.0 };
    s.seen(camera)
}

/// The bytes of a binary STL file; `attribute` tells the two bytes of each facet.
fn binary_stl(header: &[u8], mesh: &MeshData, attribute: impl Fn(usize) -> u16) -> Vec<u8> {
    let mut bytes = header.to_vec();
    bytes.resize(80, 0);
    bytes.extend((mesh.triangles.len() as u32).to_le_bytes());
    for (k, t) in mesh.triangles.iter().enumerate() {
        bytes.extend([0; 12]);
        bytes.extend(t.iter().flat_map(|&v| mesh.positions[v as usize]).flat_map(f32::to_le_bytes));
        bytes.extend(attribute(k).to_le_bytes());
    }
    bytes
}

/// A ball as text, without colours, in the colours of VisCAM (every fourth facet has none), the same codes as Magics
/// reads them, and in one colour for the whole.
fn stl() -> Built {
    let mut ball = sphere(16);
    // Closed: the first and the last meridian differ by rounding.
    for p in ball.positions.as_flattened_mut() {
        *p = (*p * 65536.0).round() / 65536.0 + 0.0;
    }
    // Z is up in such files.
    for p in &mut ball.positions {
        let [x, y, z] = *p;
        *p = [x, 0.0 - z, y];
    }
    let mut text = "solid ball\n".to_owned();
    for t in &ball.triangles {
        text += "facet normal 0 0 0\n outer loop\n";
        for [x, y, z] in t.map(|v| ball.positions[v as usize]) {
            let _ = writeln!(text, "  vertex {x:e} {y:e} {z:e}");
        }
        text += " endloop\nendfacet\n";
    }
    text += "endsolid ball\n";
    // Red in the highest of the three places, from the top to the bottom; green or blue by turns.
    let code = |k: usize| {
        let row = (k / 32).min(7) as u16;
        let color = (31 - 4 * row) << 10 | [20 << 5, 20][k / 2 % 2];
        if k % 8 < 2 { 0 } else { 0x8000 | color }
    };
    let magics = b"COLOR=\x20\xa0\xe0\xff";
    let files = [
        text.into_bytes(),
        binary_stl(b"a ball", &ball, |_| 0),
        binary_stl(b"", &ball, code),
        binary_stl(magics, &ball, |k| code(k) ^ 0x8000),
        binary_stl(magics, &ball, |_| 0x8000),
    ];
    let mut s = Stage::new()?;
    s.key_light(2.0)?;
    for (k, file) in files.iter().enumerate() {
        let scene = read(file, Format::Stl, &MemoryResolver::default())?;
        s.add(
            &scene,
            Transform::from_parts([2.0 * k as f64 - 4.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0], [0.9; 3])?,
        )?;
    }
    s.seen(flat_view())
}

/// Encoding of numbers in a PLY file.
#[derive(Clone, Copy, PartialEq)]
enum Encoding {
    Text,
    Little,
    Big,
}

/// A PLY file that is being written.
struct Ply {
    encoding: Encoding,
    bytes: Vec<u8>,
}

impl Ply {
    fn new(encoding: Encoding, header: &str) -> Self {
        let name = match encoding {
            Encoding::Text => "ascii",
            Encoding::Little => "binary_little_endian",
            Encoding::Big => "binary_big_endian",
        };
        Self { encoding, bytes: format!("ply\nformat {name} 1.0\n{header}end_header\n").into_bytes() }
    }

    fn number(&mut self, text: &str, little: &[u8]) {
        match self.encoding {
            Encoding::Text => self.bytes.extend([text.as_bytes(), b" "].concat()),
            Encoding::Little => self.bytes.extend(little),
            Encoding::Big => self.bytes.extend(little.iter().rev()),
        }
    }

    fn float(&mut self, v: f32) {
        self.number(&v.to_string(), &v.to_le_bytes());
    }

    fn byte(&mut self, v: u8) {
        self.number(&v.to_string(), &[v]);
    }

    fn int(&mut self, v: u32) {
        self.number(&v.to_string(), &v.to_le_bytes());
    }

    fn end_line(&mut self) {
        if self.encoding == Encoding::Text {
            self.bytes.push(b'\n');
        }
    }
}

const PLACES: &str = "property float x\nproperty float y\nproperty float z\n";
const BYTES: &str = "property uchar red\nproperty uchar green\nproperty uchar blue\n";
const FACES: &str = "property list uchar int vertex_indices\n";

/// Half a tube of quads: in text with colours of bytes; little-endian with colours of floats and normals; big-endian with
/// colours of faces; little-endian with a texture of vertices; in text with a texture of face corners; big-endian as strips.
fn ply() -> Built {
    let mesh = gutter(8);
    let mesh = mesh.with(|d| d.triangles = Vec::new());
    let vertices = mesh.positions.len();
    // Rows of nine vertices, from the top.
    let quads: Vec<[u32; 4]> = (0..8).map(|k| [k, k + 9, k + 10, k + 1]).collect();
    // Colour codes: red to the right, blue at the bottom.
    let code = |k: usize| [(k % 9 * 31) as u8, 60, if k < 9 { 20 } else { 220 }];
    let mut files = Vec::new();
    let element = |properties: &str| format!("element vertex {vertices}\n{PLACES}{properties}");
    let faces = |properties: &str| format!("element face {}\n{FACES}{properties}", quads.len());
    let quad = |file: &mut Ply, quad: &[u32; 4]| {
        file.byte(4);
        quad.iter().for_each(|&v| file.int(v));
    };

    let mut file = Ply::new(Encoding::Text, &(element(BYTES) + &faces("")));
    for (k, p) in mesh.positions.iter().enumerate() {
        p.iter().for_each(|&v| file.float(v));
        code(k).iter().for_each(|&v| file.byte(v));
        file.end_line();
    }
    for q in &quads {
        quad(&mut file, q);
        file.end_line();
    }
    files.push(file.bytes);

    let fractions = "property float nx\nproperty float ny\nproperty float nz\n\
        property float red\nproperty float green\nproperty float blue\n";
    let mut file = Ply::new(Encoding::Little, &(element(fractions) + &faces("")));
    for (k, (p, n)) in mesh.positions.iter().zip(&mesh.normals).enumerate() {
        p.iter().chain(n).for_each(|&v| file.float(v));
        code(k).iter().for_each(|&v| file.float(f32::from(v) / 255.0));
    }
    quads.iter().for_each(|q| quad(&mut file, q));
    files.push(file.bytes);

    let mut file = Ply::new(Encoding::Big, &(element("") + &faces(BYTES)));
    mesh.positions.as_flattened().iter().for_each(|&v| file.float(v));
    for (k, q) in quads.iter().enumerate() {
        quad(&mut file, q);
        [k as u8 * 36, 60, 220 * (k as u8 % 2)].iter().for_each(|&v| file.byte(v));
    }
    files.push(file.bytes);

    let texture = "comment TextureFile f.png\n";
    let header = texture.to_owned() + &element("property float s\nproperty float t\n") + &faces("");
    let mut file = Ply::new(Encoding::Little, &header);
    for (p, [u, v]) in mesh.positions.iter().zip(&mesh.uvs[0]) {
        // t runs up.
        p.iter().chain(&[*u, 1.0 - v]).for_each(|&v| file.float(v));
    }
    quads.iter().for_each(|q| quad(&mut file, q));
    files.push(file.bytes);

    let header = texture.to_owned() + &element("") + &faces("property list uchar float texcoord\n");
    let mut file = Ply::new(Encoding::Text, &header);
    for p in &mesh.positions {
        p.iter().for_each(|&v| file.float(v));
        file.end_line();
    }
    for q in &quads {
        quad(&mut file, q);
        file.byte(8);
        for &v in q {
            let [u, v] = mesh.uvs[0][v as usize];
            file.float(u);
            file.float(1.0 - v);
        }
        file.end_line();
    }
    files.push(file.bytes);

    let strips = "element tristrips 1\nproperty list int int vertex_indices\n";
    let mut file = Ply::new(Encoding::Big, &(element("") + strips));
    mesh.positions.as_flattened().iter().for_each(|&v| file.float(v));
    // Two strips, ended by -1 between them, with a gap of one quad.
    let strip = |columns: std::ops::RangeInclusive<u32>| columns.flat_map(|k| [k, k + 9]);
    let list: Vec<u32> = strip(0..=3).chain([u32::MAX]).chain(strip(4..=8)).collect();
    file.int(list.len() as u32);
    list.iter().for_each(|&v| file.int(v));
    files.push(file.bytes);

    let mut beside = MemoryResolver::default();
    beside.files.insert("f.png".to_owned(), png(&letter_f()?)?);
    let mut s = Stage::new()?;
    s.key_light(2.0)?;
    for (k, file) in files.iter().enumerate() {
        let scene = read(file, Format::Ply, &beside)?;
        let place = [(k % 3) as f64 * 2.0 - 2.0, 1.0 - 2.0 * (k / 3) as f64, 0.0];
        s.add(&scene, Transform::from_parts(place.map(|v| v * 0.5), [0.0, 0.0, 0.0, 1.0], [0.45; 3])?)?;
    }
    s.seen(flat_view())
}

const HEAD: &str = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<model unit=\"millimeter\" \
    xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\" \
    xmlns:m=\"http://schemas.microsoft.com/3dmanufacturing/material/2015/02\" \
    xmlns:p=\"http://schemas.microsoft.com/3dmanufacturing/production/2015/06\" requiredextensions=\"m p\">";

/// A pyramid of 10 millimetres on its base, the first two triangles, with properties of its triangles.
fn pyramid(of_triangle: impl Fn(usize) -> &'static str) -> String {
    let mut text = "<mesh><vertices>".to_owned();
    for [x, y, z] in [[-5, -5, -5], [5, -5, -5], [5, 5, -5], [-5, 5, -5], [0, 0, 5]] {
        let _ = write!(text, "<vertex x=\"{x}\" y=\"{y}\" z=\"{z}\"/>");
    }
    text += "</vertices><triangles>";
    for (k, [a, b, c]) in
        [[0, 2, 1], [0, 3, 2], [0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]].into_iter().enumerate()
    {
        let _ = write!(text, "<triangle v1=\"{a}\" v2=\"{b}\" v3=\"{c}\" {}/>", of_triangle(k));
    }
    text + "</triangles></mesh>"
}

/// Transform of an item or component, with the translation in millimetres; turned so that two sides show.
fn turned(x: f64, z: f64, scale: f64) -> String {
    // Rows are where the axes go: by about 37 degrees about z, then by 27 towards the eye.
    let [s, c, t, d] = [0.6 * scale, 0.8 * scale, 0.454 * scale, 0.891];
    format!("{c} {} {} {} {} {} 0 {} {} {x} 0 {z}", s * d, 0.6 * t, -s, c * d, 0.8 * t, -t, d * scale)
}

/// Upper row: base materials, a colour group whose corners differ, a texture, a mixture of materials, layers. Lower row: an
/// object of another part in another unit; two components of one object, the upper turned over; triangles painted in a
/// slicer; an object that a filament prints.
fn three_mf() -> Built {
    let groups = "<m:texture2d id=\"20\" path=\"/3D/f.png\" contenttype=\"image/png\" filter=\"nearest\"/>\
        <basematerials id=\"1\"><base name=\"red\" displaycolor=\"#C02010\"/>\
        <base name=\"blue\" displaycolor=\"#2040C0\"/></basematerials>\
        <m:colorgroup id=\"2\"><m:color color=\"#FF0000\"/><m:color color=\"#00FF00\"/><m:color color=\"#FFFFFF\"/>\
        </m:colorgroup><m:texture2dgroup id=\"3\" texid=\"20\">\
        <m:tex2coord u=\"0\" v=\"0\"/><m:tex2coord u=\"1\" v=\"0\"/><m:tex2coord u=\"0.5\" v=\"1\"/>\
        </m:texture2dgroup>\
        <m:compositematerials id=\"4\" matid=\"1\" matindices=\"0 1\"><m:composite values=\"1 0\"/>\
        <m:composite values=\"0.5 0.5\"/>\
        <m:composite values=\"0 1\"/></m:compositematerials>\
        <m:multiproperties id=\"5\" pids=\"2 3\" blendmethods=\"multiply\">\
        <m:multi pindices=\"0 0\"/><m:multi pindices=\"1 1\"/>\
        <m:multi pindices=\"2 2\"/></m:multiproperties>";
    let base = pyramid(|k| if k % 2 == 0 { "p1=\"1\"" } else { "" });
    let corners = |group: &'static str| pyramid(move |k| if k < 2 { "pid=\"1\" p1=\"0\"" } else { group });
    let colors = corners("pid=\"2\" p1=\"0\" p2=\"1\" p3=\"2\"");
    let textured = corners("pid=\"3\" p1=\"0\" p2=\"1\" p3=\"2\"");
    let mixed = corners("pid=\"4\" p1=\"0\" p2=\"1\" p3=\"2\"");
    let layered = corners("pid=\"5\" p1=\"0\" p2=\"1\" p3=\"2\"");
    let mut build = String::new();
    for k in 0..5 {
        let _ = write!(
            build,
            "<item objectid=\"{}\" transform=\"{}\"/>",
            10 + k,
            turned(f64::from(k) * 15.0 - 30.0, 7.0, 1.0)
        );
    }
    let other = turned(-30.0, -7.0, 1.0);
    let pair = turned(-10.0, -7.0, 0.6);
    let root = format!(
        "{HEAD}<resources>{groups}<object id=\"10\" pid=\"1\" pindex=\"0\">{base}</object>\
         <object id=\"11\">{colors}</object>\
         <object id=\"12\">{textured}</object><object id=\"13\">{mixed}</object><object id=\"14\">{layered}</object>\
         <object id=\"16\"><components><component objectid=\"10\" transform=\"1 0 0 0 1 0 0 0 1 0 0 -5\"/>\
         <component objectid=\"10\" transform=\"1 0 0 0 -1 0 0 0 -1 0 0 5\"/></components></object></resources>\
         <build>{build}<item objectid=\"5\" p:path=\"/3D/other.model\" transform=\"{other}\"/>\
         <item objectid=\"16\" transform=\"{pair}\"/></build></model>"
    );
    let microns = HEAD.replace("millimeter", "micron");
    let thousand = "<component objectid=\"4\" transform=\"800 0 0 0 800 0 0 0 800 0 0 0\"/>";
    let second = format!(
        "{microns}<resources><basematerials id=\"1\"><base name=\"green\" displaycolor=\"#20A040\"/></basematerials>\
         <object id=\"4\" pid=\"1\" pindex=\"0\">{}</object>\
         <object id=\"5\"><components>{thousand}</components></object>\
         </resources><build/></model>",
        pyramid(|_| "")
    );
    let letter = png(&letter_f()?)?;
    let relations = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
        <Relationships xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\">\
        <Relationship Target=\"/3D/3dmodel.model\" Id=\"r0\" \
        Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/></Relationships>";
    let package = stored_zip(&[
        ("_rels/.rels", relations.as_bytes()),
        ("3D/3dmodel.model", root.as_bytes()),
        ("3D/other.model", second.as_bytes()),
        ("3D/f.png", &letter),
    ]);
    // Two sides that show are cut in four. Of one, the corner at its first vertex is the second filament's and the rest the
    // first's; of the other, the other way round.
    let painted = pyramid(|k| match k {
        2 => "paint_color=\"84443\"",
        5 => "paint_color=\"48883\"",
        _ => "",
    });
    let slicer = format!(
        "{HEAD}<resources><object id=\"1\">{painted}</object><object id=\"2\">{}</object></resources><build>\
         <item objectid=\"1\" transform=\"{}\"/><item objectid=\"2\" transform=\"{}\"/></build></model>",
        pyramid(|_| ""),
        turned(10.0, -7.0, 1.0),
        turned(30.0, -7.0, 1.0)
    );
    let settings = "<config><object id=\"1\"><metadata key=\"extruder\" value=\"2\"/></object>\
        <object id=\"2\"><metadata key=\"extruder\" value=\"3\"/></object></config>";
    let filaments = "{\"filament_colour\": [\"#E0C020\", \"#303030\", \"#C04090\"]}";
    let sliced = stored_zip(&[
        ("_rels/.rels", relations.as_bytes()),
        ("3D/3dmodel.model", slicer.as_bytes()),
        ("Metadata/model_settings.config", settings.as_bytes()),
        ("Metadata/project_settings.config", filaments.as_bytes()),
    ]);
    let mut s = Stage::new()?;
    s.key_light(2.0)?;
    for package in [package, sliced] {
        let scene = read(&package, Format::ThreeMf, &MemoryResolver::default())?;
        // Pyramids stand 15 millimetres apart, two above each other.
        s.add(&scene, Transform::from_parts([0.0, 0.07, 0.0], [0.0, 0.0, 0.0, 1.0], [1000.0 / 15.0; 3])?)?;
    }
    s.seen(flat_view())
}
