//! The picture of a model whose picture has no name: beside the caller, under the model's name.
//!
//! Nobody asked for that name, so nothing is lost under it: a file that is there is replaced only if it was made this way, which a
//! text chunk in it tells (`Software`, a keyword of the PNG specification, section 11.3.3.2), or if `--force` says so.

use super::args::RenderArgs;
use super::failure::Failure;
use overcoat_description::is_standard_input;
use overcoat_image::output::OutputFormat;
use overcoat_worker::picture_format::PictureFormat;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

/// A whole tEXt chunk: length, type, keyword and text, checksum.
const MARK: &[u8] = b"\x00\x00\x00\x11tEXtSoftware\x00overcoat\x34\x76\x9d\x24";

/// Bytes of a PNG file before its second chunk: signature and header.
const BEFORE: usize = 33;

/// Endings of packed files.
const PACKED: [&str; 2] = ["gz", "zst"];

/// Settles where a picture goes that was not told.
///
/// # Errors
/// [`Failure`] if there is no name to call it by, or something else has that name.
pub(super) fn settle(args: &mut RenderArgs) -> Result<(), Failure> {
    if args.output.is_some() {
        return Ok(());
    }
    let format = match args.encoding.output_format {
        None => OutputFormat::default(),
        Some(PictureFormat::File(format)) => format,
        Some(PictureFormat::Terminal(_)) => {
            args.output = Some(PathBuf::from("-"));
            return Ok(());
        }
    };
    if !args.aov.is_empty() && format != OutputFormat::Exr {
        return Err(Failure::usage("--aov writes several files: -o OUT says where they go"));
    }
    let model = args.model.input.as_ref().or(args.model.draw.scene.as_ref());
    let Some(name) = model.filter(|path| !is_standard_input(path)).and_then(|path| name(path)) else {
        return Err(Failure::usage("no name for the picture: -o OUT says where it goes"));
    };
    let path = name.with_extension(format.extension());
    if !args.force && path.symlink_metadata().is_ok() && !is_marked(&path) {
        let message = "is there and was not made this way: -o names another file, --force replaces it";
        return Err(Failure::usage(message).at(&path));
    }
    (args.output, args.is_unnamed) = (Some(path), true);
    Ok(())
}

/// A model's name without folder, packing and ending, but with an ending to replace.
fn name(model: &Path) -> Option<PathBuf> {
    let mut name = PathBuf::from(model.file_name()?);
    if name.extension().is_some_and(|ending| PACKED.iter().any(|packed| ending.eq_ignore_ascii_case(packed)))
    {
        name.set_extension("");
    }
    Some(name)
}

/// True for a file that begins as [`mark`] leaves it.
fn is_marked(path: &Path) -> bool {
    let mut first = [0; BEFORE + MARK.len()];
    let read = File::open(path).and_then(|mut file| file.read_exact(&mut first));
    read.is_ok() && first[BEFORE..] == *MARK
}

/// Marks a PNG file as made under a name that nobody asked for.
pub(super) fn mark(png: &mut Vec<u8>) {
    if png.len() > BEFORE && png.starts_with(b"\x89PNG\r\n\x1a\n") {
        png.splice(BEFORE..BEFORE, MARK.iter().copied());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use overcoat_core::frame::DisplayImage;
    use overcoat_image::output::{OutputFormat, OutputOptions, encode_image};

    #[test]
    fn a_marked_file_is_a_file_of_the_same_pixels() {
        let image = DisplayImage { width: 2, height: 1, pixels: vec![[1, 2, 3, 255], [200, 100, 0, 255]] };
        let mut bytes = encode_image(&image, OutputFormat::Png, &OutputOptions::default()).unwrap();
        let pixels = |bytes: &[u8]| {
            let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
            let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
            reader.next_frame(&mut pixels).unwrap();
            pixels
        };
        let plain = pixels(&bytes);
        mark(&mut bytes);
        assert_eq!(pixels(&bytes), plain);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.png");
        std::fs::write(&path, &bytes).unwrap();
        assert!(is_marked(&path));
        let reader = png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().unwrap();
        let texts: Vec<_> =
            reader.info().uncompressed_latin1_text.iter().map(|t| (&t.keyword[..], &t.text[..])).collect();
        assert_eq!(texts, [("Software", "overcoat")]);
    }

    #[test]
    fn names_lose_packing_and_folder() {
        for (model, expected) in [
            ("a/b/car.glb", "car.png"),
            ("car.v2.obj.gz", "car.v2.png"),
            ("car", "car.png"),
            ("c.STL.ZST", "c.png"),
        ] {
            assert_eq!(name(Path::new(model)).unwrap().with_extension("png"), Path::new(expected), "{model}");
        }
    }
}
