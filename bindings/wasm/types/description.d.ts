// Made of src/description/scene.schema.json by scripts/types.mjs.

/** What a picture shows and how: the keys of scene files, but for the model. Every key may be left out. */
export interface Description {
  /** An animation of the model file, by name or number from 0. */
  animation?: string | number;
  /** Largest anisotropy of texture filtering. */
  anisotropy?: number;
  /** How reflections of rectangles and tubes are integrated. */
  area_lights?: "ltc" | "facets";
  /** What is behind the model: transparent, env, a colour name or #rrggbb. */
  background?: "transparent" | "env" | "black" | "silver" | "gray" | "grey" | "white" | "maroon" | "red" | "purple" | "fuchsia" | "magenta" | "green" | "lime" | "olive" | "yellow" | "navy" | "blue" | "teal" | "aqua" | "cyan" | "orange" | (string & {});
  /** The camera. Without eye the model is framed automatically, seen along view. */
  camera?: {
    /** A camera of the model file, by name or number from 0. */
    camera?: string | number;
    /** Where the camera is, in metres. */
    eye?: [number, number, number];
    /** Read over: there is no far limit. */
    far?: unknown;
    /** Vertical field of view in degrees. */
    fov_y_deg?: number;
    /** Nothing nearer than this distance in metres is drawn. */
    near?: number;
    /** Parallel projection that shows this many metres from top to bottom; 0 fits the model. */
    ortho_height?: number;
    /** What is in the centre of the picture, in metres; the middle of the model if absent. */
    target?: [number, number, number];
    /** Which way is up in the picture; +Y if absent. */
    up?: [number, number, number];
    /** Where an automatic camera stands: a name, or x,y,z from the model towards it. */
    view?: "three-quarter" | "front" | "back" | "left" | "right" | "top" | "bottom" | (string & {});
  };
  /** Light from afar: studio, none or the path of an equirectangular picture. */
  env?: "studio" | "none" | (string & {});
  /** Multiplies the environment's radiance. */
  env_intensity?: number;
  /** Turns the environment about +Y, in degrees, counter-clockwise seen from above. */
  env_rotation_deg?: number;
  /** Exposure of 8-bit output in stops, or auto. */
  exposure?: number | "auto";
  /** What is seen of a floor under the model: none, shadow, a colour name or #rrggbb; if absent shadow, without maps none. */
  ground?: "none" | "shadow" | "black" | "silver" | "gray" | "grey" | "white" | "maroon" | "red" | "purple" | "fuchsia" | "magenta" | "green" | "lime" | "olive" | "yellow" | "navy" | "blue" | "teal" | "aqua" | "cyan" | "orange" | (string & {});
  /** How much of the model the floor mirrors; 0 if absent. */
  ground_reflection?: number;
  /** Pictures to compare with, for readers. */
  ground_truth?: unknown;
  /** Lights beside those of the model file. */
  light?: ({
    /** Linear red, green and blue, or an sRGB colour #rrggbb; white if absent. */
    color?: [number, number, number] | string;
    /** In which the light travels; any length but zero. */
    direction: [number, number, number];
    /** Lux of directional lights, candela of points and spots, candela per square metre of rectangles and tubes. */
    intensity: number;
    /** Least roughness (alpha) of what it shines on, where a material honours it; 0 if absent. */
    min_roughness?: number;
    /** What kind of light it is. */
    type: "directional";
  } | {
    /** Linear red, green and blue, or an sRGB colour #rrggbb; white if absent. */
    color?: [number, number, number] | string;
    /** Lux of directional lights, candela of points and spots, candela per square metre of rectangles and tubes. */
    intensity: number;
    /** Least roughness (alpha) of what it shines on, where a material honours it; 0 if absent. */
    min_roughness?: number;
    /** Where it is, of a rectangle its centre, in metres. */
    position: [number, number, number];
    /** Metres to where it has faded out. */
    range?: number;
    /** What kind of light it is. */
    type: "point";
  } | {
    /** Linear red, green and blue, or an sRGB colour #rrggbb; white if absent. */
    color?: [number, number, number] | string;
    /** Half angle inside which it is full, in degrees; 0 if absent. */
    inner_cone_deg?: number;
    /** Lux of directional lights, candela of points and spots, candela per square metre of rectangles and tubes. */
    intensity: number;
    /** Least roughness (alpha) of what it shines on, where a material honours it; 0 if absent. */
    min_roughness?: number;
    /** Half angle outside which it is dark, in degrees; 45 if absent. */
    outer_cone_deg?: number;
    /** Where it is, of a rectangle its centre, in metres. */
    position: [number, number, number];
    /** Metres to where it has faded out. */
    range?: number;
    /** What it points at, or its front faces, in metres. */
    target: [number, number, number];
    /** What kind of light it is. */
    type: "spot";
  } | {
    /** Linear red, green and blue, or an sRGB colour #rrggbb; white if absent. */
    color?: [number, number, number] | string;
    /** Lux of directional lights, candela of points and spots, candela per square metre of rectangles and tubes. */
    intensity: number;
    /** Where it is, of a rectangle its centre, in metres. */
    position: [number, number, number];
    /** Width and height in metres. */
    size: [number, number];
    /** What it points at, or its front faces, in metres. */
    target: [number, number, number];
    /** Shines from its back as well. */
    two_sided?: boolean;
    /** What kind of light it is. */
    type: "rect";
    /** Which way is up on it; +Y if absent. */
    up?: [number, number, number];
  } | {
    /** Linear red, green and blue, or an sRGB colour #rrggbb; white if absent. */
    color?: [number, number, number] | string;
    /** One end of its axis, in metres. */
    from: [number, number, number];
    /** Lux of directional lights, candela of points and spots, candela per square metre of rectangles and tubes. */
    intensity: number;
    /** Metres. */
    radius: number;
    /** The other end of its axis, in metres. */
    to: [number, number, number];
    /** What kind of light it is. */
    type: "tube";
  })[];
  /** False leaves out the lights of the model file. */
  lights?: boolean;
  /** Width of lines in pixels. */
  line_width?: number;
  /** After its end the animation begins again. */
  loop?: boolean;
  /** Texels along a side of a depth map. */
  map_size?: number;
  /** Directions of the environment's light, each with a depth map; 0: nothing blocks it. */
  maps?: number;
  /** A material for every mesh: the path of a material file, or a built-in one. */
  material?: "anodised-aluminium" | "black-piano-lacquer" | "brushed-aluminium-lacquered" | "candy-blue" | "candy-red" | "candy-violet" | "carbon-fibre" | "chameleon" | "champagne-metallic" | "frosted-coat" | "gold-leaf-varnished" | "hazy-gloss-plastic" | "matte-wrap" | "metalflake-red" | "midnight-flake" | "orange-peel-white" | "pearl-black" | "pearl-blue" | "pearl-white" | "red-metallic" | "satin-gunmetal" | "silver-metallic" | "skin" | "swirled-black" | "two-lobe-satin" | "varnished-oak" | "velvet" | "wet-stone" | (string & {});
  /** Materials by the names of those in the model that they take the place of. */
  materials?: Record<string, "anodised-aluminium" | "black-piano-lacquer" | "brushed-aluminium-lacquered" | "candy-blue" | "candy-red" | "candy-violet" | "carbon-fibre" | "chameleon" | "champagne-metallic" | "frosted-coat" | "gold-leaf-varnished" | "hazy-gloss-plastic" | "matte-wrap" | "metalflake-red" | "midnight-flake" | "orange-peel-white" | "pearl-black" | "pearl-blue" | "pearl-white" | "red-metallic" | "satin-gunmetal" | "silver-metallic" | "skin" | "swirled-black" | "two-lobe-satin" | "varnished-oak" | "velvet" | "wet-stone" | (string & {})>;
  /** Triangles smaller than a pixel are shaded as one where their normals differ by less than this, in degrees. */
  merge_angle_deg?: number;
  /** A name, for readers. */
  name?: unknown;
  /** A note, for readers. */
  note?: unknown;
  /** Pictures of other programs, for readers. */
  peers?: unknown;
  /** Diameter of points in pixels. */
  point_size?: number;
  /** What a picture is worth: sets maps, map_size, rays and shading_rate; fast if absent. */
  quality?: "draft" | "fast" | "good" | "best";
  /** Rays that each lobe of a fragment sends for the light of other surfaces. */
  rays?: number;
  /** Coverage samples a pixel. */
  samples?: 1 | 4 | 8 | 16;
  /** Every surface is shaded as often, and not only where one shading would show. */
  shade_everywhere?: boolean;
  /** Shading model of every material; what each material names if absent. */
  shading?: "urp-desktop" | "urp-mobile" | "urp17" | "hdrp-lit" | "stacklit" | "filament" | "filament-mobile" | "filament-cloth" | "filament-2018" | "three" | "three-legacy" | "gltf" | "gltf-sampled" | "openpbr" | "velvet" | "babylon" | "standard" | "stacklit-d";
  /** Shadings a pixel where one would show; a picture has at least as many samples. */
  shading_rate?: 1 | 4 | 8 | 9 | 16;
  /** Width and height in pixels; one number makes a square. */
  size?: number | [number, number];
  /** Roughness grows where normals vary within a pixel; models of three.js always have their own way. */
  specular_antialiasing?: boolean;
  /** Seconds in the animation. */
  time?: number;
  /** Tone curve of 8-bit output; of a list of names the first counts. */
  tone_mapping?: "none" | "neutral" | "aces" | "agx" | "linear" | ("none" | "neutral" | "aces" | "agx" | "linear")[];
  /** Which axis of the model file is up; what its format has if absent. */
  up?: "+x" | "-x" | "+y" | "-y" | "+z" | "-z" | "x" | "y" | "z";
}
