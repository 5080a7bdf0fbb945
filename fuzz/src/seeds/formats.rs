//! Seeds of the target `formats`: an extension on a line, and a file of that format.

/// Texts.
const TEXTS: [(&str, &str); 12] = [
    (
        "off",
        "off\nSTCNOFF\n4 2 0 # counts\n0 0 0 0 0 1 255 0 0 255\n1 0 0 0 0 1 0 255 0\n1 1 0 0 0 1 0 0 1.0\n0 1 0 0 0 1 0.5 1 1\n4 0 1 2 3\n3 0 1 2 255 0 0\n",
    ),
    (
        "pcd",
        "pcd\n# .PCD v0.7\nVERSION 0.7\nFIELDS x y z rgb normal_x normal_y normal_z label\nSIZE 4 4 4 4 4 4 4 2\nTYPE F F F F F F F U\nCOUNT 1 1 1 1 1 1 1 1\nWIDTH 2\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\nDATA ascii\n0 0 0 4.2108e+06 0 0 1 3\nnan nan nan 0 0 0 1 4\n",
    ),
    ("xyz", "xyz\n//X Y Z R G B Nx Ny Nz\n0 0 0 255 0 0 0 0 1\n1;0;0;255;0;0;0;0;1\n1,5 1 1 9 9 9 0 0 1\n"),
    (
        "ptx",
        "ptx\n2\n1\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n5 0 0 1\n0 0 0 0.5\n1 2 3 0.25 255 0 0\n",
    ),
    (
        "dae",
        "dae\n<?xml version='1.0'?><COLLADA><asset><unit meter='0.1'/><up_axis>Z_UP</up_axis></asset><library_effects><effect id='e'><profile_COMMON><technique><phong><diffuse><color>1 0 0 1</color></diffuse><transparency><float>0.5</float></transparency></phong></technique></profile_COMMON></effect></library_effects><library_materials><material id='m'><instance_effect url='#e'/></material></library_materials><library_geometries><geometry id='g'><mesh><source id='p'><float_array>0 0 0 1 0 0 1 1 0 0 1 0</float_array><technique_common><accessor stride='3'/></technique_common></source><vertices id='v'><input semantic='POSITION' source='#p'/></vertices><polylist material='s'><input semantic='VERTEX' source='#v' offset='0'/><vcount>4</vcount><p>0 1 2 3</p></polylist></mesh></geometry></library_geometries><library_visual_scenes><visual_scene id='s'><node id='n'><rotate>0 0 1 90</rotate><instance_geometry url='#g'><bind_material><technique_common><instance_material symbol='s' target='#m'/></technique_common></bind_material></instance_geometry></node><node><instance_node url='#n'/></node></visual_scene></library_visual_scenes></COLLADA>",
    ),
    (
        "fbx",
        "fbx\n; FBX 7.4.0 project file\nFBXHeaderExtension: {\n FBXVersion: 7400\n}\nGlobalSettings: {\n Properties70: {\n P: \"UpAxis\", \"int\", \"Integer\", \"\",2\n }\n}\nObjects: {\n Geometry: 1, \"Geometry::\", \"Mesh\" {\n Vertices: *12 {\n a: 0,0,0,1,0,0,1,1,0,0,1,0\n }\n PolygonVertexIndex: *4 {\n a: 0,1,2,-4\n }\n LayerElementUV: 0 {\n MappingInformationType: \"ByPolygonVertex\"\n ReferenceInformationType: \"IndexToDirect\"\n UV: *4 {\n a: 0,0,1,1\n }\n UVIndex: *4 {\n a: 0,1,0,1\n }\n }\n }\n Model: 2, \"Model::m\", \"Mesh\" {\n Properties70: {\n P: \"Lcl Rotation\", \"Lcl Rotation\", \"\", \"A\",90,0,5\n P: \"InheritType\", \"enum\", \"\", \"\",2\n }\n }\n Material: 3, \"Material::a\", \"\" {\n Properties70: {\n P: \"DiffuseColor\", \"Color\", \"\", \"A\",1,0,0.5\n P: \"TransparencyFactor\", \"Number\", \"\", \"A\",0.5\n }\n }\n Deformer: 4, \"Deformer::\", \"Skin\" {\n }\n Deformer: 5, \"SubDeformer::\", \"Cluster\" {\n Indexes: *1 {\n a: 0\n }\n Weights: *1 {\n a: 1\n }\n Transform: *16 {\n a: 1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1\n }\n }\n}\nConnections: {\n C: \"OO\",2,0\n C: \"OO\",1,2\n C: \"OO\",3,2\n C: \"OO\",4,1\n C: \"OO\",5,4\n C: \"OO\",2,5\n}\n",
    ),
    (
        "usda",
        "usda\n#usda 1.0\n( defaultPrim = \"a\" metersPerUnit = 1 upAxis = \"Z\" subLayers = [ @b.usda@ ] )\nclass \"c\" { token purpose = \"render\" }\ndef Mesh \"m\" ( inherits = </c> references = @b.usda@</a> variants = { string v = \"x\" } ) {\nint[] faceVertexCounts = [4]\nint[] faceVertexIndices = [0, 1, 2, 3]\npoint3f[] points.timeSamples = { 0: [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], }\ntexCoord2f[] primvars:st = [(0, 0), (1, 1)] ( interpolation = \"faceVarying\" )\nint[] primvars:st:indices = [0, 1, 0, 1]\ndouble3 xformOp:rotateXYZ = (0, 90, 0)\nquatf xformOp:orient = (1, 0, 0, 0)\nuniform token[] xformOpOrder = [\"xformOp:rotateXYZ\", \"!invert!xformOp:orient\"]\nrel material:binding = </n>\nvariantSet \"v\" = { \"x\" { def GeomSubset \"s\" { int[] indices = [0] rel material:binding = </n> } } }\n}\ndef Material \"n\" { token outputs:surface.connect = </n/s.outputs:surface>\ndef Shader \"s\" { uniform token info:id = \"UsdPreviewSurface\" float inputs:roughness.connect = </n/t.outputs:g> }\ndef Shader \"t\" { uniform token info:id = \"UsdUVTexture\" asset inputs:file = @t.png@ } }\ndef PointInstancer \"p\" { rel prototypes = [ </m>, </k> ] int[] protoIndices = [0, 1] point3f[] positions = [(0, 0, 0), (1, 0, 0)] }\ndef Capsule \"k\" { double radius = 2 }\n",
    ),
    (
        "amf",
        "amf\n<?xml version='1.0'?><amf unit='inch'><material id='2'><metadata type='Name'>tin</metadata><color><r>1</r><g>0</g><b>0.5</b><a>0.5</a></color></material><object id='1'><color><r>0</r><g>1</g><b>0</b></color><mesh><vertices><vertex><coordinates><x>0</x><y>0</y><z>0</z></coordinates></vertex><vertex><coordinates><x>1</x><y>0</y><z>0</z></coordinates><color><r>1</r><g>1</g><b>0</b></color></vertex><vertex><coordinates><x>0</x><y>1</y><z>2</z></coordinates></vertex></vertices><volume materialid='2'><triangle><v1>0</v1><v2>1</v2><v3>2</v3></triangle><triangle><color><r>0</r><g>0</g><b>1</b></color><v1>2</v1><v2>1</v2><v3>0</v3></triangle></volume></mesh></object><constellation id='3'><instance objectid='1'><deltax>1</deltax><rz>90</rz></instance></constellation><constellation id='4'><instance objectid='3'><ry>30</ry></instance></constellation></amf>",
    ),
    (
        "sog",
        "sog\n{\"version\":2,\"count\":1,\"means\":{\"mins\":[0,0,0],\"maxs\":[1,1,1],\"files\":[\"a.webp\",\"b.webp\"]},\"scales\":{\"codebook\":[0],\"files\":[\"c.webp\"]},\"quats\":{\"files\":[\"d.webp\"]},\"sh0\":{\"codebook\":[0],\"files\":[\"e.webp\"]}}",
    ),
    (
        "wrl",
        "wrl\n#VRML V2.0 utf8\nPROTO P [ field SFVec3f s 1 1 1 field MFNode n [ ] eventIn SFBool e ] { Group { children [ Shape { geometry Box { size IS s } } Group { children IS n } ] } }\nP { s 2 2 2 n [ P { } ] }\nDEF A Transform { rotation 0 1 0 1 scale 1 2 3 center 1 0 0 children [ Shape { appearance Appearance { material Material { transparency 0.5 shininess 0.1 specularColor 1 1 1 } texture PixelTexture { image 2 1 4 0xff000080 255 } textureTransform TextureTransform { scale 2 2 } } geometry IndexedFaceSet { convex FALSE ccw FALSE creaseAngle 1 colorPerVertex FALSE coord DEF C Coordinate { point [ 0 0 0, 1 0 0, 1 1 0, 0 1 0 ] } color Color { color [ 1 0 0 ] } colorIndex [ 0 ] texCoord TextureCoordinate { point [ 0 0 1 1 ] } texCoordIndex [ 0 1 0 1 ] coordIndex [ 0 1 2 3 -1 ] } } ] }\nTransform { translation 3 0 0 children USE A }\nSwitch { whichChoice 0 choice Shape { geometry Sphere { radius 2 } } }\nLOD { level [ Shape { geometry Cone { } } ] }\nShape { geometry Extrusion { spine [ 0 0 0 0 1 0 1 2 0 ] scale [ 1 1 2 2 ] orientation [ 0 1 0 1 ] } }\nShape { geometry ElevationGrid { xDimension 2 zDimension 2 height [ 0 1 2 3 ] } }\nShape { geometry IndexedLineSet { coord USE C coordIndex [ 0 1 2 -1 ] } }\nShape { geometry PointSet { coord USE C } }\nInline { url \"a.wrl\" }\n",
    ),
    (
        "vrml1",
        "wrl\n#VRML V1.0 ascii\nSeparator { Info { string \"a\" } DEF M Material { diffuseColor [ 1 0 0, 0 1 0 ] emissiveColor [ ] transparency 0.5 } MaterialBinding { value PER_FACE_INDEXED } NormalBinding { value PER_VERTEX } ShapeHints { vertexOrdering CLOCKWISE shapeType SOLID faceType UNKNOWN_FACE_TYPE creaseAngle 1 } Coordinate3 { point [ 0 0 0, 1 0 0, 1 1 0, 0 1 0 ] } Normal { vector [ 0 0 1 ] } Texture2 { image 2 1 4 0xff000080 255 wrapS CLAMP } Texture2Transform { rotation 1 scaleFactor 2 2 center 1 1 } TextureCoordinate2 { point [ 0 0, 1 1 ] } Separator { MatrixTransform { matrix 1 0 0 0 0 1 0 0 0 0 1 0 3 0 0 1 } IndexedFaceSet { coordIndex [ 0 1 2 3 -1 0 1 2 -1 ] materialIndex [ 1 0 ] textureCoordIndex [ 0 1 0 1 -1 0 1 0 ] } }\nTransformSeparator { Rotation { rotation 0 0 1 1 } Scale { scaleFactor 1 2 3 } DEF C Cylinder { parts (SIDES | TOP) } }\nMaterialBinding { value PER_PART } USE C Cube { width 3 } Cone { parts BOTTOM } Sphere { } IndexedLineSet { coordIndex [ 0 1 2 -1 ] } PointSet { startIndex 1 numPoints 2 }\nSwitch { whichChild 0 USE M } LOD { range [ 1 ] Group { Translation { translation 1 2 3 } USE C } } WWWInline { name \"a.wrl\" } AsciiText { string \"a\" } }\n",
    ),
    (
        "protos",
        "x3d\n<X3D><Scene><ExternProtoDeclare name='E' url='\"a.x3d#E\"'/><ProtoDeclare name='P'><ProtoInterface><field name='s' value='1 1 1'/><field name='n'><Shape><Cone/></Shape></field></ProtoInterface><ProtoBody><Group><Shape><Box><IS><connect nodeField='size' protoField='s'/></IS></Box></Shape><Group><IS><connect nodeField='children' protoField='n'/></IS></Group></Group></ProtoBody></ProtoDeclare><ProtoInstance name='P' DEF='D'><fieldValue name='s' value='2 2 2'/></ProtoInstance><ProtoInstance USE='D'/><ProtoInstance name='P'><fieldValue name='n'><ProtoInstance name='P'/></fieldValue></ProtoInstance><ProtoInstance name='E'/></Scene></X3D>",
    ),
    (
        "x3d",
        "x3d\n<?xml version='1.0'?><!DOCTYPE X3D><X3D><Scene><Group DEF='G'><Shape><Appearance><PhysicalMaterial baseColor='1 0 0' metallic='0'/></Appearance><IndexedTriangleStripSet index='0 1 2 3 -1'><Coordinate point='0 0 0 1 0 0 0 1 0 1 1 0'/><ColorRGBA color='1 0 0 1 0 1 0 1 0 0 1 1 1 1 1 0.5'/></IndexedTriangleStripSet></Shape></Group><Transform translation='2 0 0'><Group USE='G'/></Transform><Shape><TriangleFanSet fanCount='4'><Coordinate point='0 0 0 1 0 0 0 1 0 1 1 0'/></TriangleFanSet></Shape><Shape><Box size='1 2 3'/></Shape><Shape><LineSet vertexCount='2'><Coordinate point='0 0 0 1 0 0'/></LineSet></Shape></Scene></X3D>",
    ),
    ("ksplat", "ksplat\n\0\u{1}\0\0\u{1}\0\0\0"),
];

/// All of them.
pub fn all() -> Vec<(&'static str, Vec<u8>)> {
    let mut seeds: Vec<_> = TEXTS.iter().map(|&(name, text)| (name, text.as_bytes().to_vec())).collect();
    let floats = |values: &[f32]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<_>>();
    let splat = [floats(&[0.0, 1.0, 2.0, 0.5, 0.25, 1.0]), vec![255, 0, 9, 200, 255, 128, 128, 128]].concat();
    seeds.push(("splat", [b"splat\n", &splat[..], &splat].concat()));
    let mut spz = b"spz\nNGSP\x03\0\0\0\x01\0\0\0\x01\x0c\0\0".to_vec();
    spz.extend([1; 29]);
    seeds.push(("spz", spz));
    let mut las = vec![0; 227 + 26];
    las[..4].copy_from_slice(b"LASF");
    las[24..26].copy_from_slice(&[1, 2]);
    las[94..100].copy_from_slice(&[227, 0, 227, 0, 0, 0]);
    las[104..111].copy_from_slice(&[2, 26, 0, 1, 0, 0, 0]);
    for place in [131, 139, 147] {
        las[place..place + 8].copy_from_slice(&0.01_f64.to_le_bytes());
    }
    las[227..].fill(7);
    let three_ds =
        b"MM\x4c\0\0\0\x3d\x3d\x46\0\0\0\0\x40\x40\0\0\0a\0\0\x41\x38\0\0\0\x10\x41\x20\0\0\0\x02\0";
    seeds.push((
        "3ds",
        [b"3ds\n", &three_ds[..], &[1; 24], b"\x20\x41\x12\0\0\0\x01\0\0\0\x01\0\0\0\0\0\0\0"].concat(),
    ));
    let mut vox =
        b"vox\nVOX \x96\0\0\0MAIN\0\0\0\0\x38\0\0\0SIZE\x0c\0\0\0\0\0\0\0\x02\0\0\0\x02\0\0\0\x02\0\0\0"
            .to_vec();
    vox.extend(b"XYZI\x0c\0\0\0\0\0\0\0\x02\0\0\0\0\0\0\x01\x01\x01\x01\xd8");
    seeds.push(("vox", vox));
    seeds.push(("e57", [b"e57\n".to_vec(), e57()].concat()));
    let words = |list: &[u32]| list.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<_>>();
    let text = b"{\"POINTS_LENGTH\":1,\"POSITION\":{\"byteOffset\":0},\"RGB\":{\"byteOffset\":12},\"RTC_CENTER\":[0,6378137,0]}";
    let points =
        [&b"pnts"[..], &words(&[1, 43 + text.len() as u32, text.len() as u32, 15, 0, 0]), text, &[1; 15]];
    let points = points.concat();
    let text = b"{\"INSTANCES_LENGTH\":1,\"POSITION\":{\"byteOffset\":0},\"EAST_NORTH_UP\":true}";
    let model = b"{\"asset\":{\"version\":\"2.0\"}}";
    let length = (32 + text.len() + 12 + model.len()) as u32;
    let head = words(&[1, length, text.len() as u32, 12, 0, 0, 1]);
    let instances = [&b"i3dm"[..], &head, text, &[0; 12], model].concat();
    let length = (16 + points.len() + instances.len()) as u32;
    seeds.push(("cmpt", [b"cmpt\ncmpt", &words(&[1, length, 2])[..], &points, &instances].concat()));
    seeds.push((
        "b3dm",
        [b"b3dm\nb3dm", &words(&[1, 28 + model.len() as u32, 0, 0, 0, 0])[..], model].concat(),
    ));
    seeds.push(("drc", [b"drc\n".to_vec(), super::models::draco_stream(1)].concat()));
    seeds.push(("fbx-binary", [b"fbx\n".to_vec(), fbx()].concat()));
    seeds.push(("las", [b"las\n", &las[..]].concat()));
    seeds.push(("laz", [b"laz\n".to_vec(), laz(&las)].concat()));
    seeds
}

/// A scan of three points in one page, whose checksum is wrong.
fn e57() -> Vec<u8> {
    let xml = "<?xml version='1.0'?><e57Root xmlns:nor='n'><data3D><vectorChild><pose><rotation><w>1</w><z>1</z></rotation><translation><x>5</x></translation></pose><points type='CompressedVector' fileOffset='48' recordCount='3'><prototype><cartesianX type='ScaledInteger' minimum='-9' maximum='9' scale='0.1'/><cartesianY type='Float' precision='single'/><cartesianZ type='Integer' minimum='0' maximum='0'/><colorRed type='Integer' minimum='0' maximum='255'/><colorGreen type='Integer' minimum='0' maximum='255'/><colorBlue type='Integer' minimum='0' maximum='255'/><cartesianInvalidState type='Integer' minimum='0' maximum='2'/></prototype></points></vectorChild></data3D><images2D><vectorChild/></images2D></e57Root>";
    let sizes: [u16; 7] = [2, 12, 0, 3, 3, 3, 1];
    let content: u16 = sizes.iter().sum();
    let length = (6 + 14 + content).next_multiple_of(4);
    let mut packet = vec![1, 0];
    packet.extend([length - 1, 7].iter().chain(&sizes).flat_map(|v| v.to_le_bytes()));
    packet.resize(length.into(), 5);
    let longs = |list: &[u64]| list.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<_>>();
    let section = [vec![1, 0, 0, 0, 0, 0, 0, 0], longs(&[32 + u64::from(length), 80, 0]), packet].concat();
    let place = 48 + section.len() as u64;
    let mut file = b"ASTM-E57\x01\0\0\0\0\0\0\0".to_vec();
    file.extend(longs(&[4096, place, xml.len() as u64, 4096]));
    [file, section, xml.as_bytes().to_vec()].concat()
}

/// Points of format 0 inside LASzip's compression: the first as it is, and bits that stand for more.
fn laz(las: &[u8]) -> Vec<u8> {
    let mut head = las[..227].to_vec();
    head[96..108].copy_from_slice(&[59, 1, 0, 0, 1, 0, 0, 0, 0x80, 20, 0, 9]);
    let mut record = vec![0; 54];
    record[2..16].copy_from_slice(b"laszip encoded");
    record[18..22].copy_from_slice(&[0xbc, 0x56, 34, 0]);
    let mut description = vec![2, 0, 0, 0, 2, 2, 0, 0, 0, 0, 0, 0, 4, 0, 0, 0];
    description.extend([[0xff; 8], [0xff; 8]].concat());
    description.extend([1, 0, 6, 0, 20, 0, 2, 0]);
    record[20] = description.len() as u8;
    head[96] = (227 + 54 + description.len() - 256) as u8;
    [head, record, description, vec![0; 8], vec![7; 20], (0..64_u8).map(|k| k.wrapping_mul(37)).collect()]
        .concat()
}

/// A square in the binary encoding.
fn fbx() -> Vec<u8> {
    let mut out = b"Kaydara FBX Binary  \0\x1a\0\xe8\x1c\0\0".to_vec();
    let array = |kind: u8, count: u8, bytes: Vec<u8>| {
        let length = bytes.len() as u8;
        [vec![kind, count, 0, 0, 0, 0, 0, 0, 0, length, 0, 0, 0], bytes].concat()
    };
    let number = |v: i64| [&b"L"[..], &v.to_le_bytes()].concat();
    let text = |text: &[u8]| [&[b'S', text.len() as u8, 0, 0, 0], text].concat();
    let points = [0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0];
    let points = array(b'f', 12, points.iter().flat_map(|v| v.to_le_bytes()).collect());
    let corners = array(b'i', 4, [0_i32, 1, 2, -4].iter().flat_map(|v| v.to_le_bytes()).collect());
    let start = open(&mut out, b"Objects", &[]);
    let mesh = open(&mut out, b"Geometry", &[number(1), text(b"g\0\x01Geometry"), text(b"Mesh")]);
    for (name, list) in [(&b"Vertices"[..], points), (b"PolygonVertexIndex", corners)] {
        let place = open(&mut out, name, &[list]);
        close(&mut out, place, false);
    }
    close(&mut out, mesh, true);
    let model = open(&mut out, b"Model", &[number(2), text(b"m\0\x01Model"), text(b"Mesh")]);
    close(&mut out, model, false);
    close(&mut out, start, true);
    let start = open(&mut out, b"Connections", &[]);
    let link = open(&mut out, b"C", &[text(b"OO"), number(1), number(2)]);
    close(&mut out, link, false);
    close(&mut out, start, true);
    out.extend([0; 13]);
    out
}

/// Begins a record of FBX, and returns its place.
fn open(out: &mut Vec<u8>, name: &[u8], values: &[Vec<u8>]) -> usize {
    let start = out.len();
    let list = values.concat();
    out.extend([0, values.len() as u32, list.len() as u32].map(u32::to_le_bytes).concat());
    out.push(name.len() as u8);
    out.extend([name, &list].concat());
    start
}

/// Ends a record of FBX; one with records within has one more of zeros.
fn close(out: &mut Vec<u8>, start: usize, has_records: bool) {
    if has_records {
        out.extend([0; 13]);
    }
    let end = out.len() as u32;
    out[start..start + 4].copy_from_slice(&end.to_le_bytes());
}
