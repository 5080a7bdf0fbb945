// What tests share: models of the tree, and the native program to compare with.
import { execFileSync } from "node:child_process";
import { existsSync, readFileSync } from "node:fs";
import { fileURLToPath } from "node:url";

export const root = fileURLToPath(new URL("../../..", import.meta.url));
export const here = fileURLToPath(new URL("..", import.meta.url));
export const modelPath = (name) => `${root}assets/models/${name}`;
export const model = (name) => readFileSync(modelPath(name));

/** The native program; test.sh says where it is. */
export const program = process.env.OVERCOAT ?? `${root}target/release/overcoat`;

/** Why tests of the command line cannot run, if they cannot. */
export const noCommand = existsSync(`${here}dist/cli/overcoat.wasm`) ? false : "this build has no command line";

/** Draws a model (of the tree, or by its path) with the native program: its report, and the bytes of the file. */
export function native(name, out, ...options) {
  const path = name.includes("/") ? name : modelPath(name);
  const report = execFileSync(program, ["render", path, "-o", out, "--json", ...options], { encoding: "utf8" });
  return { ...JSON.parse(report), file: readFileSync(out) };
}

/** A GLB with one triangle around whatever else its JSON says. */
export function glb(json, binary = new Uint8Array(0)) {
  const pad = (bytes, by) => Buffer.concat([bytes, Buffer.alloc((4 - (bytes.length % 4)) % 4, by)]);
  const text = pad(Buffer.from(JSON.stringify(json)), 0x20);
  const data = pad(Buffer.from(binary), 0);
  const chunk = (type, bytes) => {
    const head = Buffer.alloc(8);
    head.writeUInt32LE(bytes.length, 0);
    head.writeUInt32LE(type, 4);
    return Buffer.concat([head, bytes]);
  };
  const body = Buffer.concat([chunk(0x4e4f534a, text), ...(data.length > 0 ? [chunk(0x004e4942, data)] : [])]);
  const head = Buffer.alloc(12);
  head.write("glTF", 0);
  head.writeUInt32LE(2, 4);
  head.writeUInt32LE(12 + body.length, 8);
  return Buffer.concat([head, body]);
}
