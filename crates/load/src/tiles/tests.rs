//! Tiles that are written byte by byte, and read again.

use super::earth;
use super::features::unfolded;
use crate::hostile::{attack, limits, load, load_beside, warnings};
use crate::{Format, Loaded, MemoryResolver};
use overcoat_core::color::srgb::srgb8_to_linear;

/// A triangle of which +Y is up, two high.
fn glb() -> Vec<u8> {
    let positions = [[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
    let binary: Vec<u8> = positions.as_flattened().iter().flat_map(|v| v.to_le_bytes()).collect();
    let mut json = "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":36}],\"bufferViews\":[{\"buffer\":0,\
        \"byteLength\":36}],\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\",\
        \"min\":[0,0,0],\"max\":[1,2,0]}],\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,0,0,1]}}],\
        \"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"material\":0}]}],\
        \"nodes\":[{\"mesh\":0}],\"scenes\":[{\"nodes\":[0]}],\"scene\":0}"
        .to_owned();
    json += &" ".repeat(json.len().next_multiple_of(4) - json.len());
    let word = |v: usize| (v as u32).to_le_bytes();
    let length = 12 + 8 + json.len() + 8 + binary.len();
    [
        b"glTF\x02\0\0\0",
        &word(length)[..],
        &word(json.len()),
        b"JSON",
        json.as_bytes(),
        &word(binary.len()),
        b"BIN\0",
        &binary,
    ]
    .concat()
}

/// A tile of a kind with a feature table and what is behind it.
fn tile(kind: &[u8], text: &str, binary: &[u8], body: &[u8]) -> Vec<u8> {
    let words = |list: &[usize]| list.iter().flat_map(|&v| (v as u32).to_le_bytes()).collect::<Vec<_>>();
    let format = if kind == b"i3dm" { words(&[1]) } else { Vec::new() };
    let length = 28 + format.len() + text.len() + binary.len() + body.len();
    let head = words(&[1, length, text.len(), binary.len(), 0, 0]);
    [kind, &head, &format, text.as_bytes(), binary, body].concat()
}

fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

fn composite(tiles: &[Vec<u8>]) -> Vec<u8> {
    let body = tiles.concat();
    let head = [1, 16 + body.len(), tiles.len()].map(|v| (v as u32).to_le_bytes());
    [b"cmpt", &head.concat()[..], &body].concat()
}

/// Place in the scene of each instance's vertex of a number.
fn placed(loaded: &Loaded, vertex: usize) -> Vec<[f64; 3]> {
    let scene = &loaded.scene;
    let of = |instance: &overcoat_scene::Instance| {
        let p = scene.meshes()[instance.mesh.index()].positions()[vertex];
        instance.transform.point(p.map(f64::from))
    };
    scene.instances().iter().map(of).collect()
}

fn near(a: [f64; 3], b: [f64; 3]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-4)
}

fn points() -> Vec<u8> {
    let text = "{\"POINTS_LENGTH\":2,\"POSITION\":{\"byteOffset\":0},\"RGB\":{\"byteOffset\":24},\
                \"NORMAL_OCT16P\":{\"byteOffset\":30},\"RTC_CENTER\":[10,20,30]}  ";
    let binary =
        [floats(&[0.0, 0.0, 0.0, 1.0, 2.0, 3.0]), vec![255, 0, 0, 0, 128, 0, 128, 128, 255, 128]].concat();
    tile(b"pnts", text, &binary, &[])
}

#[test]
fn models_stand_upright() {
    let bytes =
        tile(b"b3dm", "{\"BATCH_LENGTH\":0,\"RTC_CENTER\":[1,2,3]}", &[], &[glb(), vec![0; 5]].concat());
    assert_eq!(Format::detect(&bytes), Some(Format::Tile));
    let loaded = load(&bytes, Format::Tile).unwrap();
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    assert!(near(placed(&loaded, 2)[0], [0.0, 2.0, 0.0]));
    assert_eq!(loaded.scene.origin(), [1.0, 3.0, -2.0]);
    // Drafts of the format: a batch table alone, or with the number of its rows.
    for (sizes, table) in [(&[3_u32, 4][..], &b"\"ab\""[..]), (&[4, 0, 3], b"{\"a\"")] {
        let words: Vec<u8> = sizes.iter().flat_map(|v| v.to_le_bytes()).collect();
        let length = 12 + words.len() + table.len() + glb().len();
        let head = [1, length as u32].map(u32::to_le_bytes).concat();
        let bytes = [&b"b3dm"[..], &head, &words, table, &glb()].concat();
        assert_eq!(load(&bytes, Format::Tile).unwrap().scene.triangle_count(), 1);
    }
}

#[test]
fn points_have_colors_and_normals() {
    let loaded = load(&points(), Format::Tile).unwrap();
    let mesh = &loaded.scene.meshes()[0];
    assert_eq!(mesh.colors()[1], [0.0, srgb8_to_linear(128), 0.0, 1.0]);
    assert!(mesh.normals()[0][2] > 0.99 && mesh.normals()[1][0] > 0.99, "{:?}", mesh.normals());
    // +Z of the tile is up.
    assert!(near(placed(&loaded, 1)[0], [1.0, 3.0, -2.0]));
    assert_eq!(loaded.scene.origin(), [10.0, 30.0, -20.0]);
    let text = "{\"POINTS_LENGTH\":2,\"POSITION_QUANTIZED\":{\"byteOffset\":0},\"QUANTIZED_VOLUME_OFFSET\":[1,1,1],\
                \"QUANTIZED_VOLUME_SCALE\":[2,4,8],\"RGB565\":{\"byteOffset\":12}}";
    let bytes = tile(b"pnts", text, &[255, 255, 0, 0, 0, 0, 0, 0, 0, 0, 255, 255, 0, 0xf8, 0, 0], &[]);
    let loaded = load(&bytes, Format::Tile).unwrap();
    assert!(near(placed(&loaded, 0)[0], [3.0, 1.0, -1.0]), "{:?}", placed(&loaded, 0));
    assert_eq!(loaded.scene.meshes()[0].colors()[0], [1.0, 0.0, 0.0, 1.0]);
}

#[test]
fn instances_stand_where_they_are() {
    let text = "{\"INSTANCES_LENGTH\":2,\"POSITION\":{\"byteOffset\":0},\"NORMAL_UP\":{\"byteOffset\":24},\
                \"NORMAL_RIGHT\":{\"byteOffset\":48},\"SCALE\":{\"byteOffset\":72}}";
    // The second is turned by 90 degrees about +Z of the tile: its right is +Y, and its up -X.
    let binary = floats(&[
        0.0, 0.0, 0.0, 5.0, 0.0, 0.0, 0.0, 1.0, 0.0, -1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 3.0,
    ]);
    let bytes = tile(b"i3dm", text, &binary, &glb());
    let loaded = load(&bytes, Format::Tile).unwrap();
    assert_eq!(loaded.scene.triangle_count(), 2);
    let (right, up) = (placed(&loaded, 1), placed(&loaded, 2));
    assert!(near(up[0], [0.0, 2.0, 0.0]) && near(up[1], [5.0, 6.0, 0.0]), "{up:?}");
    assert!(near(right[0], [1.0, 0.0, 0.0]) && near(right[1], [5.0, 0.0, -3.0]), "{right:?}");
    // A model beside the tile.
    let mut bytes = tile(b"i3dm", text, &binary, b"tree.glb   ");
    bytes[28] = 0;
    let mut beside = MemoryResolver::default();
    beside.files.insert("tree.glb".to_owned(), glb());
    let loaded = load_beside(&bytes, Format::Tile, &beside, &limits()).unwrap();
    assert_eq!(loaded.scene.triangle_count(), 2);
    let loaded = load(&bytes, Format::Tile).unwrap();
    assert!(warnings(&loaded)[0].contains("model 'tree.glb' is left out"), "{:?}", warnings(&loaded));
}

#[test]
fn composites_are_one_scene() {
    let model = tile(b"b3dm", "{\"BATCH_LENGTH\":0}", &[], &glb());
    let mut broken = model.clone();
    broken[4] = 9;
    let bytes = composite(&[points(), composite(&[model.clone(), model.clone()])]);
    let loaded = load(&bytes, Format::Tile).unwrap();
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    assert_eq!((loaded.scene.instances().len(), loaded.scene.materials().len()), (3, 3));
    let moved = placed(&loaded, 0)[1];
    assert!(near(moved, [-10.0, -30.0, 20.0]), "{moved:?}");
    let loaded = load(&composite(&[model, broken]), Format::Tile).unwrap();
    assert!(warnings(&loaded)[0].contains("tile 2 of 2 left out"), "{:?}", warnings(&loaded));
    let mut nested = points();
    for _ in 0..100 {
        nested = composite(&[nested]);
    }
    let error = load(&nested, Format::Tile).unwrap_err().to_string();
    assert!(error.contains("a composite"), "{error}");
}

#[test]
fn tiles_on_the_ground_are_turned_upright() {
    // On the equator, a quarter around to the east: up is +Y of the tile.
    let [east, north, up] = earth::axes([0.0, 6_378_137.0, 0.0]);
    assert!(near(east, [-1.0, 0.0, 0.0]) && near(north, [0.0, 0.0, 1.0]) && near(up, [0.0, 1.0, 0.0]));
    let text = "{\"POINTS_LENGTH\":2,\"POSITION\":{\"byteOffset\":0},\"RTC_CENTER\":[0,6378137,0]}";
    let bytes = tile(b"pnts", text, &floats(&[0.0, 0.0, 0.0, 0.0, 7.0, 1.0]), &[]);
    let loaded = load(&bytes, Format::Tile).unwrap();
    assert!(near(placed(&loaded, 1)[0], [0.0, 7.0, -1.0]), "{:?}", placed(&loaded, 1));
    let n = unfolded([-0.6, 0.8]);
    assert!(n[2] < 0.0 && (n.iter().map(|v| v * v).sum::<f32>() - 1.0).abs() < 1e-5);
}

#[test]
fn hostile_files_end_in_a_scene_or_a_message() {
    for (text, message) in [
        ("{\"POINTS_LENGTH\":4000000000,\"POSITION\":{\"byteOffset\":0}}", "is not within the feature table"),
        ("{\"POINTS_LENGTH\":1,\"POSITION\":{\"byteOffset\":-1}}", "a byteOffset that is none"),
        ("{\"POINTS_LENGTH\":1}", "the points have no positions"),
        ("[1]", "the feature table is no JSON object"),
        ("", "the feature table has no POINTS_LENGTH"),
    ] {
        let error = load(&tile(b"pnts", text, &[0; 16], &[]), Format::Tile).unwrap_err().to_string();
        assert!(error.contains(message), "{text}: {error}");
    }
    // Composites that claim more tiles than there are, behind one that cannot be read or has no length.
    for damage in [None, Some((4, 9)), Some((8, 0))] {
        let mut bytes = composite(&[points()]);
        bytes[12..16].fill(0xff);
        if let Some((place, value)) = damage {
            bytes[16 + place] = value;
        }
        assert_eq!(load(&bytes, Format::Tile).is_ok(), damage.is_none());
    }
    let text = "{\"INSTANCES_LENGTH\":1,\"POSITION\":{\"byteOffset\":0}}";
    let instanced = tile(b"i3dm", text, &floats(&[1.0, 2.0, 3.0]), &glb());
    attack(&composite(&[points(), instanced]), Format::Tile);
    attack(&tile(b"b3dm", "{\"RTC_CENTER\":[0,6378137,0]}", &[], &glb()), Format::Tile);
}
