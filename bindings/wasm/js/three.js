// A live scene of three.js, by its fields: three.js need not be there.
import { OvercoatError, what } from "./error.js";
import { Scene } from "./scene.js";
import { meshOf } from "./three-geometry.js";
import { Textures, channelOf, materialOf } from "./three-materials.js";

const wrong = (message) => new OvercoatError(message, "options");
const rgb = ({ r, g, b }) => [r, g, b];

/** Tone mappings of three.js by their numbers. */
const TONES = { 0: "none", 1: "none", 4: "aces", 6: "agx", 7: "neutral" };

/** The size in pixels of options. */
const sizeOf = (size = 512) => (typeof size === "number" ? [size, size] : size);

/** The option `camera` of a camera of three.js, for a picture of that size. */
export function threeCamera(camera, size) {
  const [width, height] = sizeOf(size);
  camera.updateWorldMatrix(true, false);
  const e = camera.matrixWorld.elements;
  // Whatever scale its parents have is none of the view's.
  const axis = (k) => {
    const length = Math.hypot(e[4 * k], e[4 * k + 1], e[4 * k + 2]) || 1;
    return [0, 1, 2].map((row) => e[4 * k + row] / length);
  };
  const axes = [0, 1, 2].map(axis);
  const pose = [...[0, 1, 2].map((row) => [axes[0][row], axes[1][row], axes[2][row], e[12 + row]]), [0, 0, 0, 1]];
  const view = { pose, convention: "opengl", near: camera.near };
  if (Number.isFinite(camera.far)) view.far = camera.far;
  const p = camera.projectionMatrix.elements;
  if (camera.isOrthographicCamera) {
    if (Math.abs(p[12]) > 1e-6 || Math.abs(p[13]) > 1e-6) throw wrong("camera: a parallel projection whose middle is not that of the picture is not drawn");
    // Depths before the camera are seen by it as well; ours begin there.
    return { ...view, near: Math.max(camera.near, 1e-6), ortho_height: 2 / p[5] };
  }
  if (!camera.isPerspectiveCamera) throw wrong(`camera: expected a PerspectiveCamera or an OrthographicCamera, found ${camera.type ?? what(camera)}`);
  return { ...view, K: [(p[0] * width) / 2, (p[5] * height) / 2, ((1 - p[8]) * width) / 2, ((1 + p[9]) * height) / 2] };
}

/** Place of an object. */
function places(object) {
  const { matrixWorld } = object;
  if (!object.isInstancedMesh) return [Array.from(matrixWorld.elements)];
  const own = matrixWorld.clone();
  return Array.from({ length: object.count }, (_, k) => {
    object.getMatrixAt(k, own);
    return Array.from(own.premultiply(matrixWorld).elements);
  });
}

const worldPosition = (object) => Array.from(object.matrixWorld.elements.slice(12, 15));

/** A light as scene files have it; `undefined` of what is none of a place or a direction. */
function lightOf(light, warn) {
  const own = { color: rgb(light.color), intensity: light.intensity };
  if (!(light.intensity > 0)) return undefined;
  const between = () => {
    light.target.updateWorldMatrix(true, false);
    const [from, to] = [worldPosition(light), worldPosition(light.target)];
    return { from, to, direction: to.map((v, k) => v - from[k]) };
  };
  if (light.isDirectionalLight) return { ...own, type: "directional", direction: between().direction };
  const range = light.distance > 0 ? { range: light.distance } : {};
  if (light.isPointLight || light.isSpotLight) {
    if (light.decay !== 2) warn(`${light.name || light.type}: light fades with the square of the distance, not by a decay of ${light.decay}`);
  }
  if (light.isPointLight) return { ...own, ...range, type: "point", position: worldPosition(light) };
  const degrees = (angle) => (angle * 180) / Math.PI;
  if (light.isSpotLight) {
    const { from, to } = between();
    const cones = { inner_cone_deg: degrees(light.angle * (1 - light.penumbra)), outer_cone_deg: degrees(light.angle) };
    return { ...own, ...range, type: "spot", position: from, target: to, ...cones };
  }
  if (light.isRectAreaLight) {
    const e = light.matrixWorld.elements;
    const position = worldPosition(light);
    const sides = [0, 1].map((k) => Math.hypot(e[4 * k], e[4 * k + 1], e[4 * k + 2]));
    return {
      ...own, type: "rect", position, target: position.map((v, k) => v - e[8 + k]), up: [e[4], e[5], e[6]],
      size: [light.width * sides[0], light.height * sides[1]],
    };
  }
  return undefined;
}

/** Light from everywhere alike as a Radiance file: of `AmbientLight` an irradiance, whose radiance is a part in pi. */
function ambientFile(irradiance) {
  const radiance = irradiance.map((v) => v / Math.PI);
  const most = Math.max(...radiance);
  const exponent = Math.floor(Math.log2(most)) + 1;
  const texel = [...radiance.map((v) => Math.min(Math.round((v / 2 ** exponent) * 256), 255)), exponent + 128];
  const head = new TextEncoder().encode("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n");
  const bytes = new Uint8Array(head.length + 4 * 32);
  bytes.set(head);
  for (let k = 0; k < 32; k++) bytes.set(texel, head.length + 4 * k);
  return bytes;
}

/** Adds lights and the environment. */
async function addLights(scene, of, warn) {
  const ambient = [0, 0, 0];
  const lights = [];
  of.traverseVisible((object) => {
    if (!object.isLight) return;
    const found = lightOf(object, warn);
    if (found !== undefined) lights.push(found);
    else if (object.isAmbientLight || object.isHemisphereLight) {
      const colors = object.isHemisphereLight ? [object.color, object.groundColor] : [object.color, object.color];
      for (const [k, part] of ["r", "g", "b"].entries()) ambient[k] += (object.intensity * (colors[0][part] + colors[1][part])) / 2;
      if (object.isHemisphereLight) warn("a HemisphereLight is the same from all sides");
    } else if (object.intensity > 0) warn(`a ${object.type} is not drawn`);
  });
  for (const light of lights) await scene.addLight(light);
  if (of.environment) warn("environment: give its file to setEnvironment(): textures of environments cannot be read back");
  if (ambient.some((part) => part > 0)) {
    await scene.setEnvironment({ env: "ambient.hdr", files: { "ambient.hdr": ambientFile(ambient) } });
  } else await scene.setEnvironment({ env: "none" });
}

/** What is drawn of an object: materials, each with the group of the geometry that is of it. */
function parts({ material, geometry }) {
  if (!Array.isArray(material)) return [[material, undefined]];
  return geometry.groups.map((group) => [material[group.materialIndex ?? 0], group]).filter(([own]) => own !== undefined);
}

/** Adds what is drawn; meshes and materials that are used several times are added once. */
async function addObjects(scene, of, warn) {
  const textures = new Textures(warn);
  const [meshes, materials] = [new Map(), new Map()];
  const once = async (all, key, make) => {
    if (!all.has(key)) all.set(key, await make());
    return all.get(key);
  };
  const objects = [];
  of.traverseVisible((object) => {
    if (object.isMesh || object.isLine || object.isPoints) objects.push(object);
    else if (object.isSprite) warn("a Sprite is not drawn");
  });
  for (const object of objects) {
    const isPosed = object.isSkinnedMesh || (object.morphTargetInfluences ?? []).some((influence) => influence !== 0);
    const isFlat = object.isLine === true || object.isPoints === true;
    if (object.isBatchedMesh) {
      warn("a BatchedMesh is not drawn");
      continue;
    }
    for (const [material, group] of parts(object)) {
      if (material.visible === false) continue;
      if (material.isShaderMaterial) warn(`${material.name || material.type}: a shader of one's own is drawn as a diffuse surface`);
      const channel = channelOf(material, warn);
      const key = [object.geometry.uuid, group?.start, group?.count, channel, material.flatShading, material.vertexColors, isPosed && object.uuid, isFlat && object.type];
      const mesh = await once(meshes, key.join(" "), async () => {
        const arrays = meshOf(object, material, channel, group);
        return arrays === undefined ? undefined : { handle: await scene.addMesh(arrays), hasMaps: arrays.uvs !== undefined };
      });
      if (mesh === undefined) continue;
      for (const [k, place] of places(object).entries()) {
        const tint = object.instanceColor ? Array.from({ length: 3 }, (_, c) => object.instanceColor.array[3 * k + c]) : undefined;
        const made = await once(materials, [material.uuid, tint, mesh.hasMaps, isFlat].join(" "), () => {
          return scene.addMaterial(materialOf(material, { textures, warn, tint, hasMaps: mesh.hasMaps, isFlat }));
        });
        await scene.addInstance(mesh.handle, made, place);
      }
    }
  }
}

/** See `types/three.d.ts`. */
export class ThreeScene {
  #camera;
  #options;

  /** @internal */
  constructor(scene, camera, options, warnings) {
    this.scene = scene;
    this.#camera = camera;
    this.#options = options;
    this.warnings = warnings;
  }

  /** The options of a picture: those of the scene and the camera as it is now. */
  options(options = {}) {
    const all = { ...this.#options, ...options };
    return { ...all, camera: all.camera ?? threeCamera(this.#camera, all.size) };
  }

  render(options) {
    return this.scene.render(this.options(options));
  }

  free() {
    this.scene.free();
  }
}

/** See `types/three.d.ts`. */
export async function fromThree(of, camera, { renderer, worker, limits, ...options } = {}) {
  if (!of?.isObject3D) throw wrong(`scene: expected a scene of three.js, found ${what(of)}`);
  if (!camera?.isCamera) throw wrong(`camera: expected a camera of three.js, found ${what(camera)}`);
  const warnings = new Set();
  const warn = (message) => warnings.add(message);
  of.updateMatrixWorld(true);
  of.traverse((object) => object.isSkinnedMesh && object.skeleton?.update());
  let hasShadows = false;
  of.traverseVisible((object) => (hasShadows ||= object.isLight === true && object.castShadow === true));
  // Nothing blocks light here if nothing throws shadows there.
  const look = { ground: "none", quality: hasShadows ? "fast" : "draft", tone_mapping: TONES[renderer?.toneMapping ?? 0] };
  if (look.tone_mapping === undefined) {
    warn(`tone mapping ${renderer.toneMapping} of three.js is not known: it is drawn without`);
    look.tone_mapping = "none";
  }
  if (renderer !== undefined && renderer.toneMapping !== 0) look.exposure = Math.log2(renderer.toneMappingExposure);
  if (of.background?.isColor) look.background = `#${of.background.getHexString()}`;
  else if (of.background) warn("background: only colours are drawn");
  if (of.fog) warn("fog is not drawn");
  const scene = new Scene({ ...(worker !== undefined && { worker }), ...(limits !== undefined && { limits }) });
  try {
    await addLights(scene, of, warn);
    await addObjects(scene, of, warn);
  } catch (error) {
    scene.free();
    throw error;
  }
  return new ThreeScene(scene, camera, { ...look, ...options }, [...warnings]);
}
