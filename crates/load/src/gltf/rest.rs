//! Files whose rest pose shows nothing: nodes that are scaled to nothing, hidden or transparent until an animation changes
//! them. Viewers play the first animation; a still picture is its first moment that shows something.

use super::animation;
use super::hierarchy::Places;
use super::pose::Pose;
use super::rig::{Drawn, Rig};
use crate::LoadError;
use overcoat_core::jobs::Jobs;
use overcoat_scene::{AlphaMode, Material};

/// Most animations that are tried; each of them is read for it.
const MOST_ANIMATIONS: usize = 4;
/// Most moments of an animation that are tried, beside its beginning.
const MOST_MOMENTS: usize = 32;

/// The file as it is, if its rest pose shows something or no animation does; else at the first moment of the first animation
/// that shows something, with a warning. `read` reads the file with an animation of that number; one that cannot be read shows
/// nothing.
pub(super) fn or_first_visible(rig: Rig, read: impl Fn(usize) -> Result<Rig, LoadError>, jobs: &Jobs) -> Rig {
    let count = rig.root.animations.len().min(MOST_ANIMATIONS);
    // Errors of making the scene are reported when it is asked for.
    if count == 0 || rig.surely_shows() || rig.shows(jobs) != Some(false) {
        return rig;
    }
    for index in 0..count {
        let Ok(mut playing) = read(index) else { continue };
        let moments = playing.animation.as_ref().map_or(Vec::new(), |(_, own)| own.moments(MOST_MOMENTS));
        for time in moments {
            playing.stands_in = Some(time);
            if playing.shows(jobs) == Some(true) {
                let name = animation::name(&playing.root, index);
                let message = format!("nothing is visible in the rest pose: {name} at {time} s is drawn");
                playing.warnings.add(|| message);
                return playing;
            }
        }
    }
    rig
}

impl Rig {
    /// True if the scene shows something, wherever it is seen from; `None` if there is none.
    fn shows(&self, jobs: &Jobs) -> Option<bool> {
        let scene = self.at(0.0, false, jobs).ok()?.scene;
        let seen = scene.instances().iter().any(|instance| {
            let material = scene.materials().get(instance.material.index());
            scene.is_solid(instance) && material.is_some_and(|material| !scene.is_invisible(material))
        });
        let placed = scene.splat_instances().iter().any(|instance| instance.transform.keeps_lines());
        Some(seen || placed && scene.splat_count() > 0)
    }

    /// True if the rest pose shows something by what its nodes and materials say: most files are not posed to find out.
    fn surely_shows(&self) -> bool {
        let Ok((_, places)) = self.places(&Pose::default()) else { return true };
        self.draws.iter().any(|drawn| self.draws_surely(drawn, &places))
    }

    fn draws_surely(&self, drawn: &Drawn, places: &Places) -> bool {
        let placed = match drawn.skin.and_then(|skin| self.skins.get(&skin)) {
            Some(skin) => places.shown(drawn.node.place).is_some() && skin.keeps_surfaces(places),
            None => places.shown(drawn.node.place).is_some_and(|place| place.keeps_surfaces()),
        };
        placed
            && drawn.copies.is_none()
            && drawn.mesh.iter().any(|draw| {
                let opaque = |(_, material): &(_, Material)| matches!(material.alpha_mode, AlphaMode::Opaque);
                let extended = |size: [f64; 3]| size.iter().filter(|&&size| size > 0.0).count() > 1;
                let solid = self.shapes.get(draw.geometry).is_some_and(|shape| {
                    !shape.mesh.triangles().is_empty() && extended(shape.mesh.bounds().size())
                });
                solid && self.materials.get(draw.material).is_some_and(opaque)
            })
    }
}
