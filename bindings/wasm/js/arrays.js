// Arrays of numbers that are given: their types and how many they are. What the numbers may be is the library's to say.
import { OvercoatError, what } from "./error.js";

const wrong = (message) => new OvercoatError(message, "options");

/** A copy as an array of a class, of an array or a typed array of numbers. */
function copy(name, value, Class, limits) {
  const isTyped = ArrayBuffer.isView(value) && !(value instanceof DataView) && typeof value[0] !== "bigint";
  if (!isTyped && !Array.isArray(value)) throw wrong(`${name}: expected an array of numbers, found ${what(value)}`);
  const most = (limits.input_bytes ?? 2 ** 30) / Class.BYTES_PER_ELEMENT;
  if (value.length > most) {
    throw new OvercoatError(`${name}: ${value.length * Class.BYTES_PER_ELEMENT} exceeds the limit of ${limits.input_bytes ?? 2 ** 30} (input_bytes)`);
  }
  if (!isTyped) {
    // Holes, too.
    const k = Array.from(value).findIndex((number) => typeof number !== "number");
    if (k >= 0) throw wrong(`${name}[${k}]: expected a number, found ${what(value[k])}`);
  }
  return new Class(value);
}

/** Sixteen numbers, column by column, as in glTF, WebGL and three.js; none for what changes nothing. */
export function matrix(name, value) {
  if (value === undefined) return new Float64Array(0);
  // A DOMMatrix, a Matrix4 of three.js.
  const given = typeof value?.toFloat64Array === "function" ? value.toFloat64Array() : (value?.elements ?? value);
  const numbers = copy(name, given, Float64Array, {});
  if (numbers.length !== 16) throw wrong(`${name}: expected 16 numbers, column by column, found ${numbers.length}`);
  return numbers;
}

/** Numbers of vertices. */
function indices(value, limits) {
  const given = copy("indices", value, Float64Array, limits);
  const k = given.findIndex((index) => !Number.isInteger(index) || index < 0 || index >= 2 ** 32);
  if (k >= 0) throw wrong(`indices[${k}]: expected a whole number from 0 on, found ${given[k]}`);
  return new Uint32Array(given);
}

const KEYS = ["positions", "indices", "normals", "uvs", "colors", "crease_deg", "kind"];
const KINDS = ["triangles", "lines", "points"];

/** What a mesh is made of, as the module takes it. */
export function meshArrays(mesh, limits) {
  if (typeof mesh !== "object" || mesh === null || Array.isArray(mesh) || ArrayBuffer.isView(mesh)) {
    throw wrong(`mesh: expected an object with positions, found ${what(mesh)}`);
  }
  const unknown = Object.keys(mesh).find((key) => !KEYS.includes(key));
  if (unknown !== undefined) throw wrong(`mesh: there is no '${unknown}'; known are ${KEYS.join(", ")}`);
  const floats = (name) => (mesh[name] === undefined ? undefined : copy(name, mesh[name], Float32Array, limits));
  const { crease_deg = 0 } = mesh;
  if (typeof crease_deg !== "number" || !(crease_deg >= 0 && crease_deg <= 180)) {
    throw wrong(`crease_deg: expected a number from 0 to 180, found ${typeof crease_deg === "number" ? crease_deg : what(crease_deg)}`);
  }
  const { kind = "triangles" } = mesh;
  if (!KINDS.includes(kind)) throw wrong(`kind: expected ${KINDS.join(", ")}, found ${typeof kind === "string" ? `'${kind}'` : what(kind)}`);
  return [
    copy("positions", mesh.positions, Float32Array, limits),
    mesh.indices === undefined ? undefined : indices(mesh.indices, limits),
    floats("normals"),
    floats("uvs"),
    floats("colors"),
    crease_deg,
    kind,
  ];
}

/** Whether it is a picture of numbers: an ImageData, or what has its fields. */
export function isPicture(value) {
  return typeof value === "object" && value !== null && "data" in value && "width" in value && "height" in value;
}

/**
 * A picture of numbers as the module takes it: width and height, four bytes each, and bytes R, G, B, A. Bytes are as in files, floats
 * from 0 to 1 the same divided by 255; one number a pixel is grey.
 */
export function pictureBytes(name, { data, width, height }, limits) {
  for (const [side, value] of [["width", width], ["height", height]]) {
    if (!Number.isInteger(value) || value < 1 || value > 65536) {
      throw wrong(`${name}: ${side}: expected a whole number from 1 to 65536, found ${typeof value === "number" ? value : what(value)}`);
    }
  }
  const isFloat = data instanceof Float32Array || data instanceof Float64Array;
  if (!isFloat && !(data instanceof Uint8Array) && !(data instanceof Uint8ClampedArray)) {
    throw wrong(`${name}: data: expected a Uint8Array, Uint8ClampedArray or Float32Array, found ${what(data)}`);
  }
  const pixels = width * height;
  const channels = data.length / pixels;
  if (![1, 3, 4].includes(channels)) throw wrong(`${name}: ${data.length} numbers are not 1, 3 or 4 for each of ${width} x ${height} pixels`);
  const most = limits.input_bytes ?? 2 ** 30;
  if (8 + 4 * pixels > most) throw new OvercoatError(`${name}: ${8 + 4 * pixels} exceeds the limit of ${most} (input_bytes)`);
  const bytes = new Uint8Array(8 + 4 * pixels).fill(255);
  new DataView(bytes.buffer).setUint32(0, width, true);
  new DataView(bytes.buffer).setUint32(4, height, true);
  // 0 for anything that is no number.
  const code = isFloat ? (v) => Math.floor(Math.min(Math.max(v || 0, 0), 1) * 255 + 0.5) : (v) => v;
  for (let k = 0; k < pixels; k++) {
    for (let c = 0; c < 3; c++) bytes[8 + 4 * k + c] = code(data[k * channels + (channels === 1 ? 0 : c)]);
    if (channels === 4) bytes[11 + 4 * k] = code(data[4 * k + 3]);
  }
  return bytes;
}
