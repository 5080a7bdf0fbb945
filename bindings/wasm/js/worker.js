// The renderer on a thread of its own: requests in, results out.
import { Engine } from "./engine.js";
import { inNode } from "./wasm.js";

let engine;

/** All memory that a result can give away. */
function buffers(result) {
  const arrays = [result, result?.pixels, result?.linear, ...Object.values(result?.aovs ?? {})];
  return arrays.filter((value) => ArrayBuffer.isView(value)).map((value) => value.buffer);
}

async function answer(port, { number, operation, request }) {
  try {
    engine ??= Engine.create();
    const result = (await engine).call(operation, request);
    port.postMessage({ number, result }, buffers(result));
  } catch (error) {
    port.postMessage({ number, error: { message: error.message, code: error.code ?? "crash" } });
  }
}

if (inNode) {
  import(/* @vite-ignore */ /* webpackIgnore: true */ "node:worker_threads").then(({ parentPort }) => {
    parentPort.on("message", (message) => answer(parentPort, message));
  });
} else {
  self.addEventListener("message", ({ data }) => answer(self, data));
}
