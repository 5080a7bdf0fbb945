// Runs a program for WASI under Node.js, with the files of this machine; paths must be absolute.
//
// Usage: node --single-threaded wasi.mjs PROGRAM.wasm ARGUMENTS...
import { realpathSync } from "node:fs";
import { readFile } from "node:fs/promises";
import process from "node:process";
import { WASI } from "node:wasi";

const [path, ...args] = process.argv.slice(2);
const wasi = new WASI({
  version: "preview1",
  args: ["overcoat", ...args],
  env: {},
  preopens: { "/": "/" },
  returnOnExit: true,
});
// Debian's wasi-libc is older than the standard library: what it lacks is imported from here. There are no threads.
const unsupported = 58;
let memory, malloc;
const text = (at) => {
  const bytes = new Uint8Array(memory.buffer, at);
  return new TextDecoder().decode(bytes.subarray(0, bytes.indexOf(0)));
};
const env = {
  pthread_attr_init: () => 0,
  pthread_attr_setstacksize: () => 0,
  pthread_attr_destroy: () => 0,
  pthread_create: () => unsupported,
  pthread_join: () => unsupported,
  pthread_detach: () => unsupported,
  fchmod: () => 0,
  realpath(path, resolved) {
    let found;
    try {
      found = new TextEncoder().encode(realpathSync(text(path)) + "\0");
    } catch {
      return 0;
    }
    const at = resolved || malloc(found.length);
    new Uint8Array(memory.buffer, at, found.length).set(found);
    return at;
  },
};
const module = await WebAssembly.compile(await readFile(path));
const instance = await WebAssembly.instantiate(module, { ...wasi.getImportObject(), env });
({ memory, malloc } = instance.exports);
process.exitCode = wasi.start(instance);
