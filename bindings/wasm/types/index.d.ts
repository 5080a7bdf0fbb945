import type { Description } from "./description.js";
import type { Scene, SceneOptions } from "./scene.js";

export type { Description } from "./description.js";
export * from "./names.js";
export * from "./scene.js";
export * from "./three.js";

/** The bytes of a file. They are copied; whoever gives them keeps them. */
export type Bytes = Uint8Array | ArrayBuffer | ArrayBufferView | Blob;

/** Bounds on what a file may ask for and on what a picture may cost; see the table of limits in the README. */
export interface Limits {
  input_bytes?: number;
  decoded_bytes?: number;
  triangles?: number;
  vertices?: number;
  nodes?: number;
  depth?: number;
  textures?: number;
  texture_pixels?: number;
  total_texture_pixels?: number;
  lights?: number;
  output_side?: number;
  output_pixels?: number;
  fragments?: number;
  shading?: number;
  blocks?: number;
  blend_entries?: number;
  frame_bytes?: number;
  frames?: number;
}

/** What a picture shows, and how it is asked for. */
export interface RenderOptions extends Omit<Description, "env"> {
  /** Light from afar: one of the program's own (studio if absent), the name of one of `files`, or the bytes of an equirectangular
   * picture (.hdr, .exr, .png, .jpg). */
  env?: Description["env"] | Bytes;
  /** What the model refers to, and environments and material files that are named here: contents by name. */
  files?: Record<string, Bytes> | Map<string, Bytes>;
  /** Planes of the G-buffer beside the pixels: "depth", "normal", "base-color", ... */
  aovs?: string[];
  /** Also gives `linear`. */
  linear?: boolean;
  /** Cancels: the promise rejects with the signal's reason, and the thread that was drawing is ended. */
  signal?: AbortSignal;
}

/** What is said once about a model. */
export interface LoadOptions extends RenderOptions {
  limits?: Limits;
  /** On a thread of its own (true) or the caller's (false). If absent: true in browsers; in Node.js true if there is a signal. */
  worker?: boolean;
}

/** A camera as programs that compute with it need it. Matrices are rows of numbers; coordinates are those of the model's file. */
export interface CameraMatrices {
  kind: "perspective" | "orthographic";
  /** Size of the picture in pixels. */
  width: number;
  height: number;
  /**
   * fx, 0, cx; 0, fy, cy; 0, 0, 1 in pixels: a point (x right, y down, z forward) is seen at fx x / z + cx, fy y / z + cy, where the first
   * pixel's centre is at 0.5; of a parallel projection without "/ z".
   */
  K: [[number, number, number], [number, number, number], [number, number, number]];
  /** The pose in the convention of OpenCV: x right, y down, z forward. */
  world_to_camera: number[][];
  /** The pose in the convention of OpenGL and three.js: x right, y up, z backward. */
  camera_to_world: number[][];
  /** In metres; `far` is null without a limit. */
  near: number;
  far: number | null;
}

/** A picture. */
export declare class RenderedImage {
  private constructor();
  /** Width in pixels. */
  readonly width: number;
  /** Height in pixels. */
  readonly height: number;
  /** RGBA, 8 bits, sRGB, straight alpha, row by row from the top: what `ImageData` takes. */
  readonly pixels: Uint8ClampedArray<ArrayBuffer>;
  /** XXH3-128 of the linear frame in hexadecimal: the same on every machine, and what `overcoat render --json` prints. */
  readonly hash: string;
  /** What the model asks for and the picture does not show; what is doubtful about the options. */
  readonly warnings: string[];
  /** The camera that it was taken with. */
  readonly camera: CameraMatrices;
  /** RGBA, linear Rec. 709, premultiplied by alpha, row by row from the top; if `linear` was asked for. */
  readonly linear?: Float32Array;
  /** The planes that were asked for, by name: as many numbers a pixel as the plane has channels; identities are whole numbers. */
  readonly aovs: Record<string, Float32Array | Uint32Array>;
  /** A PNG file, the same bytes as the command writes. */
  png(): Promise<Uint8Array<ArrayBuffer>>;
  /** A lossless WebP file. */
  webp(): Promise<Uint8Array<ArrayBuffer>>;
  /** A JPEG file, of quality 1 to 100 (90); what is transparent is lost, so ask for a `background`. */
  jpeg(quality?: number): Promise<Uint8Array<ArrayBuffer>>;
  /** A file as a Blob: "image/png" (if absent), "image/webp" or "image/jpeg". */
  toBlob(type?: "image/png" | "image/webp" | "image/jpeg"): Promise<Blob>;
  /** For `putImageData`; shares the pixels. */
  toImageData(): ImageData;
}

/** What a model is. */
export interface ModelInfo {
  triangles: number;
  splats: number;
  instances: number;
  /** Names of materials, "" where there is none. */
  materials: string[];
  /** Names of cameras, "" where there is none. */
  cameras: string[];
  /** The box of what is seen, in metres, +Y up. */
  min: [number, number, number];
  max: [number, number, number];
  warnings: string[];
}

/** A model that is loaded, with what was prepared for its last picture: the next one from elsewhere takes less. */
export declare class Model {
  private constructor();
  readonly info: ModelInfo;
  /** Draws it. Options are laid over those of `load`, key by key; files stay with the model. */
  render(options?: RenderOptions): Promise<RenderedImage>;
  /** Gives its memory back; it cannot be drawn any more. */
  free(): void;
  [Symbol.dispose](): void;
}

/** Draws a model file (glTF, GLB, OBJ, STL, PLY, 3MF, FBX, COLLADA and others) once. Rejects with an {@link OvercoatError}, or the reason of the signal. */
export declare function render(model: Bytes, options?: LoadOptions): Promise<RenderedImage>;

/** Reads a model file, to be drawn many times. */
export declare function load(model: Bytes, options?: LoadOptions): Promise<Model>;

/** A renderer on a thread of its own: pictures of one do not wait for those of another. */
export declare function createRenderer(): {
  render(model: Bytes, options?: LoadOptions): Promise<RenderedImage>;
  load(model: Bytes, options?: LoadOptions): Promise<Model>;
  scene(options?: Omit<SceneOptions, "worker">): Scene;
  about(): Promise<{ version: string; lanes: "simd128" | "scalar" }>;
  /** Ends the thread; what it has not finished rejects. */
  close(): void;
};

/** The version, and the instruction set of the module. */
export declare function about(options?: { worker?: boolean }): Promise<{ version: string; lanes: "simd128" | "scalar" }>;

/** Which build this machine runs: "simd" where it has vectors. Both draw the same bits. */
export declare function bestBuild(): "simd" | "plain";

/** How two pictures differ. */
export interface Comparison {
  /** Equal, or within the thresholds. */
  good: boolean;
  verdict: string;
  reasons: string[];
  /** null if the pictures cannot be measured against each other. `psnr` is null where they are equal. */
  metrics: null | {
    max_abs: number;
    pixels: number;
    psnr: number | null;
    ssim: number;
    flip_mean: number;
    flip_max: number;
  };
}

/** Holds two picture files against each other, by the rules of `overcoat golden check`. */
export declare function compare(
  expected: Bytes,
  actual: Bytes,
  options?: {
    /** By which `thresholds` knows it: "cars/red.png". */
    name?: string;
    /** The text of a thresholds.toml; if absent every pixel must be equal. */
    thresholds?: string;
    limits?: Limits;
    worker?: boolean;
  },
): Promise<Comparison>;

/** Why there is no picture; see `code`. */
export declare class OvercoatError extends Error {
  /** "options": what was asked for is wrong. "input": a file is, or a limit is exceeded. "crash": the module ended, and was
   * started anew. "golden": a picture is not as expected. */
  readonly code: "options" | "input" | "crash" | "golden";
}
