// Made of crates/description/src/scene.schema.json by scripts/types.mjs.

export const shadingModels = Object.freeze([
  "urp-desktop",
  "urp-mobile",
  "urp17",
  "hdrp-lit",
  "stacklit",
  "filament",
  "filament-mobile",
  "filament-cloth",
  "filament-2018",
  "three",
  "three-legacy",
  "gltf",
  "gltf-sampled",
  "openpbr",
  "velvet",
  "babylon",
  "standard",
  "stacklit-d"
]);

export const qualities = Object.freeze([
  "draft",
  "fast",
  "good",
  "best"
]);

export const toneCurves = Object.freeze([
  "none",
  "neutral",
  "aces",
  "agx",
  "linear"
]);

export const builtinMaterials = Object.freeze([
  "anodised-aluminium",
  "black-piano-lacquer",
  "brushed-aluminium-lacquered",
  "candy-blue",
  "candy-red",
  "candy-violet",
  "carbon-fibre",
  "chameleon",
  "champagne-metallic",
  "frosted-coat",
  "gold-leaf-varnished",
  "hazy-gloss-plastic",
  "matte-wrap",
  "metalflake-red",
  "midnight-flake",
  "orange-peel-white",
  "pearl-black",
  "pearl-blue",
  "pearl-white",
  "red-metallic",
  "satin-gunmetal",
  "silver-metallic",
  "skin",
  "swirled-black",
  "two-lobe-satin",
  "varnished-oak",
  "velvet",
  "wet-stone"
]);

export const backgrounds = Object.freeze([
  "transparent",
  "env",
  "black",
  "silver",
  "gray",
  "grey",
  "white",
  "maroon",
  "red",
  "purple",
  "fuchsia",
  "magenta",
  "green",
  "lime",
  "olive",
  "yellow",
  "navy",
  "blue",
  "teal",
  "aqua",
  "cyan",
  "orange"
]);

export const views = Object.freeze([
  "three-quarter",
  "front",
  "back",
  "left",
  "right",
  "top",
  "bottom"
]);
