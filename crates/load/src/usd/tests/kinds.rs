//! Points, curves, lights, cameras, and textures in tiles.

use super::{SQUARE, file, read, texture, with_material};
use crate::hostile::{attack, limits, load, load_beside, warnings};
use crate::threemf::{png, zip};
use crate::{Format, Loaded, MemoryResolver};
use overcoat_scene::{EnvironmentSource, LightKind, PrimitiveKind, Projection};

#[test]
fn points_have_colours_and_widths() {
    let loaded = read(
        "def Points \"P\" {\n point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1e20, 0, 0)]\n float[] widths = [0.5, 1, 2, 1]\n \
         color3f[] primvars:displayColor = [(1, 0, 0), (0, 1, 0), (0, 0, 1), (0, 0, 0)] ( interpolation = \"vertex\" )\n}\n",
    );
    let mesh = &loaded.scene.meshes()[0];
    assert_eq!((mesh.kind(), mesh.positions().len()), (PrimitiveKind::Points, 3));
    assert_eq!(mesh.surfels().unwrap().radii, [0.25, 0.5, 1.0]);
    assert_eq!(mesh.colors()[1], [0.0, 1.0, 0.0, 1.0]);
    assert_eq!(loaded.scene.count_of(PrimitiveKind::Points), 3);
    assert!(warnings(&loaded)[0].contains("'/P': 1 point left out"), "{:?}", loaded.warnings);
    // One width for all, and none.
    let plain = |widths: &str| {
        read(&format!(
            "def Points \"P\" {{\n point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]\n{widths}\n}}\n"
        ))
    };
    let one = plain("float[] widths = [4] ( interpolation = \"constant\" )");
    assert_eq!(one.scene.meshes()[0].surfels().unwrap().radii, [2.0; 3]);
    assert!(plain("").scene.meshes()[0].surfels().is_none());
}

fn curve(attributes: &str) -> Loaded {
    read(&format!("def BasisCurves \"C\" {{\n{attributes}\n}}\n"))
}

/// The furthest point of the first mesh along an axis, each way.
fn reach(loaded: &Loaded, axis: usize) -> [f32; 2] {
    let places = || loaded.scene.meshes()[0].positions().iter().map(move |p| p[axis]);
    [places().fold(f32::MAX, f32::min), places().fold(f32::MIN, f32::max)]
}

#[test]
fn curves_are_tubes_or_lines() {
    let points =
        "int[] curveVertexCounts = [4]\n point3f[] points = [(0, 0, 0), (1, 2, 0), (3, 2, 0), (4, 0, 0)]";
    let width = "float[] widths = [0.5] ( interpolation = \"constant\" )";
    let line = curve(&format!("{points}\n uniform token type = \"linear\""));
    let mesh = &line.scene.meshes()[0];
    assert_eq!(
        (mesh.kind(), mesh.triangles()),
        (PrimitiveKind::Lines, &[[0, 1, 1], [1, 2, 2], [2, 3, 3]][..])
    );
    assert!(line.scene.materials()[line.scene.instances()[0].material.index()].unlit);
    let tube = curve(&format!("{points}\n{width}\n uniform token type = \"linear\""));
    assert_eq!(tube.scene.meshes()[0].kind(), PrimitiveKind::Triangles);
    assert!((reach(&tube, 2)[1] - 0.25).abs() < 1e-3, "{:?}", reach(&tube, 2));
    // The middle of a Bezier curve: 3/4 of the height of its two inner points.
    let bezier = curve(&format!("{points}\n{width}"));
    assert!((reach(&bezier, 1)[1] - 1.75).abs() < 0.02, "{:?}", reach(&bezier, 1));
    let spline = curve(&format!("{points}\n uniform token basis = \"bspline\""));
    let [low, high] = reach(&spline, 0);
    assert!((low - 7.0 / 6.0).abs() < 1e-5 && (high - 17.0 / 6.0).abs() < 1e-5, "{low} {high}");
    let pinned =
        curve(&format!("{points}\n uniform token basis = \"catmullRom\"\n uniform token wrap = \"pinned\""));
    assert_eq!(reach(&pinned, 0), [0.0, 4.0]);
    let closed = curve(&format!(
        "{points}\n{width}\n uniform token type = \"linear\"\n uniform token wrap = \"periodic\""
    ));
    // Four segments of twelve sides, without ends.
    assert_eq!(closed.scene.triangle_count(), 4 * 24);
    for loaded in [&line, &tube, &bezier, &spline, &pinned, &closed] {
        assert_eq!(warnings(loaded), [""; 0]);
    }
}

#[test]
fn values_of_curves_belong_to_curves_segments_or_points() {
    let lines = |color: &str| {
        let loaded = curve(&format!(
            "uniform token type = \"linear\"\n int[] curveVertexCounts = [2, 3]\n \
             point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0), (2, 1, 0)]\n color3f[] primvars:displayColor = {color}"
        ));
        loaded.scene.meshes()[0].colors().iter().map(|c| c[0]).collect::<Vec<_>>()
    };
    assert_eq!(lines("[(0.5, 0, 0)] ( interpolation = \"constant\" )"), [0.5; 5]);
    let uniform = lines("[(0.5, 0, 0), (1, 0, 0)] ( interpolation = \"uniform\" )");
    assert_eq!(uniform, [0.5, 0.5, 1.0, 1.0, 1.0]);
    let five = "[(0, 0, 0), (0.25, 0, 0), (0.5, 0, 0), (0.75, 0, 0), (1, 0, 0)]";
    for interpolation in ["vertex", "varying"] {
        let found = lines(&format!("{five} ( interpolation = \"{interpolation}\" )"));
        assert_eq!(found, [0.0, 0.25, 0.5, 0.75, 1.0]);
    }
    let bad =
        curve("int[] curveVertexCounts = [4, -1, 2000000000]\n point3f[] points = [(0, 0, 0), (1, 0, 0)]");
    assert_eq!(bad.scene.instances().len(), 0);
    let short = curve("int[] curveVertexCounts = [2]\n point3f[] points = [(0, 0, 0), (1, 0, 0)]");
    assert!(warnings(&short)[0].contains("'/C': 1 curve left out: too short"), "{:?}", short.warnings);
}

#[test]
fn lights_have_their_units() {
    let light = |text: &str| {
        let loaded = read(&format!("{SQUARE}\ndef {text}\n"));
        assert_eq!(warnings(&loaded), [""; 0], "{text}");
        loaded.scene.lights()[0]
    };
    let sun = light(
        "DistantLight \"L\" { float inputs:intensity = 3\n bool inputs:normalize = 1\n color3f inputs:color = (1, 0.5, 0.25) }",
    );
    assert_eq!((sun.intensity, sun.color), (3.0, [1.0, 0.5, 0.25]));
    assert_eq!(sun.kind, LightKind::Directional { direction: [0.0, 0.0, -1.0] });
    // 50,000 nits over the disc of the sun.
    let lux = light("DistantLight \"L\" { }").intensity;
    assert!((lux - 3.36).abs() < 0.01, "{lux}");
    let ball = light(
        "SphereLight \"L\" { float inputs:radius = 2\n float inputs:intensity = 10\n float inputs:exposure = 1 }",
    );
    assert!((ball.intensity - 20.0 * 4.0 * std::f32::consts::PI).abs() < 1e-3, "{}", ball.intensity);
    let spot = light(
        "SphereLight \"L\" { bool inputs:normalize = 1\n float inputs:intensity = 8\n float inputs:shaping:cone:angle = 60 }",
    );
    let LightKind::Spot { outer_cone_cosine, .. } = spot.kind else { panic!("{spot:?}") };
    assert!((outer_cone_cosine - 0.5).abs() < 1e-6 && spot.intensity == 2.0);
    let panel = light(
        "RectLight \"L\" { float inputs:width = 4\n float inputs:height = 2\n bool inputs:normalize = 1\n float inputs:intensity = 16 }",
    );
    let LightKind::Rect { half_width, half_height, .. } = panel.kind else { panic!("{panel:?}") };
    assert_eq!((panel.intensity, half_width, half_height), (2.0, [-2.0, 0.0, 0.0], [0.0, 1.0, 0.0]));
    let tube = light("CylinderLight \"L\" { float inputs:length = 4\n float inputs:radius = 0.25 }");
    assert_eq!(tube.kind, LightKind::Tube { ends: [[-2.0, 0.0, 0.0], [2.0, 0.0, 0.0]], radius: 0.25 });
    assert!(matches!(light("DiskLight \"L\" { }").kind, LightKind::Rect { .. }));
    for (text, expected) in [
        ("DomeLight \"L\" { asset inputs:texture:file = @sky.hdr@ }", "its picture 'sky.hdr' is left out"),
        ("DomeLight \"L\" { }", "it has no picture"),
        (
            "DomeLight \"L\" { asset inputs:texture:file = @a.hdr@\n token inputs:texture:format = \"angular\" }",
            "'angular'",
        ),
        ("GeometryLight \"L\" { }", "lights of this type are not drawn"),
        ("RectLight \"L\" { asset inputs:texture:file = @sky.hdr@ }", "'/L': its picture has no effect"),
        ("RectLight \"L\" { float inputs:width = 0 }", "is left out"),
    ] {
        let loaded = read(&format!("{SQUARE}\ndef {text}\n"));
        assert!(warnings(&loaded)[0].contains(expected), "{:?}", loaded.warnings);
    }
}

/// A picture of 8 x 4 texels whose second row shines at both sides of its centre; or all alike.
fn sky(is_plain: bool) -> Vec<u8> {
    let mut bytes = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n".to_vec();
    for k in 0..32 {
        let shines = is_plain || matches!(k, 11 | 12);
        bytes.extend(if shines { [128, 128, 128, 129] } else { [0; 4] });
    }
    bytes
}

#[test]
fn domes_surround_the_scene_with_their_picture() {
    let beside = |metadata: &str, lights: &str| {
        let mut beside = MemoryResolver::default();
        beside.files.insert("maps/sky.hdr".to_owned(), sky(false));
        beside.files.insert("plain.hdr".to_owned(), sky(true));
        let text = file(metadata, &format!("{SQUARE}\n{lights}\n"));
        load_beside(text.as_bytes(), Format::Usd, &beside, &limits()).unwrap()
    };
    // Rows and columns with light, and the light there.
    let places = |loaded: &Loaded| {
        let EnvironmentSource::Image(image) = &loaded.scene.environment().source else {
            panic!("no picture")
        };
        assert_eq!((image.width(), image.height()), (8, 4));
        let shining = image.pixels().iter().zip(0_u32..).filter(|(pixel, _)| pixel[0] > 0.01);
        shining
            .map(|(pixel, k)| (k / 8, k % 8, pixel.map(|v| (v * 100.0).round() / 100.0)))
            .collect::<Vec<_>>()
    };
    let picture = "asset inputs:texture:file = @maps/sky.hdr@";
    let plain = beside("", &format!("def DomeLight \"L\" {{ {picture} }}"));
    // The centre of a dome's picture looks to +Z, which an environment has at three quarters.
    let ahead = vec![(1, 5, [1.0; 3]), (1, 6, [1.0; 3])];
    assert_eq!((places(&plain), warnings(&plain)), (ahead.clone(), vec![]));
    let turn = |axis: &str, degrees: i32| {
        format!(
            "float xformOp:rotate{axis} = {degrees}\n uniform token[] xformOpOrder = [\"xformOp:rotate{axis}\"]"
        )
    };
    let bright =
        "float inputs:intensity = 2\n float inputs:exposure = 1\n color3f inputs:color = (1, 0.5, 0)";
    let turned = beside("", &format!("def DomeLight \"L\" {{ {picture}\n {bright}\n {} }}", turn("Y", 90)));
    assert_eq!(places(&turned), [(1, 3, [4.0, 2.0, 0.0]), (1, 4, [4.0, 2.0, 0.0])]);
    // Upside down.
    let over = beside("", &format!("def DomeLight \"L\" {{ {picture}\n {} }}", turn("Z", 180)));
    assert_eq!(places(&over), [(2, 5, [1.0; 3]), (2, 6, [1.0; 3])]);
    // The pole is +Y in scenes of +Z, too, unless the light is of the second kind.
    let upright = "    upAxis = \"Z\"";
    for light in [
        format!("def DomeLight_1 \"L\" {{ {picture} }}"),
        format!("def DomeLight_1 \"L\" {{ {picture}\n token poleAxis = \"Z\" }}"),
        format!("def DomeLight \"L\" {{ {picture}\n {} }}", turn("X", 90)),
    ] {
        assert_eq!(places(&beside(upright, &light)), ahead, "{light}");
    }
    let two =
        beside("", &format!("def DomeLight \"L\" {{ {picture} }}\ndef DomeLight \"M\" {{ {picture} }}"));
    assert!(
        warnings(&two)[0].contains("'/M' has no effect: the scene has another one"),
        "{:?}",
        warnings(&two)
    );
    let grey = beside("", "def DomeLight \"L\" { asset inputs:texture:file = @plain.hdr@ }");
    assert!(
        warnings(&grey)[0].contains("of one colour")
            && matches!(grey.scene.environment().source, EnvironmentSource::Studio)
    );
}

#[test]
fn cameras_have_names_and_views() {
    let body = format!(
        "{SQUARE}\ndef Camera \"Main\" {{\n float verticalAperture = 20\n float focalLength = 10\n float2 clippingRange = (0.5, 100)\n \
         double3 xformOp:translate = (0, 0, 5)\n uniform token[] xformOpOrder = [\"xformOp:translate\"]\n}}\n\
         def Camera \"Plan\" {{ token projection = \"orthographic\"\n float verticalAperture = 30 }}\n"
    );
    let loaded = read(&body);
    assert_eq!(
        (loaded.scene.camera_names(), warnings(&loaded)),
        (&["Main".to_owned(), "Plan".to_owned()][..], vec![])
    );
    let [main, plan] = loaded.scene.cameras() else { panic!("two") };
    assert_eq!((main.eye, main.target, main.near), ([0.0, 0.0, 5.0], [0.0, 0.0, 0.0], 0.5));
    let Projection::Perspective { fov_y } = main.projection else { panic!("{main:?}") };
    assert!((fov_y - std::f32::consts::FRAC_PI_2).abs() < 1e-6);
    assert_eq!(plan.projection, Projection::Orthographic { height: 3.0 });
}

#[test]
fn tiles_have_pictures_of_their_own() {
    // Two squares of one mesh, in the first tile and in the one to its right.
    let mesh = "def Mesh \"Square\" {\n rel material:binding = </M>\n uniform token subdivisionScheme = \"none\"\n \
         int[] faceVertexCounts = [4, 4]\n int[] faceVertexIndices = [0, 1, 2, 3, 4, 5, 6, 7]\n \
         point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (2, 0, 0), (3, 0, 0), (3, 1, 0), (2, 1, 0)]\n \
         texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1), (0, 1), (1, 0), (2, 0), (2, 1), (1, 1)] ( interpolation = \"vertex\" )\n}\n";
    let material = with_material(
        "color3f inputs:diffuseColor.connect = </M/T.outputs:rgb>",
        &texture("T", "skin.<UDIM>.png", "token inputs:wrapS = \"clamp\""),
    );
    let material = material.split_once("def Material").unwrap().1;
    let root = file("", &format!("{mesh}def Material{material}"));
    let pictures = [png(&[[10, 0, 0, 255]], 1), png(&[[0, 20, 0, 255]], 1)];
    let read = |names: &[&str]| {
        let mut parts: Vec<(&str, &[u8])> = vec![("a.usda", root.as_bytes())];
        parts.extend(names.iter().zip(&pictures).map(|(name, bytes)| (*name, bytes.as_slice())));
        load(&zip(&parts, false), Format::Usd).unwrap()
    };
    let loaded = read(&["skin.1001.png", "skin.1002.png"]);
    assert_eq!(warnings(&loaded), [""; 0]);
    let scene = &loaded.scene;
    let texels: Vec<[u8; 4]> = scene
        .instances()
        .iter()
        .map(|instance| {
            assert_eq!(scene.meshes()[instance.mesh.index()].positions().len(), 4);
            let texture = scene.materials()[instance.material.index()].base_color_texture.unwrap();
            let texture = &scene.textures()[texture.texture.index()];
            assert_eq!(texture.sampler().wrap_u, overcoat_scene::Wrap::Repeat);
            texture.image().texels()[0]
        })
        .collect();
    assert_eq!(texels, [[10, 0, 0, 255], [0, 20, 0, 255]]);
    let lacking = read(&["skin.1001.png"]);
    assert!(warnings(&lacking)[0].contains("texture 'skin.1002.png' is left out"), "{:?}", lacking.warnings);
}

#[test]
fn kinds_with_changed_bits_are_read_or_refused() {
    attack(
        file(
            "",
            "def BasisCurves \"C\" { int[] curveVertexCounts = [5, 2]\n point3f[] points = [(0, 0, 0), (1, 2, 0), (3, 2, 0), (4, 0, 0), (5, 1, 1), (0, 0, 0), (1, 1, 1)]\n \
             uniform token basis = \"bspline\"\n uniform token wrap = \"pinned\"\n float[] widths = [1, 2] (interpolation = \"uniform\") }\n\
             def Points \"P\" { point3f[] points = [(0, 0, 0), (1, 0, 0)]\n float[] widths = [1, 2] }\n\
             def SphereLight \"L\" { float inputs:radius = 1\n float inputs:colorTemperature = 3000\n bool inputs:enableColorTemperature = 1 }\n\
             def Camera \"K\" { float focalLength = 50 }\n",
        )
        .as_bytes(),
        Format::Usd,
    );
}
