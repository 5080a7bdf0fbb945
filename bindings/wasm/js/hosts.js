// Where the renderer runs: on the caller's thread, or on one of its own, which can be ended.
import { Engine } from "./engine.js";
import { OvercoatError } from "./error.js";
import { inNode } from "./wasm.js";

/** On the caller's thread: it waits for every picture, and what has begun cannot be cancelled. */
class ThisThread {
  #engine;

  async run(operation, request, { signal } = {}) {
    signal?.throwIfAborted();
    this.#engine ??= Engine.create().catch((cause) => {
      this.#engine = undefined;
      throw new OvercoatError(`the WebAssembly module cannot be loaded: ${cause.message}`, "crash", { cause });
    });
    const engine = await this.#engine;
    signal?.throwIfAborted();
    return engine.call(operation, request);
  }
}

const closed = () => new OvercoatError("the renderer was closed", "options");

/** On a thread of its own, one request after the other. A request that is cancelled while it runs ends the thread. */
class OwnThread {
  #worker;
  #queue = [];
  #running;
  #number = 0;
  #closed = false;

  run(operation, request, { signal, transfer = [] } = {}) {
    return new Promise((resolve, reject) => {
      if (signal?.aborted) return reject(signal.reason);
      if (this.#closed) return reject(closed());
      const job = { operation, request, transfer, resolve, reject };
      job.stop = () => this.#cancel(job, signal.reason);
      job.done = () => signal?.removeEventListener("abort", job.stop);
      signal?.addEventListener("abort", job.stop, { once: true });
      this.#queue.push(job);
      this.#next();
    });
  }

  async #next() {
    if (this.#running || this.#queue.length === 0) return;
    const job = (this.#running = this.#queue.shift());
    job.number = ++this.#number;
    try {
      this.#worker ??= this.#start();
      const worker = await this.#worker;
      // It may have been cancelled while the thread was started.
      if (this.#running !== job) return;
      worker.ref?.();
      worker.postMessage({ number: job.number, operation: job.operation, request: job.request }, job.transfer);
    } catch (error) {
      this.#fail(error);
    }
  }

  async #start() {
    const worker = inNode
      ? new (await import(/* @vite-ignore */ /* webpackIgnore: true */ "node:worker_threads")).Worker(
          new URL("./worker.js", import.meta.url),
        )
      : new Worker(new URL("./worker.js", import.meta.url), { type: "module" });
    const of = (listener) => (event) => listener(inNode ? event : (event.data ?? event));
    const on = (name, listener) =>
      inNode ? worker.on(name, of(listener)) : worker.addEventListener(name, of(listener));
    on("message", (message) => this.#receive(message));
    on("error", (event) => {
      event.preventDefault?.();
      this.#fail(event);
    });
    worker.unref?.();
    return worker;
  }

  #receive({ number, result, error }) {
    const job = this.#running;
    if (job?.number !== number) return;
    if (error?.code === "crash") {
      // Memory of WebAssembly is never given back but with its thread.
      this.#end();
    }
    this.#finish(job);
    if (error) job.reject(new OvercoatError(error.message, error.code));
    else job.resolve(result);
    this.#next();
  }

  #finish(job) {
    this.#running = undefined;
    job.done();
    this.#worker?.then((worker) => !this.#running && worker.unref?.());
  }

  #cancel(job, reason) {
    job.done();
    if (this.#running === job) {
      this.#running = undefined;
      this.#end();
    } else {
      this.#queue = this.#queue.filter((other) => other !== job);
    }
    job.reject(reason);
    this.#next();
  }

  /** The thread itself has failed. */
  #fail(cause) {
    const job = this.#running;
    this.#end();
    if (job) {
      this.#finish(job);
      const why = cause?.message ? ` (${cause.message})` : "";
      job.reject(new OvercoatError(`the renderer's thread ended${why}; the next picture starts it anew`, "crash", { cause }));
    }
    this.#next();
  }

  /** Ends the thread for good. */
  close() {
    this.#closed = true;
    const jobs = [this.#running, ...this.#queue].filter(Boolean);
    this.#running = undefined;
    this.#queue = [];
    this.#end();
    for (const job of jobs) {
      job.done();
      job.reject(closed());
    }
  }

  #end() {
    this.#worker?.then((worker) => worker.terminate()).catch(() => {});
    this.#worker = undefined;
  }
}

const thisThread = new ThisThread();
const ownThread = new OwnThread();

/** A renderer on a thread of its own that nobody else uses. */
export const newThread = () => new OwnThread();

/** The host that an option asks for. Without one: in browsers the thread of its own; in Node.js too if there is a signal. */
export function hostFor(worker, signal) {
  return (worker ?? (!inNode || signal !== undefined)) ? ownThread : thisThread;
}
