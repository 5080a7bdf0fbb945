//! Materials with surfaces of MaterialX: networks of the stage, and documents that it refers to.

use super::{SQUARE, file, with_material};
use crate::hostile::{attack, limits, load, load_beside, warnings};
use crate::threemf::{png, zip};
use crate::{Format, Loaded, MemoryResolver};
use overcoat_scene::{ColorSpace, ShadingModel, Workflow};

/// The square with a material of these outputs and shaders.
fn square(material: &str) -> String {
    let square = SQUARE.replacen(
        '{',
        "( prepend apiSchemas = [\"MaterialBindingAPI\"] ) {\n rel material:binding = </M>",
        1,
    );
    format!("{square}\ndef Material \"M\" {{\n{material}\n}}\n")
}

/// A shader of a definition.
fn shader(name: &str, id: &str, inputs: &str) -> String {
    format!("def Shader \"{name}\" {{\n uniform token info:id = \"{id}\"\n{inputs}\n token outputs:out\n}}\n")
}

/// A material of a surface shader `S`, and others.
fn surface(id: &str, inputs: &str, others: &str) -> String {
    let output = "token outputs:mtlx:surface.connect = </M/S.outputs:out>\n";
    square(&format!("{output}{}{others}", shader("S", id, inputs)))
}

/// Pictures of one texel.
fn pictures() -> Vec<(&'static str, Vec<u8>)> {
    [("a.png", [200, 100, 50, 128]), ("b.png", [10, 20, 30, 255]), ("maps/c.png", [1, 2, 3, 4])]
        .map(|(name, texel)| (name, png(&[texel], 1)))
        .to_vec()
}

fn read(body: &str) -> Loaded {
    read_with(body, &[])
}

/// Reads a layer in a package with pictures and these texts.
fn read_with(body: &str, texts: &[(&str, &str)]) -> Loaded {
    let root = file("", body);
    let pictures = pictures();
    let mut parts: Vec<(&str, &[u8])> = vec![("a.usda", root.as_bytes())];
    parts.extend(pictures.iter().map(|(name, bytes)| (*name, bytes.as_slice())));
    parts.extend(texts.iter().map(|(name, text)| (*name, text.as_bytes())));
    load(&zip(&parts, false), Format::Usd).unwrap()
}

/// The texel of a texture of the only material.
fn texel(loaded: &Loaded, texture: Option<overcoat_scene::TextureRef>) -> ([u8; 4], ColorSpace) {
    let texture = &loaded.scene.textures()[texture.unwrap().texture.index()];
    (texture.image().texels()[0], texture.color_space())
}

#[test]
fn four_shaders_are_read() {
    for (id, inputs, model) in [
        (
            "ND_open_pbr_surface_surfaceshader",
            "color3f inputs:base_color = (0.25, 0.5, 1)\n float inputs:base_metalness = 1\n float inputs:specular_roughness = 0.25\n \
             float inputs:coat_weight = 0.5\n float inputs:coat_roughness = 0.125",
            Some(ShadingModel::OpenPbr),
        ),
        (
            "ND_standard_surface_surfaceshader",
            "color3f inputs:base_color = (0.25, 0.5, 1)\n float inputs:base = 1\n float inputs:metalness = 1\n \
             float inputs:specular_roughness = 0.25\n float inputs:coat = 0.5\n float inputs:coat_roughness = 0.125",
            None,
        ),
        (
            "ND_gltf_pbr_surfaceshader",
            "color3f inputs:base_color = (0.25, 0.5, 1)\n float inputs:metallic = 1\n float inputs:roughness = 0.25\n \
             float inputs:clearcoat = 0.5\n float inputs:clearcoat_roughness = 0.125",
            None,
        ),
        (
            "ND_UsdPreviewSurface_surfaceshader",
            "color3f inputs:diffuseColor = (0.25, 0.5, 1)\n float inputs:metallic = 1\n float inputs:roughness = 0.25\n \
             float inputs:clearcoat = 0.5\n float inputs:clearcoatRoughness = 0.125",
            None,
        ),
    ] {
        let loaded = read(&surface(id, inputs, ""));
        assert_eq!(warnings(&loaded), [""; 0], "{id}");
        let material = &loaded.scene.materials()[0];
        assert_eq!(material.name, "M");
        assert_eq!(material.base_color, [0.25, 0.5, 1.0, 1.0], "{id}");
        let expected = Workflow::MetallicRoughness { metallic: 1.0, roughness: 0.25, texture: None };
        assert_eq!(material.workflow, expected, "{id}");
        assert_eq!((material.coat, material.coat_roughness, material.model), (0.5, 0.125, model), "{id}");
    }
}

#[test]
fn networks_reduce_to_factors_and_pictures() {
    let loaded = read(&surface(
        "ND_standard_surface_surfaceshader",
        "color3f inputs:base_color.connect = </M/G.outputs:color>\n float inputs:base = 0.5\n \
         float inputs:metalness.connect = </M/C.outputs:out>\n float inputs:specular_roughness.connect = </M/G.outputs:rough>\n \
         float3 inputs:normal.connect = </M/N.outputs:out>\n float inputs:coat.connect = </M.inputs:wet>",
        &format!(
            "float inputs:wet = 0.25\n color3f inputs:tint = (0.5, 1, 0.25)\n{}{}{}\
             def NodeGraph \"G\" {{\n color3f inputs:tint.connect = </M.inputs:tint>\n asset inputs:map = @a.png@ ( colorSpace = \"srgb_texture\" )\n\
             color3f outputs:color.connect = </M/G/X.outputs:out>\n float outputs:rough.connect = </M/G/R.outputs:out>\n{}{}{}}}\n",
            shader("C", "ND_constant_float", "float inputs:value = 0.75"),
            shader(
                "N",
                "ND_normalmap",
                "float3 inputs:in.connect = </M/P.outputs:out>\n float inputs:scale = 0.5"
            ),
            shader("P", "ND_image_vector3", "asset inputs:file = @b.png@"),
            shader(
                "X",
                "ND_multiply_color3",
                "color3f inputs:in1.connect = </M/G/I.outputs:out>\n color3f inputs:in2.connect = </M/G.inputs:tint>"
            ),
            shader(
                "I",
                "ND_image_color3",
                "asset inputs:file.connect = </M/G.inputs:map>\n string inputs:uaddressmode = \"clamp\""
            ),
            shader(
                "R",
                "ND_extract_color3",
                "color3f inputs:in.connect = </M/G/I.outputs:out>\n int inputs:index = 2"
            ),
        ),
    ));
    assert_eq!(warnings(&loaded), [""; 0]);
    let material = &loaded.scene.materials()[0];
    assert_eq!(material.base_color, [0.25, 0.5, 0.125, 1.0]);
    assert_eq!(texel(&loaded, material.base_color_texture), ([200, 100, 50, 128], ColorSpace::Srgb));
    let Workflow::MetallicRoughness { metallic: 0.75, roughness: 1.0, texture } = material.workflow else {
        panic!("{:?}", material.workflow)
    };
    // Blue of the picture in green, where roughness is read.
    assert_eq!(texel(&loaded, texture), ([255, 50, 255, 255], ColorSpace::Linear));
    let normal = material.normal_texture.unwrap();
    assert_eq!((normal.scale, texel(&loaded, Some(normal.texture)).0), (0.5, [10, 20, 30, 255]));
    assert_eq!(material.coat, 0.25);
}

#[test]
fn coordinates_are_placed_and_named() {
    let loaded = read(&surface(
        "ND_open_pbr_surface_surfaceshader",
        "color3f inputs:base_color.connect = </M/T.outputs:out>\n float inputs:coat_weight.connect = </M/I.outputs:out>",
        &format!(
            "{}{}{}{}",
            shader(
                "T",
                "ND_tiledimage_color3",
                "asset inputs:file = @a.png@\n float2 inputs:uvtiling = (3, 2)"
            ),
            shader(
                "I",
                "ND_image_float",
                "asset inputs:file = @b.png@\n float2 inputs:texcoord.connect = </M/P.outputs:out>"
            ),
            shader(
                "P",
                "ND_place2d_vector2",
                "float2 inputs:texcoord.connect = </M/U.outputs:out>\n float2 inputs:offset = (0.25, 0)"
            ),
            shader("U", "ND_geompropvalue_vector2", "string inputs:geomprop = \"lightmap\""),
        ),
    ));
    assert_eq!(warnings(&loaded), [""; 0]);
    let material = &loaded.scene.materials()[0];
    let base = material.base_color_texture.unwrap();
    assert_eq!((base.uv_set, base.transform.rows[0][0], base.transform.rows[1][1]), (0, 3.0, 2.0));
    let coat = material.coat_texture.unwrap();
    // A quarter to the left; whole tiles are nothing.
    assert_eq!((coat.uv_set, coat.transform.rows[0][2]), (1, 0.75));
}

#[test]
fn colours_of_meshes_are_read() {
    let colored = surface(
        "ND_standard_surface_surfaceshader",
        "color3f inputs:base_color.connect = </M/P.outputs:out>\n float inputs:base = 0.5",
        &shader("P", "ND_geompropvalue_color3", "string inputs:geomprop = \"tint\""),
    );
    let colors = "color3f[] primvars:tint = [(1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1)] ( interpolation = \"vertex\" )\n texCoord2f";
    let loaded = read(&colored.replacen("texCoord2f", colors, 1));
    assert_eq!(warnings(&loaded), [""; 0]);
    assert_eq!(loaded.scene.materials()[0].base_color, [0.5, 0.5, 0.5, 1.0]);
    assert_eq!(loaded.scene.meshes()[0].colors()[1], [0.0, 1.0, 0.0, 1.0]);
}

#[test]
fn spaces_of_pictures_are_followed() {
    let space = |space: &str| {
        let image = format!("asset inputs:file = @maps/c.png@ ( colorSpace = \"{space}\" )");
        read(&surface(
            "ND_open_pbr_surface_surfaceshader",
            "color3f inputs:base_color.connect = </M/I.outputs:out>",
            &shader("I", "ND_image_color3", &image),
        ))
    };
    for (name, expected) in
        [("raw", ColorSpace::Linear), ("lin_rec709", ColorSpace::Linear), ("srgb_texture", ColorSpace::Srgb)]
    {
        let loaded = space(name);
        let texture = loaded.scene.materials()[0].base_color_texture;
        assert_eq!((texel(&loaded, texture).1, warnings(&loaded)), (expected, vec![]), "{name}");
    }
    let strange = space("acescg");
    assert!(
        warnings(&strange)[0].contains("is read as sRGB; the document says acescg"),
        "{:?}",
        strange.warnings
    );
}

/// A material with both kinds of surfaces.
fn both(mtlx: &str, others: &str) -> String {
    with_material(
        "color3f inputs:diffuseColor = (1, 0, 0)",
        &format!("token outputs:mtlx:surface.connect = </M/X.outputs:out>\n{mtlx}{others}"),
    )
}

#[test]
fn materialx_wins_unless_it_is_not_read_whole() {
    let red = |loaded: &Loaded| loaded.scene.materials()[0].base_color == [1.0, 0.0, 0.0, 1.0];
    let open = "ND_open_pbr_surface_surfaceshader";
    let whole = read(&both(&shader("X", open, "color3f inputs:base_color = (0, 1, 0)"), ""));
    assert_eq!((red(&whole), warnings(&whole)), (false, vec![]));
    assert_eq!(whole.scene.materials()[0].base_color, [0.0, 1.0, 0.0, 1.0]);
    // A pattern decides what is seen; the preview surface has been made to look like it.
    let noise = both(
        &shader("X", open, "color3f inputs:base_color.connect = </M/N.outputs:out>"),
        &shader("N", "ND_noise3d_color3", ""),
    );
    let lost = read(&noise);
    assert!(red(&lost));
    assert_eq!(
        warnings(&lost),
        [
            "USD: material '/M' is drawn by its preview surface in place of MaterialX's: base_color: the node noise3d is not read, \
          the default takes its place"
        ]
    );
    let unknown = read(&both(&shader("X", "ND_surface", ""), ""));
    assert!(red(&unknown));
    assert_eq!(warnings(&unknown).len(), 1, "{:?}", unknown.warnings);
    // The same in MaterialX's words says no more.
    let same = read(&both(
        &shader("X", "ND_UsdPreviewSurface_surfaceshader", "color3f inputs:diffuseColor = (0, 1, 0)"),
        "",
    ));
    assert_eq!((red(&same), warnings(&same)), (true, vec![]));
    // Other renderers' surfaces are none of ours.
    let other = read(&both("", "").replace("outputs:mtlx:surface", "outputs:ri:surface"));
    assert_eq!((red(&other), warnings(&other)), (true, vec![]));
}

#[test]
fn without_a_preview_what_is_lost_is_named() {
    let loaded = read(&surface(
        "ND_standard_surface_surfaceshader",
        "color3f inputs:base_color.connect = </M/N.outputs:out>\n float inputs:metalness = 1\n float inputs:subsurface_anisotropy = 0.5\n \
         float inputs:subsurface = 0.5\n float inputs:coat.connect = </M/I.outputs:out>",
        &format!(
            "{}{}",
            shader("N", "ND_worleynoise2d_float", ""),
            shader("I", "ND_image_float", "asset inputs:file = @gone.png@")
        ),
    ));
    let Workflow::MetallicRoughness { metallic: 1.0, .. } = loaded.scene.materials()[0].workflow else {
        panic!("metal")
    };
    let found = warnings(&loaded).join("\n");
    for expected in [
        "USD: material '/M': base_color: the node worleynoise2d is not read",
        "USD: material '/M': subsurface_anisotropy: has no effect",
        "USD: texture 'gone.png' is left out",
    ] {
        assert!(found.contains(expected), "{found}");
    }
    let unknown = read(&surface("ND_surface_unlit", "", ""));
    let found = warnings(&unknown).join("\n");
    assert_eq!(found, "USD: material '/M' is not drawn: MaterialX's surface 'surface_unlit' is not read");
}

const DOCUMENT: &str = "<?xml version=\"1.0\"?><materialx version=\"1.39\" colorspace=\"lin_rec709\">\
     <image name=\"i\" type=\"color3\"><input name=\"file\" type=\"filename\" value=\"../maps/c.png\" colorspace=\"srgb_texture\"/></image>\
     <open_pbr_surface name=\"s\" type=\"surfaceshader\"><input name=\"base_color\" type=\"color3\" nodename=\"i\"/>\
     <input name=\"base_metalness\" type=\"float\" value=\"0.5\"/></open_pbr_surface>\
     <surfacematerial name=\"paint\" type=\"material\"><input name=\"surfaceshader\" type=\"surfaceshader\" nodename=\"s\"/></surfacematerial>\
     <surfacematerial name=\"empty\" type=\"material\"/></materialx>";

#[test]
fn documents_are_layers() {
    let bound = |to: &str| {
        SQUARE.replacen(
            '{',
            &format!("( prepend apiSchemas = [\"MaterialBindingAPI\"] ) {{\n rel material:binding = <{to}>"),
            1,
        )
    };
    let one = format!(
        "{}def Material \"Looks\" ( references = @sub/d.mtlx@</MaterialX/Materials/paint> ) {{}}\n",
        bound("/Looks")
    );
    let all = format!("{}def \"X\" ( references = @sub/d.mtlx@ ) {{}}\n", bound("/X/Materials/paint"));
    for body in [&one, &all] {
        let loaded = read_with(body, &[("sub/d.mtlx", DOCUMENT)]);
        assert_eq!(warnings(&loaded), [""; 0]);
        let material = &loaded.scene.materials()[0];
        assert_eq!(texel(&loaded, material.base_color_texture), ([1, 2, 3, 4], ColorSpace::Srgb));
        let Workflow::MetallicRoughness { metallic: 0.5, .. } = material.workflow else { panic!("{body}") };
    }
    let empty = read_with(&all.replace("Materials/paint", "Materials/empty"), &[("sub/d.mtlx", DOCUMENT)]);
    let found = warnings(&empty).join("\n");
    assert_eq!(found, "USD: material '/X/Materials/empty' is not drawn: MaterialX has no surface for it");
    let changed = all.replace(
        "@sub/d.mtlx@ ) {}",
        "@sub/d.mtlx@ ) { over \"Materials\" { over \"paint\" { float inputs:base_metalness = 1 } } }",
    );
    let changed = read_with(&changed, &[("sub/d.mtlx", DOCUMENT)]);
    assert!(
        warnings(&changed)[0].contains("what other layers say of it has no effect"),
        "{:?}",
        changed.warnings
    );
    // A name alone makes no document, and a damaged one is no layer.
    let forged = square("string info:mtlx:material = \"paint\"");
    assert!(warnings(&read(&forged))[0].contains("has no surface that is known"));
    let damaged = read_with(&one, &[("sub/d.mtlx", "<materialx><a></materialx>")]);
    assert!(
        warnings(&damaged)[0].starts_with("USD: layer 'sub/d.mtlx' is left out"),
        "{:?}",
        damaged.warnings
    );
}

#[test]
fn networks_with_changed_bits_are_read_or_refused() {
    let network = surface(
        "ND_open_pbr_surface_surfaceshader",
        "color3f inputs:base_color.connect = </M/I.outputs:out>",
        &shader("I", "ND_image_color3", "asset inputs:file = @a.png@ ( colorSpace = \"raw\" )"),
    );
    attack(file("", &network).as_bytes(), Format::Usd);
    let body = "def \"X\" ( references = @d.mtlx@ ) {}\n".to_owned() + &square("");
    let body = file("", &body.replace("</M>", "</X/Materials/paint>"));
    for k in (0..DOCUMENT.len()).step_by(3) {
        for text in [DOCUMENT.as_bytes()[..k].to_vec(), {
            let mut changed = DOCUMENT.as_bytes().to_vec();
            changed[k] ^= 1 << (k % 8);
            changed
        }] {
            let files = [("d.mtlx".to_owned(), text)].into();
            let loaded = load_beside(body.as_bytes(), Format::Usd, &MemoryResolver { files }, &limits());
            assert_eq!(loaded.unwrap().scene.triangle_count(), 2);
        }
    }
}

#[test]
fn networks_that_use_a_node_a_thousand_times_end() {
    // Each of thirty nodes multiplies the next with itself.
    let mut nodes = String::new();
    for k in 0..30 {
        let next = k + 1;
        let inputs = format!(
            "color3f inputs:in1.connect = </M/n{next}.outputs:out>\n color3f inputs:in2.connect = </M/n{next}.outputs:out>"
        );
        nodes += &shader(&format!("n{k}"), "ND_multiply_color3", &inputs);
    }
    nodes += &shader("n30", "ND_multiply_color3", "color3f inputs:in1.connect = </M/n0.outputs:out>");
    let inputs = "color3f inputs:base_color.connect = </M/n0.outputs:out>";
    let loaded = read(&surface("ND_open_pbr_surface_surfaceshader", inputs, &nodes));
    assert!(warnings(&loaded)[0].contains("go in a circle"), "{:?}", loaded.warnings);
    // More shaders than a network may have.
    let mut many = String::new();
    for k in 0..1500 {
        let next = k + 1;
        let inputs = format!("color3f inputs:in1.connect = </M/n{next}.outputs:out>");
        many += &shader(&format!("n{k}"), "ND_add_color3", &inputs);
    }
    let loaded = read(&surface("ND_open_pbr_surface_surfaceshader", inputs, &many));
    assert!(
        warnings(&loaded).iter().any(|w| w.contains("has more than 1024 shaders")),
        "{:?}",
        loaded.warnings
    );
}
