//! Limits of one thumbnail: a file manager asks for hundreds, of files that nobody has opened yet.

use crate::args::LimitArgs;

/// Default of `--memory`, as it is written on a command line.
pub const MEMORY_DEFAULT: &str = "512Mi";

/// The limits that are smaller than those of other commands.
///
/// Models of two million triangles are within them, and textures of 8192 x 8192, or sixteen of 4096 x 4096: what is kept of those is
/// smaller. What is not ends within five seconds of one processor.
pub const THUMBNAIL_LIMITS: [(&str, u64); 7] = [
    ("input_bytes", 1 << 28),
    ("decoded_bytes", 7 << 26),
    ("triangles", 1 << 22),
    ("texture_pixels", 1 << 26),
    ("total_texture_pixels", 1 << 26),
    ("shading", 1 << 12),
    ("blocks", 1 << 25),
];

/// Lays what the user changes over [`THUMBNAIL_LIMITS`].
pub(super) fn within_thumbnail_limits(given: &LimitArgs) -> LimitArgs {
    let own = THUMBNAIL_LIMITS.into_iter().map(|(name, value)| (name.to_owned(), value));
    LimitArgs { limits: own.chain(given.limits.iter().cloned()).collect() }
}

/// A limit as `--limit` takes it.
#[must_use]
pub fn spelled((name, value): (&str, u64)) -> String {
    match value {
        v if v % (1 << 20) == 0 => format!("{name}={}Mi", v >> 20),
        v if v % (1 << 10) == 0 => format!("{name}={}Ki", v >> 10),
        v => format!("{name}={v}"),
    }
}

/// Text of `--help` about the limits.
pub(super) fn explained() -> String {
    let limits: Vec<String> = THUMBNAIL_LIMITS.into_iter().map(spelled).collect();
    format!(
        "Examples:
  overcoat thumbnail part.stl part.png
  overcoat thumbnail --size 512 file:///home/me/my%20car.glb car.png

The picture is as by overcoat render: the default view, quality fast, 8 samples, a transparent background. Of 3MF files, \
G-code and Blender files without a model that can be drawn it is the picture that they carry of themselves, with a warning.

Limits that are smaller than those of other commands: {}. --limit and --memory raise them.

Exit codes: 0 done, 1 failed, 2 wrong usage, 3 limit exceeded; but for 0 nothing is written",
        limits.join(", ")
    )
}
