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

async function pngOf(picture) {
  if (typeof picture?.png === "function") return picture.png();
  if (ArrayBuffer.isView(picture)) return picture;
  throw new OvercoatError(`expected a picture of render() or the bytes of a PNG file, found ${what(picture)}`, "options");
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

/** Matchers for the `expect` of Vitest and Jest. Goldens are in the folder `goldens` beside the test file. */
export const matchers = {
  async toMatchOvercoatGolden(picture, name, options = {}) {
    const beside = this.testPath ? join(dirname(this.testPath), "goldens") : "goldens";
    const update = this.snapshotState?._updateSnapshot === "all" || process.env.UPDATE_GOLDENS === "1";
    if (this.isNot) throw new OvercoatError("toMatchOvercoatGolden cannot be negated", "options");
    try {
      await checkGolden(picture, name, { folder: beside, update, ...options });
      return { pass: true, message: () => `${name} is as expected` };
    } catch (error) {
      if (error.code !== "golden") throw error;
      return { pass: false, message: () => error.message };
    }
  },
};
