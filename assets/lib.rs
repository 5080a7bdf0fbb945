//! Data that overcoat has built in: pre-integrated tables of shading models, the studio environment, materials. All of it is made by
//! `examples/make-assets`; README.md says what each file is.

/// Pre-integrated tables, deflated.
pub mod tables {
    /// Directional albedo of Unity's GGX and Disney diffuse.
    pub const UNITY_FGD: &[u8] = include_bytes!("tables/unity-fgd.bin");
    /// Filament's DFG terms.
    pub const FILAMENT_DFG: &[u8] = include_bytes!("tables/filament-dfg.bin");
    /// three.js's DFG terms.
    pub const THREE_DFG: &[u8] = include_bytes!("tables/three-dfg.bin");
    /// The lookup of the Khronos glTF sample renderer.
    pub const KHRONOS: &[u8] = include_bytes!("tables/khronos.bin");
    /// Directional albedo of sheen.
    pub const SHEEN_ALBEDO: &[u8] = include_bytes!("tables/sheen-albedo.bin");
    /// Directional albedo of GGX with multiple scattering.
    pub const GGX_ALBEDO: &[u8] = include_bytes!("tables/ggx-albedo.bin");
    /// Linearly transformed cosines of GGX.
    pub const LTC_GGX: &[u8] = include_bytes!("tables/ltc-ggx.bin");
}

/// The studio: the light that any model is photographed in unless a scene says otherwise.
pub mod environment {
    /// Filtered, as it is.
    pub const STUDIO: &[u8] = include_bytes!("environment/studio.env");
    /// Filtered, in three fifths of the bytes.
    pub const STUDIO_PACKED: &[u8] = include_bytes!("environment/studio.packed");
    /// Directions of its light, of the numbers that the tiers ask for.
    pub const STUDIO_DIRECTIONS: &[u8] = include_bytes!("environment/studio.directions");
}

/// A material file and its textures.
#[derive(Clone, Copy, Debug)]
pub struct Material {
    /// Name: the stem of its file.
    pub name: &'static str,
    /// The file.
    pub text: &'static str,
    /// PNG files by the names under which the file refers to them.
    pub textures: &'static [(&'static str, &'static [u8])],
}

macro_rules! material {
    ($name:literal $(, $texture:literal)*) => {
        Material {
            name: $name,
            text: include_str!(concat!("materials/", $name, ".toml")),
            textures: &[$((
                concat!("textures/", $texture, ".png"),
                include_bytes!(concat!("materials/textures/", $texture, ".png")),
            )),*],
        }
    };
}

/// All materials, by name.
pub const MATERIALS: &[Material] = &[
    material!("anodised-aluminium"),
    material!("black-piano-lacquer"),
    material!("brushed-aluminium-lacquered", "brushed-normal"),
    material!("candy-blue"),
    material!("candy-red", "flakes-normal"),
    material!("candy-violet"),
    material!("carbon-fibre", "carbon-color", "carbon-normal", "carbon-anisotropy"),
    material!("chameleon"),
    material!("champagne-metallic"),
    material!("frosted-coat", "frost-normal"),
    material!("gold-leaf-varnished", "leaf-normal", "leaf-color"),
    material!("hazy-gloss-plastic"),
    material!("matte-wrap"),
    material!("metalflake-red"),
    material!("midnight-flake"),
    material!("orange-peel-white"),
    material!("pearl-black"),
    material!("pearl-blue", "flakes-normal"),
    material!("pearl-white"),
    material!("red-metallic", "flakes-normal"),
    material!("satin-gunmetal"),
    material!("silver-metallic"),
    material!("skin", "skin-normal"),
    material!("swirled-black"),
    material!("two-lobe-satin"),
    material!("varnished-oak", "oak-color"),
    material!("velvet"),
    material!("wet-stone", "stone-color", "stone-normal", "stone-wet"),
];
