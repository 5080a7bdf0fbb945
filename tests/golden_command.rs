//! `overcoat golden` as its users meet it: folders of pictures, whoever made them.

use overcoat::decode::DecodedPicture;
use overcoat::frame::DisplayImage;
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
fn disc(step: u8) -> DisplayImage {
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
    DisplayImage { width: SIDE, height: SIDE, pixels }
}

fn png(picture: &DisplayImage) -> Vec<u8> {
    overcoat::output::encode_png(picture).unwrap()
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
    folders.write("expected/size.png", png(&DisplayImage { width: 2, height: 1, pixels: vec![[1; 4]; 2] }));
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
        ("gone.png", "no_actual", "no actual picture"),
        ("huge.png", "failed", "exceeds the limit of"),
        ("new.png", "no_expected", "no expected picture"),
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
fn strict_checks_find_what_is_unused_or_oversized() {
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
    assert_eq!(code, 4);
    assert_eq!((files[0].1.as_str(), files[1].1.as_str()), ("oversized", "unused"), "{files:?}");
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
    // The picture left by a failed test has become the expected one.
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
    assert!(empty.stderr.contains("no picture in either folder (.png, .apng, .webp"), "{}", empty.stderr);
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

/// A picture that exists on one side only is a difference, and said so in words.
#[test]
fn what_is_missing_on_one_side_is_a_difference() {
    let folders = Folders::new();
    folders.write("expected/gone.png", png(&disc(0)));
    folders.write("actual/new.png", png(&disc(0)));
    for command in [&["check"][..], &["report", "-o", "page.html"]] {
        let output = folders.run(command[0], &command[1..]);
        assert_eq!(output.code, 4, "{}", output.stderr);
        let words = "2 of 2 are not as expected: 1 without expected picture, 1 without actual picture";
        assert_eq!(output.stderr, format!("overcoat: {words}\n"));
        for row in ["no actual picture    gone.png\n", "no expected picture  new.png\n"] {
            assert!(output.stdout.contains(row), "{}", output.stdout);
        }
        assert!(output.stdout.ends_with("2 files: 1 without expected picture, 1 without actual picture\n"));
    }
    assert!(folders.path("page.html").exists());
}

/// A render that is copied to the goldens as it is, by this crate's own encoder, is not larger than it must be.
#[test]
fn fresh_renders_are_not_oversized() {
    use overcoat::output::encode_png;
    let folders = Folders::new();
    let pixels =
        (0..256 * 256_u32).map(|k| [(k / 256) as u8, (k % 256 / 4) as u8, (k / 700) as u8, 255]).collect();
    let image = DisplayImage { width: 256, height: 256, pixels };
    let fresh = encode_png(&image).unwrap();
    let mut loose = Vec::new();
    let mut encoder = png::Encoder::new(&mut loose, 256, 256);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_compression(png::Compression::NoCompression);
    encoder.write_header().unwrap().write_image_data(image.pixels.as_flattened()).unwrap();
    for side in ["expected", "actual"] {
        folders.write(&format!("{side}/fresh.png"), &fresh);
        folders.write(&format!("{side}/loose.png"), &loose);
    }
    let (code, files) = folders.verdicts(&["--strict"]);
    assert_eq!((code, files[0].1.as_str(), files[1].1.as_str()), (4, "equal", "oversized"), "{files:?}");
}

/// A moving picture whose frames are discs, with so many milliseconds for each.
fn movie(format: overcoat::output::MovieFormat, steps: &[u8], times: &[u16]) -> Vec<u8> {
    use overcoat::output::{MovieFrame, encode_movie};
    let frames: Vec<MovieFrame> =
        steps.iter().map(|&step| MovieFrame::new(&disc(step), format, true).unwrap()).collect();
    encode_movie(&frames, times).unwrap()
}

#[test]
fn every_frame_of_moving_pictures_is_compared_and_its_time() {
    use overcoat::output::MovieFormat::{Apng, WebP};
    let times = [40, 40, 40];
    for (format, extension) in [(Apng, "png"), (Apng, "apng"), (WebP, "webp")] {
        let folders = Folders::new();
        let both = |name: &str, expected: &[u8], actual: &[u8]| {
            folders.write(&format!("expected/{name}.{extension}"), expected);
            folders.write(&format!("actual/{name}.{extension}"), actual);
        };
        let good = movie(format, &[0, 1, 2], &times);
        both("a-same", &good, &good);
        both("b-last", &good, &movie(format, &[0, 1, 5], &times));
        both("c-times", &good, &movie(format, &[0, 1, 2], &[40, 20, 40]));
        both("d-fewer", &good, &movie(format, &[0, 1], &[40, 40]));
        both("e-still", &good, &png(&disc(0)));
        both("f-cut", &good, &good[..good.len() / 2]);
        let (code, files) = folders.verdicts(&[]);
        assert_eq!(code, 1);
        let expected = [
            ("equal", ""),
            ("differs", "frame 3 of 3: 292 pixels differ by up to 3"),
            ("differs", "frame 2 of 3: expected 40 ms, actual 20 ms"),
            ("differs", "expected 3 frames, actual 2"),
            ("differs", "expected an animation of 3 frames, actual a still picture"),
            ("failed", "actual picture: "),
        ];
        for ((name, verdict, reason), (wanted, words)) in files.iter().zip(expected) {
            assert!(verdict == wanted && reason.starts_with(words), "{name}: {verdict} {reason}");
        }
        assert_eq!(files.len(), expected.len());
        folders.write("expected/thresholds.toml", "max_abs = 3\n");
        let (_, files) = folders.verdicts(&[]);
        let within = "frame 3 of 3: 292 pixels differ by up to 3";
        assert_eq!((files[1].1.as_str(), files[1].2.as_str()), ("within", within));

        // The page shows the frame that differs most; accepting takes the whole file.
        std::fs::remove_file(folders.path("expected/thresholds.toml")).unwrap();
        let report = folders.run("report", &["-o", "page.html"]);
        assert_eq!(report.code, 1);
        let page = std::fs::read_to_string(folders.path("page.html")).unwrap();
        assert!(page.contains("frame 3 of 3, which differs most"));
        let name = format!("b-last.{extension}");
        assert_eq!(folders.run("accept", &[&name]).code, 0);
        let [stored, actual] = ["expected", "actual"].map(|side| folders.path(&format!("{side}/{name}")));
        assert_eq!(std::fs::read(stored).unwrap(), std::fs::read(actual).unwrap());
    }

    // The library's one-liner does the same.
    let folders = Folders::new();
    let good = movie(Apng, &[0, 1], &[40, 40]);
    folders.write("expected/turn.png", &good);
    let golden = overcoat::golden::Golden::new(folders.path("expected")).updating(false);
    golden.assert_file("turn.png", &good);
    let other = golden.check_file("turn.png", &movie(Apng, &[0, 2], &[40, 40])).unwrap_err().to_string();
    assert!(other.contains("frame 2 of 2: 292 pixels differ by up to 1"), "{other}");
    let still = golden.check("turn", &disc(0)).unwrap_err().to_string();
    assert!(still.contains("expected an animation of 2 frames, actual a still picture"), "{still}");
}

#[test]
fn nothing_in_a_folder_is_passed_over_in_silence() {
    let folders = Folders::new();
    for side in ["expected", "actual"] {
        folders.write(&format!("{side}/a.png"), png(&disc(0)));
        folders.write(&format!("{side}/a.svg"), "<svg/>");
    }
    folders.write("actual/log.txt", "x");
    let output = folders.run("check", &[]);
    assert_eq!(output.code, 0);
    assert_eq!(output.stdout, "1 file: 1 equal\n3 files are not compared: 2 .svg, 1 .txt\n");
    let json = folders.run("check", &["--json"]);
    let json: serde_json::Value = serde_json::from_str(&json.stdout).unwrap();
    assert_eq!(json["warnings"][0], "3 files are not compared: 2 .svg, 1 .txt");
    let accepted = folders.run("accept", &["a.png", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&accepted.stdout).unwrap();
    assert_eq!((&json["files"][0]["name"], &json["errors"]), (&"a.png".into(), &serde_json::json!([])));
}

/// Pictures of every format that is read are, and what is not read may not differ.
#[test]
fn no_file_that_differs_passes() {
    use image::ImageFormat;
    let folders = Folders::new();
    let kinds = [
        ("bmp", ImageFormat::Bmp),
        ("tga", ImageFormat::Tga),
        ("tiff", ImageFormat::Tiff),
        ("ppm", ImageFormat::Pnm),
        ("qoi", ImageFormat::Qoi),
    ];
    for (side, code) in [("expected", 40_u8), ("actual", 42)] {
        for (extension, format) in kinds {
            for (name, code) in [("same", 40), ("differs", code)] {
                let mut bytes = std::io::Cursor::new(Vec::new());
                let image = image::RgbImage::from_pixel(9, 7, image::Rgb([code, 50, 60]));
                image.write_to(&mut bytes, format).unwrap();
                folders.write(&format!("{side}/{name}.{extension}"), bytes.into_inner());
            }
        }
        folders.write(&format!("{side}/picture.svg"), format!("<svg id='{code}'/>"));
    }
    folders.write("actual/more.dds", "DDS ");
    for strict in [&[][..], &["--strict"]] {
        let (code, files) = folders.verdicts(strict);
        assert_eq!((code, files.len()), (4, 12), "{files:?}");
        for (name, verdict, reason) in &files {
            let wanted = match name.as_str() {
                "more.dds" => "no_expected",
                name if name.starts_with("same") => "equal",
                _ => "differs",
            };
            assert_eq!(verdict, wanted, "{name}: {reason}");
        }
    }
    let (code, files) = folders.verdicts(&["--preset", "gpu"]);
    let within = files.iter().filter(|(_, verdict, _)| verdict == "within").count();
    assert_eq!((code, within), (4, 5), "{files:?}");
    assert_eq!(folders.run("check", &["--preset", "gpo"]).code, 2);
    let output = folders.run("accept", &["--all"]);
    assert_eq!(output.code, 0, "{}", output.stderr);
    assert_eq!(folders.run("check", &[]).code, 0);
}
