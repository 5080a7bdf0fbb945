// overcoat: pictures of 3D files, the same bytes on every machine.
import { hostFor, newThread } from "./hosts.js";
import { RenderedImage } from "./image.js";
import { Model } from "./model.js";
import { bytesOf, describe, fileBytes, takeApart } from "./options.js";
import { Scene } from "./scene.js";

export { OvercoatError } from "./error.js";
export { RenderedImage } from "./image.js";
export { Model } from "./model.js";
export { Scene } from "./scene.js";
export { ThreeScene, fromThree, threeCamera } from "./three.js";
export { bestBuild } from "./wasm.js";
export * from "./names.js";

const sources = async (bytes, taken) => ({
  bytes: await bytesOf(bytes, "the model", taken.limits),
  files: await fileBytes(taken),
  limits: taken.limits,
});

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

/** A renderer on a thread of its own: pictures of one do not wait for those of another. */
export function createRenderer() {
  const thread = newThread();
  return {
    render: (bytes, options) => draw(bytes, options, thread),
    load: (bytes, options) => read(bytes, options, thread),
    scene: (options) => new Scene(options, thread),
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
