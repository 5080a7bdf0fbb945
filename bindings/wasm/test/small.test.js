// The module without default features: the same bits of what it has, a sentence about what it has not.
import assert from "node:assert/strict";
import { existsSync, readFileSync } from "node:fs";
import test from "node:test";
import { Engine } from "../js/engine.js";
import { here, model } from "./common.js";

const folder = `${here}dist/small/plain/`;
const skip = existsSync(folder) ? false : "it was not built";

test("the small module", { skip }, async () => {
  const functions = await import(`${folder}overcoat.js`);
  await functions.default({ module_or_path: await WebAssembly.compile(readFileSync(`${folder}overcoat_bg.wasm`)) });
  const [small, whole] = [new Engine(functions), await Engine.create("plain")];
  const draw = (engine, name, options) => {
    const source = { bytes: new Uint8Array(model(name)), files: [], limits: {} };
    return engine.call("draw", { source, description: JSON.stringify({ size: 24, quality: "draft", ...options }), aovs: [], linear: false });
  };
  for (const [name, options] of [
    // It has textures, and materials that name no model.
    ["sports-car.glb", {}],
    ["torus-knot.glb", { quality: "fast" }],
    ["torus-knot.glb", { shading: "stacklit-d" }],
    ["torus-knot.glb", { shading: "standard", background: "white" }],
  ]) {
    const [own, other] = [draw(small, name, options), draw(whole, name, options)];
    assert.equal(own.hash, other.hash, JSON.stringify(options));
    const { width, height, pixels } = own;
    const png = (engine) => engine.call("encode", { width, height, pixels: new Uint8Array(pixels.buffer), format: "png", quality: 90 });
    assert.deepEqual(png(small), png(whole));
  }
  const left = "this program was built without";
  assert.throws(() => draw(small, "torus-knot.glb", { shading: "stacklit" }), {
    message: `shading: stacklit is not a model that was compiled in: ${left} it`,
  });
  assert.throws(() => draw(small, "vase.ply", {}), { message: new RegExp(left) });
  assert.throws(() => draw(small, "torus-knot.glb", { material: "velvet" }), /velvet|material/);
});
