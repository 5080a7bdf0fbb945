import type { Description } from "./description.js";
import type { RenderedImage } from "./index.js";
import type { PictureOptions, Scene, SceneOptions } from "./scene.js";

/** What is asked of objects of three.js, whichever version and types are there. */
interface Object3D {
  readonly isObject3D: true;
}
interface Camera extends Object3D {
  readonly isCamera?: boolean;
}

export interface ThreeOptions extends Omit<SceneOptions, "camera"> {
  /** Whose tone mapping and exposure the picture has; none if absent. */
  renderer?: { toneMapping: number; toneMappingExposure: number };
}

/** A scene of three.js as it was when `fromThree` was called. */
export declare class ThreeScene {
  /** The scene, to be changed like any other. */
  readonly scene: Scene;
  /** What of it is not drawn as three.js does, one sentence each. */
  readonly warnings: string[];
  /** Draws it from where its camera is now. */
  render(options?: PictureOptions): Promise<RenderedImage>;
  /** The options of such a picture. */
  options(options?: PictureOptions): PictureOptions;
  /** Gives its memory back. */
  free(): void;
}

/**
 * Takes over what is visible of a live scene: meshes, lines and points with their groups, instances, skins and morph targets as they are posed;
 * standard and physical materials with their textures (basic ones are unlit, others diffuse), directional, point, spot and rectangular lights,
 * ambient light as an environment. Options are those of pictures; if absent, `quality` is "fast" where a light casts shadows and else "draft",
 * there is no floor, and the tone mapping is that of `renderer` or none. It is a copy: call it again when the scene has changed. Textures have to be readable: a
 * `DataTexture`, or where there is an `OffscreenCanvas` whatever can be drawn into one.
 */
export declare function fromThree(scene: Object3D, camera: Camera, options?: ThreeOptions): Promise<ThreeScene>;

/** The option `camera` of a camera of three.js, for a picture of that size in pixels. */
export declare function threeCamera(camera: Camera, size?: number | readonly [number, number]): Description["camera"];
