import type { Comparison, RenderedImage } from "./index.js";

export interface GoldenOptions {
  /** Where expected pictures are: "goldens" if absent, in matchers beside the test file. */
  folder?: string;
  /** Records what was drawn and rejects all the same; if absent, whether UPDATE_GOLDENS is 1 (or the runner was given -u). */
  update?: boolean;
  /** The text of a thresholds.toml; if absent that of the folder, and without one every pixel must be equal. */
  thresholds?: string;
}

/** Holds a picture against `<folder>/<name>.png`. Rejects with an OvercoatError (code "golden") unless it is as expected. */
export declare function checkGolden(
  picture: RenderedImage | Uint8Array,
  name: string,
  options?: GoldenOptions,
): Promise<Comparison>;

/** For `expect.extend` of Vitest and Jest. */
export declare const matchers: {
  toMatchOvercoatGolden(
    picture: RenderedImage | Uint8Array,
    name: string,
    options?: GoldenOptions,
  ): Promise<{ pass: boolean; message: () => string }>;
};

/** What the matchers add to `expect`. */
export interface OvercoatMatchers<R> {
  /** Holds a picture against `goldens/<name>.png` beside the test file; await it. */
  toMatchOvercoatGolden(name: string, options?: GoldenOptions): Promise<R>;
}
