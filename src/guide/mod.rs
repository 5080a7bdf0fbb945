//! Pages to read: what the shading models compute and why they differ; how pictures stay the same bits everywhere;
//! what of glTF is drawn; how a program uses the library.

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
/// The material ball in six models, and four times its difference to glTF's
/// (`overcoat compare-models assets/models/material-ball.glb --models urp17,hdrp-lit,stacklit,filament,gltf,openpbr`):
///
#[doc = concat!("<img alt=\"six models\" src=\"data:image/png;base64,", include_str!("models.png.base64"), "\">")]
///
/// StackLit's coat over silver, thickness to the right, extinction downwards (`golden/coat-extinction-grid-stacklit.toml`):
///
#[doc = concat!("<img alt=\"extinction\" src=\"data:image/png;base64,", include_str!("extinction.png.base64"), "\">")]
pub mod clear_coat {}
