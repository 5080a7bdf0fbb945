//! OBJ, MTL, STL and PLY.

use super::attack::Must::{Draw, Exceed, Fail, Warn};
use super::attack::{Attack, Must};

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n";

fn obj(name: &'static str, tries: &'static str, text: impl AsRef<[u8]>, must: Must) -> Attack {
    Attack::model(name, tries, "x.obj", text.as_ref(), must)
}

/// A textured triangle of a material of this library.
fn mtl(name: &'static str, tries: &'static str, library: impl AsRef<[u8]>, must: Must) -> Attack {
    let text = format!("mtllib m.mtl\n{TRIANGLE}usemtl a\nf 1/1 2/2 3/3\n");
    Attack::model(name, tries, "x.obj", text, must).with("m.mtl", library.as_ref())
}

fn stl(claimed: u32, facets: usize) -> Vec<u8> {
    let mut file = vec![0; 80];
    file.extend(claimed.to_le_bytes());
    for _ in 0..facets {
        for v in [0.0_f32, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0] {
            file.extend(v.to_le_bytes());
        }
        file.extend([0, 0]);
    }
    file
}

fn ply(format: &str, elements: &str, body: &[u8]) -> Vec<u8> {
    let mut file = format!("ply\nformat {format} 1.0\n{elements}end_header\n").into_bytes();
    file.extend(body);
    file
}

const VERTICES: &str = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
const FACES: &str = "element face 1\nproperty list uchar int vertex_indices\n";
const ASCII: &[u8] = b"0 0 0\n1 0 0\n0 1 0\n";

fn corners() -> Vec<u8> {
    [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].iter().flat_map(|v| v.to_le_bytes()).collect()
}

pub fn attacks() -> Vec<Attack> {
    let text = |face: &str| format!("{TRIANGLE}{face}\n");
    let star = {
        // A polygon whose every diagonal is outside: ears are searched for in vain.
        let mut out = String::new();
        for k in 0..20_000 {
            let z = if k % 2 == 0 { 1 } else { 1000 };
            out += &format!("v {} {} 0\n", (k * 7919 % 20_011) * z, (k * 104_729 % 20_021) * z);
        }
        out + "f" + &(1..=20_000).map(|k| format!(" {k}")).collect::<String>() + "\n"
    };
    let p = |name, tries, bytes: Vec<u8>, must| Attack::model(name, tries, "x.ply", bytes, must);
    let s = |name, tries, bytes: Vec<u8>, must| Attack::model(name, tries, "x.stl", bytes, must);
    vec![
        obj("obj-index-zero", "an index before the first", text("f 0 1 2"), Warn("left out")),
        obj("obj-index-beyond", "a read past the vertices", text("f 1 2 4"), Warn("left out")),
        obj("obj-index-negative", "a read before the vertices", text("f -1 -2 -4"), Warn("left out")),
        obj("obj-index-maximum", "an index that wraps in 32 bits", text("f 1 2 4294967297"), Warn("left out")),
        obj("obj-index-minimum", "the negative number without a positive one", text("f 1 2 -9223372036854775808"), Warn("left out")),
        obj("obj-index-64", "an index that wraps in 64 bits", text("f 1 2 18446744073709551617"), Warn("left out")),
        obj("obj-uv-beyond", "a read past the texture coordinates", text("f 1/9 2/9 3/9"), Warn("texture")),
        obj("obj-normal-beyond", "a read past the normals", text("f 1//1 2//1 3//1"), Warn("normal")),
        obj("obj-forward", "vertices that come later", format!("f 1 2 3\n{TRIANGLE}"), Draw),
        obj("obj-polygon-crossed", "quadratic work on one polygon", &star, Exceed("blocks")),
        obj("obj-not-a-number", "coordinates that are none", "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", Warn("left out")),
        obj("obj-infinite", "coordinates without end", "v 1e39 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", Warn("left out")),
        obj("obj-long-number", "a number of a million digits", format!("v 0.{} 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "1".repeat(1 << 20)), Draw),
        obj("obj-exponent", "an exponent of a million digits", format!("v 1e-{} 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "9".repeat(1 << 20)), Draw),
        obj("obj-one-line", "a line of a megabyte", format!("{TRIANGLE}f 1 2 3 #{}", "x".repeat(1 << 20)), Draw),
        obj("obj-continued", "a line that never ends", format!("{TRIANGLE}f 1 2 3 {}", "\\\n".repeat(1 << 18)), Draw),
        obj("obj-groups", "memory for a million objects", { let mut out = TRIANGLE.to_owned(); for k in 0..70_000 { out += &format!("o {k}\nf 1 2 3\n"); } out }, Exceed("nodes")),
        obj("obj-materials", "memory for materials that are not there", { let mut out = TRIANGLE.to_owned(); for k in 0..70_000 { out += &format!("usemtl {k}\nf 1 2 3\n"); } out }, Exceed("nodes")),
        obj("obj-libraries", "a thousand libraries", { let mut out = String::new(); for k in 0..5000 { out += &format!("mtllib {k}.mtl\n"); } out + TRIANGLE + "f 1 2 3\n" }, Warn("material libraries beyond")),
        obj("obj-triangles", "more triangles than allowed", TRIANGLE.to_owned() + &"f 1 2 3\n".repeat(1_100_000), Exceed("triangles")),
        obj("obj-nul-bytes", "text that is none", [TRIANGLE.as_bytes(), b"f 1 2 3\0\0\0\n\0\xff\xfe\nf 1 2 3\n"].concat(), Warn("OBJ")),
        obj("obj-only-garbage", "a file of no format", vec![0xee; 5000], Fail("OBJ")),
        mtl("mtl-no-name", "a material without a name", "newmtl\nKd 1 0 0\n", Warn("not defined")),
        mtl("mtl-numbers", "colours that are no numbers", "newmtl a\nKd nan inf 1e40\nNs -1e30\nd 7\nPr 1e30\nNi 0\n", Warn("not a usable value")),
        mtl("mtl-map-without-file", "a map of nothing", "newmtl a\nmap_Kd\nmap_Bump -bm\nmap_d -s 1\n", Warn("map_")),
        mtl("mtl-map-options", "options without their values", "newmtl a\nmap_Kd -s -o -t -mm -texres -clamp -blendu x y z\n", Warn("texture")),
        mtl("mtl-map-missing", "a file that is not there", "newmtl a\nmap_Kd no.png\n", Warn("is left out")),
        mtl("mtl-map-itself", "a picture that is its own library", "newmtl a\nmap_Kd m.mtl\n", Warn("is left out")),
        mtl("mtl-map-bomb", "a picture of 2^32 pixels", "newmtl a\nmap_Kd b.png\n", Warn("(texture_pixels); it is left out")).with("b.png", bomb()),
        mtl("mtl-materials", "memory for a million materials", (0..70_000).map(|k| format!("newmtl {k}\n")).collect::<String>(), Exceed("nodes")),
        mtl("mtl-binary", "a library that is no text", vec![0xff; 4096], Warn("OBJ")),
        mtl("mtl-maps-by-the-thousand", "five thousand pictures", { let mut out = String::from("newmtl a\n"); for k in 0..5000 { out += &format!("map_Kd {k}.png\n"); } out }, Warn("left out")),
        s("stl-count-maximum", "an allocation of the claimed facets", stl(u32::MAX, 2), Warn("ends after 2 of 4294967295")),
        s("stl-count-zero", "facets that are not counted", stl(0, 2), Warn("STL")),
        s("stl-cut", "an end within a facet", stl(2, 2)[..150].to_vec(), Warn("ends after 1 of 2")),
        s("stl-solid-binary", "text by its first word, binary by its content", { let mut file = stl(2, 2); file[..5].copy_from_slice(b"solid"); file }, Draw),
        s("stl-short", "less than a header", b"abc".to_vec(), Fail("neither text nor binary")),
        s("stl-vertices-nan", "corners that are no numbers", b"solid x\nfacet normal 0 0 0\nouter loop\nvertex nan 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n".to_vec(), Warn("STL")),
        s("stl-vertex-cut", "an end within a corner", b"solid x\nfacet normal 0 0 0\nouter loop\nvertex 0 0".to_vec(), Warn("ends within a facet")),
        s("stl-solids", "memory for a million solids", "solid x\nendsolid x\n".repeat(200_000).into_bytes(), Warn("no triangles")),
        s("stl-facets", "more triangles than allowed", stl(1_100_000, 1_100_000), Warn("facets are drawn as")),
        p("ply-count-maximum", "an allocation of the claimed vertices", ply("binary_little_endian", &VERTICES.replace('3', "18446744073709551615"), &corners()), Fail("cannot be")),
        p("ply-count-huge", "an allocation of four billion vertices", ply("ascii", &VERTICES.replace('3', "4000000000"), ASCII), Exceed("vertices")),
        p("ply-count-of-faces", "an allocation of the claimed faces", ply("ascii", &(VERTICES.to_owned() + &FACES.replace("face 1", "face 4000000000")), ASCII), Fail("file ends within")),
        p("ply-list-maximum", "an allocation of a list's length", ply("binary_little_endian", &(VERTICES.to_owned() + &FACES.replace("uchar", "uint")), &[corners(), vec![0xff; 4]].concat()), Fail("PLY")),
        p("ply-list-negative", "a list shorter than nothing", ply("ascii", &(VERTICES.to_owned() + &FACES.replace("uchar", "int")), &[ASCII, b"-1 0 1 2\n"].concat()), Warn("1 face left out")),
        p("ply-index-negative", "a read before the vertices", ply("ascii", &(VERTICES.to_owned() + FACES), &[ASCII, b"3 0 1 -1\n"].concat()), Warn("face")),
        p("ply-index-beyond", "a read past the vertices", ply("ascii", &(VERTICES.to_owned() + FACES), &[ASCII, b"3 0 1 3\n"].concat()), Warn("face")),
        p("ply-elements", "a header of a million elements", { let mut out = VERTICES.to_owned(); for k in 0..200_000 { out += &format!("element e{k} 0\n"); } ply("ascii", &out, ASCII) }, Fail("PLY")),
        p("ply-properties", "a row of a million values", { let mut out = VERTICES.to_owned(); for k in 0..200_000 { out += &format!("property float p{k}\n"); } ply("binary_little_endian", &out, &corners()) }, Fail("PLY")),
        p("ply-empty-rows", "four billion rows of no bytes", ply("binary_little_endian", &format!("element x 4000000000\n{VERTICES}"), &corners()), Draw),
        p("ply-empty-lists", "four billion lists of one byte", ply("binary_little_endian", &format!("element x 4000000000\nproperty list uchar int y\n{VERTICES}"), &corners()), Fail("PLY")),
        p("ply-no-end", "a header without an end", b"ply\nformat ascii 1.0\nelement vertex 3\n".to_vec(), Fail("end_header")),
        p("ply-type-unknown", "a size of no type", ply("ascii", "element vertex 3\nproperty quad x\n", ASCII), Fail("no x, y and z")),
        p("ply-cut", "an end within the vertices", ply("binary_big_endian", VERTICES, &corners()[..20]), Warn("ends within")),
        p("ply-not-finite", "coordinates that are no numbers", ply("ascii", &(VERTICES.to_owned() + FACES), b"nan 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"), Warn("PLY")),
        Attack::model("no-format", "a file that is nothing", "x.bin", vec![0x55; 64], Fail("format")),
        Attack::model("empty-file", "a file without a byte", "x.glb", Vec::new(), Fail("empty")),
        Attack::model("name-that-lies", "a PNG called glTF", "x.gltf", bomb(), Fail("glTF")),
    ]
}

/// The header of a PNG file of 65535 x 65535 pixels.
fn bomb() -> Vec<u8> {
    let mut out = b"\x89PNG\r\n\x1a\n\0\0\0\x0dIHDR\0\0\xff\xff\0\0\xff\xff\x08\x06\0\0\0".to_vec();
    let checksum = crc32fast::hash(&out[12..29]);
    out.extend(checksum.to_be_bytes());
    out
}
