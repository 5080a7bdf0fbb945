//! Seeds of 3MF (the text of a model part) and of KTX2.

/// Colours, components, painted triangles, and what is not core.
pub const THREEMF: [(&str, &str); 2] = [
    (
        "properties",
        "<model unit=\"inch\" xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\" xmlns:m=\"http://schemas.microsoft.com/3dmanufacturing/material/2015/02\"><resources><basematerials id=\"1\"><base name=\"red\" displaycolor=\"#FF0000\"/></basematerials><m:colorgroup id=\"2\"><m:color color=\"#00FF00\"/><m:color color=\"#0000FF80\"/></m:colorgroup><m:texture2d id=\"3\" path=\"/t.png\" contenttype=\"image/png\" tilestyleu=\"clamp\"/><m:texture2dgroup id=\"4\" texid=\"3\"><m:tex2coord u=\"0\" v=\"0\"/><m:tex2coord u=\"1\" v=\"0.5\"/></m:texture2dgroup><m:compositematerials id=\"6\" matid=\"1\" matindices=\"0 0\"><m:composite values=\"0.5 0.5\"/></m:compositematerials><m:multiproperties id=\"7\" pids=\"1 2\"><m:multi pindices=\"0 1\"/></m:multiproperties><object id=\"5\" pid=\"1\" pindex=\"0\"><mesh><vertices><vertex x=\"0\" y=\"0\" z=\"0\"/><vertex x=\"1\" y=\"0\" z=\"0\"/><vertex x=\"0\" y=\"1e0\" z=\"0\"/><vertex x=\"0\" y=\"0\" z=\"-1.5\"/></vertices><triangles><triangle v1=\"0\" v2=\"1\" v3=\"2\" pid=\"2\" p1=\"0\" p2=\"1\" p3=\"0\"/><triangle v1=\"0\" v2=\"1\" v3=\"3\" pid=\"4\" p1=\"0\" p2=\"1\" p3=\"1\"/><triangle v1=\"1\" v2=\"2\" v3=\"3\" pid=\"7\" p1=\"0\"/><triangle v1=\"2\" v2=\"0\" v3=\"3\" pid=\"6\" p1=\"0\"/></triangles></mesh></object><object id=\"9\"><components><component objectid=\"5\" transform=\"1 0 0 0 1 0 0 0 1 5 0 0\"/><component objectid=\"5\"/></components></object></resources><build><item objectid=\"9\" transform=\"1 0 0 0 0 1 0 -1 0 0 0 0\"/></build></model>",
    ),
    (
        "painted",
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<model unit=\"millimeter\" requiredextensions=\"p\" xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\" xmlns:slic3rpe=\"http://schemas.slic3r.org/3mf/2017/06\" xmlns:p=\"http://schemas.microsoft.com/3dmanufacturing/production/2015/06\"><metadata name=\"Title\">x &amp; y</metadata><resources><!-- a --><object id=\"1\" type=\"model\" p:UUID=\"0\"><mesh><vertices><vertex x=\"0\" y=\"0\" z=\"0\"/><vertex x=\"10\" y=\"0\" z=\"0\"/><vertex x=\"0\" y=\"10\" z=\"0\"/></vertices><triangles><triangle v1=\"0\" v2=\"1\" v3=\"2\" paint_color=\"4\" slic3rpe:mmu_segmentation=\"1C\"/></triangles></mesh></object><object id=\"2\" type=\"support\"><components><component objectid=\"1\" p:path=\"/3D/b.model\"/></components></object></resources><build><item objectid=\"1\" printable=\"0\"/><item objectid=\"2\"/><item objectid=\"1\"/></build></model>",
    ),
];

/// A container of one level (KTX file format 2.0).
fn container(format: u32, [width, height]: [u32; 2], scheme: u32, model: u8, level: &[u8]) -> Vec<u8> {
    let mut descriptor = [0; 44];
    descriptor[0] = 44;
    descriptor[12] = model;
    descriptor[31] = 3;
    let place = 104 + descriptor.len();
    let mut file = b"\xabKTX 20\xbb\r\n\x1a\n".to_vec();
    for word in [format, 1, width, height, 0, 0, 1, 1, scheme, 104, descriptor.len() as u32, 0, 0] {
        file.extend(word.to_le_bytes());
    }
    for long in [0, 0, place, level.len(), level.len()] {
        file.extend((long as u64).to_le_bytes());
    }
    file.extend(descriptor);
    file.extend(level);
    file
}

/// Textures of bytes and of blocks, as they are and in one frame of Zstandard that holds them as they are.
pub fn ktx2() -> Vec<(&'static str, Vec<u8>)> {
    let texels: Vec<u8> = (0..4 * 3 * 4).map(|k| k * 5).collect();
    // A block of mode 8, one colour; and one of mode 0, whose bits are anything.
    let solid = (23 | u128::from(0x80ff_3010_u32) << 5).to_le_bytes();
    let blocks = [solid, [0x01, 0x23, 0x45, 0x67, 0x89, 0xab, 0xcd, 0xef, 1, 2, 3, 4, 5, 6, 7, 8]].concat();
    let frame = |bytes: &[u8]| {
        let length = bytes.len() as u8;
        // A frame of one segment with its size in a byte, and one raw block, the last.
        let header = [0x28, 0xb5, 0x2f, 0xfd, 0x20, length, length << 3 | 1, length >> 5, 0];
        [&header, bytes].concat()
    };
    vec![
        ("bytes", container(37, [4, 3], 0, 1, &texels)),
        ("bytes-zstd", container(43, [4, 3], 2, 1, &frame(&texels))),
        ("uastc", container(0, [7, 4], 0, 166, &blocks)),
        ("uastc-zstd", container(0, [7, 4], 2, 166, &frame(&blocks))),
    ]
}
