//! `overcoat golden` as its users meet it: folders of pictures, whoever made them.
#![cfg(feature = "cli")]

use overcoat::golden::Picture;
use overcoat::golden::decode::DecodedPicture;
use overcoat::limits::Limits;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A folder with the folders `expected` and `actual`.
struct Folders(tempfile::TempDir);

struct Output {
    code: i32,
    stdout: String,
    stderr: String,
}

impl Folders {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        for name in ["expected", "actual"] {
            std::fs::create_dir(folder.path().join(name)).unwrap();
        }
        Self(folder)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        std::fs::create_dir_all(self.path(name).parent().unwrap()).unwrap();
        std::fs::write(self.path(name), bytes).unwrap();
    }

    /// `overcoat golden <command> expected actual <arguments>`.
    fn run(&self, command: &str, arguments: &[&str]) -> Output {
        let done = Command::new(env!("CARGO_BIN_EXE_overcoat"))
            .args(["golden", command, "expected", "actual"])
            .args(arguments)
            .current_dir(self.0.path())
            .output()
            .unwrap();
        let text = |bytes| String::from_utf8(bytes).unwrap();
        Output { code: done.status.code().unwrap(), stdout: text(done.stdout), stderr: text(done.stderr) }
    }

    /// Verdicts and reasons by name from `--json -`.
    fn verdicts(&self, arguments: &[&str]) -> (i32, Vec<(String, String, String)>) {
        let output = self.run("check", &[arguments, &["--json", "-"]].concat());
        let json: serde_json::Value = serde_json::from_str(&output.stdout)
            .unwrap_or_else(|e| panic!("{e}: {} {}", output.stdout, output.stderr));
        let text = |v: &serde_json::Value| v.as_str().unwrap().to_owned();
        let files = json["files"].as_array().unwrap().iter().map(|file| {
            let reasons: Vec<String> = file["reasons"].as_array().unwrap().iter().map(text).collect();
            (text(&file["name"]), text(&file["verdict"]), reasons.join("; "))
        });
        (output.code, files.collect())
    }
}

/// A shaded disc on a transparent ground, `step` codes brighter than usual in one quarter.
fn disc(step: u8) -> Picture {
    const SIDE: u32 = 48;
    let pixels = (0..SIDE * SIDE)
        .map(|k| {
            let (x, y) = (k % SIDE, k / SIDE);
            let (dx, dy) = (x as i32 - 24, y as i32 - 24);
            let inside = dx * dx + dy * dy < 400;
            let added = if x > 24 && y > 24 { step } else { 0 };
            if inside { [(3 * x) as u8 + added, (4 * y) as u8, 90, 255] } else { [0; 4] }
        })
        .collect();
    Picture { width: SIDE, height: SIDE, pixels }
}

fn png(picture: &Picture) -> Vec<u8> {
    picture.to_png().unwrap()
}

fn decode(path: &Path) -> DecodedPicture {
    DecodedPicture::open(path, &Limits::default()).unwrap()
}

#[test]
fn equal_folders_pass_and_different_ones_have_exit_code_4() {
    let folders = Folders::new();
    for side in ["expected", "actual"] {
        folders.write(&format!("{side}/deep/same.png"), png(&disc(0)));
    }
    let output = folders.run("check", &[]);
    assert_eq!((output.code, output.stderr.as_str()), (0, ""));
    assert_eq!(output.stdout, "1 file: 1 equal\n");

    folders.write("expected/other.png", png(&disc(0)));
    folders.write("actual/other.png", png(&disc(2)));
    let output = folders.run("check", &[]);
    assert_eq!(output.code, 4, "{}", output.stderr);
    assert!(output.stdout.contains("differs    other.png"), "{}", output.stdout);
    assert!(output.stdout.contains("pixels differ by up to 2"), "{}", output.stdout);
    assert_eq!(output.stderr, "overcoat: 1 of 2 differ\n");

    folders.write("expected/thresholds.toml", "[\"other.*\"]\nmax_abs = 2\n");
    let output = folders.run("check", &[]);
    assert_eq!(output.code, 0, "{}", output.stdout);
    assert!(output.stdout.contains("within     other.png"), "{}", output.stdout);
    folders.write("looser.toml", "flip_mean = 0.5\npsnr = 90");
    assert_eq!(folders.run("check", &["--thresholds", "looser.toml"]).code, 4);
    assert_eq!(folders.run("check", &["--quiet"]).stdout, "");
}

#[test]
fn whatever_is_wrong_with_one_file_the_rest_is_compared() {
    let folders = Folders::new();
    let good = png(&disc(0));
    for side in ["expected", "actual"] {
        folders.write(&format!("{side}/z-good.png"), &good);
    }
    folders.write("expected/cut.png", &good);
    folders.write("actual/cut.png", &good[..good.len() / 2]);
    folders.write("expected/text.exr", "not a picture");
    folders.write("actual/text.exr", "not a picture");
    folders.write("expected/gone.png", &good);
    folders.write("actual/new.png", &good);
    folders.write("expected/size.png", png(&Picture { width: 2, height: 1, pixels: vec![[1; 4]; 2] }));
    folders.write("actual/size.png", &good);
    folders.write("expected/depth.png", &good);
    let mut deep = Vec::new();
    let mut encoder = png::Encoder::new(&mut deep, 48, 48);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Sixteen);
    let codes: Vec<u8> = disc(0).pixels.as_flattened().iter().flat_map(|&v| [v, v]).collect();
    encoder.write_header().unwrap().write_image_data(&codes).unwrap();
    folders.write("actual/depth.png", &deep);
    // A header that claims 2^31 x 2^31 pixels, with a checksum that fits.
    let mut huge = good.clone();
    huge[16..24].copy_from_slice(&[0x7f, 0xff, 0xff, 0xff, 0x7f, 0xff, 0xff, 0xff]);
    let crc = huge[12..29].iter().fold(u32::MAX, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |c, _| if c & 1 == 1 { c >> 1 ^ 0xedb8_8320 } else { c >> 1 })
    });
    huge[29..33].copy_from_slice(&(!crc).to_be_bytes());
    folders.write("expected/huge.png", &good);
    folders.write("actual/huge.png", &huge);
    folders.write("expected/thresholds.toml", "max_asb = 1\n");

    let (code, files) = folders.verdicts(&[]);
    assert_eq!(code, 1);
    let expected = [
        ("cut.png", "failed", "actual picture: PNG: "),
        ("depth.png", "differs", "expected 8 bits a channel, actual 16 bits"),
        ("gone.png", "dead", "no actual picture"),
        ("huge.png", "failed", "exceeds the limit of"),
        ("new.png", "missing", "no expected picture"),
        ("size.png", "differs", "expected 2 x 1 pixels, actual 48 x 48"),
        ("text.exr", "failed", "neither a PNG nor an OpenEXR"),
        ("z-good.png", "equal", ""),
        ("thresholds.toml:1", "failed", "unknown key 'max_asb'; did you mean 'max_abs'?"),
    ];
    assert_eq!(files.len(), expected.len(), "{files:?}");
    for ((name, verdict, reason), (wanted_name, wanted_verdict, words)) in files.iter().zip(expected) {
        assert!(name.ends_with(wanted_name) && verdict == wanted_verdict, "{name} {verdict} {reason}");
        assert!(reason.contains(words), "{name}: {reason}");
    }
}

#[test]
fn strict_checks_find_what_is_dead_or_oversized() {
    let folders = Folders::new();
    let picture = disc(0);
    let mut loose = Vec::new();
    let mut encoder = png::Encoder::new(&mut loose, 48, 48);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_compression(png::Compression::NoCompression);
    encoder.write_header().unwrap().write_image_data(picture.pixels.as_flattened()).unwrap();
    for side in ["expected", "actual"] {
        folders.write(&format!("{side}/loose.png"), &loose);
    }
    folders.write("expected/thresholds.toml", "\n[\"*.exr\"]\npsnr = 40\n");
    assert_eq!(folders.verdicts(&[]).0, 0);
    let (code, files) = folders.verdicts(&["--strict"]);
    assert_eq!(code, 1);
    assert_eq!((files[0].1.as_str(), files[1].1.as_str()), ("oversized", "dead"), "{files:?}");
    assert!(files[1].0.ends_with("thresholds.toml:2") && files[1].2.contains("'*.exr'"), "{files:?}");

    // Accepting it again stores it well; the pixels stay.
    let before = decode(&folders.path("expected/loose.png"));
    assert_eq!(folders.run("accept", &["--all"]).code, 0);
    assert_eq!(decode(&folders.path("expected/loose.png")), before);
    std::fs::remove_file(folders.path("expected/thresholds.toml")).unwrap();
    assert_eq!(folders.verdicts(&["--strict"]).0, 0);
    folders.write("expected/thresholds.toml", "max_bytes = 100\n");
    let (code, files) = folders.verdicts(&["--strict"]);
    assert_eq!((code, files[0].1.as_str()), (4, "oversized"));
}

#[test]
fn accepting_takes_what_is_named_and_nothing_else() {
    let folders = Folders::new();
    for (name, step) in [("a.png", 3), ("b.png", 4), ("cars/c.png", 5)] {
        folders.write(&format!("expected/{name}"), png(&disc(0)));
        folders.write(&format!("actual/{name}"), png(&disc(step)));
    }
    folders.write("actual/cars/new.new.png", png(&disc(6)));
    let old = std::fs::read(folders.path("expected/a.png")).unwrap();

    let dry = folders.run("accept", &["--all", "--dry-run"]);
    assert_eq!((dry.code, dry.stdout.matches("would accept").count()), (0, 4), "{}", dry.stdout);
    assert_eq!(std::fs::read(folders.path("expected/a.png")).unwrap(), old);

    let named = folders.run("accept", &["b.png", "cars/*", "nobody.png"]);
    assert_eq!(named.code, 1, "{}", named.stderr);
    assert!(named.stderr.contains("nobody.png: no picture of that name"), "{}", named.stderr);
    assert_eq!(std::fs::read(folders.path("expected/a.png")).unwrap(), old);
    for name in ["b.png", "cars/c.png"] {
        let [stored, actual] = ["expected", "actual"].map(|side| folders.path(&format!("{side}/{name}")));
        assert_eq!(decode(&stored), decode(&actual));
        assert!(stored.metadata().unwrap().len() <= actual.metadata().unwrap().len());
    }
    // What a failed test had left has become the expected picture.
    assert!(folders.path("expected/cars/new.png").exists());
    assert!(!folders.path("actual/cars/new.new.png").exists());
    assert_eq!(folders.run("accept", &[]).code, 2);
}

#[test]
fn results_are_written_for_machines() {
    let folders = Folders::new();
    folders.write("expected/a.png", png(&disc(0)));
    folders.write("actual/a.png", png(&disc(9)));
    let output = folders.run("report", &["-o", "page.html", "--json", "r.json", "--junit", "r.xml"]);
    assert_eq!(output.code, 4);
    let json: serde_json::Value =
        serde_json::from_slice(&std::fs::read(folders.path("r.json")).unwrap()).unwrap();
    let metrics = &json["files"][0]["metrics"];
    assert_eq!(metrics["max_abs"], 9.0);
    assert!(metrics["flip_mean"].as_f64().unwrap() > 0.0 && metrics["ssim"].as_f64().unwrap() < 1.0);
    let xml = std::fs::read_to_string(folders.path("r.xml")).unwrap();
    assert!(xml.contains("failures=\"1\"") && xml.contains("name=\"a.png\""), "{xml}");
    let page = std::fs::read_to_string(folders.path("page.html")).unwrap();
    assert!(page.contains("\"name\":\"a.png\"") && page.matches("data:image/png;base64,").count() == 4);
    assert!(!page.contains("http:") && !page.contains("https:"));

    // Results do not depend on threads.
    let one = folders.run("check", &["--json", "-", "--threads", "1"]).stdout;
    assert_eq!(one, folders.run("check", &["--json", "-", "--threads", "4"]).stdout);
}

#[test]
fn command_lines_that_make_no_sense_have_exit_code_2() {
    let folders = Folders::new();
    let empty = folders.run("check", &[]);
    assert_eq!(empty.code, 1, "{}", empty.stderr);
    assert!(empty.stderr.contains("no .png, .exr or .hdr file"), "{}", empty.stderr);
    for arguments in [
        &["--json", "-", "--junit", "-"][..],
        &["--pixels-per-degree", "0"],
        &["--background", "blue"],
        &["--limit", "nothing=1"],
        &["--unknown"],
    ] {
        let output = folders.run("check", arguments);
        assert_eq!((output.code, output.stderr.lines().count()), (2, 1), "{arguments:?}: {}", output.stderr);
    }
    assert_eq!(folders.run("check", &["--thresholds", "none.toml"]).code, 1);
    assert_eq!(folders.run("check", &["--json", "no/such/folder.json"]).code, 1);
}
