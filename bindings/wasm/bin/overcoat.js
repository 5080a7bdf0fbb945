#!/usr/bin/env -S node --no-warnings
// The command line of overcoat, compiled for WASI: the same program as the native one, on one thread and slower.
import { existsSync } from "node:fs";
import { readFile } from "node:fs/promises";
import process from "node:process";
import { WASI } from "node:wasi";

const code = new URL("../dist/cli/overcoat.wasm", import.meta.url);
if (!existsSync(code)) {
  console.error("overcoat: this package was built without the command line (dist/cli/overcoat.wasm)");
  process.exit(70);
}
const root = process.platform === "win32" ? {} : { "/": "/" };
const { OVERCOAT_LOG, UPDATE_GOLDENS, NO_COLOR, COLUMNS } = process.env;
const given = Object.entries({ OVERCOAT_LOG, UPDATE_GOLDENS, NO_COLOR, COLUMNS }).filter(([, value]) => value !== undefined);
const wasi = new WASI({
  version: "preview1",
  args: ["overcoat", ...process.argv.slice(2)],
  env: Object.fromEntries(given),
  preopens: { ...root, ".": process.cwd() },
  returnOnExit: true,
});
try {
  const module = await WebAssembly.compile(await readFile(code));
  const instance = await WebAssembly.instantiate(module, wasi.getImportObject());
  process.exitCode = wasi.start(instance);
} catch (error) {
  console.error(`overcoat: the program ended (${error.message}); WebAssembly has 4 GB of memory at most`);
  process.exitCode = 70;
}
