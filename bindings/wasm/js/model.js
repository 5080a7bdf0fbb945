// A model that is loaded once and drawn many times.
import { LOST } from "./engine.js";
import { OvercoatError, what } from "./error.js";
import { RenderedImage } from "./image.js";
import { describe, fileBytes, takeApart } from "./options.js";

let models = 0;

/** A model that is loaded, with what was prepared for its last picture: the next one from elsewhere takes less. */
export class Model {
  #host;
  #source;
  #options;
  #id = ++models;
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
    const draw = (files) => this.#host.run("draw", { id: this.#id, files, description, aovs, linear }, { signal });
    const drawn = draw(files);
    return new RenderedImage(this.#host, await drawn.catch((error) => this.#again(error, () => draw([]), signal)));
  }

  /** Where the model went with a module that was ended, it is loaded again, with all of its files. */
  async #again(error, draw, signal) {
    if (error?.code !== LOST) throw error;
    await this.reload(signal);
    return draw().catch((error) => this.#again(error, draw, signal));
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
    this.#host.run("free", { id: this.#id }).catch(() => {});
  }

  [Symbol.dispose ?? Symbol("dispose")]() {
    this.free();
  }
}
