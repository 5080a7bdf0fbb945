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

/** What a picture may be given as: of render(), the bytes of a PNG file, or a page or an element that has screenshots (Playwright). */
export type Screen = RenderedImage | Uint8Array | { screenshot(options?: object): Promise<Uint8Array> };

export interface MatchOptions {
  /** The text of a thresholds.toml, or its keys: `{ max_abs: 8, pixels: 20 }`; `{ preset: "gpu" }` if absent. */
  thresholds?: string | Record<string, unknown>;
  /** Options of the screenshot, of pages and elements. */
  screenshot?: object;
  /** A folder that both pictures are written to if they do not agree, as `<name>.expected.png` and `<name>.actual.png`. */
  failures?: string;
  /** "picture" if absent. */
  name?: string;
  /** Options of the picture, where the scene is drawn for it. */
  [option: string]: unknown;
}

/**
 * Holds a picture against what overcoat draws. What has a `render` (a `Scene`, a `fromThree()`) is drawn as large as the picture is.
 * Rejects with an OvercoatError (code "golden") unless they agree.
 */
export declare function checkMatch(
  picture: Screen,
  expected: Screen | { render(options: { size: [number, number] }): Promise<RenderedImage> },
  options?: MatchOptions,
): Promise<Comparison>;

/** For `expect.extend` of Vitest, Jest and Playwright. */
export declare const matchers: {
  toMatchOvercoat(
    picture: Screen,
    expected: Screen | { render(options: { size: [number, number] }): Promise<RenderedImage> },
    options?: MatchOptions,
  ): Promise<{ pass: boolean; message: () => string }>;
  toMatchOvercoatGolden(
    picture: RenderedImage | Uint8Array,
    name: string,
    options?: GoldenOptions,
  ): Promise<{ pass: boolean; message: () => string }>;
};

/** What the matchers add to `expect`. */
export interface OvercoatMatchers<R> {
  /** Holds a picture, or the screenshot of a page or an element, against what overcoat draws of a scene; await it. */
  toMatchOvercoat(
    expected: Screen | { render(options: { size: [number, number] }): Promise<RenderedImage> },
    options?: MatchOptions,
  ): Promise<R>;
  /** Holds a picture against `goldens/<name>.png` beside the test file; await it. */
  toMatchOvercoatGolden(name: string, options?: GoldenOptions): Promise<R>;
}
