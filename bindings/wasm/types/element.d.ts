import type { RenderedImage } from "./index.js";

/**
 * `<overcoat-image src="model.glb" alt="A red car">`: a picture of a 3D file, drawn when it is seen, in the pixels of the
 * screen. Attributes: `src`, `env`, `width`, `height` (CSS pixels), `alt`, and the keys of a description with `-` for `_`.
 * Fires `load` and `error`.
 */
export declare class OvercoatImageElement extends HTMLElement {
  /** The picture that is shown. */
  readonly image?: RenderedImage;
  readonly state: "waiting" | "drawing" | "done" | "error";
  /** Draws anew if it is seen. */
  redraw(): void;
}

declare global {
  interface HTMLElementTagNameMap {
    "overcoat-image": OvercoatImageElement;
  }
}
