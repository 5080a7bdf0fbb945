// Which of the two modules this machine runs, and its bytes from wherever the package is.

/** The smallest module that has a vector instruction. */
const VECTORS = Uint8Array.of(
  0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 10, 1, 8, 0, 65, 0, 253, 15, 253, 98, 11,
);

/** The build that this machine runs fastest: "simd" where it has vectors, else "plain". Both draw the same bits. */
export function bestBuild() {
  return WebAssembly.validate(VECTORS) ? "simd" : "plain";
}

export const inNode = typeof process === "object" && typeof process?.versions?.node === "string";

const BUILDS = {
  simd: {
    code: () => new URL("../dist/simd/overcoat_bg.wasm", import.meta.url),
    glue: () => import("../dist/simd/overcoat.js"),
  },
  plain: {
    code: () => new URL("../dist/plain/overcoat_bg.wasm", import.meta.url),
    glue: () => import("../dist/plain/overcoat.js"),
  },
};

/** Loads a build into this thread: the functions of the module, and how to begin anew. */
export async function instantiate(build) {
  const { code, glue } = BUILDS[build];
  const functions = await glue();
  await functions.default({ module_or_path: await compile(code()) });
  return functions;
}

async function compile(url) {
  if (inNode && url.protocol === "file:") {
    const { readFile } = await import(/* @vite-ignore */ /* webpackIgnore: true */ "node:fs/promises");
    return WebAssembly.compile(await readFile(url));
  }
  const response = await fetch(url);
  if (!response.ok) throw new Error(`${url.href}: ${response.status} ${response.statusText}`);
  // A server that does not know the media type is good enough.
  if (response.headers.get("content-type") === "application/wasm") return WebAssembly.compileStreaming(response);
  return WebAssembly.compile(await response.arrayBuffer());
}
