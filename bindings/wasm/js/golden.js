// Golden pictures in tests, by the rules of `overcoat golden`: a picture must be as it was, one that is recorded has to be
// looked at, and the test that records it fails.
import { mkdir, readFile, rm, writeFile } from "node:fs/promises";
import { dirname, join, resolve } from "node:path";
import { compare } from "./index.js";
import { OvercoatError, what } from "./error.js";

const absent = (error) => (error.code === "ENOENT" ? undefined : Promise.reject(error));

/** A name leads to a file of the folder, and nowhere else. */
function placeOf(folder, name) {
  if (typeof name !== "string" || !/^[^\\/:]+(\/[^\\/:]+)*$/.test(name) || name.split("/").some((part) => /^\.*$/.test(part))) {
    throw new OvercoatError(`name: expected a name such as "cars/red", found ${typeof name === "string" ? `"${name}"` : what(name)}`, "options");
  }
  return join(folder, `${name}.png`);
}

/** The bytes of a picture: of render(), a PNG file, or what Playwright and Puppeteer take screenshots of. */
async function pngOf(picture, options) {
  if (typeof picture?.png === "function") return picture.png();
  if (typeof picture?.screenshot === "function") return picture.screenshot({ type: "png", ...options });
  if (ArrayBuffer.isView(picture)) return picture;
  throw new OvercoatError(
    `expected a picture of render(), the bytes of a PNG file, or a page or an element of Playwright, found ${what(picture)}`,
    "options",
  );
}

/** Width and height of a PNG file. */
function sizeOf(png) {
  const view = new DataView(png.buffer, png.byteOffset, png.byteLength);
  if (png.byteLength < 24 || view.getUint32(0) !== 0x89504e47) throw new OvercoatError("the picture is no PNG file", "options");
  return [view.getUint32(16), view.getUint32(20)];
}

/** Rules of an object as the text of a thresholds.toml: `{ preset: "gpu" }`, `{ max_abs: 8, pixels: 20 }`. */
function rulesOf(thresholds) {
  if (typeof thresholds === "string") return thresholds;
  if (typeof thresholds !== "object" || thresholds === null) {
    throw new OvercoatError(`thresholds: expected a text or an object of limits, found ${what(thresholds)}`, "options");
  }
  return Object.entries(thresholds).map(([key, value]) => `${key} = ${JSON.stringify(value)}\n`).join("");
}

/**
 * Holds a picture against what overcoat draws: a picture of render(), the bytes of a PNG file, or what has a render() (a Scene, a
 * fromThree()), which is drawn as large as the picture is. Rejects with an OvercoatError (code "golden") unless they agree within the
 * thresholds: by default those of the preset "gpu".
 */
export async function checkMatch(picture, expected, { thresholds = { preset: "gpu" }, screenshot, failures, name = "picture", ...options } = {}) {
  const actual = await pngOf(picture, screenshot);
  const isDrawn = typeof expected?.render === "function" && typeof expected.screenshot !== "function";
  const wanted = await pngOf(isDrawn ? await expected.render({ size: sizeOf(actual), ...options }) : expected, screenshot);
  const found = await compare(wanted, actual, { name: `${name}.png`, thresholds: rulesOf(thresholds) });
  if (found.good) return found;
  let where = "";
  if (failures !== undefined) {
    const paths = [[`${name}.expected.png`, wanted], [`${name}.actual.png`, actual]].map(([file, bytes]) => [join(resolve(failures), file), bytes]);
    await mkdir(resolve(failures), { recursive: true });
    for (const [path, bytes] of paths) await writeFile(path, bytes);
    where = `; both are in ${resolve(failures)}`;
  }
  throw new OvercoatError(`${name}: ${found.reasons.join("; ") || found.verdict}${where}`, "golden");
}

/**
 * Holds a picture against `<folder>/<name>.png`. Rejects with an OvercoatError (code "golden") if it differs, after writing
 * it to `<name>.new.png`; and if it was recorded, which `update` or UPDATE_GOLDENS=1 asks for.
 */
export async function checkGolden(picture, name, { folder = "goldens", update = process.env.UPDATE_GOLDENS === "1", thresholds } = {}) {
  const expectedPath = placeOf(resolve(folder), name);
  const actualPath = expectedPath.replace(/\.png$/, ".new.png");
  const actual = await pngOf(picture);
  const expected = await readFile(expectedPath).catch(absent);
  const write = async (path) => {
    await mkdir(dirname(path), { recursive: true });
    await writeFile(path, actual);
  };
  const rules = thresholds ?? (await readFile(join(resolve(folder), "thresholds.toml"), "utf8").catch(absent)) ?? "";
  const found = expected && (await compare(expected, actual, { name: `${name}.png`, thresholds: rules }));
  if (found?.good) {
    await rm(actualPath, { force: true });
    return found;
  }
  if (update) {
    await write(expectedPath);
    await rm(actualPath, { force: true });
    const kind = expected ? "recorded anew" : "recorded";
    throw new OvercoatError(`${expectedPath}: ${kind}; look at it, and run the tests again without UPDATE_GOLDENS`, "golden");
  }
  await write(actualPath);
  const why = found ? found.reasons.join("; ") || found.verdict : "there is no such golden";
  throw new OvercoatError(
    `${expectedPath}: ${why}; what was drawn is ${actualPath}; UPDATE_GOLDENS=1 or \`npx overcoat golden accept\` records it`,
    "golden",
  );
}

/** A result of a matcher: whether it is as expected, and otherwise why. */
async function resultOf(check, message) {
  try {
    await check();
    return { pass: true, message: () => message };
  } catch (error) {
    if (error.code !== "golden") throw error;
    return { pass: false, message: () => error.message };
  }
}

/** Matchers for the `expect` of Vitest, Jest and Playwright. Goldens are in the folder `goldens` beside the test file. */
export const matchers = {
  async toMatchOvercoatGolden(picture, name, options = {}) {
    const beside = this.testPath ? join(dirname(this.testPath), "goldens") : "goldens";
    const update = this.snapshotState?._updateSnapshot === "all" || process.env.UPDATE_GOLDENS === "1";
    if (this.isNot) throw new OvercoatError("toMatchOvercoatGolden cannot be negated", "options");
    return resultOf(() => checkGolden(picture, name, { folder: beside, update, ...options }), `${name} is as expected`);
  },

  async toMatchOvercoat(picture, expected, options = {}) {
    return resultOf(() => checkMatch(picture, expected, options), "the pictures agree, which was not expected");
  },
};
