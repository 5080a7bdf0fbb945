// Golden pictures: by function, by matchers in both test runners, and by the command line.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { cpSync, existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync, symlinkSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import test from "node:test";
import { checkGolden } from "../js/golden.js";
import { compare, render } from "../js/index.js";
import { here, model, modelPath, noCommand } from "./common.js";

const folder = mkdtempSync(join(tmpdir(), "overcoat-golden-"));
const draw = (options) => render(model("torus-knot.glb"), { size: 32, quality: "draft", ...options });

test("a golden is recorded by a failure, holds, and fails when the picture changes", async () => {
  const image = await draw();
  const goldens = { folder: join(folder, "goldens") };
  const png = join(folder, "goldens/sub/knot.png");
  const fresh = join(folder, "goldens/sub/knot.new.png");
  await assert.rejects(checkGolden(image, "sub/knot", goldens), { code: "golden", message: /there is no such golden/ });
  assert.ok(existsSync(fresh) && !existsSync(png));
  await assert.rejects(checkGolden(image, "sub/knot", { ...goldens, update: true }), { code: "golden", message: /recorded; look at it/ });
  assert.ok(existsSync(png) && !existsSync(fresh));
  assert.equal((await checkGolden(image, "sub/knot", goldens)).verdict, "equal");
  const other = await draw({ exposure: 0.02 });
  await assert.rejects(checkGolden(other, "sub/knot", goldens), { code: "golden", message: /knot\.new\.png/ });
  assert.ok(existsSync(fresh));
  // Thresholds of the folder count.
  writeFileSync(join(folder, "goldens/thresholds.toml"), "max_abs = 8\n");
  assert.equal((await checkGolden(other, "sub/knot", goldens)).verdict, "within");
  assert.ok(!existsSync(fresh), "what is as expected leaves nothing behind");
  writeFileSync(join(folder, "goldens/thresholds.toml"), "max_abbs = 8\n");
  await assert.rejects(checkGolden(other, "sub/knot", goldens), { message: /thresholds, line 1/ });
  for (const name of ["../knot", "/knot", "a//b", "", ".", 7]) {
    await assert.rejects(checkGolden(image, name, goldens), { code: "options" }, String(name));
  }
  await assert.rejects(checkGolden("picture", "knot", goldens), { code: "options", message: /found a string/ });
});

test("pictures are compared as the command does", async () => {
  const [a, b] = await Promise.all([draw(), draw({ exposure: 1 })].map(async (image) => (await image).png()));
  assert.equal((await compare(a, a)).good, true);
  const found = await compare(a, b);
  assert.equal(found.good, false);
  assert.ok(found.metrics.pixels > 100 && found.metrics.flip_mean > 0, JSON.stringify(found));
  await assert.rejects(compare(a, new Uint8Array(9)), { code: "input", message: /picture.png, actual: / });
});

/** A project of somebody's, with this package and a test. */
function project(runner) {
  const place = join(folder, runner);
  mkdirSync(join(place, "node_modules"), { recursive: true });
  symlinkSync(here, join(place, "node_modules/overcoat"));
  for (const name of ["vitest", "jest", "@jest"]) symlinkSync(join(here, "node_modules", name), join(place, "node_modules", name));
  writeFileSync(join(place, "package.json"), JSON.stringify({ type: "module", jest: { testEnvironment: "node", transform: {} } }));
  cpSync(modelPath("torus-knot.glb"), join(place, "model.glb"));
  const source = runner === "jest" ? "@jest/globals" : "vitest";
  writeFileSync(join(place, "knot.test.js"), `
    import { readFile } from "node:fs/promises";
    import { expect, test } from "${source}";
    import "overcoat/${runner}";
    import { Scene, render } from "overcoat";
    test("knot", async () => {
      const exposure = Number(process.env.EXPOSURE ?? 0);
      const image = await render(await readFile("model.glb"), { size: 32, quality: "draft", exposure });
      // A scene is drawn for what is held against it; and what differs does not match.
      const scene = await Scene.load(await readFile("model.glb"), { quality: "draft" });
      await expect(await image.png()).toMatchOvercoat(scene, { exposure, thresholds: "" });
      await expect(image).not.toMatchOvercoat(scene, { exposure: exposure + 2 });
      scene.free();
      await expect(image).toMatchOvercoatGolden("knot");
    });
  `);
  const args = runner === "jest" ? ["node_modules/jest/bin/jest.js", "--ci"] : ["node_modules/vitest/vitest.mjs", "run"];
  return (env = {}, ...more) => {
    const all = { ...process.env, CI: "1", NODE_OPTIONS: "--experimental-vm-modules --no-warnings", ...env };
    const { status, stdout, stderr } = spawnSync(process.execPath, [...args, ...more], { cwd: place, env: all, encoding: "utf8" });
    return { status, text: stdout + stderr };
  };
}

for (const runner of ["vitest", "jest"]) {
  test(`the matcher of ${runner}`, { timeout: 120_000 }, () => {
    const run = project(runner);
    const first = run();
    assert.notEqual(first.status, 0, "without a golden");
    assert.match(first.text, /there is no such golden/);
    const recording = run({ UPDATE_GOLDENS: "1" });
    assert.notEqual(recording.status, 0, "whoever records has to look");
    assert.match(recording.text, /recorded; look at it/);
    const good = run();
    assert.equal(good.status, 0, good.text);
    const changed = run({ EXPOSURE: "0.5" });
    assert.notEqual(changed.status, 0);
    assert.match(changed.text, /knot\.new\.png/);
  });
}

test("the command line runs by WASI", { timeout: 120_000, skip: noCommand }, async () => {
  const overcoat = (...args) =>
    spawnSync(process.execPath, ["--no-warnings", join(here, "bin/overcoat.js"), ...args], { cwd: folder, encoding: "utf8" });
  for (const name of ["expected", "actual"]) mkdirSync(join(folder, name));
  const drawn = overcoat("render", modelPath("torus-knot.glb"), "-o", "expected/knot.png", "--size", "32", "--quality", "draft", "--json");
  assert.equal(drawn.status, 0, drawn.stderr);
  const image = await draw();
  assert.equal(JSON.parse(drawn.stdout).frame_hash, image.hash);
  assert.deepEqual(readFileSync(join(folder, "expected/knot.png")), Buffer.from(await image.png()));
  cpSync(join(folder, "expected/knot.png"), join(folder, "actual/knot.png"));
  assert.equal(overcoat("golden", "check", "expected", "actual").status, 0);
  writeFileSync(join(folder, "actual/knot.png"), await (await draw({ exposure: 1 })).png());
  const check = overcoat("golden", "check", "expected", "actual");
  assert.notEqual(check.status, 0);
  assert.match(check.stdout + check.stderr, /knot\.png/);
  overcoat("golden", "report", "expected", "actual", "-o", "report.html");
  assert.match(readFileSync(join(folder, "report.html"), "utf8"), /knot\.png/);
  assert.equal(overcoat("golden", "accept", "expected", "actual", "knot.png").status, 0);
  assert.equal(overcoat("golden", "check", "expected", "actual").status, 0);
  const wrong = overcoat("render", "missing.glb", "-o", "x.png");
  assert.notEqual(wrong.status, 0);
  assert.match(wrong.stderr, /missing\.glb/);
});

test.after(() => rmSync(folder, { recursive: true }));
