//! Axes of a file that has been read.

use super::{Format, LoadOptions, Loaded};
use overcoat_scene::Orientation;

/// Axes of a file: those of its format, if neither the options, nor the file, nor, where the format leaves it to custom,
/// the shape of the model say otherwise.
pub(super) fn orientation(loaded: &Loaded, format: Option<Format>, options: &LoadOptions) -> Orientation {
    let of_format = format.map(Format::orientation).unwrap_or_default();
    let up = loaded.up.unwrap_or(of_format.up);
    // Another up axis has another front.
    let is_turned = loaded.is_turned && options.up.is_none_or(|chosen| chosen == up);
    let of_file = Orientation { up, is_turned, ..of_format };
    if options.up.is_some() || loaded.up.is_some() || format.is_none_or(Format::defines_up) {
        return options.orientation(of_file);
    }
    match loaded.scene.up_by_shape(of_format.up) {
        up if up == of_format.up => of_format,
        // Files that break the custom of the up axis tell nothing of their front either.
        up => Orientation { up, up_is_by_shape: true, front_is_known: false, ..of_format },
    }
}

#[cfg(all(test, feature = "obj", feature = "ply-stl"))]
mod tests {
    use super::*;
    use crate::load_bytes_with;
    use crate::{Context, NoResolver};
    use overcoat_core::jobs::Jobs;
    use overcoat_core::limits::Limits;
    use overcoat_scene::Axis;
    use std::fmt::Write as _;

    /// Four legs and a top, each as the smallest and the largest corner; the third coordinate is up.
    const TABLE: [[[i32; 3]; 2]; 5] = [
        [[-8, -5, 7], [8, 5, 8]],
        [[-8, -5, 0], [-7, -4, 7]],
        [[7, -5, 0], [8, -4, 7]],
        [[-8, 4, 0], [-7, 5, 7]],
        [[7, 4, 0], [8, 5, 7]],
    ];

    /// Triangles of the table, which stands on +Z or, of a +Y file, on +Y.
    fn triangles(up: Axis) -> Vec<[[i32; 3]; 3]> {
        let place = |[x, y, z]: [i32; 3]| if up == Axis::PositiveZ { [x, y, z] } else { [x, z, -y] };
        let mut all = Vec::new();
        for [low, high] in TABLE {
            let corner = |k: usize| std::array::from_fn(|a| if k >> a & 1 == 1 { high[a] } else { low[a] });
            for [a, b, c, d] in
                [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]]
            {
                all.extend([[a, b, c], [a, c, d]].map(|t: [usize; 3]| t.map(|k| place(corner(k)))));
            }
        }
        all
    }

    /// The table as a file of a format.
    fn file(format: Format, up: Axis) -> String {
        let triangles = triangles(up);
        let count = triangles.len();
        let mut text = match format {
            Format::Obj => String::new(),
            Format::Stl => "solid table\n".to_owned(),
            _ => format!(
                "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
                 element face {count}\nproperty list uchar int vertex_indices\nend_header\n",
                3 * count
            ),
        };
        for triangle in &triangles {
            let [open, word, close] = match format {
                Format::Obj => ["", "v ", ""],
                Format::Stl => ["facet normal 0 0 0\nouter loop\n", "vertex ", "endloop\nendfacet\n"],
                _ => ["", "", ""],
            };
            text += open;
            for [x, y, z] in triangle {
                writeln!(text, "{word}{x} {y} {z}").unwrap();
            }
            text += close;
        }
        for k in (0..3 * count).step_by(3) {
            match format {
                Format::Obj => writeln!(text, "f {} {} {}", k + 1, k + 2, k + 3).unwrap(),
                Format::Stl => {}
                _ => writeln!(text, "3 {k} {} {}", k + 1, k + 2).unwrap(),
            }
        }
        text
    }

    fn load(text: &str, format: Format, options: &LoadOptions) -> Loaded {
        let (limits, jobs) = (Limits::default(), Jobs::new(1));
        let context = Context { resolver: &NoResolver, limits: &limits, jobs: &jobs };
        load_bytes_with(text.as_bytes(), Some(format), options, &context).unwrap()
    }

    #[test]
    fn models_stand_whatever_the_custom_is() {
        for format in [Format::Obj, Format::Ply, Format::Stl] {
            let usual = format.orientation();
            for up in [Axis::PositiveY, Axis::PositiveZ] {
                let loaded = load(&file(format, up), format, &LoadOptions::default());
                let found = loaded.scene.orientation();
                assert_eq!((found.up, found.up_is_by_shape), (up, up != usual.up), "{format:?}");
                assert_eq!(found.front_is_known, usual.front_is_known && up == usual.up, "{format:?}");
                assert!(loaded.warnings.is_empty());
                let bounds = loaded.scene.bounds();
                assert_eq!(
                    (bounds.min, bounds.max),
                    ([-8.0, 0.0, -5.0], [8.0, 8.0, 5.0]),
                    "{format:?} {up:?}"
                );
            }
        }
    }

    #[test]
    fn a_choice_overrules_the_shape() {
        for format in [Format::Obj, Format::Ply, Format::Stl] {
            for &up in Axis::ALL {
                let text = file(format, Axis::PositiveZ);
                let found = load(&text, format, &LoadOptions::default().with_up(up)).scene.orientation();
                assert_eq!(found, Orientation { up, ..format.orientation() }, "{format:?}");
            }
        }
    }
}
