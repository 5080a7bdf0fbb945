//! Pictures for terminals, read back by decoders of their own: what a terminal would show is the picture.

use base64::Engine;
use overcoat::frame::DisplayImage;
use overcoat::output::{TerminalFormat, encode_terminal};
use std::collections::BTreeSet;

/// Pixels that a terminal shows: a colour where something is drawn.
type Shown = Vec<Option<[u8; 3]>>;

/// The text between a start and an end that it must have.
fn within<'a>(text: &'a str, start: &str, end: &str) -> &'a str {
    let inner = text.strip_prefix(start).and_then(|text| text.strip_suffix(end));
    inner.unwrap_or_else(|| panic!("no {start:?} and {end:?}"))
}

/// The number at the beginning of a text, and the rest.
fn number(text: &str) -> (usize, &str) {
    let end = text.find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len());
    (text[..end].parse().unwrap(), &text[end..])
}

/// Width, height, registers as of 255 and what is drawn.
fn decode_sixel(text: &str) -> (usize, usize, Vec<[u8; 3]>, Shown) {
    let text = within(text, "\x1bP0;1;0q\"1;1;", "\x1b\\\x1b[0m\n");
    let (width, rest) = number(text);
    let (height, mut rest) = number(rest.strip_prefix(';').unwrap());
    let mut shown = vec![None; width * height];
    let (mut registers, mut register, mut x, mut band) = (Vec::new(), 0, 0, 0);
    while let Some(code) = rest.chars().next() {
        rest = &rest[1..];
        match code {
            '#' => {
                (register, rest) = number(rest);
                if let Some(color) = rest.strip_prefix(";2;") {
                    let (r, color) = number(color);
                    let (g, color) = number(&color[1..]);
                    let (b, color) = number(&color[1..]);
                    rest = color;
                    assert_eq!(register, registers.len());
                    registers.push([r, g, b].map(|v| ((v * 255 + 50) / 100) as u8));
                }
            }
            '$' => x = 0,
            '-' => (x, band) = (0, band + 1),
            '!' | '?'..='~' => {
                let mut count = 1;
                let mut data = code;
                if code == '!' {
                    (count, rest) = number(rest);
                    data = rest.chars().next().unwrap();
                    rest = &rest[1..];
                }
                let bits = data as u8 - b'?';
                for x in x..x + count {
                    assert!(x < width);
                    for row in (0..6).filter(|row| bits >> row & 1 == 1) {
                        let pixel = &mut shown[(band * 6 + row) * width + x];
                        assert_eq!(*pixel, None, "drawn twice");
                        *pixel = Some(registers[register]);
                    }
                }
                x += count;
            }
            other => panic!("{other:?}"),
        }
    }
    assert_eq!(band, (height - 1) / 6);
    (width, height, registers, shown)
}

/// Width, height (of whole cells) and what is drawn: half blocks by their colours.
fn decode_blocks(text: &str) -> (usize, usize, Shown) {
    let (mut width, mut shown) = (0, Vec::new());
    let lines: Vec<&str> = text.strip_suffix('\n').unwrap().split('\n').collect();
    for line in &lines {
        let (mut upper, mut lower) = (Vec::new(), Vec::new());
        let (mut ink, mut paper) = (None, None);
        let mut rest = *line;
        while let Some(glyph) = rest.chars().next() {
            rest = &rest[glyph.len_utf8()..];
            match glyph {
                '\x1b' => {
                    let (codes, after) = rest[1..].split_once('m').unwrap();
                    rest = after;
                    let codes: Vec<u8> = codes.split(';').map(|code| code.parse().unwrap()).collect();
                    match codes[..] {
                        [0] => (ink, paper) = (None, None),
                        [49] => paper = None,
                        [38, 2, r, g, b] => ink = Some([r, g, b]),
                        [48, 2, r, g, b] => paper = Some([r, g, b]),
                        _ => panic!("{codes:?}"),
                    }
                }
                ' ' => {
                    upper.push(paper);
                    lower.push(paper);
                }
                '\u{2580}' => {
                    upper.push(Some(ink.unwrap()));
                    lower.push(paper);
                }
                '\u{2584}' => {
                    upper.push(paper);
                    lower.push(Some(ink.unwrap()));
                }
                other => panic!("{other:?}"),
            }
        }
        assert!(line.ends_with("\x1b[0m") && ink.is_none() && paper.is_none());
        width = upper.len();
        shown.extend(upper);
        shown.extend(lower);
    }
    assert_eq!(shown.len(), width * lines.len() * 2);
    (width, lines.len() * 2, shown)
}

/// The PNG file of a sequence of chunks.
fn decode_kitty(text: &str) -> Vec<u8> {
    let chunks: Vec<&str> = within(text, "\x1b_G", "\x1b\\\x1b[0m\n").split("\x1b\\\x1b_G").collect();
    let mut data = String::new();
    for (k, chunk) in chunks.iter().enumerate() {
        let (control, chunk) = chunk.split_once(';').unwrap();
        let more = u8::from(k + 1 < chunks.len());
        let first = if k == 0 { "a=T,f=100," } else { "" };
        assert_eq!(control, format!("{first}q=2,m={more}"));
        assert!(chunk.len() <= 4096 && (more == 0 || chunk.len() % 4 == 0));
        data.push_str(chunk);
    }
    base64::engine::general_purpose::STANDARD.decode(data).unwrap()
}

fn text(image: &DisplayImage, format: TerminalFormat) -> String {
    let bytes = encode_terminal(image, format).unwrap();
    assert_eq!(bytes, encode_terminal(image, format).unwrap(), "not the same twice");
    String::from_utf8(bytes).unwrap()
}

/// Pixels that a terminal should show of a picture whose pixels are either there or not.
fn expected(image: &DisplayImage) -> Shown {
    image.pixels.iter().map(|&[r, g, b, a]| (a >= 128).then_some([r, g, b])).collect()
}

/// A picture of a size and of colours by position; of every opacity.
fn picture(width: u32, height: u32, color: impl Fn(u32, u32) -> [u8; 3]) -> DisplayImage {
    let pixel = |k: u32| {
        let (x, y) = (k % width, k / width);
        let [r, g, b] = color(x, y);
        // Runs, holes and borders.
        let alpha = if (x / 7 + y / 3) % 3 == 0 { (x * 31 + y * 17) % 256 } else { 255 };
        if alpha == 0 { [0; 4] } else { [r, g, b, alpha as u8] }
    };
    DisplayImage { width, height, pixels: (0..width * height).map(pixel).collect() }
}

/// Sizes that end within a band, a cell and a run; one pixel; many colours.
fn pictures() -> Vec<DisplayImage> {
    let many = |x: u32, y: u32| [(x * 2) as u8, (y * 3) as u8, ((x * y) / 40) as u8];
    let few = |x: u32, y: u32| [(x / 9 * 40) as u8, (y / 5 * 20) as u8, 77];
    let mut all = vec![picture(128, 85, many), picture(61, 47, few), picture(300, 6, few)];
    all.extend([(1, 1), (1, 13), (5, 2)].map(|(w, h)| picture(w, h, many)));
    all.push(DisplayImage { width: 9, height: 14, pixels: vec![[0; 4]; 9 * 14] });
    all.push(DisplayImage { width: 40, height: 7, pixels: vec![[1, 2, 3, 255]; 40 * 7] });
    all
}

#[test]
fn sixels_are_the_picture_within_their_palette() {
    for image in pictures() {
        let (width, height, registers, shown) = decode_sixel(&text(&image, TerminalFormat::Sixel));
        assert_eq!([width as u32, height as u32], [image.width, image.height]);
        let colors: BTreeSet<[u8; 3]> = expected(&image).into_iter().flatten().collect();
        assert_eq!(registers.len(), colors.len().min(256));
        let mut errors = 0_u32;
        for (shown, expected) in shown.iter().zip(expected(&image)) {
            assert_eq!(shown.is_some(), expected.is_some());
            let (Some(shown), Some(expected)) = (shown, expected) else { continue };
            let error = std::iter::zip(shown, expected).map(|(a, b)| u32::from(a.abs_diff(b))).max().unwrap();
            // Registers have 101 steps: at most one of 255 is lost by them.
            assert!(error <= if colors.len() <= 256 { 1 } else { 40 }, "{shown:?} {expected:?}");
            errors += error;
        }
        assert!(errors as usize <= 12 * image.pixels.len(), "{errors}");
    }
}

#[test]
fn sixels_are_run_lengths_and_leave_ends_out() {
    let image = DisplayImage { width: 40, height: 7, pixels: vec![[255, 0, 0, 255]; 280] };
    assert_eq!(
        text(&image, TerminalFormat::Sixel),
        "\x1bP0;1;0q\"1;1;40;7#0;2;100;0;0#0!40~-#0!40@\x1b\\\x1b[0m\n"
    );
}

#[test]
fn blocks_are_the_picture() {
    for image in pictures() {
        let (width, height, shown) = decode_blocks(&text(&image, TerminalFormat::Blocks));
        assert_eq!([width as u32, height as u32], [image.width, image.height.next_multiple_of(2)]);
        let mut expected = expected(&image);
        // Below an odd row there is nothing.
        expected.resize(shown.len(), None);
        assert_eq!(shown, expected);
    }
}

#[test]
fn kitty_gets_the_png_in_chunks() {
    let mut chunked = 0;
    for image in pictures() {
        let text = text(&image, TerminalFormat::Kitty);
        chunked += usize::from(text.contains("m=1;"));
        let png = decode_kitty(&text);
        assert_eq!(png, overcoat::output::encode_png(&image).unwrap());
        assert_eq!(pixels(&png), (image.width, image.pixels.clone()));
    }
    assert!(chunked > 0, "no picture was larger than a chunk");
}

/// Width and pixels of a PNG.
fn pixels(png: &[u8]) -> (u32, Vec<[u8; 4]>) {
    let mut reader = png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    let pixels = match info.color_type {
        png::ColorType::Rgb => bytes.as_chunks::<3>().0.iter().map(|&[r, g, b]| [r, g, b, 255]).collect(),
        _ => bytes.as_chunks::<4>().0.to_vec(),
    };
    (info.width, pixels)
}

#[test]
fn pictures_that_are_none_are_refused() {
    for &format in TerminalFormat::ALL {
        for (width, height, pixels) in [(0, 4, 0), (4, 0, 0), (2, 2, 3), (2, 2, 5)] {
            let image = DisplayImage { width, height, pixels: vec![[0; 4]; pixels] };
            let message = encode_terminal(&image, format).unwrap_err().to_string();
            assert!(message.starts_with(&format!("cannot encode {format}: ")), "{message}");
        }
    }
}

#[cfg(target_os = "linux")]
mod program {
    use super::{decode_blocks, decode_kitty, decode_sixel, expected, pixels};
    use overcoat::frame::DisplayImage;
    use std::path::Path;
    use std::process::{Command, Output, Stdio};

    fn folder() -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("x.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
        folder
    }

    fn render(folder: &Path, args: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_overcoat"))
            .args(["render", "x.obj"])
            .args(args)
            .current_dir(folder)
            .output()
            .unwrap()
    }

    #[test]
    fn what_is_written_is_the_picture_of_the_png() {
        let folder = folder();
        let of = |format: &str| {
            let done = render(
                folder.path(),
                &["-o", "-", "--size", "50x41", "--ground", "none", "--output-format", format],
            );
            assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
            done.stdout
        };
        let png = of("png");
        let (width, pixels) = pixels(&png);
        let image = DisplayImage { width, height: 41, pixels };
        let mut shown = expected(&image);
        assert!(shown.iter().any(Option::is_some) && shown.iter().any(Option::is_none));
        let text = |format: &str| String::from_utf8(of(format)).unwrap();
        assert_eq!(decode_kitty(&text("kitty")), png);
        let sixels = decode_sixel(&text("sixel")).3;
        assert!(sixels.iter().map(Option::is_some).eq(shown.iter().map(Option::is_some)));
        shown.resize(50 * 42, None);
        assert_eq!(decode_blocks(&text("blocks")).2, shown);
        // Nobody is asked for its size: it is no terminal.
        let usual = render(folder.path(), &["-o", "-", "--output-format", "sixel"]).stdout;
        assert_eq!(decode_sixel(&String::from_utf8(usual).unwrap()).0, 512);
        // A report of linear light beside it, and the same bytes.
        let args = ["-o", "x.six", "--size", "50x41", "--output-format", "sixel", "--json"];
        assert!(render(folder.path(), &args).status.success());
        assert_eq!(std::fs::read(folder.path().join("x.six")).unwrap(), of("sixel"));
        // Without transparency there is a shadow, as in every picture; and where someone asks for it.
        let sixel = |more: &[&str]| {
            let all = [&["-o", "-", "--size", "50x41", "--output-format", "sixel"], more].concat();
            render(folder.path(), &all).stdout
        };
        assert_ne!(sixel(&["--ground", "shadow"]), of("sixel"));
        let white = ["--background", "white"];
        assert_eq!(sixel(&white), sixel(&[&white[..], &["--ground", "shadow"]].concat()));
        assert_ne!(sixel(&white), sixel(&[&white[..], &["--ground", "none"]].concat()));
    }

    #[test]
    fn what_contradicts_itself_is_said_in_a_line() {
        let folder = folder();
        for (args, message) in [
            (
                ["-o", "x.png", "--output-format", "sixel"].as_slice(),
                "contradicts the name, which is of .png",
            ),
            (&["-o", "x.six"], "unknown format"),
            (&["-o", "-", "--output-format", "sixels"], "did you mean 'sixel'?"),
            (
                &["-o", "-", "--output-format", "kitty", "--jpeg-quality", "9"],
                "is for .jpg and not for kitty",
            ),
            (&["-o", "-", "--output-format", "kitty", "--json"], "cannot both go to standard output"),
            (&["-o", "-", "--output-format", "blocks", "--aov", "depth"], "as .exr only"),
        ] {
            let done = render(folder.path(), args);
            let said = String::from_utf8(done.stderr).unwrap();
            assert_eq!((done.status.code(), said.lines().count()), (Some(2), 1), "{args:?}: {said}");
            assert!(said.contains(message) && done.stdout.is_empty(), "{said}");
        }
    }

    /// Output of a script on a terminal of 60 columns and 20 rows, with `$0` for the program; `None` where there is no
    /// program that makes terminals.
    fn in_terminal(folder: &Path, script: &str) -> Option<String> {
        let inner =
            format!("stty cols 60 rows 20 -onlcr; {}", script.replace("$0", env!("CARGO_BIN_EXE_overcoat")));
        let done = Command::new("script")
            .args(["-q", "-e", "-c", &inner, "/dev/null"])
            .env("SHELL", "/bin/sh")
            .current_dir(folder)
            .stdin(Stdio::null())
            .output()
            .ok()?;
        Some(String::from_utf8(done.stdout).unwrap())
    }

    #[test]
    fn a_terminal_gets_what_it_can_show_and_what_fits() {
        let folder = folder();
        let Some(blocks) = in_terminal(folder.path(), "$0 render x.obj -q -o - --output-format blocks")
        else {
            eprintln!("SKIPPED, NOTHING WAS TESTED: no script");
            return;
        };
        assert_eq!(
            {
                let (width, height, _) = decode_blocks(&blocks);
                [width, height]
            },
            [36, 36],
            "{blocks:?}"
        );
        let sixels = in_terminal(folder.path(), "$0 render x.obj -q -o - --output-format sixel").unwrap();
        // Cells of 8 x 16, since this terminal tells no pixels: 480 x 288 without the rows of the prompt.
        assert_eq!(decode_sixel(&sixels).0, 288);
        let sandboxed =
            in_terminal(folder.path(), "$0 --sandbox render x.obj -q -o - --output-format sixel").unwrap();
        assert!(sandboxed == sixels || sandboxed.contains("no sandbox here"), "{sandboxed:?}");
        let asked =
            in_terminal(folder.path(), "$0 render x.obj -q -o - --size 20 --output-format blocks").unwrap();
        assert_eq!(decode_blocks(&asked).0, 20);
        let refused = in_terminal(folder.path(), "$0 render x.obj -q -o -").unwrap();
        assert!(refused.contains("--output-format kitty, sixel or blocks"), "{refused:?}");
    }
}
