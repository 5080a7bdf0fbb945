// Made of crates/description/src/scene.schema.json by scripts/types.mjs.

/** What a picture shows and how: the keys of scene files, but for the model. Every key may be left out. */
export interface Description {
  /** Animation of the model file (glTF), by name or by number from 0 [default: none, the pose of the file]. */
  animation?: string | number;
  /** Largest anisotropy of texture filtering, 1 to 16 [default: 8]. */
  anisotropy?: number;
  /** Surface of a pixel that planes of depth, place, direction and identity show: center or nearest [default: center]. */
  aov_sample?: "center" | "nearest";
  /** Integration of the reflections of rectangles and tubes: ltc, as engines do, or facets, slower and within 1 percent [default: ltc]. */
  area_lights?: "ltc" | "facets";
  /** Background: transparent, env, #rrggbb (the # may be left out) or a colour name [default: transparent, of .jpg white]. */
  background?: "transparent" | "env" | "black" | "silver" | "gray" | "grey" | "white" | "maroon" | "red" | "purple" | "fuchsia" | "magenta" | "green" | "lime" | "olive" | "yellow" | "navy" | "blue" | "teal" | "aqua" | "cyan" | "orange" | (string & {});
  /** The camera. Without eye the model is framed automatically, seen along view. */
  camera?: {
    /** Intrinsics in pixels, in place of a field of view: the matrix fx, 0, cx; 0, fy, cy; 0, 0, 1, or the list fx, fy, cx, cy. */
    K?: [[number, number, number], [number, number, number], [number, number, number]] | [number, number, number, number];
    /** Camera of the model file, by name or by number from 0. */
    camera?: string | number;
    /** Meaning of the pose: opencv (world to camera, +x right, +y down, +z forward) or opengl (camera to world, +y up, -z forward). */
    convention?: "opencv" | "opengl";
    /** Principal point in pixels from the left border: the first pixel's centre is at 0.5. */
    cx?: number;
    /** Principal point in pixels from the upper border. */
    cy?: number;
    /** Position of the camera in metres, in the scene: the upright model, +Y is up. */
    eye?: [number, number, number];
    /** No surface farther from the camera than this many metres is drawn [default: no limit]. */
    far?: number;
    /** Vertical field of view in degrees, 0.1 to 179 [default: 30]. */
    fov_y_deg?: number;
    /** Focal length in widths of a pixel; with fy, cx and cy in place of K. */
    fx?: number;
    /** Focal length in heights of a pixel. */
    fy?: number;
    /** Width and height in pixels of the picture that the intrinsics are for; pictures of another size have its shape [default: that of the picture]. */
    intrinsics_size?: number | [number, number];
    /** Nothing nearer to the camera than this many metres is drawn [default: by the distance]. */
    near?: number;
    /** Parallel projection that shows this many metres from top to bottom; 0 fits the model. */
    ortho_height?: number;
    /** Position and direction of the camera, a 4 x 4 matrix: opencv, world to camera; opengl, camera to world, by convention. */
    pose?: [[number, number, number, number], [number, number, number, number], [number, number, number, number], [number, number, number, number]] | [number, number, number, number, number, number, number, number, number, number, number, number, number, number, number, number];
    /** Point in the centre of the picture, in metres [default: the middle of the model]. */
    target?: [number, number, number];
    /** Direction that is up in the picture [default: 0,1,0]. */
    up?: [number, number, number];
    /** Direction from which the model is framed: three-quarter, front, back, left, right, top, bottom, or x,y,z from the model towards the camera [default: three-quarter, or another one from the front and above that shows twice as much]. */
    view?: "three-quarter" | "front" | "back" | "left" | "right" | "top" | "bottom" | (string & {});
  };
  /** Strength by which concave creases are drawn darker and convex ones lighter, 0 to 2 [default: 1 of parts without colours (STL, 3MF, OBJ, PLY), but in draft; else 0]. */
  cavity?: number;
  /** Width of the lines of edges in pixels, 0.1 to 64 [default: 1.2 in 512x512, with the root of the shorter side]. */
  edge_width?: number;
  /** Edges that are drawn as dark lines: none, creases (where faces meet at more than 40 degrees) or boundary (and where they end) [default: creases of parts without colours (STL, 3MF, OBJ, PLY); else none]. */
  edges?: "none" | "creases" | "boundary";
  /** Equirectangular picture or cube (.hdr, .exr; .jpg, .png, .webp with a warning) that lights the scene, or one of the program's own: studio, car-studio, sky or none [default: studio]. */
  env?: "studio" | "car-studio" | "sky" | "none" | (string & {});
  /** Factor of the environment's radiance [default: 1]. */
  env_intensity?: number;
  /** Turn of the environment about the vertical axis in degrees, counter-clockwise seen from above [default: 0]. */
  env_rotation_deg?: number;
  /** Exposure of 8-bit pictures in stops, -64 to 64: +1 doubles the light; auto meters the object [default: 0]. */
  exposure?: number | "auto";
  /** Floor under the model: none, shadow (only the model's shadow, over what is behind it), #rrggbb or a colour name (a matt floor that fades) [default: shadow; of bench and without maps none]. */
  ground?: "none" | "shadow" | "black" | "silver" | "gray" | "grey" | "white" | "maroon" | "red" | "purple" | "fuchsia" | "magenta" | "green" | "lime" | "olive" | "yellow" | "navy" | "blue" | "teal" | "aqua" | "cyan" | "orange" | (string & {});
  /** Share of the model's light that the floor mirrors, 0 to 1 [default: 0]. */
  ground_reflection?: number;
  /** Pictures to compare with, for readers. */
  ground_truth?: unknown;
  /** Lights beside those of the model file. */
  light?: ({
    /** Linear red, green and blue, or an sRGB colour #rrggbb [default: white]. */
    color?: [number, number, number] | string;
    /** In which the light travels; any length but zero. */
    direction: [number, number, number];
    /** Lux of directional lights, candela of points and spots, candela per square metre of rectangles and tubes. */
    intensity: number;
    /** Least roughness (alpha) of what it shines on, where a material honours it, 0 to 1 [default: 0]. */
    min_roughness?: number;
    /** What kind of light it is. */
    type: "directional";
  } | {
    /** Linear red, green and blue, or an sRGB colour #rrggbb [default: white]. */
    color?: [number, number, number] | string;
    /** Lux of directional lights, candela of points and spots, candela per square metre of rectangles and tubes. */
    intensity: number;
    /** Least roughness (alpha) of what it shines on, where a material honours it, 0 to 1 [default: 0]. */
    min_roughness?: number;
    /** Where it is, of a rectangle its centre, in metres. */
    position: [number, number, number];
    /** Metres to where it has faded out. */
    range?: number;
    /** What kind of light it is. */
    type: "point";
  } | {
    /** Linear red, green and blue, or an sRGB colour #rrggbb [default: white]. */
    color?: [number, number, number] | string;
    /** Half angle inside which it is full, in degrees, 0 to 90 [default: 0]. */
    inner_cone_deg?: number;
    /** Lux of directional lights, candela of points and spots, candela per square metre of rectangles and tubes. */
    intensity: number;
    /** Least roughness (alpha) of what it shines on, where a material honours it, 0 to 1 [default: 0]. */
    min_roughness?: number;
    /** Half angle outside which it is dark, in degrees, 0 to 90 [default: 45]. */
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
    /** Linear red, green and blue, or an sRGB colour #rrggbb [default: white]. */
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
    /** Which way is up on it [default: +Y]. */
    up?: [number, number, number];
  } | {
    /** Linear red, green and blue, or an sRGB colour #rrggbb [default: white]. */
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
  /** Width of lines in pixels, 0.1 to 64 [default: 1.5]. */
  line_width?: number;
  /** Begin the animation again after its end. */
  loop?: boolean;
  /** Texels along a side of a depth map, 32 to 2048 [default: by the tier]. */
  map_size?: number;
  /** Directions of the environment's light, each with a depth map of the scene, 0 to 256 [default: by the tier]. */
  maps?: number;
  /** Material of every mesh: the path of a material file, or the name of a built-in one. */
  material?: "anodised-aluminium" | "black-piano-lacquer" | "brushed-aluminium-lacquered" | "candy-blue" | "candy-red" | "candy-violet" | "carbon-fibre" | "chameleon" | "champagne-metallic" | "frosted-coat" | "gold-leaf-varnished" | "hazy-gloss-plastic" | "matte-wrap" | "metalflake-red" | "midnight-flake" | "orange-peel-white" | "pearl-black" | "pearl-blue" | "pearl-white" | "red-metallic" | "satin-gunmetal" | "silver-metallic" | "skin" | "swirled-black" | "two-lobe-satin" | "varnished-oak" | "velvet" | "wet-stone" | (string & {});
  /** Materials by the names of the model's materials that they replace. */
  materials?: Record<string, "anodised-aluminium" | "black-piano-lacquer" | "brushed-aluminium-lacquered" | "candy-blue" | "candy-red" | "candy-violet" | "carbon-fibre" | "chameleon" | "champagne-metallic" | "frosted-coat" | "gold-leaf-varnished" | "hazy-gloss-plastic" | "matte-wrap" | "metalflake-red" | "midnight-flake" | "orange-peel-white" | "pearl-black" | "pearl-blue" | "pearl-white" | "red-metallic" | "satin-gunmetal" | "silver-metallic" | "skin" | "swirled-black" | "two-lobe-satin" | "varnished-oak" | "velvet" | "wet-stone" | (string & {})>;
  /** Shade triangles smaller than two pixels as one where their normals differ by less than this many degrees: faster on dense meshes, with less smoothing of sharp reflections, 0 to 45 [default: 0]. */
  merge_angle_deg?: number;
  /** A name, for readers. */
  name?: unknown;
  /** A note, for readers. */
  note?: unknown;
  /** Pictures of other programs, for readers. */
  peers?: unknown;
  /** Plate of a 3MF project that is drawn alone, by its number from 1, 1 to 4294967295 [default: all of them, side by side]. */
  plate?: number;
  /** Diameter of points in pixels, 0.1 to 64 [default: by the distances between them, at least about a pixel; 3 if they are far apart]. */
  point_size?: number;
  /** Quality tier: draft (no shadows), fast (shadows of the environment), good (and light from other surfaces by rays) or best [default: fast; of bench draft]. */
  quality?: "draft" | "fast" | "good" | "best";
  /** Rays that each lobe sends for the light of other surfaces, 0 to 256 [default: by the tier]. */
  rays?: number;
  /** Strength by which surfaces are drawn darker towards their outline, 0 to 2 [default: 1 of white models in the studio, but in draft; else 0]. */
  rim?: number;
  /** Samples a pixel for smooth edges, 1, 4, 8 or 16 [default: 8]. */
  samples?: 1 | 4 | 8 | 16;
  /** Shade every surface at the shading rate, and not only where one shading would show. */
  shade_everywhere?: boolean;
  /** Shading model of every surface [default: what each material names, else standard]. */
  shading?: "urp-desktop" | "urp-mobile" | "urp17" | "hdrp-lit" | "stacklit" | "filament" | "filament-mobile" | "filament-cloth" | "filament-2018" | "three" | "three-legacy" | "gltf" | "gltf-sampled" | "openpbr" | "velvet" | "babylon" | "standard" | "stacklit-d";
  /** Shadings a pixel where one would show (sharp highlights on curved surfaces, alpha masks, shining normal maps, textures without mip levels), with at least as many samples, 1, 4, 8, 9 or 16 [default: by the tier]. */
  shading_rate?: 1 | 4 | 8 | 9 | 16;
  /** Width and height in pixels; one number makes a square [default: 512x512]. */
  size?: number | [number, number];
  /** Let roughness grow where normals vary within a pixel, against flickering highlights: Filament's way in its models, Tokuyoshi's and Kaplanyan's of 2019 in others, and for what normal maps lose as they shrink; those of three.js always have their own. */
  specular_antialiasing?: boolean;
  /** Seconds in the animation; beyond its end it stays as it is there [default: 0]. */
  time?: number;
  /** Tone curve of 8-bit pictures: none (or linear), neutral, aces, agx; of a list of names in a scene file the first counts [default: neutral]. */
  tone_mapping?: "none" | "neutral" | "aces" | "agx" | "linear" | ("none" | "neutral" | "aces" | "agx" | "linear")[];
  /** Axis of the model file that is up; the model is turned upright, with its lights and cameras [default: that of the file or of its format; of formats that leave it to custom the one of +y and +z on which the model stands]. */
  up?: "+x" | "-x" | "+y" | "-y" | "+z" | "-z" | "x" | "y" | "z";
}
