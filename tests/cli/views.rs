//! Views: camera, orientation of the model, and exposure.

use super::{folder, glb, overcoat, quad, quad_buffer, read_png, stderr};
use serde_json::{Value, json};
use std::fs;
use std::path::Path;

/// Report of a command with `--json`.
fn report(folder: &Path, args: &[&str]) -> Value {
    let output = overcoat(folder, &[args, &["--json"]].concat());
    assert!(output.status.success(), "{args:?}: {}", stderr(&output));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn render(folder: &Path, args: &[&str]) -> Value {
    report(folder, &[&["render", "-o", "out.png", "--size", "48x40"], args].concat())
}

/// Numbers as options take them.
fn list(numbers: &Value) -> String {
    let text = |v: &Value| v.to_string();
    numbers.as_array().map_or_else(|| text(numbers), |all| all.iter().map(text).collect::<Vec<_>>().join(","))
}

/// Boxes, each as its smallest and its largest corner, as OBJ whose coordinates are those of `place`.
fn boxes(boxes: &[[[i32; 3]; 2]], place: impl Fn([i32; 3]) -> [i32; 3]) -> String {
    let line = |word: &str, [x, y, z]: [i32; 3]| format!("{word} {x} {y} {z}\n");
    let mut text = String::new();
    // Corners of each side, in one order seen from outside, and its normal.
    let sides = [
        ([0, 4, 6, 2], [-1, 0, 0]),
        ([1, 3, 7, 5], [1, 0, 0]),
        ([0, 1, 5, 4], [0, -1, 0]),
        ([2, 6, 7, 3], [0, 1, 0]),
        ([0, 2, 3, 1], [0, 0, -1]),
        ([4, 5, 7, 6], [0, 0, 1]),
    ];
    for (_, normal) in sides {
        text += &line("vn", place(normal));
    }
    for (number, [low, high]) in boxes.iter().enumerate() {
        for k in 0..8 {
            let corner = |a: usize| if k >> a & 1 == 1 { high[a] } else { low[a] };
            text += &line("v", place([corner(0), corner(1), corner(2)]));
        }
        for (side, (corners, _)) in sides.iter().enumerate() {
            let words = corners.map(|k| format!("{}//{}", 8 * number + k + 1, side + 1));
            text += &format!("f {}\n", words.join(" "));
        }
    }
    text
}

/// A body, a head in front of and above it, and legs: it faces +Z.
const COW: [[[i32; 3]; 2]; 4] =
    [[[-2, 2, -4], [2, 6, 4]], [[-1, 5, 3], [1, 9, 6]], [[-2, 0, 2], [2, 2, 3]], [[-2, 0, -3], [2, 2, -2]]];

/// Eye minus target.
fn direction(report: &Value) -> [f64; 3] {
    let camera = &report["camera"];
    [0, 1, 2].map(|k| camera["eye"][k].as_f64().unwrap() - camera["target"][k].as_f64().unwrap())
}

#[test]
fn the_camera_that_was_used_makes_the_picture_again() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("cow.obj"), boxes(&COW, |p| p)).unwrap();
    for args in [
        &[][..],
        &["--view", "top"],
        &["--view", "-1,0.3,2", "--fov", "17.3"],
        &["--ortho"],
        &["--up", "-z", "--near", "0.01"],
        &["--eye", "9,8,7", "--camera-up", "1,1,0"],
    ] {
        let first = render(folder, &[&["cow.obj"], args].concat());
        let camera = &first["camera"];
        let mut again = vec!["cow.obj".to_owned()];
        for (option, key) in
            [("--eye", "eye"), ("--target", "target"), ("--camera-up", "up"), ("--near", "near")]
        {
            again.extend([option.to_owned(), list(&camera[key])]);
        }
        match camera["projection"].as_str() {
            Some("perspective") => again.extend(["--fov".to_owned(), list(&camera["fov_y_degrees"])]),
            _ => again.push(format!("--ortho={}", list(&camera["height"]))),
        }
        again.extend(["--up".to_owned(), first["up_axis"].as_str().unwrap().to_owned()]);
        let again: Vec<&str> = again.iter().map(String::as_str).collect();
        let second = render(folder, &again);
        assert_eq!(second["camera"], *camera, "{args:?}");
        assert_eq!(second["frame_hash"], first["frame_hash"], "{args:?}");
    }
    let sheet = report(folder, &["sheet", "cow.obj", "quad.glb", "-o", "sheet.png", "--size", "16"]);
    for cell in sheet["cells"].as_array().unwrap() {
        assert!(cell["camera"]["eye"].is_array() && cell["up_axis"] == "+y", "{cell}");
    }
    for command in ["turntable", "compare-models"] {
        let args = ["cow.obj", "-o", "moving.png", "--size", "16"];
        let last = if command == "turntable" { "--frames=2" } else { "--models=gltf" };
        let report = report(folder, &[&[command], &args[..], &[last]].concat());
        assert!(report["camera"]["near"].is_number() && report["up_axis"] == "+y", "{report}");
    }
}

/// Matrices of a camera, also of an automatic one, are those that options take.
#[test]
fn the_matrices_of_a_camera_make_the_picture_again() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("cow.obj"), boxes(&COW, |p| p)).unwrap();
    for args in [&[][..], &["--view", "top", "--far", "90"], &["--intrinsics", "60,50,70.5,-3"]] {
        let first = render(folder, &[&["cow.obj"], args].concat());
        let camera = &first["camera"];
        assert_eq!(camera["size"], json!([48, 40]), "{args:?}");
        let k = &camera["k"];
        let four = [&k[0][0], &k[1][1], &k[0][2], &k[1][2]].map(Value::to_string).join(",");
        for convention in ["opencv", "opengl"] {
            let pose = &camera["pose"][convention];
            fs::write(folder.join("pose.json"), pose.to_string()).unwrap();
            let numbers = pose.as_array().unwrap().iter().map(list).collect::<Vec<_>>().join(" ");
            for pose in ["pose.json", &numbers] {
                let near = list(&camera["near"]);
                let mut again = vec!["cow.obj", "--intrinsics", &four, "--pose", pose, "--near", &near];
                again.extend(["--pose-convention", convention]);
                let second = render(folder, &again);
                assert_eq!(second["frame_hash"], first["frame_hash"], "{args:?} {convention}");
            }
        }
    }
    // Options win over a scene file, whose camera stands elsewhere and has another projection.
    let scene = "model = 'cow.obj'\n[camera]\nK = [60, 50, 30.5, 10]\npose = \
        [1, 0, 0, 0, 0, 1, 0, 4, 0, 0, 1, 20, 0, 0, 0, 1]\nconvention = 'opengl'\n";
    fs::write(folder.join("scene.toml"), scene).unwrap();
    let of_file = render(folder, &["--scene", "scene.toml"]);
    assert_eq!(of_file["camera"]["pose"]["opengl"][2], json!([0.0, 0.0, 1.0, 20.0]));
    let viewed = render(folder, &["--scene", "scene.toml", "--view", "front", "--fov", "30"]);
    assert_eq!(viewed["frame_hash"], render(folder, &["cow.obj", "--view", "front"])["frame_hash"]);
}

#[test]
fn a_model_is_turned_upright_whichever_axis_is_up() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("y.obj"), boxes(&COW, |p| p)).unwrap();
    let expected = render(folder, &["y.obj"]);
    // Map from right, up and front in the scene to the coordinates of the file.
    type Place = fn([i32; 3]) -> [i32; 3];
    let files: [(&str, Place); 5] = [
        ("-y", |[x, y, z]| [-x, -y, z]),
        ("z", |[x, y, z]| [x, -z, y]),
        ("-z", |[x, y, z]| [x, z, -y]),
        ("+x", |[x, y, z]| [y, -x, z]),
        ("-x", |[x, y, z]| [-y, x, z]),
    ];
    for (up, place) in files {
        fs::write(folder.join("turned.obj"), boxes(&COW, place)).unwrap();
        let turned = render(folder, &["turned.obj", "--up", up]);
        assert_eq!(turned["camera"], expected["camera"], "{up}");
        assert_eq!(turned["frame_hash"], expected["frame_hash"], "{up}");
        let info = report(folder, &["info", "turned.obj", "--up", up]);
        assert_eq!(info["bounds"], json!({"min": [-2.0, 0.0, -4.0], "max": [2.0, 9.0, 6.0]}), "{up}");
        assert!(up.ends_with(info["up_axis"].as_str().unwrap().trim_start_matches('+')), "{info}");
        let scene = format!("model = 'turned.obj'\nup = '{up}'\nsize = [48, 40]\n");
        fs::write(folder.join("scene.toml"), scene).unwrap();
        let by_file = report(folder, &["render", "--scene", "scene.toml", "-o", "out.png"]);
        assert_eq!(by_file["frame_hash"], expected["frame_hash"], "{up}");
    }
    // Without the option, by the format.
    let stl = "solid a\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 0 2\nendloop\nendfacet\nendsolid\n";
    fs::write(folder.join("a.stl"), stl).unwrap();
    let info = report(folder, &["info", "a.stl"]);
    assert_eq!((&info["up_axis"], &info["front_axis"]), (&json!("+z"), &json!("-y")));
    assert_eq!(info["bounds"]["max"], json!([1.0, 2.0, 0.0]));
    let text = String::from_utf8(overcoat(folder, &["info", "a.stl"]).stdout).unwrap();
    assert!(text.contains("+z of the file is up, -y its front\n"), "{text}");
    let text = String::from_utf8(overcoat(folder, &["info", "y.obj"]).stdout).unwrap();
    assert!(text.contains("+y of the file is up, +z its front (the format does not say)\n"), "{text}");
}

#[test]
fn cameras_and_lights_of_the_file_turn_with_it() {
    let folder = folder();
    let folder = folder.path();
    let mut file = quad();
    file["extensionsUsed"] = json!(["KHR_lights_punctual"]);
    file["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "spot", "intensity": 40}]}});
    file["nodes"]
        .as_array_mut()
        .unwrap()
        .push(json!({"translation": [0.5, 0.25, 2.0], "extensions": {"KHR_lights_punctual": {"light": 0}}}));
    file["scenes"][0]["nodes"] = json!([0, 1, 2]);
    fs::write(folder.join("lit.glb"), glb(&file, &quad_buffer())).unwrap();
    // Sums of three coordinates round otherwise in another order, which 8 bits do not show.
    let mut pictures = Vec::new();
    for up in ["+y", "-y", "+z", "-z", "+x", "-x"] {
        let report = render(
            folder,
            &["lit.glb", "--camera", "eye", "--env", "none", "--quality", "draft", "--up", up],
        );
        pictures.push((report, fs::read(folder.join("out.png")).unwrap()));
    }
    for (_, picture) in &pictures {
        assert!(*picture == pictures[0].1);
    }
    assert_eq!(pictures[2].0["camera"]["eye"], json!([0.0, 4.0, 0.0]));
}

#[test]
fn heads_are_seen_where_the_format_does_not_say_where_the_front_is() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("front.obj"), boxes(&COW, |p| p)).unwrap();
    fs::write(folder.join("back.obj"), boxes(&COW, |[x, y, z]| [-x, y, -z])).unwrap();
    let (front, back) = (render(folder, &["front.obj"]), render(folder, &["back.obj"]));
    let ([x, y, z], turned) = (direction(&front), direction(&back));
    assert!(x > 0.0 && y > 0.0 && z > 0.0);
    assert!([x + turned[0], y - turned[1], z + turned[2]].iter().all(|d| d.abs() < 1e-4), "{turned:?}");
    // An explicit view is taken as it is.
    assert!(direction(&render(folder, &["back.obj", "--view", "front"]))[2] > 0.0);
}

/// A quad that faces another way.
fn facing(rotation: [f64; 4]) -> Vec<u8> {
    let mut file = quad();
    file["nodes"][0]["rotation"] = json!(rotation);
    glb(&file, &quad_buffer())
}

#[test]
fn flat_models_are_seen_from_where_they_show() {
    let folder = folder();
    let folder = folder.path();
    let half = 0.5_f64.sqrt();
    // By the turn of a quad that faces +Z: what it faces then, and whether the view is from above.
    for (rotation, normal, above) in [
        ([0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 1.0], true),
        ([-half, 0.0, 0.0, half], [0.0, 1.0, 0.0], true),
        ([half, 0.0, 0.0, half], [0.0, -1.0, 0.0], false),
        ([0.0, 1.0, 0.0, 0.0], [0.0, 0.0, -1.0], true),
        ([0.0, half, 0.0, half], [1.0, 0.0, 0.0], true),
        ([0.0, -half, 0.0, half], [-1.0, 0.0, 0.0], true),
    ] {
        fs::write(folder.join("flat.glb"), facing(rotation)).unwrap();
        let d = direction(&render(folder, &["flat.glb"]));
        let length = d.iter().map(|v| v * v).sum::<f64>().sqrt();
        let towards: f64 = (0..3).map(|k| d[k] * normal[k]).sum::<f64>() / length;
        assert!(towards > 0.25, "{normal:?} from {d:?}");
        assert_eq!(d[1] > 0.0, above, "{normal:?} from {d:?}");
    }
}

#[test]
fn lights_that_leave_nothing_but_white_are_named_and_metered() {
    let folder = folder();
    let folder = folder.path();
    let mut file = quad();
    file["extensionsUsed"] = json!(["KHR_lights_punctual"]);
    file["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 54351}]}});
    file["nodes"]
        .as_array_mut()
        .unwrap()
        .push(json!({"translation": [0.0, 0.0, 2.0], "extensions": {"KHR_lights_punctual": {"light": 0}}}));
    file["scenes"][0]["nodes"] = json!([0, 1, 2]);
    file["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = json!([0.8, 0.8, 0.8, 1.0]);
    fs::write(folder.join("lit.glb"), glb(&file, &quad_buffer())).unwrap();
    let quiet = |args: &[&str]| {
        let output =
            overcoat(folder, &[&["render", "lit.glb", "-o", "out.png", "--size", "64"], args].concat());
        assert!(output.status.success(), "{}", stderr(&output));
        let picture = fs::read(folder.join("out.png")).unwrap();
        (stderr(&output), picture)
    };
    for background in ["transparent", "white", "black"] {
        let (message, lowered) = quiet(&["--background", background]);
        assert!(message.contains(" stops lower; --exposure 0 keeps it"), "{message}");
        assert!(message.contains("--no-lights") && message.lines().count() == 1, "{message}");
        assert_eq!(lowered, quiet(&["--background", background, "--exposure", "auto"]).1);
        let (message, _) = quiet(&["--background", background, "--exposure", "0"]);
        assert!(message.contains("100 percent of the object is white"), "{message}");
        assert!(message.contains("--exposure auto") && message.contains("--no-lights"), "{message}");
        assert_eq!(message.lines().count(), 1, "{message}");
    }
    let told = render(folder, &["lit.glb"]);
    assert!(told["warnings"][0].as_str().unwrap().contains("stops lower"), "{told}");
    assert!(told["exposure"].as_f64().unwrap() < -4.0, "{told}");
    let sheet = report(folder, &["sheet", "lit.glb", "-o", "sheet.png", "--size", "64"]);
    assert!(sheet["cells"][0]["warnings"][0].as_str().unwrap().contains("stops lower"), "{sheet}");
    let two = report(folder, &["diff", "lit.glb", "lit.glb", "-o", "diff.png", "--size", "64"]);
    assert_eq!(two["exposure"], told["exposure"], "{two}");
    let film = report(folder, &["turntable", "lit.glb", "-o", "b.png", "--size", "16", "--frames", "2"]);
    assert!(film["exposure"].as_f64().unwrap() < -4.0, "{film}");
    let output = overcoat(folder, &["thumbnail", "lit.glb", "small.png", "--size", "64"]);
    assert!(output.status.success(), "{}", stderr(&output));
    let (_, _, pixels) = read_png(&fs::read(folder.join("small.png")).unwrap());
    assert!(pixels.chunks(4).any(|p| p[3] == 255 && (60..200).contains(&p[0])), "all is white");
    // A light as meant changes nothing.
    file["extensions"]["KHR_lights_punctual"]["lights"][0]["intensity"] = json!(4.0);
    fs::write(folder.join("meant.glb"), glb(&file, &quad_buffer())).unwrap();
    let meant = render(folder, &["meant.glb"]);
    assert_eq!(
        (meant["exposure"].as_f64(), meant["warnings"].as_array().map(Vec::len)),
        (Some(0.0), Some(0))
    );

    assert_eq!(quiet(&["--no-lights"]).0, "");
    let (message, direct) = quiet(&["--exposure", "auto"]);
    assert_eq!(message, "");
    // The same by way of a frame, and from what the report says.
    let metered =
        report(folder, &["render", "lit.glb", "-o", "frame.png", "--size", "64", "--exposure", "auto"]);
    assert_eq!(fs::read(folder.join("frame.png")).unwrap(), direct);
    let stops = metered["exposure"].to_string();
    assert!(stops.starts_with('-'), "{stops}");
    assert_eq!(quiet(&["--exposure", &stops]).1, direct);
    let (_, _, pixels) = read_png(&direct);
    let mut reds: Vec<u8> = pixels.chunks(4).filter(|p| p[3] == 255).map(|p| p[0]).collect();
    reds.sort_unstable();
    let median = reds[reds.len() / 2];
    assert!((60..235).contains(&median), "{median}");
    // Black, where there is no other light.
    let (message, _) = quiet(&["--env", "none", "--exposure", "-60"]);
    assert!(message.contains("is black: the lights are too dark"), "{message}");
    fs::write(folder.join("scene.json"), r#"{"model": "lit.glb", "exposure": "auto", "size": [64, 64]}"#)
        .unwrap();
    let by_file = report(folder, &["render", "--scene", "scene.json", "-o", "by-file.png"]);
    assert_eq!(by_file["exposure"], metered["exposure"]);
    assert_eq!(fs::read(folder.join("by-file.png")).unwrap(), direct);
    let film = report(
        folder,
        &["turntable", "lit.glb", "-o", "a.png", "--size", "16", "--frames", "2", "--exposure", "auto"],
    );
    assert!(film["exposure"].as_f64().unwrap() < -4.0, "{film}");
}

/// A model that stands on the axis that is not usual is turned with a word about it, and no warning.
#[test]
fn models_that_evidently_stand_are_turned_with_a_note() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("y.obj"), boxes(&COW, |p| p)).unwrap();
    fs::write(folder.join("z.obj"), boxes(&COW, |[x, y, z]| [x, -z, y])).unwrap();
    let note = "+z of the file is up by the shape of the model; --up +y has it as usual in its format\n";
    let said = |args: &[&str]| {
        let all = [&["render"], args, &["--size", "48x40", "-o", "out.png"]].concat();
        let out = overcoat(folder, &all);
        assert!(out.status.success(), "{out:?}");
        stderr(&out)
    };
    assert_eq!(said(&["z.obj"]), note);
    for silent in [&["z.obj", "--up", "+y"][..], &["z.obj", "--up", "+z"], &["z.obj", "--quiet"], &["y.obj"]]
    {
        assert_eq!(said(silent), "", "{silent:?}");
    }
    let found = render(folder, &["z.obj"]);
    let given = render(folder, &["z.obj", "--up", "+z"]);
    assert_eq!((&found["up_axis"], &found["up_is_by_shape"]), (&json!("+z"), &json!(true)));
    assert_eq!((&given["up_is_by_shape"], &found["warnings"]), (&json!(false), &json!([])));
    assert_eq!(found["frame_hash"], given["frame_hash"]);
    assert_eq!(found["frame_hash"], render(folder, &["y.obj"])["frame_hash"]);
    let info = |args: &[&str]| String::from_utf8(overcoat(folder, args).stdout).unwrap();
    let text = info(&["info", "z.obj"]);
    assert!(text.contains("+z of the file is up by the shape of the model, -y its front"), "{text}");
    assert!(info(&["info", "z.obj", "--up", "y"]).contains("+y of the file is up, +z its front"));
    let [by_shape, as_usual] = ["z.obj", "y.obj"].map(|file| report(folder, &["info", file]));
    assert_eq!((&by_shape["up_is_by_shape"], &as_usual["up_is_by_shape"]), (&json!(true), &json!(false)));
}
