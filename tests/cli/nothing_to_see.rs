//! Pictures of nothing and of hardly anything.

use super::*;

#[test]
fn a_picture_of_nothing_is_a_failure() {
    let folder = folder();
    fs::write(folder.path().join("flat.obj"), "v 0 0 0\nv 1 0 0\nf 1 1 2\n").unwrap();
    let mut clear = quad();
    clear["materials"][0]["alphaMode"] = "BLEND".into();
    clear["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = json!([1, 1, 1, 0]);
    fs::write(folder.path().join("clear.glb"), glb(&clear, &quad_buffer())).unwrap();
    let mut nothing = quad();
    nothing["nodes"] = json!([{}, {}]);
    nothing["meshes"] = json!([]);
    fs::write(folder.path().join("nothing.glb"), glb(&nothing, &quad_buffer())).unwrap();
    let before = names(folder.path());
    for (line, reason) in [
        ("render flat.obj", "have no area"),
        ("render clear.glb", "transparent all over"),
        ("render clear.glb --background env", "transparent all over"),
        ("render nothing.glb", "no triangles"),
        ("render quad.glb --eye 0,0,5 --target 0,0,9", "behind the camera; --view"),
        ("render quad.glb --eye 0,0,5 --target 9,0,5", "beside the picture; --view"),
        ("render quad.glb --eye 0,0,-5", "seen from behind; --view"),
        ("render quad.glb --eye 0,0,90000", "smaller than a pixel; --eye"),
        ("turntable clear.glb --frames 3", "transparent all over"),
        ("animate nothing.glb --animation 0", "no triangles"),
        ("compare-models clear.glb --models gltf,three", "transparent all over"),
        ("diff quad.glb clear.glb", "transparent all over"),
    ] {
        let mut args: Vec<&str> = line.split(' ').collect();
        let animated = args[0] == "animate";
        if animated {
            nothing["animations"] = json!([{"channels": [], "samplers": []}]);
            fs::write(folder.path().join("nothing.glb"), glb(&nothing, &quad_buffer())).unwrap();
        }
        args.extend(["-o", "out.png", "--size", "24"]);
        let output = overcoat(folder.path(), &args);
        let message = stderr(&output);
        let last = message.lines().last().unwrap_or_default();
        assert_eq!(output.status.code(), Some(1), "{line}: {message}");
        assert!(last.contains("nothing to see: ") && last.contains(reason), "{line}: {message}");
        assert_eq!(names(folder.path()), before, "{line}");
        args.push("--allow-empty");
        let output = overcoat(folder.path(), &args);
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(0), "{line}: {message}");
        assert!(message.contains("warning: nothing to see: "), "{line}: {message}");
        fs::remove_file(folder.path().join("out.png")).unwrap();
    }
    let bench = overcoat(folder.path(), &["bench", "clear.glb", "--frames", "1", "--size", "24"]);
    assert_eq!(bench.status.code(), Some(1), "{}", stderr(&bench));
    // Every cell of a sheet must have something to see.
    let sheet = ["sheet", "quad.glb", "flat.obj", "-o", "out.png", "--size", "24", "--json"];
    let output = overcoat(folder.path(), &sheet);
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains("1 of 2"), "{}", stderr(&output));
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(report["cells"][1]["error"].as_str().unwrap().contains("nothing to see"), "{report}");
    let allowed = overcoat(folder.path(), &[&sheet[..], &["--allow-empty"]].concat());
    assert_eq!(allowed.status.code(), Some(0), "{}", stderr(&allowed));
}

#[test]
fn hardly_anything_to_see_is_a_warning_that_helps() {
    let folder = folder();
    let far = ["render", "quad.glb", "-o", "out.png", "--size", "64", "--eye", "0,0,200"];
    let message = stderr(&overcoat(folder.path(), &far));
    assert!(message.contains("hardly anything to see") && message.contains("--view"), "{message}");
    // A crowd of triangles, and a stray one.
    let mut text = String::new();
    for k in 0..400 {
        let [x, y, z] = [k % 8, k / 8 % 8, k / 64].map(|v| f64::from(v) * 0.25);
        text += &format!("v {x} {y} {z}\nv {} {y} {z}\nv {x} {} {z}\nf -3 -2 -1\n", x + 0.2, y + 0.2);
    }
    text += "v 70 0 0\nv 71 0 0\nv 70 1 0\nf -3 -2 -1\n";
    fs::write(folder.path().join("stray.obj"), text).unwrap();
    let draw = |more: &[&str]| {
        let args = [&["render", "stray.obj", "-o", "out.png", "--size", "128"], more].concat();
        let message = stderr(&overcoat(folder.path(), &args));
        let (_, _, pixels) = read_png(&fs::read(folder.path().join("out.png")).unwrap());
        (message, pixels.chunks(4).filter(|p| p[3] > 0).count())
    };
    // The crowd is framed, and the warning says from where all can be seen; from there, what helps.
    let (message, covered) = draw(&[]);
    assert!(message.contains("1 of 401 triangles are far from all others"), "{message}");
    assert!(covered > 128 * 128 / 8, "{covered} pixels");
    let place = |message: &str| -> [String; 4] {
        let words: Vec<&str> = message.split_whitespace().collect();
        let at = words.iter().position(|w| *w == "--eye").unwrap();
        std::array::from_fn(|k| words[at + k].to_owned())
    };
    let place_of_all = place(&message);
    let (message, covered) = draw(&place_of_all.each_ref().map(String::as_str));
    assert!(message.contains("all but 1 of 401 triangles are within"), "{message}");
    assert!(covered > 0 && covered < 128 * 128 / 50, "{covered} pixels");
    let closer = place(&message);
    let (message, covered) = draw(&closer.each_ref().map(String::as_str));
    assert_eq!(message, "");
    assert!(covered > 128 * 128 / 8, "{covered} pixels");
}

/// Points are discs, which a frame does not cut, and a few of them far away do not make the others a speck.
#[test]
fn clouds_fill_the_picture_and_stay_within_it() {
    let folder = folder();
    let lattice: Vec<[f64; 3]> = (0..400).map(|k| [f64::from(k % 20), f64::from(k / 20), 0.0]).collect();
    let strays: Vec<[f64; 3]> =
        (0..3).map(f64::from).map(|k| [900.0 * k, 700.0 - 800.0 * k, 600.0]).collect();
    let ply = |points: &[[f64; 3]]| {
        let lines: String = points.iter().map(|[x, y, z]| format!("{x} {y} {z}\n")).collect();
        format!(
            "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
             end_header\n{lines}",
            points.len()
        )
    };
    fs::write(folder.path().join("cloud.ply"), ply(&lattice)).unwrap();
    fs::write(folder.path().join("strays.ply"), ply(&[&lattice[..], &strays].concat())).unwrap();
    let warning = "3 of 403 points are far from all others";
    for (file, warns) in [("cloud.ply", false), ("strays.ply", true)] {
        let output = overcoat(folder.path(), &["render", file, "-o", "out.png", "--size", "96"]);
        let message = stderr(&output);
        assert_eq!(message.matches(warning).count(), usize::from(warns), "{message}");
        let (width, height, pixels) = read_png(&fs::read(folder.path().join("out.png")).unwrap());
        let alpha = |x: u32, y: u32| pixels[(4 * (y * width + x) + 3) as usize];
        let border = (0..width).flat_map(|k| [[k, 0], [k, height - 1], [0, k], [width - 1, k]]);
        assert!(border.into_iter().all(|[x, y]| alpha(x, y) == 0), "{file}");
        let covered = pixels.chunks(4).filter(|p| p[3] > 0).count();
        assert!(covered > 96 * 96 / 2, "{file}: {covered} pixels");
    }
    let turn = ["turntable", "strays.ply", "-o", "turn.png", "--frames", "2", "--size", "32"];
    let message = stderr(&overcoat(folder.path(), &turn));
    assert_eq!(message.matches(warning).count(), 1, "{message}");
}
