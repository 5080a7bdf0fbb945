//! Pages to read: what the shading models compute and why they differ; how other renderers are tested by the referee; how
//! pictures stay the same bits everywhere; what of glTF is drawn; how a program uses the library.

/// How a program uses the library.
#[doc = include_str!("library.md")]
/// # From a file to pixels
///
/// `examples/file-to-pixels.rs`:
///
/// ```no_run
#[doc = include_str!("../../examples/file-to-pixels.rs")]
/// ```
///
/// # A scene by hand
///
/// `examples/scene-by-hand.rs`:
///
/// ```no_run
#[doc = include_str!("../../examples/scene-by-hand.rs")]
/// ```
///
/// # A test of pictures
///
/// `examples/golden-image/main.rs`:
///
/// ```no_run
#[doc = include_str!("../../examples/golden-image/main.rs")]
/// ```
pub mod library {}

/// How the same bits are kept on every machine.
#[doc = include_str!("bit_identity.md")]
pub mod bit_identity {}

/// What of a glTF file is drawn.
#[doc = include_str!("formats.md")]
pub mod formats {}

/// Clear coat in every engine.
#[doc = include_str!("clear_coat.md")]
/// Pictures of it are files of the repository: `assets/models.png` has one car paint in six models and their differences to
/// glTF's (the command is in `docs/src/introduction.md`), and `golden/coat-extinction-grid-stacklit.png` StackLit's coat over silver, thickness to the right, extinction
/// downwards. Any model is drawn so by
/// `overcoat compare-models assets/models/material-ball.glb --models urp17,hdrp-lit,stacklit,filament,gltf,openpbr -o models.png`.
pub mod clear_coat {}

/// Car paint: flakes, pearl, candy, orange peel, swirl marks and scratches.
// Where its figure is comes first, since of two definitions the first one counts: the page's own leads to a file, which it is
// shown with where it is a file itself.
#[doc = include_str!("car_paint/figures.md")]
#[doc = include_str!("car_paint.md")]
pub mod car_paint {}

/// A test of clear coats for any renderer.
#[doc = include_str!("conformance.md")]
pub mod conformance {}

/// Mistakes in notes on clear coats that circulate, with what they do to a picture.
///
// Where its figures are comes first, since of two definitions the first one counts: the page's own lead to files, which it is
// shown with where it is a file itself.
#[doc = include_str!("errata/figures.md")]
#[doc = include_str!("errata.md")]
pub mod errata {}

/// StackLit repaired: a coat over a base by the adding method, its derivation and its errors.
#[doc = include_str!("stacklit_d.md")]
pub mod stacklit_d {}
