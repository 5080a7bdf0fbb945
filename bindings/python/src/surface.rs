//! Warnings about losses: what a picture lacks of what its user may expect.

use overcoat::Scene;
use overcoat::frame::{DisplayOptions, Frame};
use overcoat::render::{RenderOptions, RenderStats};
use overcoat::scene::Camera;
use overcoat_worker::losses::{left_out, limited, lowered_exposure};

/// One sentence for each; `display` is as it was asked for, `exposure` that of the picture.
pub(crate) fn losses(
    scene: &Scene,
    camera: &Camera,
    options: &RenderOptions,
    (display, exposure): (&DisplayOptions, f32),
    frame: &Frame,
    stats: &RenderStats,
) -> Vec<String> {
    let mut all: Vec<String> = left_out(scene, options.shading).map(|warning| warning.message).collect();
    all.extend(scene.texture_losses());
    all.extend(limited(stats).map(|warning| warning.message));
    all.extend(lowered_exposure(display, exposure).map(|warning| warning.message));
    if display.background.is_none() && frame.is_tinted() {
        all.push(
            "glass tints what is behind it, which a picture with one opacity for all colours cannot show: it is grey there; \
             a colour or 'env' as background shows it"
                .to_owned(),
        );
    }
    if let Some(unseen) = stats.unseen(scene, camera, options) {
        all.push(format!("nothing to see: {unseen}"));
    }
    all
}
