#!/usr/bin/env -S node --no-warnings
// The command line of overcoat, compiled for WASI: the same program as the native one, on one thread and slower.
import { existsSync, readdirSync, statSync } from "node:fs";
import { readFile } from "node:fs/promises";
import { isAbsolute, join } from "node:path";
import process from "node:process";
import { WASI } from "node:wasi";

const code = new URL("../dist/cli/overcoat.wasm", import.meta.url);
if (!existsSync(code)) {
  console.error("overcoat: this package was built without the command line (dist/cli/overcoat.wasm)");
  process.exit(70);
}
/**
 * The folders that the program sees: the current one for relative paths, and those of the root for absolute ones. The C
 * library of WASI compares names without their slashes, so "/" as a whole would hide the current folder, and a folder of the
 * root is left out where the current one has an entry of its name.
 */
function folders() {
  const here = process.cwd();
  const seen = { ".": here };
  if (process.platform === "win32") return seen;
  for (const name of readdirSync("/")) {
    const path = `/${name}`;
    if (["proc", "sys", "dev"].includes(name) || !statSync(path, { throwIfNoEntry: false })?.isDirectory()) continue;
    if (!existsSync(join(here, name))) {
      seen[path] = path;
    } else if (process.argv.some((argument) => argument.includes(`${path}/`) && isAbsolute(argument.replace(/^.*=/, "")))) {
      console.error(`overcoat: a path in ${path} cannot be told from one in the folder ${join(here, name)}: run it elsewhere`);
      process.exit(64);
    }
  }
  if (here !== "/") seen[here] = here;
  return seen;
}

const { OVERCOAT_LOG, UPDATE_GOLDENS, NO_COLOR, COLUMNS } = process.env;
const given = Object.entries({ OVERCOAT_LOG, UPDATE_GOLDENS, NO_COLOR, COLUMNS }).filter(([, value]) => value !== undefined);
const wasi = new WASI({
  version: "preview1",
  args: ["overcoat", ...process.argv.slice(2)],
  env: Object.fromEntries(given),
  preopens: folders(),
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
