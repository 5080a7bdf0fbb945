// The page in Chromium, used as a reader would.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync, mkdirSync } from "node:fs";
import { join } from "node:path";
import test from "node:test";
import { fileURLToPath } from "node:url";
import { serve } from "../../wasm/scripts/serve.mjs";

const root = fileURLToPath(new URL("../../..", import.meta.url));
const program = process.env.OVERCOAT ?? join(root, "target/release/overcoat");
const skip = existsSync(join(root, "bindings/wasm/node_modules/playwright-core")) ? false : "there is no playwright-core in bindings/wasm";
/** Where pictures of the page go for whoever wants to look: SCREENSHOTS=folder. */
const shots = process.env.SCREENSHOTS;
if (shots) mkdirSync(shots, { recursive: true });

/** Opens the page in a browser. */
async function withPage(use) {
  const { withPageOf } = await import("../../wasm/test/browser.js");
  const server = await serve(0, join(root, "docs/src"));
  try {
    await withPageOf(server, (page) => use(page, `${server.url}/coat-lab/`));
  } finally {
    server.close();
  }
}

test("a page that is not built says so", { skip, timeout: 60_000 }, () =>
  withPage(async (page, address) => {
    await page.route("**/dist/**", (route) => route.abort());
    await page.goto(address);
    await page.waitForFunction(() => document.body.dataset.state === "error");
    assert.match(await page.textContent("#status"), /not built: run bindings\/coat-lab\/build\.sh/);
  }));

test("the page, used by a reader", { skip, timeout: 300_000 }, () => withPage(read));

async function read(page, address) {
  const done = async () => {
    await page.waitForFunction(() => ["done", "error"].includes(document.body.dataset.state), undefined, { timeout: 120_000 });
    assert.equal(await page.getAttribute("body", "data-state"), "done", await page.textContent("#status"));
  };
  const change = async (action) => {
    await page.evaluate(() => delete document.body.dataset.state);
    await action();
    await done();
  };
  const shot = async (name, options = {}) => {
    if (shots) await page.screenshot({ path: join(shots, `${name}.png`), ...options });
  };
  /** Referee and models of the table on the page, by rows. */
  const table = async () => {
    await page.evaluate(() => (document.querySelector("#numbers").open = true));
    await page.waitForSelector("#numbers tbody tr");
    return page.$$eval("#numbers tbody tr", (rows) => rows.map((row) => [...row.children].map((cell) => Number(cell.textContent))));
  };
  /** The same by the command on the page. */
  const native = async () => {
    const command = await page.textContent("#command");
    const words = command.split(" ").slice(1);
    const { rows } = JSON.parse(execFileSync(program, [...words, "--json"], { encoding: "utf8" }));
    const luminance = ([r, g, b]) => 0.2126 * r + 0.7152 * g + 0.0722 * b;
    return rows.map((row) => [row.value, luminance(row.truth), ...row.models.map((model) => luminance(model.radiance))]);
  };
  const agrees = async () => {
    const [shown, expected] = [await table(), await native()];
    assert.equal(shown.length, expected.length);
    for (const [k, row] of shown.entries()) {
      const [value, mean, , ...models] = row;
      for (const [m, number] of [value, mean, ...models].entries()) {
        assert.ok(Math.abs(number - expected[k][m]) <= 0.00051, `row ${k}, number ${m}: ${number} is not ${expected[k][m]}`);
      }
    }
  };

  await page.goto(address);
  await done();
  assert.match(await page.textContent("#done"), /^65,536 walks, ± \d\.\d %$/);
  await shot("desktop");
  await change(() => page.selectOption("[name=samples]", "1024"));
  await agrees();

  // Sliders by keys; the address keeps them.
  await change(async () => {
    await page.focus("[name=coat-roughness]");
    for (let k = 0; k < 10; k++) await page.keyboard.press("ArrowRight");
  });
  assert.match(page.url(), /#coat-roughness=0\.2&samples=1024$|#samples=1024&coat-roughness=0\.2$/);
  assert.match(await page.textContent("#command"), /--coat-roughness 0\.2/);
  await agrees();
  await change(() => page.selectOption("[name=over]", "light"));
  assert.ok(await page.isDisabled("[name=light]"));
  await change(() => page.selectOption("[name=base]", "metal"));
  await change(() => page.check("[name=model][value=gltf]"));
  await agrees();
  await shot("lobes", { fullPage: true });
  const lines = await page.locator("#plot polyline").count();
  assert.equal(lines, 8);
  await page.selectOption("[name=show]", "error");
  await page.waitForFunction(() => document.querySelector("#plot").textContent.includes("error in percent"));
  await shot("errors");

  // Another page at the same address shows the same.
  const [url, told] = [page.url(), await page.textContent("#command")];
  await page.goto("about:blank");
  await page.goto(url);
  await done();
  assert.equal(await page.textContent("#command"), told);
  await change(() => page.click("#reset"));
  assert.ok(!(await page.textContent("#command")).includes("coat-roughness"));
  assert.match(page.url(), /#$/);

  // Pausing stops the walks, and what is asked for next begins anew.
  await page.selectOption("[name=samples]", "262144");
  const isWalking = () => document.querySelector("#done").textContent.includes("walks,") && document.body.dataset.state === "busy";
  await page.waitForFunction(isWalking);
  await page.click("#pause");
  await page.waitForTimeout(300);
  const paused = await page.textContent("#done");
  await page.waitForTimeout(500);
  assert.equal(await page.textContent("#done"), paused);
  await change(() => page.selectOption("[name=samples]", "1024"));
  assert.match(await page.textContent("#done"), /^1,024 walks/);

  await page.click("#copy");
  await page.waitForFunction(() => document.querySelector("#status").textContent.startsWith("The command is"));
  await page.emulateMedia({ colorScheme: "dark" });
  await shot("dark");
  await page.setViewportSize({ width: 390, height: 800 });
  await page.waitForTimeout(200);
  const [wide, view] = await page.evaluate(() => [document.documentElement.scrollWidth, innerWidth]);
  assert.ok(wide <= view, `${wide} is wider than ${view}`);
  await shot("narrow-top");
  await shot("narrow", { fullPage: true });
  await page.emulateMedia({ colorScheme: "light" });
  await shot("narrow-light");
}
