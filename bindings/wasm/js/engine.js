// The renderer of one thread: the module, its models, and what happens when it ends.
import { OvercoatError } from "./error.js";
import { bestBuild, instantiate } from "./wasm.js";

/** What the module's panics begin with (src/lib.rs). */
const PANIC = "panic: ";

/** Runs what a host asks for, one call after the other. */
export class Engine {
  #functions;
  #models = new Map();

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
  draw({ id, source, files = [], description, aovs, linear }) {
    const kept = this.#models.get(id);
    const model = kept ?? this.#model(source);
    try {
      for (const [name, bytes] of files) model.set_file(name, bytes);
      const picture = model.render(description, aovs);
      try {
        return {
          width: picture.width,
          height: picture.height,
          pixels: picture.pixels(),
          hash: picture.hash(),
          warnings: picture.warnings(),
          ...(linear && { linear: picture.linear() }),
          aovs: Object.fromEntries(aovs.map((name) => [name, picture.plane(name)])),
        };
      } finally {
        this.#release(picture);
      }
    } finally {
      if (!kept) this.#release(model);
    }
  }

  encode({ width, height, pixels, format, quality }) {
    return this.#functions.encode(width, height, pixels, format, quality);
  }

  compare({ name, expected, actual, thresholds, limits }) {
    return JSON.parse(this.#functions.compare(name, expected, actual, thresholds, JSON.stringify(limits)));
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
    if (error?.name === "OptionsError") {
      // The description came as one line.
      return new OvercoatError(error.message.replace(/^line 1: /, ""), "options");
    }
    if (error?.name === "Error" && !error.message.startsWith(PANIC)) return new OvercoatError(error.message);
    this.#models.clear();
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
