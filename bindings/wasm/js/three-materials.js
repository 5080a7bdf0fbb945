// Materials and textures of three.js as the keys of material files.
import { OvercoatError } from "./error.js";

// Numbers of three.js (src/constants.js).
const WRAPS = { 1000: "repeat", 1001: "clamp", 1002: "mirror" };
const NEAREST = [1003, 1004, 1005];
const [BACK, DOUBLE] = [1, 2];
const [HALF_FLOAT] = [1016];
const CHANNELS = { 1023: 4, 1028: 1, 1022: 3 };

const clamp = (value, low, high) => Math.min(Math.max(value, low), high);
const rgb = ({ r, g, b }, by = 1) => [r * by, g * by, b * by];

/** Codes of sRGB of linear light, and linear codes of sRGB, 0 to 255 (IEC 61966-2-1). */
const toSrgb = (v) => (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055);
const toLinear = (v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);
const codes = (of) => Uint8Array.from({ length: 256 }, (_, code) => Math.round(255 * of(code / 255)));
const TO_SRGB = codes(toSrgb);
const TO_LINEAR = codes(toLinear);

function fromHalf(bits) {
  const [sign, exponent, mantissa] = [bits >> 15 ? -1 : 1, (bits >> 10) & 31, bits & 1023];
  if (exponent === 0) return sign * 2 ** -24 * mantissa;
  return exponent === 31 ? 0 : sign * 2 ** (exponent - 15) * (1 + mantissa / 1024);
}

/** Pixels of whatever a browser draws from: an image, a canvas, a bitmap, a frame of a video. */
function drawn(image) {
  const width = image.naturalWidth ?? image.videoWidth ?? image.displayWidth ?? image.width;
  const height = image.naturalHeight ?? image.videoHeight ?? image.displayHeight ?? image.height;
  if (typeof OffscreenCanvas === "undefined" || !(width > 0 && height > 0)) return undefined;
  const context = new OffscreenCanvas(width, height).getContext("2d", { willReadFrequently: true });
  context.drawImage(image, 0, 0, width, height);
  return { data: context.getImageData(0, 0, width, height).data, width, height };
}

/** Reads textures, each once. */
export class Textures {
  #pictures = new Map();
  #warn;

  constructor(warn) {
    this.#warn = warn;
  }

  /** A texture as the value of a key, for a slot of colours (sRGB) or of data. `undefined` of what cannot be read. */
  use(name, texture, isColor, extra = {}) {
    if (!texture) return undefined;
    const file = this.#picture(name, texture, isColor);
    if (file === undefined) return undefined;
    texture.updateMatrix?.();
    const [u, v] = [texture.repeat?.x ?? 1, texture.repeat?.y ?? 1];
    const e = texture.matrix?.elements ?? [1, 0, 0, 0, 1, 0, 0, 0, 1];
    const rotation = texture.rotation ?? 0;
    if (rotation !== 0 && u !== v) this.#warn(`${name}: a texture that is turned and scaled differently along its sides lies a little otherwise`);
    return {
      file,
      scale: [u, v],
      rotation: (rotation * 180) / Math.PI,
      offset: [e[6], e[7]],
      wrap: [WRAPS[texture.wrapS] ?? "clamp", WRAPS[texture.wrapT] ?? "clamp"],
      filter: NEAREST.includes(texture.magFilter) ? "nearest" : "linear",
      ...extra,
    };
  }

  #picture(name, texture, isColor) {
    const key = `${texture.uuid} ${texture.version} ${isColor}`;
    if (!this.#pictures.has(key)) this.#pictures.set(key, this.#read(name, texture, isColor));
    return this.#pictures.get(key);
  }

  #read(name, texture, isColor) {
    const image = texture.image ?? texture.source?.data;
    if (!image || texture.isCompressedTexture || texture.isVideoTexture) {
      this.#warn(`${name}: a ${texture.isCompressedTexture ? "compressed texture" : "texture without a picture"} is not drawn`);
      return undefined;
    }
    let { data, width, height } = image;
    if (!ArrayBuffer.isView(data)) {
      const read = drawn(image);
      if (read === undefined) {
        this.#warn(`${name}: its picture cannot be read here: a DataTexture can`);
        return undefined;
      }
      ({ data, width, height } = read);
    }
    const channels = CHANNELS[texture.isDataTexture ? texture.format : 1023] ?? data.length / (width * height);
    if (![1, 2, 3, 4].includes(channels)) {
      this.#warn(`${name}: a texture of that format is not drawn`);
      return undefined;
    }
    const value = texture.type === HALF_FLOAT ? (k) => fromHalf(data[k]) : (k) => data[k];
    const isFloat = texture.type === HALF_FLOAT || data instanceof Float32Array;
    const code = isFloat ? (k) => Math.round(255 * clamp(value(k), 0, 1)) : (k) => data[k];
    // Colour space of the numbers, and the one that the slot takes them for.
    const isSrgb = texture.colorSpace === "srgb";
    const curve = isColor === isSrgb ? undefined : isColor ? TO_SRGB : TO_LINEAR;
    const exact = isFloat && curve === TO_SRGB ? (k) => Math.round(255 * toSrgb(clamp(value(k), 0, 1))) : (k) => (curve ? curve[code(k)] : code(k));
    const out = new Uint8Array(4 * width * height).fill(255);
    for (let y = 0; y < height; y++) {
      // WebGL has the first row of its memory at v = 0, and flipped pictures their last there.
      const from = texture.flipY ? height - 1 - y : y;
      for (let x = 0; x < width; x++) {
        const [at, to] = [(from * width + x) * channels, 4 * (y * width + x)];
        for (let c = 0; c < 3; c++) out[to + c] = c < channels ? exact(at + c) : channels === 1 ? out[to] : 0;
        if (channels === 4) out[to + 3] = code(at + 3);
      }
    }
    return { data: out, width, height };
  }
}

/** Textures of a material by their keys: slot, whether of colours, channel. */
const MAPS = [
  ["map", "base_color_texture", true],
  ["normalMap", "normal_texture", false],
  ["aoMap", "occlusion_texture", false],
  ["emissiveMap", "emissive_texture", true],
  ["clearcoatMap", "coat_texture", false, "r"],
  ["clearcoatRoughnessMap", "coat_roughness_texture", false, "g"],
  ["clearcoatNormalMap", "coat_normal_texture", false],
  ["sheenColorMap", "sheen_color_texture", true],
  ["sheenRoughnessMap", "sheen_roughness_texture", false, "a"],
  ["transmissionMap", "transmission_texture", false, "r"],
  ["thicknessMap", "thickness_texture", false, "g"],
  ["iridescenceMap", "iridescence_texture", false, "r"],
  ["iridescenceThicknessMap", "iridescence_thickness_texture", false, "g"],
  ["specularIntensityMap", "specular_texture", false, "a"],
  ["specularColorMap", "specular_color_texture", true],
  ["anisotropyMap", "anisotropy_texture", false],
];

const UNKNOWN_MAPS = ["alphaMap", "bumpMap", "displacementMap", "lightMap", "envMap", "gradientMap", "matcap"];

/**
 * The keys of a material. `tint` multiplies its colour, of instances; `hasMaps`: the geometry has texture coordinates; `isFlat`: it has
 * lines or points.
 */
export function materialOf(material, { textures, warn, tint, hasMaps, isFlat }) {
  const name = material.name || material.type;
  const { opacity = 1 } = material;
  const color = rgb(material.color ?? { r: 1, g: 1, b: 1 });
  const base = color.map((part, k) => clamp(part * (tint?.[k] ?? 1), 0, 1));
  const found = { model: "three", base_color: [...base, clamp(opacity, 0, 1)], double_sided: material.side === DOUBLE };
  if (material.side === BACK) warn(`${name}: sides that are seen from behind alone are drawn from both`);
  if (material.side === BACK || isFlat) found.double_sided = true;
  if (material.alphaTest > 0) Object.assign(found, { alpha_mode: "mask", alpha_cutoff: material.alphaTest });
  // Materials that transmit are not blended: light goes through them.
  else if (material.transparent && !(material.transmission > 0)) found.alpha_mode = "blend";
  const isLit = material.isMeshStandardMaterial === true;
  if (isLit) standard(material, found);
  else if (material.isMeshBasicMaterial || isFlat) found.unlit = true;
  else {
    Object.assign(found, { metallic: 0, roughness: 1, specular: 0 });
    if (material.emissive) emission(material, found);
    warn(`${name}: a ${material.type} is drawn as a diffuse surface`);
  }
  if (material.isMeshPhysicalMaterial) physical(material, found);
  if (hasMaps) maps(name, material, found, textures);
  for (const map of UNKNOWN_MAPS) if (material[map]) warn(`${name}: ${map} is not drawn`);
  return found;
}

function emission(material, found) {
  const emissive = rgb(material.emissive, material.emissiveIntensity ?? 1);
  if (emissive.some((part) => part > 0)) found.emissive = emissive.map((part) => clamp(part, 0, 1000));
}

function standard(material, found) {
  found.metallic = clamp(material.metalness, 0, 1);
  found.roughness = clamp(material.roughness, 0, 1);
  emission(material, found);
}

function physical(material, found) {
  found.ior = clamp(material.ior, 1, 1000);
  found.specular = clamp(material.specularIntensity, 0, 1);
  found.specular_color = rgb(material.specularColor);
  if (material.clearcoat > 0) {
    found.coat = clamp(material.clearcoat, 0, 1);
    found.coat_roughness = clamp(material.clearcoatRoughness, 0, 1);
  }
  if (material.sheen > 0) {
    found.sheen_color = rgb(material.sheenColor, material.sheen).map((part) => clamp(part, 0, 1));
    found.sheen_roughness = clamp(material.sheenRoughness, 0, 1);
  }
  if (material.transmission > 0) {
    found.transmission = clamp(material.transmission, 0, 1);
    found.thickness = Math.max(material.thickness, 0);
    found.attenuation_color = rgb(material.attenuationColor);
    if (Number.isFinite(material.attenuationDistance) && material.attenuationDistance > 0) {
      found.attenuation_distance = material.attenuationDistance;
    }
    found.dispersion = Math.max(material.dispersion ?? 0, 0);
  }
  if (material.iridescence > 0) {
    found.iridescence = clamp(material.iridescence, 0, 1);
    found.iridescence_ior = clamp(material.iridescenceIOR, 1, 5);
    found.iridescence_thickness = [...material.iridescenceThicknessRange];
  }
  if (material.anisotropy > 0) {
    found.anisotropy = clamp(material.anisotropy, 0, 1);
    found.anisotropy_rotation = (material.anisotropyRotation * 180) / Math.PI;
  }
}

function maps(name, material, found, textures) {
  const use = (map, isColor, channel) => {
    return textures.use(`${name}: ${map}`, material[map], isColor, channel === undefined ? {} : { channel });
  };
  for (const [map, key, isColor, channel] of MAPS) {
    const texture = use(map, isColor, channel);
    if (texture !== undefined) found[key] = texture;
  }
  if (material.metalnessMap && material.metalnessMap === material.roughnessMap) {
    const both = use("metalnessMap", false);
    if (both !== undefined) found.metallic_roughness_texture = both;
  } else {
    const [metallic, roughness] = [use("metalnessMap", false, "b"), use("roughnessMap", false, "g")];
    if (metallic !== undefined) found.metallic_texture = metallic;
    if (roughness !== undefined) found.roughness_texture = roughness;
  }
  if (found.normal_texture !== undefined) found.normal_scale = material.normalScale?.x ?? 1;
  if (found.coat_normal_texture !== undefined) found.coat_normal_scale = material.clearcoatNormalScale?.x ?? 1;
  if (found.occlusion_texture !== undefined) found.occlusion_strength = clamp(material.aoMapIntensity ?? 1, 0, 1);
}

/** The set of texture coordinates that a material's textures are read by: 0 or, if all agree, another one. */
export function channelOf(material, warn) {
  const used = [...MAPS.map(([map]) => map), "metalnessMap", "roughnessMap"].map((map) => material[map]?.channel).filter((k) => k !== undefined);
  const channel = used[0] ?? 0;
  if (used.some((other) => other !== channel)) warn(`${material.name || material.type}: its textures are all read by one set of coordinates, uv${channel || ""}`);
  return channel;
}

export const refuse = (message) => new OvercoatError(message, "options");
