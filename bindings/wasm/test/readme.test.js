// Every listing of the README runs, in a project of its own that has this package.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { cpSync, mkdirSync, mkdtempSync, readFileSync, rmSync, symlinkSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import test from "node:test";
import { here, modelPath, noCommand } from "./common.js";
import { withBrowser } from "./browser.js";

const text = readFileSync(join(here, "README.md"), "utf8");
const listings = [...text.matchAll(/^```(\w+)\n([\s\S]*?)^```$/gm)].map(([, language, code]) => ({ language, code }));
const named = (language) =>
  listings
    .filter((listing) => listing.language === language)
    .map(({ code }) => {
      const name = /^(?:\/\/|<!--) (\S+)/.exec(code)?.[1];
      assert.ok(name, `a listing without a name: ${code.slice(0, 40)}`);
      return [name, code];
    });

const folder = mkdtempSync(join(tmpdir(), "overcoat-readme-"));
mkdirSync(join(folder, "node_modules"));
symlinkSync(here, join(folder, "node_modules/overcoat"));
symlinkSync(join(here, "node_modules/vitest"), join(folder, "node_modules/vitest"));
writeFileSync(join(folder, "package.json"), '{ "type": "module" }');
cpSync(modelPath("torus-knot.glb"), join(folder, "model.glb"));
cpSync(modelPath("torus-knot.obj"), join(folder, "model.obj"));
cpSync(modelPath("torus-knot.mtl"), join(folder, "torus-knot.mtl"));
test.after(() => rmSync(folder, { recursive: true }));

const run = (args, env = {}) =>
  spawnSync(args[0], args.slice(1), { cwd: folder, encoding: "utf8", timeout: 120_000, env: { ...process.env, ...env } });
const node = process.execPath;

const SAYS = {
  "render.js": /^512 512 [0-9a-f]{32}\n$/,
  "options.js": /^true true \[\]\n$/,
  "turn.js": /\nfront [0-9a-f]{32}\nleft [0-9a-f]{32}\nback [0-9a-f]{32}\nright [0-9a-f]{32}\n$/,
  "scene.js": /^true true 0 6\.08\nnull\nthe instance is not there: it has been removed\ntrue\n$/,
  "arrays.js": /^true true\n$/,
  "files.js": /^true true 65536\n$/,
  "errors.js": /^options sise: there is no such key; did you mean 'size'\?\ninput .*\nTimeoutError\n$/,
};

for (const [name, code] of named("js")) {
  test(`listing ${name}`, { timeout: 240_000 }, () => {
    writeFileSync(join(folder, name), code);
    if (name.endsWith(".test.js")) {
      const vitest = [node, "node_modules/vitest/vitest.mjs", "run"];
      assert.notEqual(run(vitest, { UPDATE_GOLDENS: "1", CI: "1" }).status, 0, "it records");
      const second = run(vitest, { CI: "1" });
      assert.equal(second.status, 0, second.stdout + second.stderr);
      return;
    }
    const { status, stdout, stderr } = run([node, name]);
    assert.equal(status, 0, stderr);
    assert.match(stdout, SAYS[name] ?? assert.fail(`${name}: what should it say?`));
  });
}

test("commands", { timeout: 240_000, skip: noCommand }, () => {
  const overcoat = [node, "--no-warnings", join(here, "bin/overcoat.js")];
  const commands = listings.filter(({ language }) => language === "sh").flatMap(({ code }) => code.trim().split("\n"));
  let tried = 0;
  for (const line of commands) {
    const [program, name, ...args] = line.split(" ");
    if (program !== "npx") continue;
    assert.equal(name, "overcoat");
    if (args[0] === "golden" && tried === 1) {
      for (const side of ["expected", "actual"]) {
        mkdirSync(join(folder, side));
        cpSync(join(folder, "picture.png"), join(folder, side, "picture.png"));
      }
    }
    const { status, stderr } = run([...overcoat, ...args]);
    assert.equal(status, 0, `${line}: ${stderr}`);
    tried++;
  }
  assert.equal(tried, 4);
});

test("pages", { timeout: 240_000 }, () =>
  withBrowser(async (browser) => {
    const { serve } = await import("../scripts/serve.mjs");
    const imports = { overcoat: "/overcoat/js/index.js", "overcoat/element": "/overcoat/js/element.js" };
    assert.ok(text.includes(JSON.stringify({ imports }).replaceAll('":', '": ').replaceAll(",", ", ").replace("{", "{ ").replace('{"ov', '{ "ov').replaceAll("}}", " } }")), "the import map of the text");
    symlinkSync(here, join(folder, "overcoat"));
    for (const [name, code] of named("html")) {
      const map = `<script type="importmap">${JSON.stringify({ imports })}</script>`;
      writeFileSync(join(folder, name), code.replace("<!doctype html>", `<!doctype html>${map}`));
      const server = await serve(0, folder);
      const page = await browser.newPage();
      const errors = [];
      page.on("pageerror", (error) => errors.push(error.message));
      page.on("console", (message) => message.type() === "error" && !/favicon/.test(message.location().url) && errors.push(message.text()));
      await page.goto(`${server.url}/${name}`);
      await page.waitForFunction(
        () => {
          const canvas = document.querySelector("canvas") ?? document.querySelector("overcoat-image")?.shadowRoot?.querySelector("canvas");
          const pixels = canvas?.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
          return pixels?.some((v) => v > 0);
        },
        undefined,
        { timeout: 60_000 },
      );
      assert.deepEqual(errors, [], name);
      await page.close();
      server.close();
    }
  }),
);
