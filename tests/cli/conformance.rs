//! `overcoat conformance`: what is in the pack, that it is true, what `score.py` says of it, and what is refused.

use super::{names, overcoat, stderr};
use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, Layer, LayerAttributes,
    LineOrder, WritableImage, f16, read_all_flat_layers_from_file,
};
use overcoat_core::math::double::{atan2, tan};
use overcoat_lab::lab::{Base, Light, Referee, Specimen};
use overcoat_lab::truth::Samples;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A coat over matt grey, as in the pack.
const MATT: Specimen = Specimen {
    coat: 1.0,
    coat_roughness: 0.0,
    coat_ior: 1.5,
    thickness: 0.0,
    extinction: [0.0; 3],
    base_roughness: 0.5,
    metal: false,
    base: Base::Convention,
    base_ior: 1.5,
    color: [0.18; 3],
    specular: 0.0,
};

type Planes = BTreeMap<String, Vec<f32>>;

fn read(path: &Path) -> Planes {
    let image = read_all_flat_layers_from_file(path).unwrap();
    let list = image.layer_data[0].channel_data.list.iter();
    list.map(|c| (c.name.to_string(), c.sample_data.values_as_f32().collect())).collect()
}

fn write(path: &Path, side: usize, planes: &Planes) {
    let channel = |(name, values): (&String, &Vec<f32>)| {
        AnyChannel::new(name.as_str(), FlatSamples::F32(values.clone()))
    };
    let channels = AnyChannels::sort(planes.iter().map(channel).collect());
    let layer = Layer::new((side, side), LayerAttributes::default(), Encoding::UNCOMPRESSED, channels);
    Image::from_layer(layer).write().to_file(path).unwrap();
}

/// Makes a pack of some scenes.
fn pack(folder: &Path, name: &str, extra: &[&str]) -> PathBuf {
    let output = overcoat(folder, &[&["conformance", name], extra].concat());
    assert!(output.status.success(), "{}", stderr(&output));
    folder.join(name)
}

/// All files below a folder.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    for name in names(folder) {
        let path = folder.join(&name);
        if path.is_dir() {
            found.extend(files(&path).into_iter().map(|(below, bytes)| (format!("{name}/{below}"), bytes)));
        } else {
            found.insert(name, fs::read(path).unwrap());
        }
    }
    found
}

/// The ray through a place of the picture and where it meets the ball: normal and view.
fn hit(side: usize, x: f64, y: f64) -> [[f64; 3]; 2] {
    let half = tan(12.5_f64.to_radians());
    let across = |c: f64| (2.0 * c / side as f64 - 1.0) * half;
    let d = [across(x), -across(y), -1.0];
    // |(0, 0, 5) + t d| = 1
    let (a, b, c) = (d.iter().map(|c| c * c).sum::<f64>(), 5.0 * d[2], 24.0);
    let t = (-b - (b * b - a * c).sqrt()) / a;
    let view = d.map(|c| -c / a.sqrt());
    [[t * d[0], t * d[1], 5.0 + t * d[2]], view]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| a[k] * b[k]).sum()
}

const LAMP: [f64; 3] = [2.0 / 3.0, 1.0 / 3.0, 2.0 / 3.0];

#[test]
fn a_pack_is_whole_and_has_the_same_bytes_again() {
    let work = tempfile::tempdir().unwrap();
    let few =
        ["--size", "32", "--samples", "32", "--scenes", "coat-half-lamp,furnace", "--models", "three,gltf"];
    let a = pack(work.path(), "a", &[&few[..], &["--threads", "1"]].concat());
    // An empty folder is as good as none.
    fs::create_dir(work.path().join("b")).unwrap();
    let output =
        overcoat(work.path(), &[&["conformance", "b", "--json", "--threads", "3"], &few[..]].concat());
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&report["pack"], &report["scores"][0]["scene"]), (&"1.1".into(), &"furnace".into()));
    assert_eq!(
        (&report["scores"][0]["passes"], &report["scores"][2]["passes"]),
        (&true.into(), &false.into())
    );
    let (a, b) = (files(&a), files(&work.path().join("b")));
    assert_eq!(names(work.path()), ["a", "b"]);
    assert!(a == b, "other threads, other bytes");
    let expected = [
        "LICENSE",
        "README.md",
        "VERSION",
        "aov.exr",
        "engines/gltf/coat-half-lamp.exr",
        "engines/gltf/furnace.exr",
        "engines/scores.tsv",
        "engines/three/coat-half-lamp.exr",
        "engines/three/furnace.exr",
        "environments/box.exr",
        "environments/gradient.exr",
        "environments/white.exr",
        "scenes.tsv",
        "scenes/ball.bin",
        "scenes/coat-half-lamp.gltf",
        "scenes/coat-half-lamp.json",
        "scenes/furnace.gltf",
        "scenes/furnace.json",
        "score.py",
        "truth/coat-half-lamp.exr",
        "truth/furnace.exr",
    ];
    assert_eq!(a.keys().collect::<Vec<_>>(), expected);
    assert_eq!(report["files"], expected.len());
    let text = |name: &str| String::from_utf8(a[name].clone()).unwrap();
    assert!(text("LICENSE").contains("SPDX-License-Identifier: CC0-1.0"));
    assert!(text("VERSION").starts_with("overcoat conformance pack 1.1\n"));
    assert!(text("README.md").starts_with("# Conformance pack 1.1 "));
    // Parameters that are missing in the description of a scene could not be drawn by others.
    let scene: serde_json::Value = serde_json::from_str(&text("scenes/coat-half-lamp.json")).unwrap();
    assert_eq!(scene["surfaces"][0]["share"], 0.5);
    assert_eq!(scene["surfaces"][0]["layers"][0]["index"], 1.5);
    assert_eq!(scene["surfaces"][1]["layers"][0]["kind"], "lambert");
    // Another seed is another truth.
    let other = pack(work.path(), "c", &[&few[..], &["--seed", "1"]].concat());
    let other = files(&other);
    assert!(other["truth/coat-half-lamp.exr"] != a["truth/coat-half-lamp.exr"]);
    assert!(other["truth/furnace.exr"] == a["truth/furnace.exr"], "which has no variance");
}

/// The truth of a pack is that of closed forms where there are any, else that of the library's referee.
#[test]
fn the_truth_is_true() {
    const SIDE: usize = 48;
    let work = tempfile::tempdir().unwrap();
    let scenes = "furnace,matt-gradient,matt-lamp,coat-matt-white,coat-rough-lamp";
    let folder =
        pack(work.path(), "p", &["--size", "48", "--samples", "512", "--scenes", scenes, "--models", "gltf"]);
    let aov = read(&folder.join("aov.exr"));
    let truth = |name: &str| read(&folder.join(format!("truth/{name}.exr")));
    let [furnace, gradient, lamp, white, rough] =
        ["furnace", "matt-gradient", "matt-lamp", "coat-matt-white", "coat-rough-lamp"].map(truth);
    let at = |planes: &Planes, name: String, k: usize| f64::from(planes[&name][k]);
    let coated = Specimen { coat_roughness: 0.5, color: [0.8, 0.4, 0.2], ..MATT };
    let (matt, coated) = (Referee::new(&MATT).unwrap(), coated.stack(true).unwrap());
    let (mut scored, mut referees) = (0, 0);
    for k in (0..SIDE * SIDE).filter(|&k| furnace["mask.Y"][k] == 1.0) {
        let [normal, view] = hit(SIDE, (k % SIDE) as f64 + 0.5, (k / SIDE) as f64 + 0.5);
        for (c, (axis, channel)) in ["X", "Y", "Z"].iter().zip(["R", "G", "B"]).enumerate() {
            assert!((at(&aov, format!("normal.{axis}"), k) - normal[c]).abs() < 1e-6);
            assert!((at(&aov, format!("position.{axis}"), k) - normal[c]).abs() < 1e-6);
            let close = |planes: &Planes, expected: f64| {
                let error = at(planes, format!("variance.{channel}"), k).sqrt();
                let found = at(planes, channel.to_owned(), k);
                let bound = 6.0 * error + at(planes, format!("footprint.{channel}"), k) + 1e-6;
                assert!((found - expected).abs() <= bound, "{found} at {k} is not {expected} +- {error}");
            };
            close(&furnace, 1.0);
            // The cosine's part of a linear radiance is two thirds of its slope.
            close(&gradient, 0.8 * (0.5 + 0.4 * normal[c] * 2.0 / 3.0));
            let cosine = dot(normal, LAMP);
            if lamp["mask.Y"][k] == 1.0 {
                // Which is the middle of the pixel, so that all that is allowed is needed near the edge.
                let bound = at(&lamp, format!("tolerance.{channel}"), k);
                let off = at(&lamp, channel.to_owned(), k) - [0.8, 0.5, 0.2][c] * cosine.max(0.0);
                assert!(off.abs() <= bound, "{off} at {k} is more than {bound}");
            }
            // These take their time.
            if k % 97 == 0 {
                referees += 1;
                let samples = Samples { first: 0, count: 8192, seed: 7 };
                let up = dot(normal, view);
                let degrees = atan2((1.0 - up * up).sqrt(), up).to_degrees();
                close(&white, matt.radiance(degrees, Light::White, &samples).unwrap().mean()[c]);
                if lamp["mask.Y"][k] == 1.0 && cosine > 0.0 {
                    let wo = [(1.0 - up * up).sqrt(), 0.0, up];
                    let x = (dot(view, LAMP) - up * cosine) / wo[0];
                    let wi = [x, (1.0 - x * x - cosine * cosine).max(0.0).sqrt(), cosine];
                    let found = coated.evaluate(wo, wi, &samples).unwrap().total;
                    // Two thirds of a percent are its own noise.
                    let expected = std::f64::consts::PI * found.mean()[c];
                    let error = at(&rough, format!("variance.{channel}"), k).sqrt();
                    let bound = 6.0 * error + at(&rough, format!("footprint.{channel}"), k) + 0.04 * expected;
                    assert!((at(&rough, channel.to_owned(), k) - expected).abs() <= bound);
                }
            }
        }
        assert!((at(&aov, "depth.Z".to_owned(), k) - (5.0 - normal[2])).abs() < 1e-6);
        assert_eq!(aov["coverage.Y"][k], 1.0);
        scored += 1;
    }
    // Two pixels at the edge of the ball, of pi 22^2 pixels, are left out.
    assert!((1100..1400).contains(&scored) && referees > 20, "{scored} {referees}");
    let covered: f32 = aov["coverage.Y"].iter().sum();
    assert!((covered / (std::f32::consts::PI * 22.097 * 22.097) - 1.0).abs() < 0.002, "{covered}");
}

/// The glTF files say the same scenes.
#[test]
fn the_gltf_files_are_the_scenes() {
    let work = tempfile::tempdir().unwrap();
    let scenes = ["matt-lamp", "coat-half-lamp", "coat-plastic-box"];
    let folder = pack(
        work.path(),
        "p",
        &["--size", "64", "--samples", "32", "--scenes", &scenes.join(","), "--models", "gltf"],
    );
    for name in scenes {
        let environment = if name.ends_with("lamp") { "none" } else { "p/environments/box.exr" };
        let input = format!("p/scenes/{name}.gltf");
        let args = [
            &["render", &input, "-o", "x.exr", "--size", "64", "--shading", "gltf"][..],
            &[
                "--camera",
                "camera",
                "--env",
                environment,
                "--samples",
                "4",
                "--quality",
                "draft",
                "--ground",
                "none",
            ],
        ]
        .concat();
        let output = overcoat(work.path(), &args);
        assert!(output.status.success(), "{}", stderr(&output));
        let (loaded, built) =
            (read(&work.path().join("x.exr")), read(&folder.join(format!("engines/gltf/{name}.exr"))));
        let mask = &read(&folder.join(format!("truth/{name}.exr")))["mask.Y"];
        for channel in ["R", "G", "B"] {
            for k in (0..mask.len()).filter(|&k| mask[k] == 1.0) {
                let (a, b) = (loaded[channel][k], built[channel][k]);
                assert!((a - b).abs() <= 0.002 * b + 1e-4, "{name}: {a} is not {b}");
            }
        }
    }
}

/// Plastic by engines' convention and plastic of the coat's index: the same parameters but for the name of the base, the lobe less in
/// the layers, and darker.
#[test]
fn scenes_of_plastic_name_their_base() {
    let work = tempfile::tempdir().unwrap();
    let scenes = "coat-plastic-gradient,coat-interface-gradient,coat-metal-lamp,matt-lamp";
    let folder =
        pack(work.path(), "p", &["--size", "32", "--samples", "256", "--scenes", scenes, "--models", "gltf"]);
    let read = |name: &str| -> serde_json::Value {
        serde_json::from_slice(&fs::read(folder.join(format!("scenes/{name}.json"))).unwrap()).unwrap()
    };
    let base = |scene: &serde_json::Value| scene["parameters"]["base"].as_str().unwrap().to_owned();
    let kinds = |scene: &serde_json::Value| -> Vec<String> {
        let layers = scene["surfaces"][0]["layers"].as_array().unwrap();
        layers.iter().map(|layer| layer["kind"].as_str().unwrap().to_owned()).collect()
    };
    let (mut convention, mut interface) = (read("coat-plastic-gradient"), read("coat-interface-gradient"));
    assert_eq!([base(&convention), base(&interface)], ["convention", "interface"]);
    assert_eq!([base(&read("coat-metal-lamp")), base(&read("matt-lamp"))], ["metal", "lambert"]);
    let coat = ["dielectric_interface", "absorbing_medium"];
    assert_eq!(kinds(&convention), [coat[0], coat[1], "dielectric_interface", "lambert"]);
    assert_eq!(kinds(&interface), [coat[0], coat[1], "lambert"]);
    for scene in [&mut convention, &mut interface] {
        scene["parameters"]["base"] = "any".into();
    }
    assert_eq!(convention["parameters"], interface["parameters"]);
    let mean =
        |name: &str| -> f32 { self::read(&folder.join(format!("truth/{name}.exr")))["G"].iter().sum() };
    let [interface, convention] = ["coat-interface-gradient", "coat-plastic-gradient"].map(mean);
    assert!(interface < 0.97 * convention, "{interface} {convention}");
}

/// Python, if there is one.
fn score(arguments: &[&str], folder: &Path) -> Option<Output> {
    match Command::new("python3").args(arguments).current_dir(folder).output() {
        Ok(output) => Some(output),
        Err(_) => {
            eprintln!("skipped: there is no python3");
            None
        }
    }
}

fn rows(text: &str) -> Vec<Vec<&str>> {
    text.lines().skip(1).map(|line| line.split('\t').collect()).collect()
}

#[test]
fn the_script_passes_what_is_right_and_fails_what_is_too_bright() {
    const SIDE: usize = 48;
    let work = tempfile::tempdir().unwrap();
    let few =
        ["--size", "48", "--samples", "256", "--scenes", "furnace,coat-matt-white,matt-lamp,coat-half-lamp"];
    let a = pack(work.path(), "a", &[&few[..], &["--models", "three,stacklit-d"]].concat());
    // Another run of the referee is a path tracer: right, with noise of its own that it states.
    let right = pack(work.path(), "b", &[&few[..], &["--seed", "1", "--models", "three"]].concat());
    let bright = work.path().join("bright");
    fs::create_dir(&bright).unwrap();
    for name in names(&right.join("truth")) {
        let mut planes = read(&right.join("truth").join(&name));
        for channel in ["R", "G", "B"] {
            planes.get_mut(channel).unwrap().iter_mut().for_each(|v| *v *= 1.02);
        }
        write(&bright.join(&name), SIDE, &planes);
    }
    fs::copy(a.join("aov.exr"), bright.join("aov.exr")).unwrap();
    let Some(output) = score(&["a/score.py", "b/truth", "-o", "page.html", "--name", "<right>"], work.path())
    else {
        return;
    };
    let text = String::from_utf8(output.stdout.clone()).unwrap();
    assert_eq!(output.status.code(), Some(0), "{text}{}", stderr(&output));
    assert_eq!(text.lines().filter(|line| line.starts_with("pass")).count(), 4, "{text}");
    let page = fs::read_to_string(work.path().join("page.html")).unwrap();
    assert!(
        page.contains("&lt;right&gt;: 4 of 4 scenes pass") && page.matches("data:image/png").count() == 16
    );
    assert!(!page.contains("http"), "the page needs nothing else");

    let output = score(&["a/score.py", "bright"], work.path()).unwrap();
    let text = String::from_utf8(output.stdout.clone()).unwrap();
    assert_eq!(output.status.code(), Some(1), "{text}{}", stderr(&output));
    assert_eq!(text.lines().filter(|line| line.starts_with("FAIL")).count(), 4, "{text}");
    assert_eq!(text.lines().filter(|line| line.starts_with("pass")).count(), 3, "planes are right: {text}");
    let output = score(&["a/score.py", "bright", "--allow", "0.03"], work.path()).unwrap();
    assert_eq!(output.status.code(), Some(0));

    // The program and the script have the same rules and the same FLIP.
    let known = fs::read_to_string(a.join("engines/scores.tsv")).unwrap();
    for model in ["three", "stacklit-d"] {
        let folder = format!("a/engines/{model}");
        assert!(score(&["a/score.py", &folder, "--tsv", "s.tsv"], work.path()).unwrap().stderr.is_empty());
        let found = fs::read_to_string(work.path().join("s.tsv")).unwrap();
        let known: Vec<Vec<&str>> = rows(&known).into_iter().filter(|row| row[0] == model).collect();
        assert_eq!((rows(&found).len(), known.len()), (4, 4));
        for (found, known) in rows(&found).iter().zip(&known) {
            assert_eq!((found[0], found[1], found.len()), (known[1], known[2], known.len() - 1));
            assert_eq!(found[12..], known[13..], "there is one truth without --one-bounce");
            for (a, b) in found[2..12].iter().zip(&known[3..13]) {
                let (a, b): (f64, f64) = (a.parse().unwrap(), b.parse().unwrap());
                assert!((a - b).abs() <= 2e-5 * b.abs().max(1.0), "{model} {}: {a} is not {b}", found[0]);
            }
        }
    }
}

/// A renderer of one bounce fails by the truth of all bounces and passes by that of one; the verdicts name both.
#[test]
fn renderers_of_one_bounce_have_a_truth_of_their_own() {
    let work = tempfile::tempdir().unwrap();
    let few =
        ["--size", "32", "--samples", "128", "--scenes", "matt-lamp,coat-rough-lamp", "--models", "three"];
    let a = pack(work.path(), "a", &[&few[..], &["--one-bounce"]].concat());
    let b = pack(work.path(), "b", &[&few[..], &["--one-bounce", "--seed", "1"]].concat());
    assert_eq!(names(&a.join("one-bounce")), ["coat-rough-lamp.exr"], "others have one truth");
    let known = fs::read_to_string(a.join("engines/scores.tsv")).unwrap();
    let known = rows(&known);
    assert_eq!((known[0][13], known[1][13]), ("-", "fail"), "{known:?}");
    fs::copy(b.join("truth/matt-lamp.exr"), b.join("one-bounce/matt-lamp.exr")).unwrap();
    let run = |folder: &str, extra: &[&str]| -> Option<(String, Option<i32>)> {
        let output = score(&[&["a/score.py", folder], extra].concat(), work.path())?;
        Some((String::from_utf8(output.stdout.clone()).unwrap(), output.status.code()))
    };
    let Some((text, code)) = run("b/one-bounce", &[]) else { return };
    let line = text.lines().find(|line| line.contains("coat-rough-lamp")).unwrap();
    assert!(line.starts_with("FAIL") && line.contains("too dark as a whole"), "{text}");
    assert!(line.contains("one bounce: pass") && code == Some(1), "{text}");
    assert_eq!(run("b/one-bounce", &["--one-bounce"]).unwrap().1, Some(0));
    let (text, code) = run("b/truth", &[]).unwrap();
    assert!(text.contains("one bounce: FAIL") && code == Some(0), "{text}");
    assert_eq!(run("b/truth", &["--one-bounce"]).unwrap().1, Some(1));
}

#[test]
fn the_script_says_what_it_cannot_score() {
    let work = tempfile::tempdir().unwrap();
    let few = ["--size", "32", "--samples", "32", "--scenes", "furnace", "--models", "three"];
    let a = pack(work.path(), "a", &few);
    let folder = work.path().join("mine");
    fs::create_dir(&folder).unwrap();
    let picture = folder.join("furnace.exr");
    let said = |extra: &[&str], words: &[&str], code: i32| {
        let arguments = [&["a/score.py", "mine", "-o", "page.html"], extra].concat();
        let Some(output) = score(&arguments, work.path()) else { return };
        let text = stderr(&output);
        assert_eq!(output.status.code(), Some(code), "{text}");
        assert!(words.iter().all(|word| text.contains(word)), "{words:?}: {text}");
        assert_eq!(work.path().join("page.html").exists(), code < 2, "no page of what cannot be scored");
        assert!(code < 2 || !text.contains("Traceback"), "{text}");
    };
    said(&[], &["furnace.exr: missing"], 2);
    said(&["--scenes", "furnac"], &["no scene furnac; there are furnace"], 2);
    said(&["--allow", "2"], &["--allow"], 2);
    let good = fs::read(a.join("engines/three/furnace.exr")).unwrap();
    fs::write(&picture, &good[..good.len() / 2]).unwrap();
    said(&[], &["furnace.exr: damaged"], 2);
    fs::write(&picture, b"\x89PNG\r\n\x1a\n").unwrap();
    said(&[], &["furnace.exr: expected OpenEXR or PFM"], 2);
    let plane = |value: f32, side: usize| vec![value; side * side];
    let mut planes: Planes = ["R", "G", "B"].map(|c| (c.to_owned(), plane(1.0, 16))).into();
    write(&picture, 16, &planes);
    said(&[], &["16 x 16 pixels; expected 32 x 32"], 2);
    planes.values_mut().for_each(|values| *values = plane(f32::NAN, 32));
    write(&picture, 32, &planes);
    said(&[], &["furnace.exr: R at", "is nan; expected finite"], 2);
    planes.values_mut().for_each(|values| *values = plane(1.0, 32));
    let blue = planes.remove("B").unwrap();
    write(&picture, 32, &planes);
    said(&[], &["expected channels R, G, B", "found G, R"], 2);
    // Rows from the bottom, big-endian: what is above 1 is above.
    fs::remove_file(&picture).unwrap();
    let mut pfm = b"PF\n32 32\n1.0\n".to_vec();
    for row in 0..32 {
        let value: f32 = if row < 16 { 1.0 } else { 1.5 };
        (0..96).for_each(|_| pfm.extend(value.to_be_bytes()));
    }
    fs::write(folder.join("furnace.pfm"), pfm).unwrap();
    said(&[], &[], 1);
    planes.insert("B".to_owned(), blue);
    write(&picture, 32, &planes);
    said(&[], &[], 0);
}

/// Compressions and tiles of other renderers, in sizes that are no multiple of anything, halves and floats: the script reads what
/// was written, and says so where a file is damaged.
#[test]
fn the_script_reads_piz_and_tiles() {
    const SIZE: [usize; 2] = [75, 53];
    let work = tempfile::tempdir().unwrap();
    let few = ["--size", "32", "--samples", "32", "--scenes", "furnace", "--models", "three"];
    let folder = pack(work.path(), "a", &few);
    // Few different values in large areas, so that what is compressed is smaller: else blocks are stored as they are.
    let value = |k: usize| (k % SIZE[0] / 9 + k / SIZE[0] / 7 * 2) as f32 * 0.25 - 1.0;
    let values: Vec<f32> = (0..SIZE[0] * SIZE[1]).map(value).collect();
    let halves = values.iter().map(|v| f16::from_f32(*v)).collect();
    let numbers = (0..values.len() as u32).map(|k| k / 500 * 0x1_0001).collect();
    let print = "import sys, score\np = score.read(sys.argv[1])\nprint(p.width, p.height)\n\
        for c in 'GIR': print(*p.channels[c])";
    let run = |path: &Path| {
        let path = path.to_str().unwrap();
        Command::new("python3").args(["-c", print, path]).env("PYTHONPATH", &folder).output()
    };
    for compression in [Compression::PIZ, Compression::PXR24, Compression::ZIP16, Compression::RLE] {
        for blocks in [Blocks::ScanLines, Blocks::Tiles(exr::math::Vec2(32, 20))] {
            let channels = AnyChannels::sort(
                vec![
                    AnyChannel::new("R", FlatSamples::F32(values.clone())),
                    AnyChannel::new("G", FlatSamples::F16(Vec::clone(&halves))),
                    AnyChannel::new("I", FlatSamples::U32(Vec::clone(&numbers))),
                ]
                .into(),
            );
            let encoding = Encoding { compression, blocks, line_order: LineOrder::Increasing };
            let layer = Layer::new((SIZE[0], SIZE[1]), LayerAttributes::default(), encoding, channels);
            let path = work.path().join("x.exr");
            Image::from_layer(layer).write().to_file(&path).unwrap();
            let bytes = fs::read(&path).unwrap();
            assert!(bytes.len() < 9 * values.len(), "{compression:?} {blocks:?}: {}", bytes.len());
            let Ok(output) = run(&path) else { return eprintln!("skipped: there is no python3") };
            let text = String::from_utf8(output.stdout.clone()).unwrap();
            let mut lines = text.lines();
            assert_eq!(lines.next(), Some("75 53"), "{compression:?} {blocks:?}: {}", stderr(&output));
            let floats: Vec<f64> = values.iter().map(|v| f64::from(*v)).collect();
            let integers: Vec<f64> = (0..values.len()).map(|k| (k / 500 * 0x1_0001) as f64).collect();
            for (channel, expected) in ["G", "I", "R"].into_iter().zip([&floats, &integers, &floats]) {
                let found: Vec<f64> = lines.next().unwrap().split(' ').map(|v| v.parse().unwrap()).collect();
                assert!(found == *expected, "{compression:?} {blocks:?} {channel}");
            }
            for cut in [bytes.len() / 3, bytes.len() - 9] {
                fs::write(&path, &bytes[..cut]).unwrap();
                let said = stderr(&run(&path).unwrap());
                assert!(said.contains("score.Wrong") && said.contains("damaged"), "{compression:?}: {said}");
            }
        }
    }
}

#[test]
fn what_is_there_is_left_alone() {
    let work = tempfile::tempdir().unwrap();
    fs::create_dir(work.path().join("full")).unwrap();
    fs::write(work.path().join("full/x"), b"mine").unwrap();
    fs::write(work.path().join("file"), b"mine").unwrap();
    for (args, code, said) in [
        (&["full"][..], 1, "full: cannot be made: it is there and not empty"),
        (&["file"], 1, "something is there that is no folder"),
        (&["none/pack"], 1, "none/pack: cannot be made: none: No such file"),
        (&["file/pack"], 1, "file is no folder"),
        (&[".."], 1, "it needs a name of its own"),
        (&["new", "--size", "31"], 2, "32 to 512"),
        (&["new", "--samples", "31"], 2, "32 to 1048576"),
        (&["new", "--scenes", "furnac"], 2, "no scene of the pack; did you mean 'furnace'?"),
        (&["new", "--models", "thre"], 2, "did you mean 'three'?"),
        (&[], 2, "FOLDER"),
    ] {
        let output = overcoat(work.path(), &[&["conformance"], args].concat());
        let text = stderr(&output);
        assert_eq!(output.status.code(), Some(code), "{args:?}: {text}");
        assert!(text.contains(said) && text.lines().count() == 1, "{args:?}: {text}");
    }
    assert_eq!(names(work.path()), ["file", "full"]);
    assert_eq!(names(&work.path().join("full")), ["x"]);
}

/// A pack that cannot be written completely leaves nothing behind, and an existing folder as it was.
#[cfg(unix)]
#[test]
fn a_pack_that_cannot_be_written_leaves_nothing() {
    let work = tempfile::tempdir().unwrap();
    fs::create_dir(work.path().join("there")).unwrap();
    for name in ["new", "there"] {
        // Blocks of 512 bytes: the ball is larger.
        let script = format!(
            "ulimit -f 1000; \"$0\" conformance {name} --size 32 --samples 32 --scenes furnace --models three"
        );
        let output = Command::new("sh")
            .args(["-c", &script, env!("CARGO_BIN_EXE_overcoat")])
            .current_dir(work.path())
            .output()
            .unwrap();
        let text = stderr(&output);
        assert_eq!(output.status.code(), Some(1), "{text}");
        assert!(
            text.contains("ball.bin: cannot be written: File too large") && text.lines().count() == 1,
            "{text}"
        );
        assert_eq!(names(work.path()), ["there"]);
        assert_eq!(names(&work.path().join("there")), [""; 0]);
    }
}
