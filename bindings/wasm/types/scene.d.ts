import type { Bytes, Limits, ModelInfo, RenderedImage, RenderOptions } from "./index.js";
import type { Description } from "./description.js";

type HandleKind = "model" | "instance" | "mesh" | "material" | "light";

/**
 * Names a part of one scene until it is removed. Used afterwards, or with another scene, it rejects with code "options"; it never
 * becomes the name of something else.
 */
export interface Handle<Kind extends HandleKind = HandleKind> {
  readonly kind: Kind;
  /** The scene that it is in. */
  readonly scene: Scene;
}

export interface MaterialHandle extends Handle<"material"> {
  /** What it is called in its file; "" if it has no name. */
  readonly name: string;
}

/** A model: one place and one pose, and the parts of its file, in its order. */
export interface ModelHandle extends Handle<"model"> {
  /** What the file is, as it was added; its box is that of the model's own axes. */
  readonly info: ModelInfo;
  readonly instances: readonly Handle<"instance">[];
  readonly materials: readonly MaterialHandle[];
  readonly lights: readonly Handle<"light">[];
  /** Seconds to the last key frame of its animation; null if it was added without one. */
  readonly duration: number | null;
}

/** 16 numbers, column by column, as in glTF and WebGL: a typed array, an array, a `DOMMatrix`, a `Matrix4` of three.js. */
export type Matrix = ArrayLike<number> | { toFloat64Array(): Float64Array } | { readonly elements: ArrayLike<number> };

/** What a mesh is made of. All arrays are copied. */
export interface MeshArrays {
  /** x, y and z of each vertex, in metres; +Y is up. */
  positions: ArrayLike<number>;
  /** "triangles" if absent; "lines", two vertices each, as wide as `line_width`; "points", one each, as large as `point_size`. */
  kind?: "triangles" | "lines" | "points";
  /** Three vertices of each triangle, counter-clockwise seen from the front, or as `kind` says. If absent, those that follow each other. */
  indices?: ArrayLike<number>;
  /** x, y and z of each vertex's normal, of any length. If absent, faces are flat, or smooth by `crease_deg`. */
  normals?: ArrayLike<number>;
  /** Two numbers a vertex; (0, 0) is the upper left of a texture. */
  uvs?: ArrayLike<number>;
  /** Red, green, blue (linear) and alpha of each vertex, 0 to 1; they multiply those of the material. */
  colors?: ArrayLike<number>;
  /** Without normals, smooth ones are found, with edges where faces meet at more than this many degrees, 0 to 180. 0 if absent: flat. */
  crease_deg?: number;
}

/**
 * A picture of numbers as a texture, row 0 on top, with 1, 3 or 4 numbers a pixel: bytes, or floats from 0 to 1, that mean what they do in
 * files: sRGB in textures of colours, linear in others.
 */
export interface Picture {
  data: Uint8Array | Uint8ClampedArray | Float32Array;
  width: number;
  height: number;
}

/**
 * A material: the name of a built-in one or of one of `files` (.toml), the keys of a material file, or null for clay. Textures are names
 * of `files` or pictures of numbers (an `ImageData`), alone or as `file` of an object with `wrap`, `scale` and others.
 */
export type MaterialSource = string | Record<string, unknown> | null;

/** Files that are referred to, by name. */
type Files = Pick<RenderOptions, "files">;

/** Options of a picture of a scene; what is in the scene is not among them. */
export type PictureOptions = Omit<
  RenderOptions,
  "env" | "env_rotation_deg" | "env_intensity" | "light" | "lights" | "material" | "materials" | "animation" | "loop" | "up" | "time" | "files"
>;

/** What is said once about a scene. */
export interface SceneOptions extends Omit<PictureOptions, "signal"> {
  /** Of each file, mesh and picture. */
  limits?: Limits;
  /**
   * On a thread of its own (true) or the caller's (false), where what has begun cannot be cancelled. If absent: true in browsers,
   * false in Node.js.
   */
  worker?: boolean;
}

export interface ModelOptions extends Files, Pick<Description, "animation" | "time" | "loop" | "up" | "material" | "materials"> {
  /** Model to world. */
  transform?: Matrix;
}

/** What is seen in a pixel. */
export interface Hit {
  instance: Handle<"instance">;
  /** The model that it is a part of. */
  model: ModelHandle | null;
  /** What it is made of. */
  material: MaterialHandle | null;
  /** Its number in the mesh; of meshes of points, that of the point. */
  triangle: number;
  /** Numbers of its three vertices in the mesh. */
  vertices: [number, number, number];
  /** Weights of the vertices where it is seen, 0 to 1, of sum 1. */
  barycentric: [number, number, number];
  /** Metres along the view direction, as the plane "depth". */
  depth: number;
  /** Where that is, in metres. */
  position: [number, number, number];
  /** Seen from behind. */
  back_facing: boolean;
}

/**
 * A scene that is kept: what is in it has handles, which stay while other things come and go. What is asked is done in that order,
 * waited for or not; what is refused changes nothing. Lengths are metres, +Y is up. All methods reject with an `OvercoatError`.
 */
export declare class Scene {
  /** An empty scene under the studio. Options of pictures hold for all that `render` draws, under its own. */
  constructor(options?: SceneOptions);
  /** A scene with one model in it. `render` draws what the function of that name draws of the file, to the bit. */
  static load(model: Bytes, options?: SceneOptions): Promise<Scene>;
  /** Adds a model file (glTF, GLB, OBJ, STL, PLY, 3MF, FBX, COLLADA and others) with its lights; with `animation`, `setPose` can move it. */
  addModel(model: Bytes, options?: ModelOptions): Promise<ModelHandle>;
  /** Adds a mesh, to be placed by `addInstance`. */
  addMesh(mesh: MeshArrays): Promise<Handle<"mesh">>;
  /** Adds a material; clay if nothing is said of it. */
  addMaterial(source?: MaterialSource, options?: Files): Promise<MaterialHandle>;
  /** Places a mesh. */
  addInstance(mesh: Handle<"mesh">, material: Handle<"material">, transform?: Matrix): Promise<Handle<"instance">>;
  /** Adds a light, with the keys of scene files. */
  addLight(light: NonNullable<Description["light"]>[number]): Promise<Handle<"light">>;
  /** Moves an instance, or a model with all of its parts. Of a model's instance it is the place in the model. */
  setTransform(handle: Handle<"instance"> | ModelHandle, transform: Matrix): Promise<void>;
  /** Where it is: 16 numbers, column by column. */
  getTransform(handle: Handle<"instance"> | ModelHandle): Promise<Float64Array>;
  /** Hides it, or shows it again. The lights of a hidden model go on shining. */
  setVisible(handle: Handle<"instance"> | ModelHandle, visible: boolean): Promise<void>;
  /** Brings a model to a time of its animation, in seconds from 0 on. */
  setPose(model: ModelHandle, seconds: number): Promise<void>;
  /** Puts another mesh in the place of one, in every instance of it. */
  setMesh(handle: Handle<"mesh">, mesh: MeshArrays): Promise<void>;
  /** Puts another material in the place of one, in every instance made of it. With `over: true` keys that are not there stay. */
  setMaterial(handle: Handle<"material">, source: MaterialSource, options?: Files): Promise<void>;
  setInstanceMesh(instance: Handle<"instance">, mesh: Handle<"mesh">): Promise<void>;
  setInstanceMaterial(instance: Handle<"instance">, material: Handle<"material">): Promise<void>;
  /** Puts another light in the place of one. */
  setLight(handle: Handle<"light">, light: NonNullable<Description["light"]>[number]): Promise<void>;
  /** Light from afar. What is not said stays as it is. */
  setEnvironment(options: Files & Pick<RenderOptions, "env" | "env_rotation_deg" | "env_intensity">): Promise<void>;
  /** Removes it: a model with all of its parts; a mesh or a material only if no instance is made of it. */
  remove(handle: Handle): Promise<void>;
  /** Draws the scene as it is. */
  render(options?: PictureOptions): Promise<RenderedImage>;
  /**
   * What is seen in a pixel, counted from the upper left corner, without drawing: of the picture that `render` draws with these
   * options; if absent, with those of the last picture. null where there is nothing; floor and environment are not found.
   */
  pick(x: number, y: number, options?: PictureOptions): Promise<Hit | null>;
  /** Gives its memory back; it cannot be used any more. */
  free(): void;
  [Symbol.dispose](): void;
}
