// Scenes of arrays: textures of numbers, lines and points, and the camera of a picture.
import assert from "node:assert/strict";
import { deflateSync } from "node:zlib";
import test from "node:test";
import { Scene, render } from "../js/index.js";
import { model } from "./common.js";

const QUAD = { positions: [-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0], indices: [0, 1, 2, 0, 2, 3], normals: [0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1], uvs: [0, 1, 1, 1, 1, 0, 0, 0] };
const look = { size: 32, quality: "draft", ground: "none", camera: { eye: [0, 0, 5], target: [0, 0, 0], ortho_height: 2.5 } };

/** A PNG of bytes R, G, B. */
function png(data, width, height) {
  const table = Uint32Array.from({ length: 256 }, (_, n) => { for (let k = 0; k < 8; k++) n = n & 1 ? 0xedb88320 ^ (n >>> 1) : n >>> 1; return n; });
  const chunk = (type, body) => {
    const bytes = Buffer.concat([Buffer.from(type), body]);
    let crc = ~0;
    for (const byte of bytes) crc = table[(crc ^ byte) & 255] ^ (crc >>> 8);
    const [head, tail] = [Buffer.alloc(4), Buffer.alloc(4)];
    head.writeUInt32BE(body.length);
    tail.writeUInt32BE(~crc >>> 0);
    return Buffer.concat([head, bytes, tail]);
  };
  const header = Buffer.alloc(13);
  header.writeUInt32BE(width, 0);
  header.writeUInt32BE(height, 4);
  header.set([8, 2], 8);
  const rows = Buffer.concat(Array.from({ length: height }, (_, y) => Buffer.concat([Buffer.from([0]), Buffer.from(data.subarray(3 * width * y, 3 * width * (y + 1)))])));
  return Buffer.concat([Buffer.from([137, 80, 78, 71, 13, 10, 26, 10]), chunk("IHDR", header), chunk("IDAT", deflateSync(rows)), chunk("IEND", Buffer.alloc(0))]);
}

async function drawn(material, options) {
  const scene = new Scene();
  await scene.addInstance(await scene.addMesh(QUAD), await scene.addMaterial(material, options));
  const { hash } = await scene.render(look);
  scene.free();
  return hash;
}

test("textures of numbers are those of files", async () => {
  const data = Uint8Array.from({ length: 3 * 4 * 4 }, (_, k) => (k * 37) % 256);
  const picture = { data, width: 4, height: 4 };
  const file = { files: { "a.png": png(data, 4, 4) } };
  const keys = (of) => ({ base_color_texture: of, normal_texture: { file: of, wrap: "clamp", filter: "nearest" }, coat: 1, coat_color: [1, 0.5, 0.2] });
  const expected = await drawn(keys("a.png"), file);
  assert.equal(await drawn(keys(picture)), expected);
  assert.equal(await drawn(keys({ ...picture, data: Float32Array.from(data, (v) => v / 255) })), expected);
  assert.notEqual(await drawn({ ...keys(picture), normal_texture: false }), expected);
  for (const [bad, message] of [
    [{ ...picture, width: 5 }, /48 numbers are not 1, 3 or 4 for each of 5 x 4/],
    [{ ...picture, width: 0 }, /width: expected a whole number from 1/],
    [{ ...picture, data: [1, 2] }, /data: expected a Uint8Array/],
  ]) {
    await assert.rejects(drawn({ base_color_texture: bad }), { code: "options", message });
  }
});

test("lines and points are drawn as wide as the options say", async () => {
  const area = async (mesh, options) => {
    const scene = new Scene();
    await scene.addInstance(await scene.addMesh(mesh), await scene.addMaterial({ unlit: true }));
    const { linear } = await scene.render({ ...look, ...options, linear: true });
    scene.free();
    return linear.reduce((sum, v, k) => (k % 4 === 3 ? sum + v : sum), 0);
  };
  const corners = { positions: QUAD.positions };
  const around = { ...corners, kind: "lines", indices: [0, 1, 1, 2, 2, 3, 3, 0] };
  // Four sides of 25.6 pixels.
  const [thin, thick] = [await area(around, { line_width: 1 }), await area(around, { line_width: 3 })];
  assert.ok(thin > 92 && thin < 112 && thick > 280 && thick < 320, `${thin} ${thick}`);
  const points = await area({ ...corners, kind: "points" }, { point_size: 6 });
  assert.ok(points > 4 * 22 && points < 4 * 34, String(points));
  await assert.rejects(area({ ...corners, kind: "strips" }), { code: "options", message: /kind: expected triangles, lines, points, found 'strips'/ });
  await assert.rejects(area({ ...corners, kind: "lines", indices: [0, 1, 2] }), { code: "options", message: /indices: expected a multiple of 2/ });
});

test("a picture has its camera, which it can be asked for again", async () => {
  const options = { size: [64, 48], quality: "draft" };
  const image = await render(model("rounded-cube.glb"), options);
  const { K, kind, width, height, camera_to_world: pose, near, far } = image.camera;
  assert.deepEqual([kind, width, height, K[0][2], K[1][2], far], ["perspective", 64, 48, 32, 24, null]);
  const again = await render(model("rounded-cube.glb"), { ...options, camera: { K: [K[0][0], K[1][1], K[0][2], K[1][2]], pose, convention: "opengl", near }, aovs: ["depth", "position"] });
  assert.ok(Math.abs(again.camera.K[0][0] - K[0][0]) < 1e-9);
  // Depth unprojects to the plane of positions.
  let worst = 0;
  for (let k = 0; k < 64 * 48; k++) {
    const z = again.aovs.depth[k];
    if (z === 0) continue;
    const local = [(z * ((k % 64) + 0.5 - K[0][2])) / K[0][0], (-z * (Math.floor(k / 64) + 0.5 - K[1][2])) / K[1][1], -z, 1];
    for (let row = 0; row < 3; row++) {
      const at = pose[row].reduce((sum, v, c) => sum + v * local[c], 0);
      worst = Math.max(worst, Math.abs(at - again.aovs.position[3 * k + row]) / z);
    }
  }
  assert.ok(worst < 1e-5, String(worst));
});
