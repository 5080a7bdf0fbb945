// A scene that is kept: the bits of the file drawn once, handles that stay, what is seen in a pixel, and what is refused.
import assert from "node:assert/strict";
import test from "node:test";
import { Engine } from "../js/engine.js";
import { Handle } from "../js/handles.js";
import { Journal } from "../js/journal.js";
import { OvercoatError, Scene, createRenderer, load, render } from "../js/index.js";
import { glb, model } from "./common.js";

const knot = model("torus-knot.glb");
const cube = model("rounded-cube.glb");
const SMALL = { size: 48, quality: "draft", ground: "none" };
const away = (x, y = 0, z = 0) => [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, x, y, z, 1];
/** Two triangles of a square of that side around the origin, seen from the front. */
const square = (side = 1) => ({
  positions: [-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0].map((v) => (v * side) / 2),
  indices: [0, 1, 2, 0, 2, 3],
});
const FRONT = { eye: [0, 0, 5], target: [0, 0, 0], ortho_height: 4 };

async function fails(promise, message, code = "options") {
  await assert.rejects(promise, (error) => {
    assert.ok(error instanceof OvercoatError, String(error?.stack));
    assert.match(error.message, message);
    assert.equal(error.code, code, error.message);
    assert.ok(!error.message.includes("\n"), "one line");
    return true;
  });
}

for (const worker of [false, true]) {
  test(`a file in a scene is drawn as the file${worker ? ", on another thread" : ""}`, async () => {
    for (const name of ["torus-knot.glb", "vase.ply", "sports-car.glb"]) {
      const once = await render(model(name), { size: 64, worker });
      const scene = await Scene.load(model(name), { size: 64, worker });
      const kept = await scene.render();
      assert.deepEqual((await scene.addModel(model(name))).info, (await load(model(name), { worker })).info);
      assert.equal(kept.hash, once.hash, name);
      assert.deepEqual(kept.pixels, once.pixels);
      scene.free();
    }
  });

  test(`what is moved and moved back has the same bytes${worker ? ", on another thread" : ""}`, async () => {
    const scene = new Scene({ ...SMALL, worker });
    const [left, right] = [await scene.addModel(knot), await scene.addModel(cube, { transform: away(3) })];
    const camera = { eye: [1.5, 1, 8], target: [1.5, 0, 0] };
    const first = await scene.render({ camera });
    for (const handle of [right, left.instances[0]]) {
      const before = await scene.getTransform(handle);
      await scene.setTransform(handle, away(0.25, 1));
      assert.notEqual((await scene.render({ camera })).hash, first.hash);
      await scene.setTransform(handle, before);
      assert.equal((await scene.render({ camera })).hash, first.hash);
      await scene.setVisible(handle, false);
      assert.notEqual((await scene.render({ camera })).hash, first.hash);
      await scene.setVisible(handle, true);
    }
    const last = await scene.render({ camera });
    assert.equal(last.hash, first.hash);
    assert.deepEqual(await last.png(), await first.png());
    scene.free();
  });
}

test("a picture without a camera is framed for the scene as it is", async () => {
  const make = async (seen) => {
    const scene = new Scene(SMALL);
    const look = async () => seen && scene.render();
    const first = await scene.addModel(cube);
    await look();
    const second = await scene.addModel(knot, { transform: away(1) });
    await look();
    await scene.setTransform(second, away(4));
    const moved = (await scene.render()).hash;
    await scene.setVisible(first, false);
    const hidden = (await scene.render()).hash;
    await look();
    await scene.addInstance(await scene.addMesh(square()), await scene.addMaterial(), away(0, 9));
    const added = (await scene.render()).hash;
    await scene.remove(first);
    await look();
    await scene.remove(second);
    return [moved, hidden, added, (await scene.render()).hash];
  };
  const all = await make(true);
  assert.deepEqual(all, await make(false));
  // Framed for the first state, what was moved away would not be in the picture.
  assert.equal(new Set(all).size, 4);
});

test("meshes, materials, instances and lights of arrays", async () => {
  const scene = new Scene({ ...SMALL, camera: FRONT });
  const empty = await scene.render();
  const mesh = await scene.addMesh(square());
  const red = await scene.addMaterial({ base_color: "#f00", roughness: 0.4 });
  const instance = await scene.addInstance(mesh, red, away(1));
  const image = await scene.render();
  assert.notEqual(image.hash, empty.hash);
  const at = (picture, x, y) => [...picture.pixels.subarray(4 * (48 * y + x), 4 * (48 * y + x) + 4)];
  const [r, g, b, alpha] = at(image, 36, 24);
  assert.ok(r > 2 * g && r > 2 * b && alpha === 255, String([r, g, b, alpha]));
  assert.equal(at(image, 12, 24)[3], 0);
  // Typed arrays, arrays without indices, a DOMMatrix-like and a Matrix4-like are the same.
  const { positions, indices } = square();
  const flat = { positions: Float32Array.from(indices.flatMap((k) => positions.slice(3 * k, 3 * k + 3))) };
  await scene.setMesh(mesh, flat);
  assert.equal((await scene.render()).hash, image.hash);
  await scene.setMesh(mesh, { positions: Float64Array.from(positions), indices: Uint16Array.from(indices) });
  await scene.setTransform(instance, { elements: away(1) });
  await scene.setTransform(instance, { toFloat64Array: () => Float64Array.from(away(1)) });
  assert.equal((await scene.render()).hash, image.hash);
  // Another material, by its handle and in its place, and back.
  const green = await scene.addMaterial({ base_color: "#0f0", roughness: 0.4 });
  await scene.setInstanceMaterial(instance, green);
  const other = await scene.render();
  assert.ok(at(other, 36, 24)[1] > 2 * at(other, 36, 24)[0]);
  await scene.setMaterial(green, { base_color: "#f00", roughness: 0.4 });
  assert.equal((await scene.render()).hash, image.hash);
  await scene.setMaterial(green, { over: true, base_color: "#00f" });
  await scene.setMaterial(green, { over: true, base_color: "#f00" });
  assert.equal((await scene.render()).hash, image.hash, "roughness has stayed");
  await scene.setMaterial(green, "velvet");
  assert.notEqual((await scene.render()).hash, image.hash);
  await scene.setMaterial(green, { base_color: "#f00", roughness: 0.4 });
  // Vertex colours and smooth normals.
  await scene.setMesh(mesh, { ...square(), colors: Array(4).fill([0, 1, 0, 1]).flat(), crease_deg: 40 });
  assert.notEqual((await scene.render()).hash, image.hash);
  await scene.setMesh(mesh, square());
  // Lights, and light from afar.
  const sun = await scene.addLight({ type: "directional", direction: [0, 0, -1], intensity: 3 });
  const lit = await scene.render();
  assert.notEqual(lit.hash, image.hash);
  await scene.setLight(sun, { type: "directional", direction: [0, 0, -1], intensity: 0 });
  assert.notEqual((await scene.render()).hash, lit.hash);
  await scene.remove(sun);
  assert.equal((await scene.render()).hash, image.hash);
  await scene.setEnvironment({ env_rotation_deg: 90, env_intensity: 2 });
  assert.notEqual((await scene.render()).hash, image.hash);
  await scene.setEnvironment({ env: "none" });
  await scene.setEnvironment({ env: "studio", env_rotation_deg: 0, env_intensity: 1 });
  assert.equal((await scene.render()).hash, image.hash);
  await scene.remove(instance);
  assert.equal((await scene.render()).hash, empty.hash);
  for (const handle of [mesh, red, green]) await scene.remove(handle);
});

test("textures of materials come from files, and go with them", async () => {
  const scene = new Scene({ ...SMALL, camera: FRONT });
  const mesh = await scene.addMesh({ ...square(2), uvs: [0, 1, 1, 1, 1, 0, 0, 0] });
  const files = { "carbon.png": model("textures/carbon-color.png") };
  const carbon = await scene.addMaterial({ base_color_texture: "carbon.png" }, { files });
  const instance = await scene.addInstance(mesh, carbon);
  const textured = (await scene.render()).hash;
  await scene.setMaterial(carbon, null);
  const clay = (await scene.render()).hash;
  assert.notEqual(clay, textured);
  await scene.setMaterial(carbon, "mine.toml", { files: { ...files, "mine.toml": new TextEncoder().encode('base_color_texture = "carbon.png"\n') } });
  assert.equal((await scene.render()).hash, textured);
  await fails(scene.setMaterial(carbon, { base_color_texture: "other.png" }), /^material: base_color_texture: .*other\.png/);
  assert.equal((await scene.render()).hash, textured, "what is refused changes nothing");
  await scene.remove(instance);
  await scene.remove(carbon);
});

test("what is seen in a pixel", async () => {
  for (const worker of [false, true]) {
    const scene = new Scene({ ...SMALL, camera: FRONT, worker });
    const mesh = await scene.addMesh(square());
    const [red, blue] = [await scene.addMaterial({ base_color: "#f00" }), await scene.addMaterial({ base_color: "#00f" })];
    const left = await scene.addInstance(mesh, red, away(-1));
    const right = await scene.addInstance(mesh, blue, away(1, 0, 0.5));
    await scene.render();
    assert.equal(await scene.pick(24, 24), null);
    assert.equal(await scene.pick(0, 0), null);
    const hit = await scene.pick(12, 24);
    assert.equal(hit.instance, left, "the same handle");
    assert.equal(hit.material, red);
    assert.equal(hit.model, null);
    assert.ok(Math.abs(hit.depth - 5) < 1e-4, String(hit.depth));
    // Within pixel 12 of 48 over 4 metres.
    [-2 + (4 * 12.5) / 48, 2 - (4 * 24.5) / 48, 0].forEach((v, k) => assert.ok(Math.abs(hit.position[k] - v) <= 2 / 48, String(hit.position)));
    assert.ok(Math.abs(hit.barycentric.reduce((a, b) => a + b) - 1) < 1e-5);
    // Weights of the vertices that are named.
    const { positions, indices } = square();
    assert.deepEqual(hit.vertices, indices.slice(3 * hit.triangle, 3 * hit.triangle + 3));
    const x = hit.vertices.reduce((sum, vertex, k) => sum + hit.barycentric[k] * positions[3 * vertex], -1);
    assert.ok(Math.abs(x - hit.position[0]) < 1e-3);
    assert.equal(hit.back_facing, false);
    const other = await scene.pick(36, 24);
    assert.deepEqual([other.instance === right, other.depth], [true, 4.5]);
    // Of another picture, and of the scene as it is now.
    assert.equal((await scene.pick(90, 60, { size: 120 })).instance, right);
    await scene.render({ size: 96 });
    assert.equal((await scene.pick(72, 48)).instance, right, "of the last picture");
    await scene.setTransform(right, away(0));
    assert.equal(await scene.pick(72, 48), null);
    assert.equal((await scene.pick(48, 48)).instance, right);
    await fails(scene.pick(96, 0), /96/);
    await fails(scene.pick(-1, 0), /^x: expected a whole number of pixels from 0 on, found -1$/);
    await fails(scene.pick(0, 0.5), /^y: /);
    await fails(scene.pick("1", 0), /^x: .*found a string$/);

    // Parts of a model.
    await scene.remove(left);
    await scene.setVisible(right, false);
    const car = await scene.addModel(model("sports-car.glb"));
    await scene.render({ camera: { view: "front" } });
    const part = await scene.pick(24, 24);
    assert.equal(part.model, car);
    assert.ok(car.instances.includes(part.instance) && car.materials.includes(part.material));
    scene.free();
  }
});

test("a handle is good until its thing is removed, in its own scene", async () => {
  const scene = new Scene(SMALL);
  const other = new Scene(SMALL);
  const mesh = await scene.addMesh(square());
  const material = await scene.addMaterial();
  const instance = await scene.addInstance(mesh, material);
  await fails(other.addInstance(mesh, material), /^mesh: the mesh is one of another scene$/);
  await fails(other.remove(instance), /^handle: the instance is one of another scene$/);
  await fails(scene.addInstance(material, mesh), /^mesh: expected the handle of a mesh, found that of a material$/);
  await fails(scene.setTransform(mesh, away(1)), /^handle: expected the handle of an instance or a model, found that of a mesh$/);
  for (const [value, found] of [[undefined, "nothing"], [null, "null"], [7, "a number \\(7\\)"], [{}, "an object \\(Object\\)"]]) {
    await fails(scene.remove(value), new RegExp(`^handle: expected the handle of .* found ${found}$`));
  }
  await fails(scene.remove(mesh), /^the mesh is in use, by instance 0$/);
  await fails(scene.remove(material), /^the material is in use, by instance 0$/);
  await scene.remove(instance);
  await fails(scene.remove(instance), /^the instance is not there: it has been removed/);
  await fails(scene.setTransform(instance, away(1)), /^the instance is not there/);
  const next = await scene.addInstance(mesh, material);
  await fails(scene.setVisible(instance, true), /^the instance is not there/);
  await scene.remove(next);
  const car = await scene.addModel(cube);
  const part = car.instances[0];
  await scene.remove(car);
  await fails(scene.setTransform(part, away(1)), /^the instance is not there/);
  await fails(scene.setPose(car, 0), /^the model is not there/);
  const twice = await scene.addModel(knot);
  await scene.remove(twice.instances[0]);
  assert.equal(twice.instances.length, 0);
  scene.free();
  await fails(scene.render(), /^the scene was freed$/);
  await fails(scene.addMesh(square()), /^the scene was freed$/);
});

test("what is no mesh, matrix, light or option is refused in a sentence", async () => {
  const scene = new Scene(SMALL);
  const mesh = await scene.addMesh(square());
  const material = await scene.addMaterial();
  const instance = await scene.addInstance(mesh, material);
  const before = (await scene.render()).hash;
  const { positions, indices } = square();
  for (const [arrays, message] of [
    [undefined, /^mesh: expected an object with positions, found nothing$/],
    [positions, /^mesh: expected an object with positions, found an array$/],
    [{}, /^positions: expected an array of numbers, found nothing$/],
    [{ positions: "abc" }, /^positions: expected an array of numbers, found a string$/],
    [{ positions: ["0", 1, 2] }, /^positions\[0\]: expected a number, found a string$/],
    [{ positions: [0, , 2] }, /^positions\[1\]: expected a number, found nothing$/],
    [{ positions: [[0, 0, 0]] }, /^positions\[0\]: expected a number, found an array$/],
    [{ positions: positions.slice(1) }, /^positions: expected a multiple of 3 numbers, found 11$/],
    [{ positions: positions.with(4, NaN), indices }, /^mesh: .*not finite|^mesh: .*finite/],
    [{ positions: positions.with(4, 1e300), indices }, /^mesh: /],
    [{ positions }, /^positions: without indices each three vertices are a triangle, and there are 4$/],
    [{ positions, indices: [0, 1] }, /^indices: expected a multiple of 3 numbers, found 2$/],
    [{ positions, indices: [0, 1, 9] }, /^mesh: /],
    [{ positions, indices: [0, 1, -1] }, /^indices\[2\]: expected a whole number from 0 on, found -1$/],
    [{ positions, indices: [0, 1, 1.5] }, /^indices\[2\]: expected a whole number/],
    [{ positions, indices: [0, 1, 2 ** 32] }, /^indices\[2\]: expected a whole number/],
    [{ positions, indices: new BigInt64Array(3) }, /^indices: expected an array of numbers/],
    [{ positions, indices, normals: [0, 0, 1] }, /^mesh: .*normal/],
    [{ positions, indices, uvs: [0, 0, 1] }, /^uvs: expected a multiple of 2/],
    [{ positions, indices, colors: [0, 0, 1] }, /^colors: expected a multiple of 4/],
    [{ positions, indices, crease_deg: 181 }, /^crease_deg: expected a number from 0 to 180, found 181$/],
    [{ positions, indices, faces: [] }, /^mesh: there is no 'faces'; known are positions/],
  ]) {
    await fails(scene.addMesh(arrays), message);
    await fails(scene.setMesh(mesh, arrays), message);
  }
  for (const [transform, message] of [
    [undefined, /^transform: expected 16 numbers/],
    [null, /^transform: expected an array of numbers, found null$/],
    ["identity", /^transform: expected an array of numbers, found a string$/],
    [away(1).slice(1), /^transform: expected 16 numbers, column by column, found 15$/],
    [away(NaN), /^transform: /],
    [away(Infinity), /^transform: /],
    [away(1).with(3, 1), /^transform: expected \(0, 0, 0, 1\) as last row/],
    [away(1).with(15, 2), /^transform: expected \(0, 0, 0, 1\) as last row/],
  ]) {
    await fails(scene.setTransform(instance, transform), message);
    if (transform !== undefined) await fails(scene.addInstance(mesh, material, transform), message);
  }
  for (const [call, message] of [
    [() => scene.setVisible(instance, 1), /^visible: expected true or false, found a number \(1\)$/],
    [() => scene.addLight(), /^light: expected an object, found nothing$/],
    [() => scene.addLight({ type: "sun" }), /light.*type/],
    [() => scene.addLight({ type: "directional", direction: [0, 0, 0], intensity: 1 }), /direction/],
    [() => scene.addLight({ type: "point", position: [0, NaN, 0], intensity: 1 }), /^position\[1\]: expected a finite number, found NaN$/],
    [() => scene.addMaterial(7), /^material: expected a name, an object or null, found a number \(7\)$/],
    [() => scene.addMaterial("velvit"), /velvet/],
    [() => scene.addMaterial({ base_colour: "#fff" }), /^material: unknown key 'base_colour'.*base_color/],
    [() => scene.addMaterial({ roughness: 2 }), /^material: roughness: 2.* is out of range/],
    [() => scene.addMaterial({ roughness: NaN }), /^roughness: expected a finite number/],
    [() => scene.addModel("a.glb"), /^the model: expected the bytes of a file .* found a string$/],
    [() => scene.addModel(knot, { sise: 3 }), /^sise: there is no such key here/],
    [() => scene.addModel(knot, { animation: 0, material: "velvet" }), /^material: not of a model with an animation/],
    [() => scene.addModel(knot, { material: "velvit" }), /velvet/],
    [() => scene.addModel(knot, { transform: [1] }), /^transform: expected 16 numbers/],
    [() => scene.setEnvironment({ env: 7 }), /env/],
    [() => scene.setEnvironment({ exposure: 1 }), /^exposure: there is no such key here/],
    [() => scene.setEnvironment(), /^options: expected env, env_rotation_deg or env_intensity$/],
    [() => scene.render({ sise: 1 }), /sise: there is no such key; did you mean 'size'/],
    [() => scene.render({ light: [] }), /^light: is the scene's, by addLight\(\)$/],
    [() => scene.render({ env: "none" }), /^env: is the scene's, by setEnvironment\(\)$/],
    [() => scene.render({ worker: true }), /^worker: is an option of the scene$/],
    [() => scene.render(null), /^options: expected an object, found null$/],
    [() => scene.render({ aovs: ["deapth"] }), /^aovs: there is no 'deapth'/],
  ]) {
    await fails(call(), message);
  }
  await fails(scene.addModel(new Uint8Array(9)), /./, "input");
  await fails(scene.addModel(knot.subarray(0, 300)), /./, "input");
  await fails(scene.setEnvironment({ env: new Uint8Array(9) }), /./, "input");
  await fails(new Scene({ limits: { triangles: 1 } }).addMesh(square()), /^mesh: 2 exceeds the limit of 1 \(triangles\)$/);
  assert.throws(() => new Scene({ material: "velvet" }), { code: "options", message: /^material: is the scene's/ });
  assert.throws(() => new Scene("small"), { code: "options" });
  assert.equal((await scene.render()).hash, before, "nothing of it has changed anything");
});

test("what is asked is done in that order, waited for or not", async () => {
  const scene = new Scene(SMALL);
  const whole = scene.addModel(new Blob([knot]));
  const image = scene.render();
  const model = await whole;
  scene.setVisible(model, false);
  const hidden = scene.render();
  scene.setVisible(model, true);
  const [first, second, third] = [await image, await hidden, await scene.render()];
  assert.equal(first.hash, third.hash);
  assert.notEqual(second.hash, first.hash);
});

/** A triangle that moves to the right in one second, with a material. */
const moving = glb(
  {
    asset: { version: "2.0" },
    buffers: [{ byteLength: 68 }],
    bufferViews: [{ buffer: 0, byteLength: 36 }, { buffer: 0, byteOffset: 36, byteLength: 8 }, { buffer: 0, byteOffset: 44, byteLength: 24 }],
    accessors: [
      { bufferView: 0, componentType: 5126, count: 3, type: "VEC3", min: [0, 0, 0], max: [1, 1, 0] },
      { bufferView: 1, componentType: 5126, count: 2, type: "SCALAR", min: [0], max: [1] },
      { bufferView: 2, componentType: 5126, count: 2, type: "VEC3" },
    ],
    materials: [{ name: "paint" }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 }, material: 0 }] }],
    nodes: [{ mesh: 0 }],
    scenes: [{ nodes: [0] }],
    animations: [{ channels: [{ sampler: 0, target: { node: 0, path: "translation" } }], samplers: [{ input: 1, output: 2 }] }],
  },
  new Uint8Array(Float32Array.of(0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 1, 0, 0).buffer),
);

test("a model with an animation is posed", async () => {
  const scene = new Scene({ ...SMALL, camera: FRONT });
  const model = await scene.addModel(moving, { animation: 0 });
  assert.equal(model.duration, 1);
  assert.deepEqual([model.info.triangles, model.info.max[0]], [1, 1]);
  const late = await scene.addModel(moving, { animation: 0, time: 1 });
  assert.equal(late.info.max[0], 2);
  await scene.remove(late);
  assert.deepEqual(model.materials.map(({ name }) => name), ["paint"]);
  const first = (await scene.render()).hash;
  assert.equal((await render(moving, { ...SMALL, camera: FRONT, animation: 0, time: 0 })).hash, first);
  await scene.setPose(model, 0.5);
  assert.equal((await scene.render()).hash, (await render(moving, { ...SMALL, camera: FRONT, animation: 0, time: 0.5 })).hash);
  await scene.setPose(model, 0);
  assert.equal((await scene.render()).hash, first);
  const still = await scene.addModel(moving);
  assert.equal(still.duration, null);
  await fails(scene.setPose(still, 0), /^pose: the model was added without an animation$/);
  for (const seconds of [-1, NaN, Infinity]) await fails(scene.setPose(model, seconds), /^pose: expected seconds from 0 on/);
  await fails(scene.setPose(model, "1"), /^pose: expected seconds from 0 on, found a string$/);
});

test("a module that was started anew has the scene as it was", { timeout: 240_000 }, async () => {
  const renderer = createRenderer();
  const scene = renderer.scene({ ...SMALL, camera: { eye: [1.5, 0.5, 10], target: [1.5, 0.5, 0], ortho_height: 8 } });
  const still = await scene.addModel(cube, { transform: away(2) });
  const [mesh, spare] = [await scene.addMesh(square()), await scene.addMesh(square(2))];
  const [red, gone] = [await scene.addMaterial({ base_color: "#f00" }), await scene.addMaterial("velvet")];
  const instance = await scene.addInstance(spare, gone, away(-1));
  const posed = await scene.addModel(moving, { animation: 0 });
  const sun = await scene.addLight({ type: "directional", direction: [0, -1, -1], intensity: 2 });
  await scene.addLight({ type: "point", position: [0, 3, 0], intensity: 30 });
  // The same pose again moves nothing: what was moved since stays.
  await scene.setPose(posed, 0.75);
  await scene.setTransform(posed.instances[0], away(0, 1));
  await scene.setPose(posed, 0.75);
  const late = await scene.addMaterial({ base_color: "#0ff" });
  await scene.setInstanceMaterial(instance, late);
  await scene.setInstanceMesh(instance, mesh);
  await scene.remove(gone);
  await scene.remove(spare);
  await scene.setMaterial(late, { over: true, roughness: 0.2 });
  await scene.setMaterial(late, { over: true, coat: 1 });
  // An instance of a material of a model that is removed.
  const borrowed = await scene.addModel(knot);
  const second = await scene.addInstance(mesh, borrowed.materials[0], away(3, 1));
  await scene.remove(borrowed);
  await scene.setTransform(second, away(3, 1.5));
  const third = await scene.addInstance(mesh, red, away(0, 2));
  const lent = await scene.addModel(knot);
  await scene.setInstanceMaterial(third, lent.materials[0]);
  await scene.remove(lent);
  await scene.setInstanceMaterial(third, lent.materials[0]);
  await scene.setEnvironment({ env_rotation_deg: 45 });
  await scene.setEnvironment({ env_intensity: 0.5 });
  await scene.remove(sun);
  const before = await scene.render();
  const hits = async () => {
    const found = [];
    for (let x = 2; x < 48; x += 3) for (let y = 2; y < 48; y += 3) found.push((await scene.pick(x, y))?.instance);
    return found;
  };
  const seen = await hits();
  assert.deepEqual(new Set(seen), new Set([undefined, still.instances[0], instance, posed.instances[0], second, third]));

  for (let turn = 0; turn < 2; turn++) {
    // Ends the thread, with what waits behind.
    const controller = new AbortController();
    const long = scene.render({ size: 4096, quality: "best", rays: 256, signal: controller.signal });
    const waiting = scene.render();
    const second = new AbortController();
    const never = scene.render({ signal: second.signal });
    setTimeout(() => second.abort(new Error("changed my mind")), 50);
    const first = await Promise.race([long.then(() => "long"), never.catch((error) => error.message)]);
    assert.equal(first, "changed my mind", "at once, and not when its turn has come");
    setTimeout(() => controller.abort(), 300);
    await assert.rejects(long, { name: "AbortError" });
    assert.equal((await waiting).hash, before.hash, "what waited is drawn, of the same scene");
    assert.deepEqual(await hits(), seen);
    await fails(scene.setMaterial(gone, null), /^the material is not there/);
    // Handles go on.
    await scene.setTransform(still, away(5));
    assert.notEqual((await scene.render()).hash, before.hash);
    await scene.setTransform(still, away(2));
    assert.equal((await scene.render()).hash, before.hash);
  }

  // One that waits while another's picture ends the thread.
  const controller = new AbortController();
  const long = renderer.render(knot, { size: 4096, quality: "best", rays: 256, signal: controller.signal });
  const waiting = scene.render();
  setTimeout(() => controller.abort(), 300);
  await assert.rejects(long, { name: "AbortError" });
  assert.equal((await waiting).hash, before.hash);
  renderer.close();
  await fails(scene.render(), /^the renderer was closed$/);
});

test("what no longer counts is not kept", async () => {
  // As a scene keeps it: what is said again, and what is gone, leaves nothing behind.
  const asked = [];
  const journal = new Journal();
  const scene = {};
  const [mesh, instance] = [new Handle("mesh", scene), new Handle("instance", scene)];
  const material = () => {
    const made = new Handle("material", scene);
    journal.add({ operation: "add_material", args: ["{}"], makes: made });
    return made;
  };
  journal.add({ operation: "add_mesh", args: [], makes: mesh });
  let own = material();
  journal.add({ operation: "add_instance", args: [mesh, own], makes: instance });
  for (let k = 0; k < 10; k++) {
    const next = material();
    journal.addSubstance({ operation: "set_instance_material", args: [instance, next], about: instance }, "material", 1);
    journal.remove(own, { operation: "remove", args: ["material", own], about: own });
    journal.add({ operation: "set_transform", args: ["instance", instance, k], about: instance }, "place");
    own = next;
    asked.push([...journal].map(({ operation }) => operation));
  }
  for (const all of asked) assert.deepEqual(all, ["add_mesh", "add_material", "add_instance", "set_transform"]);
  assert.deepEqual([...journal].map(({ args }) => args), [[], ["{}"], [mesh, own], ["instance", instance, 9]]);
  journal.remove(instance, { operation: "remove", args: ["instance", instance], about: instance });
  assert.deepEqual([...journal].map(({ operation }) => operation), ["add_mesh", "add_material"]);
});

test("both builds pick and draw the same", async () => {
  const answers = [];
  for (const build of ["plain", "simd"]) {
    const engine = await Engine.create(build);
    engine.call("beginWorld", { id: 1, limits: {} });
    engine.call("change", { id: 1, name: "add_model", args: [new Uint8Array(knot), "{}", new Float64Array(0), [], []] });
    const request = { id: 1, description: JSON.stringify(SMALL) };
    const { hash } = engine.call("drawWorld", { ...request, aovs: [], linear: false });
    const hits = [];
    for (let x = 0; x < 48; x += 3) for (let y = 0; y < 48; y += 3) hits.push(engine.call("pick", { ...request, x, y }));
    // Names have numbers of their world.
    answers.push({ hash, hits: hits.map((hit) => hit.replace(/"(instance|model|material)":"\d+"/g, "")) });
  }
  assert.deepEqual(answers[0], answers[1]);
  assert.ok(answers[0].hits.some((hit) => hit !== "null"));
});
