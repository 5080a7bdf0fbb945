// The same bits as the native program: on the caller's thread and on another, with vectors and without.
import assert from "node:assert/strict";
import { mkdtempSync, readFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import test from "node:test";
import { about, bestBuild, load, render } from "../js/index.js";
import { Engine } from "../js/engine.js";
import { model, native } from "./common.js";

const folder = mkdtempSync(join(tmpdir(), "overcoat-"));
const PICTURES = [
  ["torus-knot.glb", { size: 96 }, ["--size", "96"]],
  ["sports-car.glb", { size: [120, 80], quality: "draft", shading: "stacklit" }, ["--size", "120x80", "--quality", "draft", "--shading", "stacklit"]],
  ["vase.ply", { size: 64, material: "candy-red", background: "white" }, ["--size", "64", "--material", "candy-red", "--background", "white"]],
  ["rounded-cube.stl", { size: 64, camera: { view: "front" }, samples: 16 }, ["--size", "64", "--view", "front", "--samples", "16"]],
  ["draped-cloth.glb", { size: 64, env: "none", light: [{ type: "directional", direction: [0, -1, -1], intensity: 3 }] }, undefined],
];

test("the default picture is that of every door", async () => {
  const [, , hash] = readFileSync(new URL("../../../tests/default-picture.txt", import.meta.url), "utf8").split(/\s+/);
  assert.equal((await render(model("rounded-cube.glb"), { size: [96, 64] })).hash, hash);
});

for (const [name, options, flags] of PICTURES) {
  test(`${name}, ${JSON.stringify(options)}`, async () => {
    const [here, there] = await Promise.all([
      render(model(name), options),
      render(model(name), { ...options, worker: true }),
    ]);
    assert.match(here.hash, /^[0-9a-f]{32}$/);
    assert.equal(there.hash, here.hash);
    assert.deepEqual(there.pixels, here.pixels);
    for (const build of ["plain", "simd"]) {
      const engine = await Engine.create(build);
      assert.equal(engine.about().lanes, build === "simd" ? "simd128" : "scalar");
      const source = { bytes: new Uint8Array(model(name)), files: [], limits: {} };
      const drawn = engine.call("draw", { source, description: JSON.stringify(options), aovs: [], linear: false });
      assert.equal(drawn.hash, here.hash, build);
    }
    if (flags) {
      const picture = native(name, join(folder, "picture.png"), ...flags);
      assert.equal(here.hash, picture.frame_hash);
      assert.deepEqual(Buffer.from(await here.png()), picture.file, "the bytes of the PNG file");
      assert.deepEqual(Buffer.from(await there.png()), picture.file);
    }
  });
}

test("the build with vectors is taken where there are any", async () => {
  assert.equal(bestBuild(), "simd");
  assert.equal((await about()).lanes, "simd128");
  assert.equal((await about({ worker: true })).lanes, "simd128");
});

test("a model that is kept draws what one that is loaded anew does, whatever came before", async () => {
  const kept = await load(model("material-ball.glb"), { size: 48 });
  const cameras = [{ view: "front" }, { view: "top" }, { eye: [2, 1, 2], target: [0, 0, 0] }, { view: "front" }];
  for (const [k, camera] of cameras.entries()) {
    const options = { camera, shading: k % 2 ? "three" : "gltf", quality: k === 2 ? "good" : "fast" };
    const once = await render(model("material-ball.glb"), { size: 48, ...options });
    assert.equal((await kept.render(options)).hash, once.hash, JSON.stringify(options));
  }
  kept.free();
  await assert.rejects(kept.render(), { code: "options", message: "the model was freed" });
});

test("files beside the model are found by their names", async () => {
  const names = ["torus-knot.mtl", "textures/carbon-color.png", "textures/carbon-normal.png"];
  const files = Object.fromEntries(names.map((name) => [name, model(name)]));
  const with_ = await render(model("torus-knot.obj"), { size: 48, files });
  const without = await render(model("torus-knot.obj"), { size: 48 });
  const command = native("torus-knot.obj", join(folder, "knot.png"), "--size", "48");
  assert.equal(with_.hash, command.frame_hash);
  assert.notEqual(without.hash, command.frame_hash);
  assert.match(without.warnings.join(), /torus-knot\.mtl/);
});

test("material files and environments come from files, or as bytes", async () => {
  const files = { "lacquer.toml": new TextEncoder().encode('base_color = "#300"\ncoat = 1\nroughness = 0.5\n') };
  const lacquer = await render(model("torus-knot.glb"), { size: 32, material: "lacquer.toml", files });
  assert.notEqual(lacquer.hash, (await render(model("torus-knot.glb"), { size: 32 })).hash);
  // Radiance, 2 x 1 pixels: one half is red, the other dark.
  const sky = Buffer.concat([Buffer.from("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n"), Buffer.from([200, 10, 10, 129, 10, 10, 10, 129])]);
  const bytes = await render(model("torus-knot.glb"), { size: 32, env: sky });
  const named = await render(model("torus-knot.glb"), { size: 32, env: "sky.hdr", files: { "sky.hdr": sky } });
  assert.equal(bytes.hash, named.hash);
  assert.notEqual(bytes.hash, (await render(model("torus-knot.glb"), { size: 32 })).hash);
  const kept = await load(model("torus-knot.glb"), { size: 32 });
  assert.equal((await kept.render({ env: sky })).hash, bytes.hash);
  const other = Buffer.from(sky).fill(90, sky.length - 4, sky.length - 1);
  assert.notEqual((await kept.render({ env: other })).hash, bytes.hash, "another picture under the same name");
  assert.equal((await kept.render({ env: sky, env_rotation_deg: 0 })).hash, bytes.hash);
});

test("planes and linear light have the sizes they are said to have", async () => {
  const image = await render(model("torus-knot.glb"), { size: [40, 30], linear: true, aovs: ["depth", "normal"] });
  assert.ok(image.pixels instanceof Uint8ClampedArray);
  assert.equal(image.pixels.length, 40 * 30 * 4);
  assert.equal(image.linear.length, 40 * 30 * 4);
  assert.equal(image.aovs.depth.length, 40 * 30);
  assert.equal(image.aovs.normal.length, 40 * 30 * 3);
  // Where nothing covers a pixel there is no colour, in either form.
  assert.equal(image.pixels[3], 0);
  assert.equal(image.linear[3], 0);
  const blob = await image.toBlob("image/jpeg");
  assert.deepEqual([...new Uint8Array(await blob.arrayBuffer()).slice(0, 2)], [0xff, 0xd8]);
  assert.equal(Buffer.from(await image.webp()).toString("latin1", 8, 12), "WEBP");
});
