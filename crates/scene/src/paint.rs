//! Car paint beyond colour and coat: flakes in the base; orange peel, scratches and swirl marks in the coat.
//!
//! None of it is read from textures or needs texture coordinates: it is procedural, in the object's own space, so that
//! it moves with the object and has the same size all over it. Lengths are metres of the scene (of the object, where
//! its transform scales it: an object drawn twice as large has flakes of the size that is written here).
//!
//! Every shading model shows flakes, and every one whose coat has normals of its own shows the rest. The colour of a
//! pixel is a mix of a few surfaces, each shaded by the model's own formulas: the base as it is, the flakes, and both
//! beneath the scratched coat.

use super::Material;
use super::lobes::group;

impl Material {
    /// True if there are flakes in the base.
    pub fn has_flakes(&self) -> bool {
        self.lobes.flakes.share > 0.0
    }

    /// True if the coat has orange peel.
    pub fn has_orange_peel(&self) -> bool {
        self.coat > 0.0 && self.lobes.coat_surface.peel > 0.0
    }

    /// True if the coat has scratches.
    pub fn has_scratches(&self) -> bool {
        self.coat > 0.0 && self.lobes.coat_surface.scratches > 0.0
    }

    /// True if the coat has swirl marks.
    pub fn has_swirl(&self) -> bool {
        self.coat > 0.0 && self.lobes.coat_surface.swirl > 0.0
    }

    /// True if there are flakes, orange peel, scratches or swirl marks.
    pub fn is_painted(&self) -> bool {
        self.has_flakes() || self.has_orange_peel() || self.has_scratches() || self.has_swirl()
    }
}

group! {
    /// Flakes of metal or coated mica in the base.
    ///
    /// Each flake is a metal mirror, a little rough, that lies at an angle of its own. Where pixels are smaller than flakes each is
    /// seen; where they are larger a pixel shows the mean of its flakes, which strays from that of all of them, a rough metal, by
    /// as much less as there are more.
    ///
    /// The default is none; if there were some, of aluminium, a third of a millimetre wide.
    Flakes {
        /// Share of the base that they cover, 0 none to 1 all.
        share: f32 = 0.0,
        /// Reflectance at normal incidence, linear, 0 to 1. With a film: that of the flake beneath the film.
        color: [f32; 3] = [0.91, 0.92, 0.92],
        /// Their diameter in metres, [`Flakes::LEAST_SIZE`] or more.
        size: f32 = 0.000_3,
        /// Spread of their tilt, 0 (all of them flat) to 1: the perceptual roughness of the GGX surface that perfectly
        /// smooth ones make together.
        spread: f32 = 0.5,
        /// Perceptual roughness of each flake, 0 to 1.
        roughness: f32 = 0.2,
        /// Thickness in nanometres of a film on them whose colour depends on the angle (pearl); 0 is none.
        film_thickness: f32 = 0.0,
        /// Index of refraction of the film, 1.5 or more: that of the paint around it is 1.5. Titania has about 2.5, iron oxide 2.9.
        film_ior: f32 = 2.5,
        /// Share of the light a flake does not reflect that reaches the base beneath, 0 none (metal) to 1 all (mica).
        transparency: f32 = 0.0,
    }
}

impl Flakes {
    /// The least diameter in metres.
    pub const LEAST_SIZE: f32 = 1e-6;
}

group! {
    /// Surface of a coat that is no perfect mirror, which the default is.
    CoatSurface {
        /// Orange peel: the root mean square of the slopes of its waves along each axis, 0 none to 1. Good paintwork has .005, bad .03.
        peel: f32 = 0.0,
        /// Length of these waves in metres, [`Flakes::LEAST_SIZE`] or more: they are .75 to 2.4 times as long. Of cars the eye sees those of 1 to
        /// 10 millimetres. The edges that a surface of radius R mirrors are bent and stay whole where the slope is less than a twentieth
        /// of this length over R.
        peel_size: f32 = 0.005,
        /// Scratches: share of the coat that they cover, 0 none to 1.
        scratches: f32 = 0.0,
        /// Length of a scratch in metres, [`Flakes::LEAST_SIZE`] or more.
        scratch_length: f32 = 0.03,
        /// Swirl marks, as of washing: share of the coat that their fine grooves cover, 0 none to 1. They are seen about the reflections of lights alone.
        swirl: f32 = 0.0,
        /// Length of such a groove in metres, [`Flakes::LEAST_SIZE`] or more.
        swirl_size: f32 = 0.03,
    }
}
