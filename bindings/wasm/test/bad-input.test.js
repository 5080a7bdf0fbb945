// Whatever comes in, a promise rejects with one sentence, and the next picture is drawn.
import assert from "node:assert/strict";
import test from "node:test";
import { OvercoatError, Scene, createRenderer, load, render } from "../js/index.js";
import { glb, model } from "./common.js";

const knot = model("torus-knot.glb");

async function fails(promise, code, message) {
  await assert.rejects(promise, (error) => {
    assert.ok(error instanceof OvercoatError, String(error?.stack));
    assert.equal(error.code, code, error.message);
    assert.match(error.message, message);
    assert.ok(!error.message.includes("\n"), "one line");
    return true;
  });
}

const works = async (options) => assert.match((await render(knot, { size: 16, ...options })).hash, /^[0-9a-f]{32}$/);

test("what is no file is refused by name", async () => {
  for (const [value, found] of [
    [undefined, "nothing"], [null, "null"], ["car.glb", "a string"], [7, "a number \\(7\\)"], [{}, "an object \\(Object\\)"],
    [[1, 2], "an array"], [() => 0, "a function"],
  ]) {
    await fails(render(value), "options", new RegExp(`^the model: expected the bytes of a file .* found ${found}$`));
  }
});

test("options are checked, with a suggestion", async () => {
  for (const [options, message] of [
    [null, /^options: expected an object, found null/],
    ["512", /^options: expected an object/],
    [{ sise: 512 }, /sise: there is no such key; did you mean 'size'/],
    [{ size: -1 }, /size/],
    [{ size: "big" }, /size/],
    [{ size: NaN }, /^size: expected a finite number, found NaN/],
    [{ camera: { eye: [0, Infinity, 0] } }, /^camera.eye\[1\]: expected a finite number, found Infinity/],
    [{ camera: "front" }, /camera: .*expected a table/],
    [{ size: 10n }, /^size: expected .* found a bigint \(10\)/],
    [{ quality: () => "best" }, /^quality: expected .* found a function/],
    [{ quality: "ultra" }, /quality: .*draft, fast, good/],
    [{ shading: "phong" }, /shading/],
    [{ camera: new Date() }, /^camera: expected .* found an object \(Date\)/],
    [{ model: "a.glb" }, /^model: the model is given as bytes/],
    [{ aovs: ["deapth"] }, /^aovs: there is no 'deapth'; known are/],
    [{ aovs: "depth" }, /^aovs: expected an array of names/],
    [{ limits: { triangels: 1 } }, /^limits: there is no 'triangels'; known are/],
    [{ limits: { triangles: -1 } }, /^limits.triangles: expected a whole number/],
    [{ limits: 7 }, /^limits: expected an object/],
    [{ files: { "a.bin": "text" } }, /^files: 'a.bin': expected the bytes of a file/],
    [{ files: ["a.bin"] }, /^files: expected an object/],
    [{ signal: true }, /^signal: expected an AbortSignal/],
    [{ worker: "yes" }, /^worker: expected true or false/],
    [{ env: "sky.hdr" }, /sky.hdr/],
    [{ material: "velvit" }, /velvet/],
  ]) {
    for (const worker of [undefined, true]) {
      if (worker && (options === null || typeof options !== "object" || "worker" in options)) continue;
      const given = worker ? { ...options, worker } : options;
      await assert.rejects(render(knot, given), (error) => {
        assert.ok(error instanceof OvercoatError, `${JSON.stringify(options, (k, v) => typeof v === "bigint" ? "n" : v)}: ${error.stack}`);
        assert.match(error.message, message);
        return true;
      });
    }
  }
  const cyclic = {};
  cyclic.camera = cyclic;
  await fails(render(knot, cyclic), "options", /nested too deeply/);
  await works();
});

test("a file in pieces is told as that", async () => {
  await fails(render(new Uint8Array(0)), "input", /./);
  await fails(render(new TextEncoder().encode("hello")), "input", /./);
  for (const length of [11, 20, 300]) {
    await fails(render(knot.subarray(0, length), { size: 16 }), "input", /./);
  }
  // Every byte of the head, changed.
  for (let at = 0; at < 64; at++) {
    const damaged = Buffer.from(knot);
    damaged[at] ^= 0x55;
    await render(damaged, { size: 8 }).catch((error) => assert.ok(error instanceof OvercoatError, error.stack));
  }
  await works();
});

test("a file that claims more than there is is refused before memory is taken", async () => {
  const bomb = glb({
    asset: { version: "2.0" },
    buffers: [{ byteLength: 36 }],
    bufferViews: [{ buffer: 0, byteLength: 36 }],
    accessors: [{ bufferView: 0, componentType: 5126, count: 4_000_000_000, type: "VEC3" }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 } }] }],
    nodes: [{ mesh: 0 }],
    scenes: [{ nodes: [0] }],
  }, new Uint8Array(36));
  await fails(render(bomb), "input", /./);
  await fails(render(knot, { size: 100_000 }), "input", /output/);
  await fails(render(knot, { size: 16, limits: { triangles: 10 } }), "input", /exceeds the limit of 10 \(triangles\)/);
  await works();
});

test("inputs of gigabytes are refused before they are copied", async () => {
  // A file that is nowhere: nothing of it may be read.
  const blob = { size: 5e9, arrayBuffer: () => assert.fail("it was read") };
  await fails(render(blob), "input", /^the model: 5000000000 exceeds the limit of 1073741824 \(input_bytes\)$/);
  const large = new ArrayBuffer(2 ** 30 + 1);
  await fails(render(large), "input", /^the model: 1073741825 exceeds the limit of 1073741824/);
  await fails(render(large, { limits: { input_bytes: 2 ** 40 } }), "input", /./);
  await fails(render(knot, { files: { "big.bin": large } }), "input", /^files: 'big.bin': 1073741825 exceeds/);
  await fails(render(knot, { limits: { input_bytes: 1000 } }), "input", /exceeds the limit of 1000/);
  await works();
});

test("when memory runs out, a new module takes over", { timeout: 240_000 }, async () => {
  for (const worker of [false, true]) {
    const kept = await load(knot, { size: 16, worker });
    const before = (await kept.render()).hash;
    const scene = await Scene.load(knot, { size: 16, worker });
    assert.equal((await scene.render()).hash, before);
    // Two gigabytes of zeros: as much again does not fit beside them, whatever the limits allow.
    const limits = { input_bytes: 2 ** 31 - 1, decoded_bytes: 2 ** 40, output_pixels: 2 ** 40, frame_bytes: 2 ** 40 };
    const most = { size: 16384, limits: { ...limits, output_side: 16384 }, worker, linear: true, aovs: ["position", "normal", "uv", "depth"] };
    await fails(render(knot, most), "crash", /memory.*started anew/);
    await works({ worker });
    assert.equal((await kept.render()).hash, before, "models of before are loaded again");
    assert.equal((await scene.render()).hash, before, "and scenes are made again");
    kept.free();
  }
});

test("a promise that is cancelled rejects with the signal's reason", async () => {
  const aborted = AbortSignal.abort(new Error("changed my mind"));
  await assert.rejects(render(knot, { signal: aborted }), { message: "changed my mind" });
  await assert.rejects(load(knot, { signal: aborted }), { message: "changed my mind" });

  const renderer = createRenderer();
  const kept = await renderer.load(knot, { size: 16 });
  const controller = new AbortController();
  const start = performance.now();
  // Minutes of work.
  const long = renderer.render(knot, { size: 4096, quality: "best", rays: 256, signal: controller.signal });
  const waiting = renderer.render(knot, { size: 16 });
  const second = new AbortController();
  const never = renderer.render(knot, { size: 16, signal: second.signal });
  second.abort();
  await assert.rejects(never, { name: "AbortError" });
  const behind = kept.render();
  setTimeout(() => controller.abort(), 200);
  await assert.rejects(long, { name: "AbortError" });
  assert.ok(performance.now() - start < 10_000, "at once");
  assert.match((await waiting).hash, /^[0-9a-f]{32}$/, "what waited behind it is drawn");
  assert.equal((await behind).hash, (await waiting).hash, "and a model that was loaded before, if its picture waited, too");
  assert.equal((await kept.render()).hash, (await waiting).hash, "models live on");
  const last = renderer.render(knot, { size: 2048, quality: "best", rays: 256 });
  renderer.close();
  await fails(last, "options", /closed/);
});

test("a limit in time: AbortSignal.timeout", async () => {
  const options = { size: 4096, quality: "best", rays: 256, signal: AbortSignal.timeout(300) };
  await assert.rejects(render(knot, options), { name: "TimeoutError" });
  await works();
});
