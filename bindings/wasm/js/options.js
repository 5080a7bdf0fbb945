// From options to what the module takes: the keys of a scene description as JSON, files as bytes. What the keys mean and
// allow is the library's, and so are the messages about them.
import { OvercoatError, what } from "./error.js";

/** Options that are not of the description. */
const OWN = new Set(["files", "limits", "aovs", "linear", "signal", "worker"]);

/** The name under which the bytes of an environment are among the files. */
const ENVIRONMENT = "env (bytes)";

/** Bytes of a file at most, if no limit says less: what a vector of 32-bit WebAssembly can have. */
const MOST = 2 ** 31 - 1;
const DEFAULT_INPUT = 2 ** 30;

const wrong = (message) => new OvercoatError(message, "options");

/** Takes options apart: `{ description, files, limits, aovs, linear, signal, worker }`. */
export function takeApart(options) {
  if (options === undefined) options = {};
  if (!isPlain(options)) throw wrong(`options: expected an object, found ${what(options)}`);
  const description = {};
  const own = {};
  for (const [key, value] of Object.entries(options)) {
    if (value === undefined) continue;
    if (OWN.has(key)) own[key] = value;
    else description[key] = value;
  }
  if ("model" in description) throw wrong("model: the model is given as bytes, not by its path");
  const { signal, worker, linear, aovs = [], limits = {}, files = {} } = own;
  if (signal !== undefined && typeof signal?.addEventListener !== "function") {
    throw wrong(`signal: expected an AbortSignal, found ${what(signal)}`);
  }
  for (const [name, value] of [["worker", worker], ["linear", linear]]) {
    if (value !== undefined && typeof value !== "boolean") {
      throw wrong(`${name}: expected true or false, found ${what(value)}`);
    }
  }
  if (!Array.isArray(aovs) || aovs.some((name) => typeof name !== "string")) {
    throw wrong(`aovs: expected an array of names, found ${what(aovs)}`);
  }
  if (!isPlain(limits)) throw wrong(`limits: expected an object, found ${what(limits)}`);
  if (!isPlain(files) && !(files instanceof Map)) {
    throw wrong(`files: expected an object of names and bytes, found ${what(files)}`);
  }
  const entries = files instanceof Map ? [...files] : Object.entries(files);
  if (isBytes(description.env)) {
    entries.push([ENVIRONMENT, description.env]);
    description.env = ENVIRONMENT;
  }
  return { description, files: entries, limits: json(limits, "limits", 1), aovs, linear: linear === true, signal, worker };
}

/** A description as JSON. Only data has a form there: everything else is refused by name. */
export function describe(description) {
  return JSON.stringify(json(description, "", 0));
}

/** The value as JSON has it: typed arrays become lists. */
function json(value, path, depth) {
  const at = path || "options";
  if (depth > 16) throw wrong(`${at}: nested too deeply`);
  if (value === null || typeof value === "string" || typeof value === "boolean") return value;
  if (typeof value === "number") {
    if (!Number.isFinite(value)) throw wrong(`${at}: expected a finite number, found ${value}`);
    return value;
  }
  const within = (key) => (path ? `${path}.${key}` : key);
  if (Array.isArray(value) || (ArrayBuffer.isView(value) && !(value instanceof DataView) && value.length <= 64)) {
    return Array.from(value, (item, k) => json(item, `${at}[${k}]`, depth + 1));
  }
  if (isPlain(value)) {
    const entries = Object.entries(value).filter(([, item]) => item !== undefined);
    return Object.fromEntries(entries.map(([key, item]) => [key, json(item, within(key), depth + 1)]));
  }
  throw wrong(`${at}: expected a number, a string, true, false, an array or an object, found ${what(value)}`);
}

function isPlain(value) {
  if (typeof value !== "object" || value === null) return false;
  const prototype = Object.getPrototypeOf(value);
  // An object of another realm (a test's, a frame's) is as good.
  return prototype === null || Object.getPrototypeOf(prototype) === null;
}

function isBytes(value) {
  return isBuffer(value) || ArrayBuffer.isView(value) || isBlob(value);
}

const isBuffer = (value) => /^\[object (Shared)?ArrayBuffer\]$/.test(Object.prototype.toString.call(value));
const isBlob = (value) => typeof value?.arrayBuffer === "function" && typeof value?.size === "number";

/** Copies of files' bytes, with their names. */
export const fileBytes = ({ files, limits }) =>
  Promise.all(files.map(async ([name, content]) => [name, await bytesOf(content, `files: '${name}'`, limits)]));

/** A copy of a file's bytes that may be given away. Its size is looked at before. */
export async function bytesOf(value, name, limits) {
  if (!isBytes(value)) {
    throw wrong(`${name}: expected the bytes of a file (Uint8Array, ArrayBuffer or Blob), found ${what(value)}`);
  }
  const size = value.byteLength ?? value.size;
  const most = Math.min(MOST, limits.input_bytes ?? DEFAULT_INPUT);
  if (size > most) throw new OvercoatError(`${name}: ${size} exceeds the limit of ${most} (input_bytes)`);
  try {
    if (isBlob(value)) return new Uint8Array(await value.arrayBuffer());
    const view = ArrayBuffer.isView(value)
      ? new Uint8Array(value.buffer, value.byteOffset, value.byteLength)
      : new Uint8Array(value);
    return view.slice();
  } catch (cause) {
    throw new OvercoatError(`${name}: its ${size} bytes cannot be read: ${cause?.message ?? cause}`, "input", { cause });
  }
}
