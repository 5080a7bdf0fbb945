//! The list of scenes. Those under one light follow each other, so that its map is filtered once.

use super::light::Sky;
use crate::lab::{Base, Specimen};
use crate::truth::{Interface, Stack, StackError};

/// A ball of a material under a light.
#[derive(Clone, Copy, Debug)]
pub struct Scene {
    /// Name of its files.
    pub name: &'static str,
    /// Purpose of the scene, a sentence.
    pub about: &'static str,
    /// Layers of the ball.
    pub specimen: Specimen,
    /// Light around it.
    pub sky: Sky,
    /// Factor on the number of walks, for scenes where few find the light, or each takes little time.
    pub effort: u32,
}

impl Scene {
    /// True if it has no coat, so that every correct renderer passes: it is about lights, maps, cameras and units.
    pub fn is_plain(&self) -> bool {
        self.specimen.coat == 0.0
    }

    /// True if the base beneath the coat has multiple scattering between its facets. A plain scene has not: its GGX is
    /// that of every renderer, of which some estimate the light of further bounces and others lose it.
    pub fn has_all_bounces(&self) -> bool {
        !self.is_plain()
    }

    /// The layers, with the coat or without.
    pub fn stack(&self, coated: bool) -> Result<Stack, StackError> {
        let Specimen { metal, color, base_roughness, .. } = self.specimen;
        if metal && !self.has_all_bounces() {
            let facets = Interface::schlick_conductor(color).rough(base_roughness * base_roughness);
            return Stack::builder().interface(facets).build();
        }
        self.specimen.stack(coated)
    }

    /// True if the scene has a second truth, [`Truth::of_one_bounce`](super::Truth::of_one_bounce).
    pub fn has_truth_of_one_bounce(&self) -> bool {
        self.has_all_bounces() && self.specimen.has_further_bounces()
    }
}

/// A smooth coat of index 1.5 over a matt grey surface, which the others vary.
const MATT: Specimen = Specimen {
    coat: 1.0,
    coat_roughness: 0.0,
    coat_ior: 1.5,
    thickness: 0.0,
    extinction: [0.0; 3],
    base_roughness: 0.5,
    metal: false,
    base: Base::Convention,
    base_ior: 1.5,
    color: [0.18; 3],
    specular: 0.0,
};

const RED_PLASTIC: Specimen = Specimen { coat_roughness: 0.1, color: [0.5, 0.1, 0.1], specular: 1.0, ..MATT };

const DARK_PLASTIC: Specimen =
    Specimen { coat_roughness: 0.25, color: [0.05, 0.08, 0.2], specular: 1.0, base_roughness: 0.6, ..MATT };

const COPPER: [f64; 3] = [0.95, 0.64, 0.54];

/// All scenes.
pub const SCENES: [Scene; 14] = [
    Scene {
        name: "furnace",
        about: "No coat, matt, reflects all: the picture is 1.",
        specimen: Specimen { coat: 0.0, color: [1.0; 3], ..MATT },
        sky: Sky::White,
        effort: 1,
    },
    Scene {
        name: "coat-matt-white",
        about: "A smooth coat over matt grey: light that the coat sends back down is seen again.",
        specimen: MATT,
        sky: Sky::White,
        effort: 1,
    },
    Scene {
        name: "coat-tinted-white",
        about: "A smooth coat that absorbs over metal: the slant of the way through it.",
        specimen: Specimen {
            thickness: 1.0,
            extinction: [0.1, 0.4, 1.0],
            metal: true,
            specular: 1.0,
            color: [0.9; 3],
            base_roughness: 0.3,
            ..MATT
        },
        sky: Sky::White,
        effort: 1,
    },
    Scene {
        name: "matt-gradient",
        about: "No coat, matt: the axes of the map.",
        specimen: Specimen { coat: 0.0, color: [0.8; 3], ..MATT },
        sky: Sky::Gradient,
        effort: 1,
    },
    Scene {
        name: "coat-plastic-gradient",
        about: "A nearly smooth coat over plastic as engines have it, with a reflection of its own below the coat.",
        specimen: RED_PLASTIC,
        sky: Sky::Gradient,
        effort: 2,
    },
    Scene {
        name: "coat-interface-gradient",
        about: "The same over plastic of the coat's index: no interface lies between the two.",
        specimen: Specimen { base: Base::Interface, ..RED_PLASTIC },
        sky: Sky::Gradient,
        effort: 2,
    },
    Scene {
        name: "coat-dense-gradient",
        about: "A coat of index 1.9 over matt: more of the light is caught beneath it.",
        specimen: Specimen { coat_roughness: 0.2, coat_ior: 1.9, color: [0.5; 3], ..MATT },
        sky: Sky::Gradient,
        effort: 1,
    },
    Scene {
        name: "coat-plastic-box",
        about: "A coat over dark plastic as engines have it in a dark room with one soft box.",
        specimen: DARK_PLASTIC,
        sky: Sky::Box,
        effort: 6,
    },
    Scene {
        name: "coat-interface-box",
        about: "The same over dark plastic of the coat's index: no interface lies between the two.",
        specimen: Specimen { base: Base::Interface, ..DARK_PLASTIC },
        sky: Sky::Box,
        effort: 6,
    },
    Scene {
        name: "matt-lamp",
        about: "No coat, matt: the unit and the direction of the lamp.",
        specimen: Specimen { coat: 0.0, color: [0.8, 0.5, 0.2], ..MATT },
        sky: Sky::Lamp,
        effort: 1,
    },
    Scene {
        name: "metal-lamp",
        about: "No coat, dark metal of GGX with one bounce: the highlight's shape.",
        specimen: Specimen {
            coat: 0.0,
            metal: true,
            specular: 1.0,
            color: [0.25, 0.2, 0.15],
            base_roughness: 0.3,
            ..MATT
        },
        sky: Sky::Lamp,
        effort: 1,
    },
    Scene {
        name: "coat-rough-lamp",
        about: "A rough coat over matt.",
        specimen: Specimen { coat_roughness: 0.5, color: [0.8, 0.4, 0.2], ..MATT },
        sky: Sky::Lamp,
        effort: 1,
    },
    Scene {
        name: "coat-metal-lamp",
        about: "A coat over metal: two highlights, of which one is widened by the other.",
        specimen: Specimen {
            coat_roughness: 0.3,
            metal: true,
            specular: 1.0,
            color: COPPER,
            base_roughness: 0.4,
            ..MATT
        },
        sky: Sky::Lamp,
        effort: 1,
    },
    Scene {
        name: "coat-half-lamp",
        about: "Half of the surface has a coat.",
        specimen: Specimen { coat: 0.5, coat_roughness: 0.3, color: [0.2, 0.5, 0.3], ..MATT },
        sky: Sky::Lamp,
        effort: 1,
    },
];
