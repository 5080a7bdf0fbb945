//! Files of every format that names its textures one by one, with more of them than the limits allow.

use crate::hostile::{load_beside, warnings};
use crate::threemf::{png, zip};
use crate::{Format, Loaded, MemoryResolver};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use overcoat_core::limits::Limits;
use overcoat_scene::Texture;

/// Textures of each file, and texels along their sides.
const COUNT: u32 = 9;
const SIDE: u32 = 256;

/// A file for each number, one after the other.
fn each(part: impl Fn(u32) -> String) -> String {
    (0..COUNT).map(part).collect()
}

fn usd() -> Vec<u8> {
    let meshes = each(|k| {
        // The roughness of the last is made of two pictures.
        let rough = if k + 1 == COUNT { "float inputs:roughness.connect = </M8/T.outputs:g>" } else { "" };
        format!(
            "def Mesh \"G{k}\" (prepend apiSchemas = [\"MaterialBindingAPI\"]) {{\n rel material:binding = </M{k}>\n\
             uniform token subdivisionScheme = \"none\"\n int[] faceVertexCounts = [3]\n\
             int[] faceVertexIndices = [0, 1, 2]\n point3f[] points = [(0, 0, {k}), (1, 0, {k}), (0, 1, {k})]\n\
             texCoord2f[] primvars:st = [(0, 0), (1, 0), (0, 1)] (interpolation = \"vertex\")\n}}\n\
             def Material \"M{k}\" {{\n token outputs:surface.connect = </M{k}/S.outputs:surface>\n\
             def Shader \"S\" {{\n uniform token info:id = \"UsdPreviewSurface\"\n\
             color3f inputs:diffuseColor.connect = </M{k}/T.outputs:rgb>\n{rough}\n token outputs:surface\n }}\n\
             def Shader \"T\" {{\n uniform token info:id = \"UsdUVTexture\"\n asset inputs:file = @t{k}.png@\n }}\n}}\n"
        )
    });
    format!("#usda 1.0\n(\n metersPerUnit = 1\n)\n{meshes}").into_bytes()
}

fn fbx() -> Vec<u8> {
    let objects = each(|k| {
        let [geometry, model, material, texture] = [1, 2, 3, 4].map(|n| k * 10 + n);
        format!(
            "Geometry: {geometry}, \"Geometry::g\", \"Mesh\" {{\n Vertices: *9 {{\n a: 0,0,0,1,0,0,0,1,{k}\n }}\n\
             PolygonVertexIndex: *3 {{\n a: 0,1,-3\n }}\n}}\nModel: {model}, \"Model::m\", \"Mesh\" {{\n}}\n\
             Material: {material}, \"Material::m{k}\", \"\" {{\n}}\nTexture: {texture}, \"Texture::t\", \"\" {{\n\
             RelativeFilename: \"t{k}.png\"\n}}\n"
        )
    });
    let connections = each(|k| {
        let [geometry, model, material, texture] = [1, 2, 3, 4].map(|n| k * 10 + n);
        format!(
            "C: \"OO\",{geometry},{model}\nC: \"OO\",{material},{model}\nC: \"OO\",{model},0\n\
             C: \"OP\",{texture},{material}, \"DiffuseColor\"\n"
        )
    });
    format!(
        "; FBX 7.4.0 project file\nFBXHeaderExtension:  {{\n FBXVersion: 7400\n}}\nObjects:  {{\n{objects}}}\n\
         Connections:  {{\n{connections}}}\n"
    )
    .into_bytes()
}

fn vrml() -> Vec<u8> {
    let shapes = each(|k| {
        format!(
            "Shape {{ appearance Appearance {{ texture ImageTexture {{ url \"t{k}.png\" }} }} geometry IndexedFaceSet {{ \
             coord Coordinate {{ point [ 0 0 {k} 4 0 {k} 4 2 {k} ] }} coordIndex [ 0 1 2 ] }} }}\n"
        )
    });
    format!("#VRML V2.0 utf8\n{shapes}").into_bytes()
}

fn ply() -> Vec<u8> {
    let comments = each(|k| format!("comment TextureFile t{k}.png\n"));
    let faces = each(|k| format!("3 0 1 2 6 0 0 1 0 0 1 {k}\n"));
    format!(
        "ply\nformat ascii 1.0\n{comments}element vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
         element face {COUNT}\nproperty list uchar int vertex_indices\nproperty list uchar float texcoord\n\
         property int texnumber\nend_header\n0 0 0\n1 0 0\n0 1 0\n{faces}"
    )
    .into_bytes()
}

fn collada() -> Vec<u8> {
    let images = each(|k| format!("<image id='i{k}'><init_from>t{k}.png</init_from></image>"));
    let effects = each(|k| {
        format!(
            "<effect id='e{k}'><profile_COMMON><technique sid='c'><lambert><diffuse><texture texture='i{k}'/></diffuse>\
             </lambert></technique></profile_COMMON></effect>"
        )
    });
    let materials = each(|k| format!("<material id='m{k}'><instance_effect url='#e{k}'/></material>"));
    let nodes = each(|k| {
        format!(
            "<node><instance_geometry url='#g'><bind_material><technique_common><instance_material symbol='m' \
             target='#m{k}'/></technique_common></bind_material></instance_geometry></node>"
        )
    });
    format!(
        "<?xml version='1.0'?>\n<COLLADA xmlns='http://www.collada.org/2005/11/COLLADASchema' version='1.4.1'>\
         <library_images>{images}</library_images><library_effects>{effects}</library_effects>\
         <library_materials>{materials}</library_materials><library_geometries><geometry id='g'><mesh>\
         <source id='p'><float_array id='pa' count='9'>0 0 0 2 0 0 2 2 0</float_array><technique_common>\
         <accessor source='#pa' count='3' stride='3'/></technique_common></source>\
         <vertices id='v'><input semantic='POSITION' source='#p'/></vertices><triangles material='m' count='1'>\
         <input semantic='VERTEX' source='#v' offset='0'/><p>0 1 2</p></triangles></mesh></geometry></library_geometries>\
         <library_visual_scenes><visual_scene id='s'>{nodes}</visual_scene></library_visual_scenes>\
         <scene><instance_visual_scene url='#s'/></scene></COLLADA>\n"
    )
    .into_bytes()
}

fn three_ds() -> Vec<u8> {
    let chunk = |kind: u16, parts: &[&[u8]]| {
        let content = parts.concat();
        [&kind.to_le_bytes()[..], &(content.len() as u32 + 6).to_le_bytes(), &content].concat()
    };
    let mut all = Vec::new();
    for k in 0..COUNT {
        let (name, file) = (format!("m{k}\0"), format!("t{k}.png\0"));
        let texture = chunk(0xA200, &[&chunk(0xA300, &[file.as_bytes()])]);
        all.extend(chunk(0xAFFF, &[&chunk(0xA000, &[name.as_bytes()]), &texture]));
    }
    for k in 0..COUNT {
        let name = format!("m{k}\0");
        let corners: Vec<u8> = [0.0_f32, 0.0, k as f32, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]
            .into_iter()
            .flat_map(f32::to_le_bytes)
            .collect();
        let vertices = chunk(0x4110, &[&[3, 0], &corners]);
        let of_material = chunk(0x4130, &[name.as_bytes(), &[1, 0, 0, 0]]);
        let faces = chunk(0x4120, &[&[1, 0, 0, 0, 1, 0, 2, 0, 0, 0], &of_material]);
        all.extend(chunk(0x4000, &[name.as_bytes(), &chunk(0x4100, &[&vertices, &faces])]));
    }
    chunk(0x4D4D, &[&chunk(0x3D3D, &[&all])])
}

fn amf() -> Vec<u8> {
    let values = STANDARD.encode(vec![99; (SIDE * SIDE) as usize]);
    let textures = each(|k| {
        let id = k + 1;
        format!("<texture id=\"{id}\" width=\"{SIDE}\" height=\"{SIDE}\">{values}</texture>")
    });
    let triangles = each(|k| {
        let id = k + 1;
        format!(
            "<triangle><v1>0</v1><v2>1</v2><v3>2</v3><texmap rtexid=\"{id}\" gtexid=\"{id}\" btexid=\"{id}\">\
             <utex1>0</utex1><utex2>1</utex2><utex3>0</utex3><vtex1>0</vtex1><vtex2>0</vtex2><vtex3>1</vtex3></texmap>\
             </triangle>"
        )
    });
    let vertices: String = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
        .iter()
        .map(|[x, y, z]| {
            format!("<vertex><coordinates><x>{x}</x><y>{y}</y><z>{z}</z></coordinates></vertex>")
        })
        .collect();
    format!(
        "<?xml version=\"1.0\"?>\n<amf unit=\"meter\">{textures}<object id=\"0\"><mesh><vertices>{vertices}</vertices>\
         <volume>{triangles}</volume></mesh></object></amf>\n"
    )
    .into_bytes()
}

fn three_mf() -> Vec<u8> {
    let resources = each(|k| {
        let [texture, group, object] = [1, 2, 3].map(|n| k * 10 + n);
        format!(
            "<m:texture2d id=\"{texture}\" path=\"/3D/Textures/t{k}.png\" contenttype=\"image/png\"/>\
             <m:texture2dgroup id=\"{group}\" texid=\"{texture}\"><m:tex2coord u=\"0\" v=\"0\"/></m:texture2dgroup>\
             <object id=\"{object}\" pid=\"{group}\" pindex=\"0\"><mesh><vertices><vertex x=\"0\" y=\"0\" z=\"{k}\"/>\
             <vertex x=\"9\" y=\"0\" z=\"{k}\"/><vertex x=\"0\" y=\"9\" z=\"{k}\"/></vertices><triangles>\
             <triangle v1=\"0\" v2=\"1\" v3=\"2\"/></triangles></mesh></object>"
        )
    });
    let items = each(|k| format!("<item objectid=\"{}\"/>", k * 10 + 3));
    let model = format!(
        "<?xml version=\"1.0\"?>\n<model unit=\"millimeter\" \
         xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\" \
         xmlns:m=\"http://schemas.microsoft.com/3dmanufacturing/material/2015/02\"><resources>{resources}</resources>\
         <build>{items}</build></model>"
    );
    let relations = "<?xml version=\"1.0\"?><Relationships \
        xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\"><Relationship Target=\"/3D/a.model\" Id=\"r\" \
        Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/></Relationships>";
    let picture = picture(SIDE);
    let names: Vec<String> = (0..COUNT).map(|k| format!("3D/Textures/t{k}.png")).collect();
    let mut parts = vec![("_rels/.rels", relations.as_bytes()), ("3D/a.model", model.as_bytes())];
    parts.extend(names.iter().map(|name| (name.as_str(), picture.as_slice())));
    zip(&parts, false)
}

fn obj() -> Vec<u8> {
    let faces = each(|k| format!("usemtl m{k}\nf 1 2 3\n"));
    format!("mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n{faces}").into_bytes()
}

fn gltf() -> Vec<u8> {
    let list = |part: fn(u32) -> String| (0..COUNT).map(part).collect::<Vec<_>>().join(",");
    let buffer =
        STANDARD.encode([0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].map(f32::to_le_bytes).concat());
    format!(
        "{{\"asset\":{{\"version\":\"2.0\"}},\"scene\":0,\"scenes\":[{{\"nodes\":[0]}}],\"nodes\":[{{\"mesh\":0}}],\
         \"meshes\":[{{\"primitives\":[{}]}}],\"accessors\":[{{\"bufferView\":0,\"componentType\":5126,\"count\":3,\
         \"type\":\"VEC3\",\"min\":[0,0,0],\"max\":[1,1,0]}}],\"bufferViews\":[{{\"buffer\":0,\"byteLength\":36}}],\
         \"buffers\":[{{\"byteLength\":36,\"uri\":\"data:application/octet-stream;base64,{buffer}\"}}],\
         \"materials\":[{}],\"textures\":[{}],\"images\":[{}]}}",
        list(|k| format!("{{\"attributes\":{{\"POSITION\":0}},\"material\":{k}}}")),
        list(|k| format!("{{\"pbrMetallicRoughness\":{{\"baseColorTexture\":{{\"index\":{k}}}}}}}")),
        list(|k| format!("{{\"source\":{k}}}")),
        list(|k| format!("{{\"uri\":\"t{k}.png\"}}")),
    )
    .into_bytes()
}

fn picture(side: u32) -> Vec<u8> {
    png(&vec![[200, 100, 50, 255]; (side * side) as usize], side)
}

/// The formats, and a file of each.
fn files() -> [(Format, Vec<u8>); 10] {
    [
        (Format::Usd, usd()),
        (Format::Fbx, fbx()),
        (Format::Vrml, vrml()),
        (Format::Ply, ply()),
        (Format::Collada, collada()),
        (Format::ThreeDs, three_ds()),
        (Format::Amf, amf()),
        (Format::ThreeMf, three_mf()),
        (Format::Obj, obj()),
        (Format::Gltf, gltf()),
    ]
}

fn load((format, bytes): &(Format, Vec<u8>), limits: &Limits, side: impl Fn(u32) -> u32) -> Loaded {
    let mut beside = MemoryResolver::default();
    for k in 0..COUNT {
        beside.files.insert(format!("t{k}.png"), picture(side(k)));
    }
    let library = each(|k| format!("newmtl m{k}\nmap_Kd t{k}.png\n"));
    beside.files.insert("a.mtl".to_owned(), library.into_bytes());
    load_beside(bytes, *format, &beside, limits).unwrap()
}

/// The warnings about textures.
fn said(loaded: &Loaded) -> Vec<&str> {
    warnings(loaded)
        .into_iter()
        .filter(|message| message.contains("texels") || message.contains("left out"))
        .collect()
}

fn sides(loaded: &Loaded) -> Vec<u32> {
    loaded.scene.textures().iter().map(Texture::width).collect()
}

#[test]
fn equal_textures_are_kept_equally_in_every_format() {
    for file in &files() {
        let format = file.0;
        let all = load(file, &Limits::default(), |_| SIDE);
        let count = all.scene.textures().len();
        assert!(count >= COUNT as usize, "{format:?}: {count}");
        assert_eq!((sides(&all), said(&all)), (vec![SIDE; count], vec![]), "{format:?}");
        // Eight would fit.
        let few = Limits::default().with_total_texture_pixels((SIDE * SIDE * 8).into());
        let half = load(file, &few, |_| SIDE);
        assert_eq!(sides(&half), vec![SIDE / 2; count], "{format:?}");
        let [message] = said(&half)[..] else { panic!("{format:?}: {:?}", half.warnings) };
        assert!(message.contains(" of 256 x 256 texels is drawn from 128 x 128, and 8 more"), "{message}");
        // Limits of bytes are shared alike; geometry and texts are counted before textures.
        let bytes =
            Limits::default().with_decoded_bytes(if matches!(format, Format::Amf | Format::ThreeMf) {
                5 << 20
            } else {
                3 << 20
            });
        let reduced = load(file, &bytes, |_| SIDE);
        let side = sides(&reduced)[0];
        assert!(side < SIDE && side > SIDE / 8, "{format:?}: {side}");
        assert_eq!(sides(&reduced), vec![side; count], "{format:?}");
    }
}

#[test]
fn small_textures_stay_beside_large_ones() {
    for file in files().iter().filter(|file| !matches!(file.0, Format::ThreeMf | Format::Amf)) {
        let size = |k| if k % 2 == 0 { 64 } else { SIDE };
        let few = Limits::default().with_total_texture_pixels((SIDE * SIDE * 2).into());
        let loaded = load(file, &few, size);
        let expected: Vec<u32> = (0..COUNT).map(|k| size(k).min(SIDE / 2)).collect();
        assert_eq!(sides(&loaded)[..COUNT as usize], expected, "{:?}", file.0);
    }
}

/// One picture that is larger than any may be is drawn from a level that is not, or left out; the model is drawn.
#[test]
fn a_texture_beyond_the_limit_of_one_does_not_refuse_the_file() {
    for file in &files() {
        let format = file.0;
        let limits = Limits::default().with_texture_pixels((SIDE * SIDE / 2).into());
        let loaded = load(file, &limits, |_| SIDE);
        assert_eq!(loaded.scene.textures()[0].width(), SIDE / 2, "{format:?}");
        assert!(said(&loaded)[0].contains("is drawn from 128 x 128"), "{:?}", loaded.warnings);
        let texel = loaded.scene.textures()[0].image().texels()[0];
        assert_eq!(texel[3], 255, "{format:?}: {texel:?}");
        // Eight times as many texels are read, and no more.
        if format == Format::Amf {
            continue;
        }
        let limits = Limits::default().with_texture_pixels((SIDE * SIDE / 9).into());
        let loaded = load(file, &limits, |_| SIDE);
        assert!(loaded.scene.textures().is_empty(), "{format:?}");
        assert_eq!(loaded.scene.triangle_count(), u64::from(COUNT), "{format:?}");
        let message = said(&loaded)[0];
        assert!(message.contains("texture_pixels"), "{format:?}: {message}");
    }
}
