//! Layers that are written here, and read again.

mod binary;
mod hostile;
mod kinds;
mod materialx;

use crate::hostile::{limits, load, load_beside, warnings};
use crate::threemf::{png, zip};
use crate::{Format, Loaded, MemoryResolver};
use overcoat_scene::{AlphaMode, Axis, Workflow};

/// A square from (0, 0, 0) to (2, 2, 0) with texture coordinates.
const SQUARE: &str = "def Mesh \"Square\" {
    uniform token subdivisionScheme = \"none\"
    int[] faceVertexCounts = [4]
    int[] faceVertexIndices = [0, 1, 2, 3]
    point3f[] points = [(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0)]
    texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1), (0, 1)] (
        interpolation = \"vertex\"
    )
}
";

fn file(metadata: &str, body: &str) -> String {
    format!("#usda 1.0\n(\n    metersPerUnit = 1\n{metadata}\n)\n{body}")
}

fn read(body: &str) -> Loaded {
    load(file("", body).as_bytes(), Format::Usd).unwrap()
}

/// Reads a file with others beside it.
fn read_beside(body: &str, beside: &[(&str, &str)]) -> Loaded {
    let files = beside.iter().map(|(name, text)| ((*name).to_owned(), text.as_bytes().to_vec())).collect();
    load_beside(file("", body).as_bytes(), Format::Usd, &MemoryResolver { files }, &limits()).unwrap()
}

/// The first vertex of every instance, where it stands.
fn corners(loaded: &Loaded) -> Vec<[f64; 3]> {
    let scene = &loaded.scene;
    let corner = |instance: &overcoat_scene::Instance| {
        let first = scene.meshes()[instance.mesh.index()].positions()[0];
        instance.transform.point(first.map(f64::from)).map(|v| (v * 1e6).round() / 1e6)
    };
    scene.instances().iter().map(corner).collect()
}

/// A triangle whose first vertex is (1, 0, 0), in a prim with a transform.
fn moved(operations: &str) -> String {
    format!(
        "def Mesh \"M\" {{\n{operations}\n int[] faceVertexCounts = [3]\n int[] faceVertexIndices = [0, 1, 2]\n \
         point3f[] points = [(1, 0, 0), (0, 1, 0), (0, 0, 1)]\n}}\n"
    )
}

#[test]
fn a_mesh_has_its_points_axes_and_unit() {
    let loaded = read(SQUARE);
    let mesh = &loaded.scene.meshes()[0];
    assert_eq!(mesh.positions(), [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 2.0, 0.0], [0.0, 2.0, 0.0]]);
    assert_eq!(mesh.triangles(), [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(loaded.up, Some(Axis::PositiveY));
    assert_eq!(warnings(&loaded), [""; 0]);
    // Centimetres without a word.
    let loaded = load(format!("#usda 1.0\n( upAxis = \"Z\" )\n{SQUARE}").as_bytes(), Format::Usd).unwrap();
    assert_eq!(loaded.up, Some(Axis::PositiveZ));
    assert_eq!(loaded.scene.instances()[0].transform.uniform_scale(), 0.01);
}

#[test]
fn operations_apply_from_the_last_to_the_first() {
    let order = |list: &str| format!("uniform token[] xformOpOrder = [{list}]\n");
    let all = "double3 xformOp:translate = (5, 0, 0)\n float xformOp:rotateZ = 90\n float3 xformOp:scale = (2, 3, 4)\n \
               float3 xformOp:rotateXYZ = (90, 90, 0)\n quatf xformOp:orient = (0.70710678, 0, 0, 0.70710678)\n \
               matrix4d xformOp:transform = ((0, 1, 0, 0), (-1, 0, 0, 0), (0, 0, 1, 0), (7, 8, 9, 1))\n";
    for (list, expected) in [
        ("\"xformOp:translate\", \"xformOp:rotateZ\", \"xformOp:scale\"", [5.0, 2.0, 0.0]),
        ("\"xformOp:scale\", \"xformOp:rotateZ\", \"xformOp:translate\"", [0.0, 18.0, 0.0]),
        ("\"xformOp:orient\"", [0.0, 1.0, 0.0]),
        ("\"xformOp:transform\"", [7.0, 9.0, 9.0]),
        ("\"xformOp:transform\", \"!invert!xformOp:transform\"", [1.0, 0.0, 0.0]),
        ("\"!invert!xformOp:translate\"", [-4.0, 0.0, 0.0]),
        // About X first, where nothing moves, then about Y.
        ("\"xformOp:rotateXYZ\"", [0.0, 0.0, -1.0]),
        ("\"xformOp:unknown\"", [1.0, 0.0, 0.0]),
    ] {
        assert_eq!(corners(&read(&moved(&format!("{all}{}", order(list))))), [expected], "{list}");
    }
    let within = |list: &str| {
        let inner = moved(&format!("double3 xformOp:translate = (5, 0, 0)\n{}", order(list)));
        let outer =
            "double3 xformOp:translate = (0, 10, 0)\n uniform token[] xformOpOrder = [\"xformOp:translate\"]";
        corners(&read(&format!("def Xform \"X\" {{\n{outer}\n{inner}}}\n")))
    };
    assert_eq!(within("\"xformOp:translate\""), [[6.0, 10.0, 0.0]]);
    assert_eq!(within("\"!resetXformStack!\", \"xformOp:translate\""), [[6.0, 0.0, 0.0]]);
}

#[test]
fn samples_and_defaults() {
    let sampled = "double3 xformOp:translate.timeSamples = {\n 1: (3, 0, 0),\n 2:(4, 0, 0),\n }\n \
                   double3 xformOp:translate = (9, 0, 0)\n uniform token[] xformOpOrder = [\"xformOp:translate\"]";
    let loaded = read(&moved(sampled));
    assert_eq!(corners(&loaded), [[4.0, 0.0, 0.0]]);
    assert!(warnings(&loaded).contains(&"USD: animations have no effect: the first sample is drawn"));
}

#[test]
fn values_belong_to_meshes_faces_points_or_corners() {
    let mesh = |attributes: &str| {
        let body = format!(
            "def Mesh \"M\" {{\n uniform token subdivisionScheme = \"none\"\n int[] faceVertexCounts = [3, 3]\n \
             int[] faceVertexIndices = [0, 1, 2, 0, 2, 3]\n \
             point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]\n{attributes}\n}}\n"
        );
        read(&body).scene
    };
    let colors = |values: &str, interpolation: &str| {
        let scene = mesh(&format!(
            "color3f[] primvars:displayColor = {values} ( interpolation = \"{interpolation}\" )"
        ));
        let mesh = &scene.meshes()[0];
        let red = |v: u32| mesh.colors()[v as usize][0];
        mesh.triangles().iter().map(|t| t.map(red)).collect::<Vec<_>>()
    };
    let four = "[(0, 0, 0), (0.25, 0, 0), (0.5, 0, 0), (1, 0, 0)]";
    assert_eq!(colors(four, "vertex"), [[0.0, 0.25, 0.5], [0.0, 0.5, 1.0]]);
    assert_eq!(colors(four, "constant"), [[0.0; 3]; 2]);
    assert_eq!(colors("[(1, 0, 0), (0.5, 0, 0)]", "uniform"), [[1.0; 3], [0.5; 3]]);
    let six = "[(0, 0, 0), (0.25, 0, 0), (0.5, 0, 0), (1, 0, 0), (0.125, 0, 0), (0.75, 0, 0)]";
    assert_eq!(colors(six, "faceVarying"), [[0.0, 0.25, 0.5], [1.0, 0.125, 0.75]]);
    let indexed = "int[] primvars:displayColor:indices = [0, 0, 0, 1, 1, 1]\n \
                   color3f[] primvars:displayColor = [(1, 0, 0), (0.5, 0, 0)] ( interpolation = \"faceVarying\" )";
    let scene = mesh(indexed);
    assert_eq!(scene.meshes()[0].colors().len(), 6);
    let scene = mesh("int[] holeIndices = [1]\n uniform token orientation = \"leftHanded\"");
    assert_eq!(scene.triangle_count(), 1);
    let mesh = &scene.meshes()[0];
    let corners = mesh.triangles()[0].map(|v| mesh.positions()[v as usize]);
    assert_eq!(corners, [[1.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0; 3]]);
}

#[test]
fn what_is_not_meant_to_be_seen_is_left_out() {
    let count = |body: &str| read(body).scene.instances().len();
    assert_eq!(count(&moved("token visibility = \"invisible\"")), 0);
    assert_eq!(count(&moved("uniform token purpose = \"proxy\"")), 0);
    assert_eq!(count(&moved("uniform token purpose = \"render\"")), 1);
    assert_eq!(count(&moved("").replace("def Mesh", "class Mesh")), 0);
    assert_eq!(count(&moved("").replace("def Mesh", "over")), 0);
    assert_eq!(count(&moved("").replace("\"M\" {", "\"M\" ( active = false ) {")), 0);
    let inside = format!("def Xform \"X\" {{\n token visibility = \"invisible\"\n{}}}\n", moved(""));
    assert_eq!(count(&inside), 0);
}

#[test]
fn stronger_opinions_win() {
    let translate = |x: u32| format!("double3 xformOp:translate = ({x}, 0, 0)");
    let order = "uniform token[] xformOpOrder = [\"xformOp:translate\"]";
    let other =
        file("defaultPrim = \"A\"", &format!("def Xform \"A\" {{\n{}\n{order}\n{SQUARE}}}\n", translate(1)));
    let read = |body: &str| read_beside(body, &[("sub/other.usda", &other)]);
    let x = |loaded: &Loaded| corners(loaded).into_iter().map(|corner| corner[0]).collect::<Vec<_>>();
    // A reference, and an opinion over it.
    assert_eq!(x(&read("def \"R\" ( references = @sub/other.usda@ ) {}")), [1.0]);
    let over = format!("def \"R\" ( prepend references = @./sub/other.usda@</A> ) {{ {} }}", translate(2));
    assert_eq!(x(&read(&over)), [2.0]);
    assert_eq!(x(&read("def \"R\" ( payload = @sub/other.usda@ ) {}")), [1.0]);
    // Inherits are stronger than variants, variants than references; local opinions are the strongest.
    let all = |local: &str, inherit: &str, chosen: &str| {
        format!(
            "class \"_c\" {{ {} }}\ndef \"R\" ( {inherit} references = @sub/other.usda@\n variants = {{ string v = \
             \"{chosen}\" }}\n prepend variantSets = \"v\" ) {{\n{local}\n variantSet \"v\" = {{ \"a\" {{ {} }}\n \"b\" {{}} }} }}",
            translate(5),
            translate(6)
        )
    };
    assert_eq!(x(&read(&all("", "", "b"))), [1.0]);
    assert_eq!(x(&read(&all("", "", "a"))), [6.0]);
    assert_eq!(x(&read(&all("", "inherits = </_c>\n", "a"))), [5.0]);
    assert_eq!(x(&read(&all(&translate(7), "inherits = </_c>\n", "a"))), [7.0]);
    // References to what is within a prim that itself refers.
    let deep = "def \"R\" ( references = @sub/other.usda@ ) {}\ndef \"S\" ( references = </R/Square> ) {}";
    assert_eq!(x(&read(deep)), [1.0, 0.0]);
    let missing = read("def \"R\" ( references = @gone.usda@ ) {}");
    assert_eq!(x(&missing), [0.0; 0]);
    assert!(
        warnings(&missing)[0].starts_with("USD: layer 'gone.usda' is left out"),
        "{:?}",
        missing.warnings
    );
}

#[test]
fn sublayers_are_weaker_and_circles_end() {
    let below = file(
        "",
        "over \"M\" { double3 xformOp:translate = (3, 0, 0)\n uniform token[] xformOpOrder = [\"xformOp:translate\"] }",
    );
    let with = |metadata: &str, body: &str| {
        let files = [("below.usda".to_owned(), below.clone().into_bytes())].into();
        load_beside(file(metadata, body).as_bytes(), Format::Usd, &MemoryResolver { files }, &limits())
            .unwrap()
    };
    assert_eq!(corners(&with("subLayers = [ @below.usda@ ]", &moved(""))), [[4.0, 0.0, 0.0]]);
    let own = moved("double3 xformOp:translate = (8, 0, 0)");
    assert_eq!(corners(&with("subLayers = [ @below.usda@ ]", &own)), [[9.0, 0.0, 0.0]]);
    for body in [
        "def \"A\" ( references = </A> ) {}",
        "def \"A\" ( references = </B> ) {}\ndef \"B\" ( references = </A> ) {}",
        "def \"A\" { def \"C\" ( references = </A> ) {} }",
        "def \"A\" ( references = </A/B> ) { def \"B\" ( inherits = </A> ) {} }",
    ] {
        let loaded = read(body);
        assert!(
            warnings(&loaded).iter().any(|w| w.contains("leads back to itself")),
            "{body} {:?}",
            loaded.warnings
        );
    }
    let looped = file("subLayers = [ @a.usda@ ]", "");
    let files = [("a.usda".to_owned(), looped.clone().into_bytes())].into();
    let loaded = load_beside(looped.as_bytes(), Format::Usd, &MemoryResolver { files }, &limits()).unwrap();
    assert!(warnings(&loaded).iter().any(|w| w.contains("contains itself")), "{:?}", loaded.warnings);
}

#[test]
fn instancers_place_their_prototypes() {
    let body = format!(
        "def PointInstancer \"I\" {{\n rel prototypes = [ </I/P> ]\n int[] protoIndices = [0, 0, 0, 4]\n \
         point3f[] positions = [(0, 0, 0), (10, 0, 0), (20, 0, 0), (30, 0, 0)]\n \
         quath[] orientations = [(1, 0, 0, 0), (0.70710678, 0, 0, 0.70710678), (1, 0, 0, 0), (1, 0, 0, 0)]\n \
         float3[] scales = [(1, 1, 1), (2, 2, 2), (1, 1, 1), (1, 1, 1)]\n int64[] invisibleIds = [2]\n \
         def \"P\" {{\n{}}}\n}}\n",
        moved("")
    );
    let found = corners(&read(&body));
    assert_eq!(found, [[1.0, 0.0, 0.0], [10.0, 2.0, 0.0]]);
}

/// A material with a shader of some inputs, and the square that it is on.
fn with_material(inputs: &str, others: &str) -> String {
    let square = SQUARE.replacen(
        '{',
        "( prepend apiSchemas = [\"MaterialBindingAPI\"] ) {\n rel material:binding = </M>",
        1,
    );
    format!(
        "{square}\ndef Material \"M\" {{\n token outputs:surface.connect = </M/S.outputs:surface>\n float inputs:shine = 0.25\n \
         def Shader \"S\" {{\n uniform token info:id = \"UsdPreviewSurface\"\n{inputs}\n token outputs:surface\n }}\n{others}}}\n"
    )
}

/// A texture shader in the material.
fn texture(name: &str, file: &str, more: &str) -> String {
    format!(
        "def Shader \"{name}\" {{\n uniform token info:id = \"UsdUVTexture\"\n asset inputs:file = @{file}@\n{more}\n}}\n"
    )
}

#[test]
fn preview_surfaces_become_materials() {
    let inputs = "color3f inputs:diffuseColor = (0.25, 0.5, 1)\n float inputs:metallic = 1\n \
                  float inputs:roughness.connect = </M.inputs:shine>\n float inputs:clearcoat = 0.5\n \
                  float inputs:opacity = 0.5\n float inputs:ior = 1.25\n color3f inputs:emissiveColor = (2, 0, 0)";
    let loaded = read(&with_material(inputs, ""));
    let material = &loaded.scene.materials()[0];
    assert_eq!(material.base_color, [0.25, 0.5, 1.0, 0.5]);
    assert_eq!(
        material.workflow,
        Workflow::MetallicRoughness { metallic: 1.0, roughness: 0.25, texture: None }
    );
    assert_eq!((material.coat, material.coat_roughness, material.ior), (0.5, 0.01, 1.25));
    assert_eq!((material.emissive, material.alpha_mode), ([2.0, 0.0, 0.0], AlphaMode::Blend));
    assert!(!material.double_sided);
    let cut = read(&with_material(
        "float inputs:opacityThreshold = 0.5\n int inputs:useSpecularWorkflow = 1\n color3f inputs:specularColor = (1, 0.5, 0)\n float inputs:roughness = 0.25",
        "",
    ));
    let material = &cut.scene.materials()[0];
    assert_eq!(material.alpha_mode, AlphaMode::Mask { cutoff: 0.5 });
    let expected =
        Workflow::SpecularGlossiness { specular: [1.0, 0.5, 0.0], glossiness: 0.75, texture: None };
    assert_eq!((&material.workflow, material.base_color), (&expected, [0.18, 0.18, 0.18, 1.0]));
}

#[test]
fn pictures_of_one_channel_become_one_texture() {
    let png = |texel: [u8; 4]| png(&[texel], 1);
    let inputs = "float inputs:roughness.connect = </M/R.outputs:r>\n float inputs:metallic.connect = </M/T.outputs:g>\n \
                  color3f inputs:diffuseColor.connect = </M/R.outputs:rgb>";
    let transform = "def Shader \"X\" {\n uniform token info:id = \"UsdTransform2d\"\n float inputs:rotation = 90\n \
                     float2 inputs:translation = (0.25, 0.5)\n float2 inputs:in.connect = </M/P.outputs:result>\n}\n\
                     def Shader \"P\" {\n uniform token info:id = \"UsdPrimvarReader_float2\"\n string inputs:varname = \"st\"\n}\n";
    let first = texture(
        "R",
        "r.png",
        "float2 inputs:st.connect = </M/X.outputs:result>\n token inputs:wrapS = \"clamp\"",
    );
    let body = with_material(
        inputs,
        &format!("{first}{}{transform}", texture("T", "t.png", "float4 inputs:scale = (0.5, 0.5, 0.5, 1)")),
    );
    let root = file("", &body);
    let parts: [(&str, &[u8]); 3] =
        [("a.usda", root.as_bytes()), ("r.png", &png([40, 50, 60, 255])), ("t.png", &png([70, 80, 90, 255]))];
    let package = zip(&parts, false);
    let loaded = load(&package, Format::Usd).unwrap();
    assert_eq!(warnings(&loaded), [""; 0]);
    let material = &loaded.scene.materials()[0];
    let Workflow::MetallicRoughness { metallic: 1.0, roughness: 1.0, texture: Some(packed) } =
        &material.workflow
    else {
        panic!("{:?}", material.workflow)
    };
    let texels = loaded.scene.textures()[packed.texture.index()].image().texels().to_vec();
    // Half of the green of the second.
    assert_eq!(texels, [[255, 40, 40, 255]]);
    let base = material.base_color_texture.unwrap();
    assert_eq!(loaded.scene.textures()[base.texture.index()].image().texels(), [[40, 50, 60, 255]]);
    // The point (1, 0) with v up, (1, 1) with v down, turns to (0, 1) and moves to (0.25, 1.5), which is -0.5 from above.
    let [u, v] = base.transform.rows.map(|row| row[0] + row[1] + row[2]);
    assert!((u - 0.25).abs() < 1e-6 && (v + 0.5).abs() < 1e-6, "{u} {v}");
}

#[test]
fn subsets_have_materials_of_their_own() {
    let material = |name: &str| {
        format!(
            "def Material \"{name}\" {{\n token outputs:surface.connect = </{name}/S.outputs:surface>\n def Shader \"S\" {{\n \
             uniform token info:id = \"UsdPreviewSurface\"\n }}\n}}\n"
        )
    };
    let body = format!(
        "def Mesh \"M\" {{\n rel material:binding = </A>\n int[] faceVertexCounts = [3, 3]\n int[] faceVertexIndices = [0, 1, 2, 0, 2, 3]\n \
         point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]\n def GeomSubset \"s\" {{\n uniform token elementType = \"face\"\n \
         int[] indices = [1]\n rel material:binding = </B>\n }}\n}}\n{}{}",
        material("A"),
        material("B")
    );
    let loaded = read(&body);
    let names =
        loaded.scene.instances().iter().map(|i| loaded.scene.materials()[i.material.index()].name.as_str());
    assert_eq!(names.collect::<Vec<_>>(), ["A", "B"]);
    assert_eq!(loaded.scene.triangle_count(), 2);
}

#[test]
fn shapes_have_their_sizes() {
    for (kind, attributes, half) in [
        ("Cube", "double size = 4", [2.0, 2.0, 2.0]),
        ("Sphere", "double radius = 3", [3.0; 3]),
        ("Cylinder", "double radius = 2\n double height = 6\n uniform token axis = \"X\"", [3.0, 2.0, 2.0]),
        ("Cone", "double radius = 2\n double height = 6\n uniform token axis = \"Y\"", [2.0, 3.0, 2.0]),
        ("Capsule", "double radius = 1\n double height = 2", [1.0, 1.0, 2.0]),
        ("Plane", "double width = 2\n double length = 4", [1.0, 2.0, 0.0]),
    ] {
        let loaded = read(&format!("def {kind} \"S\" {{\n{attributes}\n}}\n"));
        let mesh = &loaded.scene.meshes()[0];
        let reach = |axis: usize| mesh.positions().iter().map(|p| p[axis].abs()).fold(0.0, f32::max);
        for (axis, half) in half.into_iter().enumerate() {
            assert!((reach(axis) - half).abs() < 1e-5, "{kind} {axis} {}", reach(axis));
        }
        // Every triangle faces the way that its normals do.
        for triangle in mesh.triangles() {
            let [a, b, c] = triangle.map(|v| mesh.positions()[v as usize]);
            let [u, v] = [b, c].map(|p| [p[0] - a[0], p[1] - a[1], p[2] - a[2]]);
            let cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
            for normal in triangle.map(|v| mesh.normals()[v as usize]) {
                let dot = cross[0] * normal[0] + cross[1] * normal[1] + cross[2] * normal[2];
                assert!(dot > 0.0, "{kind} {triangle:?} {dot}");
            }
        }
    }
}

#[test]
fn texts_are_read_tolerantly() {
    let odd = "#usda 1.0 # comment\n/* more\n */ ( 'doc' customLayerData = { string a = \"x)\"\n dictionary d = { int[] b = [1, 2] } } )\n\
               def Mesh \"M\" ( doc = \"\"\"three \" quotes\"\"\"; kind = \"component\" ) {\n\
               custom string note = 'it\\'s'\n int[] faceVertexCounts = [3,]; int[] faceVertexIndices = [0 1 2]\n\
               reorder properties = [\"points\"]\n rel nothing\n float3[] extent.timeSamples = { 1: None, 2: [(0, 0, 0)] }\n\
               point3f[] points = [(0,0,0),(100,0,0),(0,100,0),]\n}\n";
    let loaded = load(odd.as_bytes(), Format::Usd).unwrap();
    assert_eq!(loaded.scene.triangle_count(), 1);
    // Up to what cannot be read.
    let cut = load(format!("{odd}def Mesh \"N\" {{ ! }}").as_bytes(), Format::Usd).unwrap();
    assert_eq!(cut.scene.triangle_count(), 1);
    assert!(warnings(&cut).iter().any(|w| w.contains("line 13 cannot be read")), "{:?}", cut.warnings);
}
