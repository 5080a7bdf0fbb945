// What comes out.
import { OvercoatError } from "./error.js";

const TYPES = { "image/png": "png", "image/jpeg": "jpg", "image/webp": "webp" };

/** A picture: pixels, the hash of its linear light, and files of it. */
export class RenderedImage {
  #host;

  constructor(host, { width, height, pixels, hash, warnings, camera, linear, aovs }) {
    this.#host = host;
    this.width = width;
    this.height = height;
    this.pixels = pixels;
    this.hash = hash;
    this.warnings = warnings;
    this.camera = camera;
    this.linear = linear;
    this.aovs = aovs;
  }

  png() {
    return this.#encode("png");
  }

  webp() {
    return this.#encode("webp");
  }

  async jpeg(quality = 90) {
    if (!Number.isInteger(quality) || quality < 1 || quality > 100) {
      throw new OvercoatError(`quality: expected a whole number from 1 to 100, found ${String(quality)}`, "options");
    }
    return this.#encode("jpg", quality);
  }

  async toBlob(type = "image/png") {
    const format = TYPES[type];
    if (!format) {
      throw new OvercoatError(`type: expected ${Object.keys(TYPES).join(", ")}, found '${type}'`, "options");
    }
    return new Blob([await this.#encode(format)], { type });
  }

  /** For putImageData; where there is such a class. */
  toImageData() {
    return new ImageData(this.pixels, this.width, this.height);
  }

  #encode(format, quality = 90) {
    const pixels = new Uint8Array(this.pixels.buffer, this.pixels.byteOffset, this.pixels.byteLength);
    return this.#host.run("encode", { width: this.width, height: this.height, pixels, format, quality });
  }
}
