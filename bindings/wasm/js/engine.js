// The renderer of one thread: the module, its models and scenes, and what happens when it ends.
import { OvercoatError } from "./error.js";
import { bestBuild, instantiate } from "./wasm.js";

/** What the module's panics begin with (src/lib.rs). */
const PANIC = "panic: ";

/** Code of the error about what is kept here, and is not: the module was started anew. Whoever keeps it sends it again. */
export const LOST = "lost";

/** Runs what a host asks for, one call after the other. */
export class Engine {
  #functions;
  #models = new Map();
  #worlds = new Map();

  constructor(functions) {
    this.#functions = functions;
  }

  static async create(build = bestBuild()) {
    return new Engine(await instantiate(build));
  }

  /** One of the methods below, whose arguments and results can be sent between threads. */
  call(operation, request) {
    try {
      return this[operation](request);
    } catch (error) {
      throw this.#explain(error);
    }
  }

  /** What this thread runs. */
  about() {
    return { version: this.#functions.version(), lanes: this.#functions.lanes() };
  }

  load({ id, source, description }) {
    const model = this.#model(source);
    try {
      const info = JSON.parse(model.info(description));
      this.#models.set(id, model);
      return info;
    } catch (error) {
      this.#release(model);
      throw error;
    }
  }

  free({ id }) {
    this.#models.get(id)?.free();
    this.#models.delete(id);
  }

  /** Draws a model that is there, or one that comes with the request and goes after it. */
  draw({ id, source, files = [], ...request }) {
    const model = source === undefined ? this.#kept(this.#models, id) : this.#model(source);
    try {
      for (const [name, bytes] of files) model.set_file(name, bytes);
      return this.#picture(model, request);
    } finally {
      if (source !== undefined) this.#release(model);
    }
  }

  /** Makes a scene that is empty, in the place of one of that number. */
  beginWorld({ id, limits }) {
    this.freeWorld({ id });
    this.#worlds.set(id, new this.#functions.World(JSON.stringify(limits)));
  }

  freeWorld({ id }) {
    this.#worlds.get(id)?.free();
    this.#worlds.delete(id);
  }

  /** Calls a method of a scene that is there. */
  change({ id, name, args }) {
    return this.#kept(this.#worlds, id)[name](...args);
  }

  drawWorld({ id, ...request }) {
    return this.#picture(this.#kept(this.#worlds, id), request);
  }

  pick({ id, description, x, y }) {
    return this.#kept(this.#worlds, id).pick(description, x, y) ?? "null";
  }

  encode({ width, height, pixels, format, quality }) {
    return this.#functions.encode(width, height, pixels, format, quality);
  }

  compare({ name, expected, actual, thresholds, limits }) {
    return JSON.parse(this.#functions.compare(name, expected, actual, thresholds, JSON.stringify(limits)));
  }

  #kept(all, id) {
    const kept = all.get(id);
    if (kept === undefined) throw new OvercoatError("it went with the module that was ended", LOST);
    return kept;
  }

  #picture(of, { description, aovs, linear }) {
    const picture = of.render(description, aovs);
    try {
      return {
        width: picture.width,
        height: picture.height,
        pixels: picture.pixels(),
        hash: picture.hash(),
        warnings: picture.warnings(),
        camera: JSON.parse(picture.camera()),
        ...(linear && { linear: picture.linear() }),
        aovs: Object.fromEntries(aovs.map((name) => [name, picture.plane(name)])),
      };
    } finally {
      this.#release(picture);
    }
  }

  #model({ bytes, files, limits }) {
    const names = files.map(([name]) => name);
    const contents = files.map(([, content]) => content);
    return new this.#functions.Model(bytes, names, contents, JSON.stringify(limits));
  }

  /** Gives memory back. Of an instance that has ended there is none: what was wrong is told by what ended it. */
  #release(object) {
    try {
      object.free();
    } catch {
      // It goes with its instance.
    }
  }

  /** An error as the user sees it. What is no sentence of the library's has ended the instance, and a new one is made. */
  #explain(error) {
    if (error instanceof OvercoatError) return error;
    if (error?.name === "OptionsError") {
      // The description came as one line.
      return new OvercoatError(error.message.replace(/^line 1: /, ""), "options");
    }
    if (error?.name === "Error" && !error.message.startsWith(PANIC)) return new OvercoatError(error.message);
    this.#models.clear();
    this.#worlds.clear();
    const why = (error?.message ?? String(error)).replace(/\s+/g, " ");
    try {
      this.#functions.__wbg_reset_state();
    } catch (cause) {
      return new OvercoatError(`the renderer ended (${why}) and cannot be started again: ${cause.message}`, "crash");
    }
    // A vector that is larger than addresses reach is a panic, one that is larger than memory a trap.
    const reason =
      why.startsWith(PANIC) && !why.includes("capacity overflow")
        ? `the renderer failed: ${why.slice(PANIC.length)}`
        : `the renderer ran out of memory, of which WebAssembly has 4 GB at most (${why})`;
    return new OvercoatError(`${reason}; it was started anew`, "crash", { cause: error });
  }
}
