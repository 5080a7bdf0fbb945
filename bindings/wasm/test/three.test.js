// Live scenes of three.js: beside the same scene written as glTF by its exporter, and what of them is taken over.
import assert from "node:assert/strict";
import test from "node:test";
import * as THREE from "three";
import { GLTFExporter } from "three/addons/exporters/GLTFExporter.js";
import { fromThree, render, threeCamera } from "../js/index.js";
import { checkMatch, matchers } from "../js/golden.js";

// Parts of browsers that the exporter needs.
globalThis.FileReader ??= class {
  readAsArrayBuffer(blob) {
    blob.arrayBuffer().then((buffer) => {
      this.result = buffer;
      this.onloadend();
    });
  }
};

const exported = (scene) => new Promise((done, failed) => new GLTFExporter().parse(scene, (glb) => done(new Uint8Array(glb)), failed, { binary: true, onlyVisible: true }));

const look = { size: [96, 72], quality: "draft", ground: "none", samples: 4, tone_mapping: "none" };

function camera() {
  const own = new THREE.PerspectiveCamera(40, 96 / 72, 0.1, 100);
  own.position.set(2, 2.5, 6);
  own.lookAt(0, 0, 0);
  return own;
}

/** The live scene, and its glTF under the same light from the same camera. */
async function both(scene, seen = camera()) {
  const live = await fromThree(scene, seen, look);
  const glb = await exported(scene);
  const [ours, theirs] = [await live.render(), await render(glb, { ...look, env: "none", shading: "three", camera: threeCamera(seen, look.size) })];
  live.free();
  return { ours, theirs, warnings: live.warnings };
}

/** The largest difference of a pixel, and how many pixels differ by more than 1. */
function apart({ ours, theirs }) {
  let [most, pixels, covered] = [0, 0, 0];
  for (let k = 0; k < ours.pixels.length; k += 4) {
    let here = 0;
    for (let c = 0; c < 4; c++) here = Math.max(here, Math.abs(ours.pixels[k + c] - theirs.pixels[k + c]));
    most = Math.max(most, here);
    if (here > 1) pixels++;
    if (ours.pixels[k + 3] > 0) covered++;
  }
  return { most, pixels, covered };
}

function lit() {
  const scene = new THREE.Scene();
  const sun = new THREE.DirectionalLight(0xfff0e0, 2);
  sun.position.set(1, 3, 2);
  // glTF's lights shine along their own axis.
  sun.target.position.set(0, 0, -1);
  sun.add(sun.target);
  sun.rotation.set(-0.8, 0.4, 0);
  const lamp = new THREE.PointLight(0xff8040, 30, 0, 2);
  lamp.position.set(-2, 1.5, 2);
  const spot = new THREE.SpotLight(0x80a0ff, 60, 0, 0.5, 0.3, 2);
  spot.position.set(0, 4, 1);
  spot.target.position.set(0, 0, -1);
  spot.add(spot.target);
  spot.rotation.set(-1.3, 0, 0);
  return scene.add(sun, lamp, spot);
}

test("standard and physical materials, lights and groups are those of the exporter", async () => {
  const scene = lit();
  const ball = new THREE.SphereGeometry(0.7, 32, 24);
  const add = (material, x, y) => {
    const mesh = new THREE.Mesh(ball, material);
    mesh.position.set(x, y, 0);
    scene.add(mesh);
  };
  add(new THREE.MeshStandardMaterial({ color: 0xcc3311, roughness: 0.4, metalness: 0.2 }), -1.6, 0.8);
  add(new THREE.MeshPhysicalMaterial({ color: 0x113366, roughness: 0.6, clearcoat: 1, clearcoatRoughness: 0.1 }), 0, 0.8);
  add(new THREE.MeshPhysicalMaterial({ color: 0x333333, roughness: 0.8, sheen: 1, sheenRoughness: 0.5, sheenColor: 0x8844aa }), 1.6, 0.8);
  add(new THREE.MeshPhysicalMaterial({ color: 0xffffff, roughness: 0.2, transmission: 0.8, thickness: 0.5, attenuationColor: 0x88ff88, attenuationDistance: 1, ior: 1.4 }), -1.6, -0.8);
  add(new THREE.MeshStandardMaterial({ color: 0x888888, emissive: 0x2244ff, emissiveIntensity: 1.5 }), 0, -0.8);
  const box = new THREE.BoxGeometry(1, 1, 1);
  const sides = [0xff0000, 0x00ff00, 0x0000ff, 0xffff00, 0x00ffff, 0xff00ff].map((color) => new THREE.MeshStandardMaterial({ color, roughness: 1 }));
  const cube = new THREE.Mesh(box, sides);
  cube.position.set(1.6, -0.8, 0);
  cube.rotation.set(0.3, 0.6, 0);
  scene.add(cube);
  const hidden = new THREE.Mesh(box);
  hidden.visible = false;
  scene.add(hidden);
  const found = await both(scene);
  const { most, pixels, covered } = apart(found);
  console.log(`standard and physical: ${covered} pixels, ${pixels} differ by more than 1 of 255, by ${most} at most; warnings ${JSON.stringify(found.warnings)}`);
  assert.ok(covered > 1500 && most <= 1, JSON.stringify({ most, pixels, covered }));
  assert.deepEqual(found.warnings, []);
});

test("instances, colours of vertices, lines and points are those of the exporter", async () => {
  const scene = lit();
  const instanced = new THREE.InstancedMesh(new THREE.ConeGeometry(0.3, 0.8, 16), new THREE.MeshStandardMaterial({ color: 0x99bbff }), 5);
  for (let k = 0; k < 5; k++) instanced.setMatrixAt(k, new THREE.Matrix4().makeTranslation(k - 2, 0.8, 0));
  scene.add(instanced);
  const colored = new THREE.PlaneGeometry(2, 1);
  colored.setAttribute("color", new THREE.Float32BufferAttribute([1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1], 3));
  const plane = new THREE.Mesh(colored, new THREE.MeshBasicMaterial({ vertexColors: true, side: THREE.DoubleSide }));
  plane.position.y = -0.8;
  scene.add(plane);
  const found = await both(scene);
  const { most, pixels, covered } = apart(found);
  console.log(`instances and colours: ${covered} pixels, ${pixels} differ by more than 1 of 255, by ${most} at most`);
  assert.ok(covered > 500 && most <= 1, JSON.stringify({ most, pixels, covered }));

  const flat = new THREE.Scene();
  const corners = new THREE.BufferGeometry().setFromPoints([[-1, -1, 0], [1, -1, 0], [1, 1, 0]].map((p) => new THREE.Vector3(...p)));
  flat.add(new THREE.LineLoop(corners, new THREE.LineBasicMaterial({ color: 0xff0000 })));
  flat.add(new THREE.Points(corners, new THREE.PointsMaterial({ color: 0x0000ff })));
  const live = await fromThree(flat, camera(), { ...look, point_size: 6, line_width: 2 });
  const { pixels: drawn } = await live.render();
  let [red, blue] = [0, 0];
  for (let k = 0; k < drawn.length; k += 4) {
    if (drawn[k + 3] < 200) continue;
    red += drawn[k] > 200 && drawn[k + 2] < 60;
    blue += drawn[k + 2] > 200 && drawn[k] < 60;
  }
  live.free();
  assert.ok(red > 60 && blue > 40, `${red} ${blue}`);
});

test("skins and morph targets are as they are posed", async () => {
  const scene = lit();
  const geometry = new THREE.CylinderGeometry(0.3, 0.3, 2, 12, 8);
  const count = geometry.attributes.position.count;
  const [joints, weights] = [new Uint16Array(4 * count), new Float32Array(4 * count)];
  for (let k = 0; k < count; k++) {
    const up = Math.min(Math.max(geometry.attributes.position.getY(k) + 0.5, 0), 1);
    joints.set([0, 1, 0, 0], 4 * k);
    weights.set([1 - up, up, 0, 0], 4 * k);
  }
  geometry.setAttribute("skinIndex", new THREE.BufferAttribute(joints, 4));
  geometry.setAttribute("skinWeight", new THREE.BufferAttribute(weights, 4));
  const [low, high] = [new THREE.Bone(), new THREE.Bone()];
  low.position.y = -1;
  high.position.y = 1;
  low.add(high);
  const skinned = new THREE.SkinnedMesh(geometry, new THREE.MeshStandardMaterial({ color: 0xddaa66 }));
  skinned.add(low);
  skinned.bind(new THREE.Skeleton([low, high]));
  scene.add(skinned);
  const straight = await both(scene);
  high.rotation.z = 0.9;
  const bent = await both(scene);
  // three.js turns normals by the blend of the bones' matrices, readers of glTF by its inverse transpose: bends are shaded a little otherwise.
  for (const [found, allowed] of [[straight, 1], [bent, 16]]) {
    const { most, pixels, covered } = apart(found);
    console.log(`skin: ${covered} pixels, ${pixels} differ by more than 1 of 255, by ${most} at most`);
    assert.ok(covered > 200 && most <= allowed, JSON.stringify({ most, pixels, covered }));
  }
  assert.ok(apart({ ours: straight.ours, theirs: bent.ours }).pixels > 100);

  const morph = new THREE.BoxGeometry(1, 1, 1);
  const moved = morph.attributes.position.clone();
  for (let k = 0; k < moved.count; k++) moved.setX(k, moved.getX(k) * 3);
  morph.morphAttributes.position = [moved];
  const wide = new THREE.Scene().add(new THREE.Mesh(morph, new THREE.MeshBasicMaterial()));
  const area = async () => {
    const live = await fromThree(wide, camera(), look);
    const { pixels } = await live.render();
    live.free();
    return pixels.filter((v, k) => k % 4 === 3 && v > 127).length;
  };
  const narrow = await area();
  wide.children[0].morphTargetInfluences[0] = 0.5;
  const middle = await area();
  assert.ok(middle > 1.4 * narrow && middle < 2.2 * narrow, `${narrow} ${middle}`);
});

test("textures lie as in WebGL, whatever their order of rows, colour space and type", async () => {
  const data = new Uint8Array([255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 128, 128, 128, 255]);
  const front = new THREE.OrthographicCamera(-1, 1, 1, -1, 0.1, 10);
  front.position.z = 2;
  const seen = async (change) => {
    const map = new THREE.DataTexture(data, 2, 2);
    map.colorSpace = THREE.SRGBColorSpace;
    change(map);
    map.needsUpdate = true;
    const scene = new THREE.Scene().add(new THREE.Mesh(new THREE.PlaneGeometry(2, 2), new THREE.MeshBasicMaterial({ map })));
    const live = await fromThree(scene, front, { ...look, size: 32 });
    const { pixels } = await live.render();
    live.free();
    const at = (x, y) => [...pixels.slice(4 * (32 * y + x), 4 * (32 * y + x) + 3)];
    return [at(8, 8), at(24, 8), at(8, 24), at(24, 24)];
  };
  // v = 0, below, is the first row.
  assert.deepEqual(await seen(() => {}), [[0, 0, 255], [128, 128, 128], [255, 0, 0], [0, 255, 0]]);
  assert.deepEqual(await seen((map) => (map.flipY = true)), [[255, 0, 0], [0, 255, 0], [0, 0, 255], [128, 128, 128]]);
  const linear = await seen((map) => (map.colorSpace = THREE.NoColorSpace));
  assert.ok(Math.abs(linear[1][0] - 188) <= 1, String(linear[1]));
  assert.deepEqual(await seen((map) => Object.assign(map, { image: { data: Float32Array.from(data, (v) => v / 255), width: 2, height: 2 }, type: THREE.FloatType })), await seen(() => {}));
  assert.deepEqual((await seen((map) => map.offset.set(0.5, 0)) )[2], [0, 255, 0].map((v, k) => (k === 1 ? 255 : 0)));
});

test("cameras are those of three.js", async () => {
  const scene = new THREE.Scene().add(new THREE.Mesh(new THREE.SphereGeometry(0.05), new THREE.MeshBasicMaterial()));
  const place = new THREE.Vector3(0.7, -0.3, -0.5);
  scene.children[0].position.copy(place);
  const shifted = camera();
  shifted.setViewOffset(400, 300, 60, 40, 260, 210);
  const parallel = new THREE.OrthographicCamera(-2, 2, 1.5, -1.5, 0.1, 50);
  parallel.position.set(3, 2, 5);
  parallel.lookAt(0, 0, 0);
  parallel.zoom = 1.3;
  parallel.updateProjectionMatrix();
  for (const own of [camera(), shifted, parallel]) {
    const live = await fromThree(scene, own, { ...look, size: [200, 150], samples: 8 });
    const picture = await live.render();
    live.free();
    const { K, world_to_camera: rows, kind } = picture.camera;
    assert.equal(kind, own.isPerspectiveCamera ? "perspective" : "orthographic");
    const [x, y, z] = rows.slice(0, 3).map((row) => row[0] * place.x + row[1] * place.y + row[2] * place.z + row[3]);
    const by = own.isPerspectiveCamera ? z : 1;
    const [u, v] = [(K[0][0] * x) / by + K[0][2], (K[1][1] * y) / by + K[1][2]];
    const clip = place.clone().project(own);
    assert.ok(Math.abs(u - ((clip.x + 1) / 2) * 200) < 1e-3 && Math.abs(v - ((1 - clip.y) / 2) * 150) < 1e-3, `${u} ${v}`);
    let [sum, left, top] = [0, 0, 0];
    for (let k = 3; k < picture.pixels.length; k += 4) {
      const [w, n] = [picture.pixels[k], (k - 3) / 4];
      [sum, left, top] = [sum + w, left + w * (n % 200), top + w * Math.floor(n / 200)];
    }
    assert.ok(Math.abs(left / sum + 0.5 - u) < 0.5 && Math.abs(top / sum + 0.5 - v) < 0.5);
  }
});

test("what is not drawn is told, and what is no scene is refused", async () => {
  const scene = new THREE.Scene();
  scene.fog = new THREE.Fog(0xffffff);
  scene.background = new THREE.Color(0x204060);
  scene.add(new THREE.AmbientLight(0xffffff, Math.PI), new THREE.Mesh(new THREE.BoxGeometry(), new THREE.MeshPhongMaterial({ color: 0x808080 })));
  const live = await fromThree(scene, camera(), look);
  const { pixels, warnings } = await live.render();
  assert.ok(live.warnings.some((text) => text.includes("fog")) && live.warnings.some((text) => text.includes("MeshPhongMaterial")), String(live.warnings));
  assert.deepEqual([...pixels.slice(0, 4)], [0x20, 0x40, 0x60, 255]);
  const middle = 4 * (36 * 96 + 48);
  // Ambient light of pi: its irradiance times albedo over pi, here that of 0x80.
  assert.ok(Math.abs(pixels[middle] - 0x80) < 6, `${pixels[middle]} ${warnings}`);
  live.free();
  await assert.rejects(fromThree({}, camera()), { code: "options", message: /expected a scene of three.js/ });
  await assert.rejects(fromThree(scene, scene), { code: "options", message: /expected a camera/ });
});

test("toMatchOvercoat draws what a screenshot is held against", async () => {
  const scene = lit().add(new THREE.Mesh(new THREE.TorusKnotGeometry(0.8, 0.25, 64, 12), new THREE.MeshStandardMaterial({ color: 0xcc8844 })));
  const live = await fromThree(scene, camera(), look);
  const image = await live.render({ size: [80, 60] });
  const png = await image.png();
  const page = { screenshot: async ({ type, clip }) => (assert.equal(type, "png"), assert.deepEqual(clip, { x: 1 }), png) };
  assert.equal((await checkMatch(png, live)).good, true);
  assert.equal((await matchers.toMatchOvercoat(page, live, { thresholds: "", screenshot: { clip: { x: 1 } } })).pass, true);
  const other = await matchers.toMatchOvercoat(image, live, { exposure: 2, thresholds: { max_abs: 4, pixels: 3 } });
  assert.equal(other.pass, false);
  assert.match(other.message(), /picture: /);
  await assert.rejects(checkMatch("page", live), { code: "options", message: /a page or an element of Playwright, found a string/ });
  await assert.rejects(checkMatch(new Uint8Array(40), live), { code: "options", message: /no PNG file/ });
  live.free();
});
