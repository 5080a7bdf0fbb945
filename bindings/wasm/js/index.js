// overcoat: pictures of 3D files, the same bytes on every machine.
import { hostFor, newThread } from "./hosts.js";
import { RenderedImage } from "./image.js";
import { bytesOf, describe, takeApart } from "./options.js";
import { OvercoatError, what } from "./error.js";

export { OvercoatError } from "./error.js";
export { RenderedImage } from "./image.js";
export { bestBuild } from "./wasm.js";
export * from "./names.js";

const sources = async (bytes, taken) => ({
  bytes: await bytesOf(bytes, "the model", taken.limits),
  files: await fileBytes(taken),
  limits: taken.limits,
});

const fileBytes = ({ files, limits }) =>
  Promise.all(files.map(async ([name, content]) => [name, await bytesOf(content, `files: '${name}'`, limits)]));

const bufferOf = (source) => [source.bytes.buffer, ...source.files.map(([, content]) => content.buffer)];

/** Draws a model file once. */
export async function render(bytes, options) {
  return draw(bytes, options, undefined);
}

async function draw(bytes, options, thread) {
  const taken = takeApart(options);
  const { aovs, linear, signal } = taken;
  signal?.throwIfAborted();
  const host = thread ?? hostFor(taken.worker, signal);
  const description = describe(taken.description);
  const source = await sources(bytes, taken);
  const request = { source, description, aovs, linear };
  return new RenderedImage(host, await host.run("draw", request, { signal, transfer: bufferOf(source) }));
}

/** Reads a model file, to be drawn many times. */
export async function load(bytes, options) {
  return read(bytes, options, undefined);
}

async function read(bytes, options, thread) {
  const taken = takeApart(options);
  taken.signal?.throwIfAborted();
  const host = thread ?? hostFor(taken.worker, taken.signal);
  // What is kept here is what a thread that was ended begins with again.
  const source = await sources(bytes, taken);
  const model = new Model(host, source, taken.files, options);
  await model.reload(taken.signal);
  return model;
}

let models = 0;

/** A model that is loaded, with what was prepared for its last picture: the next one from elsewhere takes less. */
export class Model {
  #host;
  #source;
  #options;
  #id = ++models;
  #generation = -1;
  #info;
  #freed = false;
  /** Files as they were given, by their names. */
  #given;

  /** @internal */
  constructor(host, source, given, options) {
    if (!host?.run) throw new OvercoatError("a model is made by load()", "options");
    this.#given = new Map(given);
    this.#host = host;
    this.#source = source;
    this.#options = { ...options };
    delete this.#options.signal;
    delete this.#options.worker;
    delete this.#options.files;
    delete this.#options.limits;
  }

  /** What the model is: counts, names, its box. */
  get info() {
    return this.#info;
  }

  /** @internal */
  async reload(signal) {
    const request = { id: this.#id, source: this.#source, description: describe(takeApart(this.#options).description) };
    this.#info = await this.#host.run("load", request, { signal });
    this.#generation = this.#host.generation;
  }

  /** Draws it. Options are laid over those of load(). */
  async render(options = {}) {
    if (this.#freed) throw new OvercoatError("the model was freed", "options");
    if (typeof options !== "object" || options === null) {
      throw new OvercoatError(`options: expected an object, found ${what(options)}`, "options");
    }
    for (const key of ["worker", "limits"]) {
      if (options[key] !== undefined) throw new OvercoatError(`${key}: is an option of load()`, "options");
    }
    const taken = takeApart({ ...this.#options, ...options });
    const { aovs, linear, signal } = taken;
    signal?.throwIfAborted();
    const description = describe(taken.description);
    const files = await this.#newFiles(taken.files);
    const isThere = this.#generation === this.#host.generation;
    if (!isThere) await this.reload(signal);
    const request = { id: this.#id, files: isThere ? files : [], description, aovs, linear };
    return new RenderedImage(this.#host, await this.#host.run("draw", request, { signal }));
  }

  /** The files that are not there yet, or are others; they stay with the model. */
  async #newFiles(files) {
    const others = files.filter(([name, content]) => this.#given.get(name) !== content);
    const read = await fileBytes({ files: others, limits: this.#source.limits });
    others.forEach(([name, content]) => this.#given.set(name, content));
    const names = new Set(read.map(([name]) => name));
    this.#source.files = [...this.#source.files.filter(([name]) => !names.has(name)), ...read];
    return read;
  }

  /** Gives its memory back; it cannot be drawn any more. */
  free() {
    if (this.#freed) return;
    this.#freed = true;
    if (this.#generation === this.#host.generation) this.#host.run("free", { id: this.#id }).catch(() => {});
  }

  [Symbol.dispose ?? Symbol("dispose")]() {
    this.free();
  }
}

/** A renderer on a thread of its own: pictures of one do not wait for those of another. */
export function createRenderer() {
  const thread = newThread();
  return {
    render: (bytes, options) => draw(bytes, options, thread),
    load: (bytes, options) => read(bytes, options, thread),
    about: () => thread.run("about"),
    close: () => thread.close(),
  };
}

/** The version, and the instruction set of the module: "simd128" or "scalar". */
export async function about(options = {}) {
  return hostFor(options.worker, undefined).run("about");
}

/** Holds two picture files against each other, by the rules of `overcoat golden check`. */
export async function compare(expected, actual, { name = "picture.png", thresholds = "", limits = {}, worker } = {}) {
  const request = {
    name,
    expected: await bytesOf(expected, "expected", limits),
    actual: await bytesOf(actual, "actual", limits),
    thresholds,
    limits,
  };
  return hostFor(worker, undefined).run("compare", request);
}
