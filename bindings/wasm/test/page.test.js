// The demo page, used like a person would, and the element.
import assert from "node:assert/strict";
import { mkdirSync, mkdtempSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import test from "node:test";
import { render } from "../js/index.js";
import { serve } from "../scripts/serve.mjs";
import { model, native } from "./common.js";
import { withPageOf } from "./browser.js";

const folder = mkdtempSync(join(tmpdir(), "overcoat-page-"));
/** Where pictures of the page go for whoever wants to look: SCREENSHOTS=folder. */
const shots = process.env.SCREENSHOTS;
if (shots) mkdirSync(shots, { recursive: true });

/** Opens a path of the server in a browser. */
async function withPage(path, use) {
  const server = await serve();
  try {
    await withPageOf(server, async (page) => {
      await page.goto(`${server.url}${path}`);
      await use(page, server);
    });
  } finally {
    server.close();
  }
}

test("the demo page", { timeout: 300_000 }, () =>
  withPage("/demo/", async (page) => {
    const done = async () => {
      await page.waitForFunction(() => ["done", "error"].includes(document.body.dataset.state), undefined, { timeout: 90_000 });
      assert.equal(await page.getAttribute("body", "data-state"), "done", await page.textContent("#status"));
      return page.textContent("#hash");
    };
    const change = async (action) => {
      await page.evaluate(() => delete document.body.dataset.state);
      await action();
      return done();
    };
    const picture = join(folder, "picture.png");

    await page.selectOption("#size", "256");
    const first = await done();
    assert.match(first, /^[0-9a-f]{32}$/);
    if (shots) await page.screenshot({ path: join(shots, "car.png") });

    // Another model, another engine, another tier: the command on the page draws the same.
    await change(() => page.selectOption("#model", "torus-knot"));
    await change(() => page.selectOption("#shading", "stacklit"));
    const hash = await change(() => page.selectOption("#quality", "draft"));
    const command = await page.textContent("#command");
    const flags = command.split(" ").slice(5).filter((flag) => flag !== "--json");
    assert.equal(command.split(" ").slice(0, 3).join(" "), "overcoat render torus-knot.glb");
    assert.equal(native("torus-knot.glb", picture, ...flags).frame_hash, hash, command);

    // The hash of a server, pasted with the report around it.
    await page.fill("#server", `{"frame_hash": "${hash}", "x": 1}`);
    assert.match(await page.textContent("#verdict"), /^Equal/);
    await page.fill("#server", "0".repeat(32));
    assert.match(await page.textContent("#verdict"), /^Another/);

    // Dragging turns it, and when it rests the command has the camera.
    const box = await page.locator("#view").boundingBox();
    const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
    const turned = await change(async () => {
      await page.mouse.move(x, y);
      await page.mouse.down();
      for (let k = 1; k <= 12; k++) await page.mouse.move(x + 12 * k, y + 4 * k);
      await page.mouse.up();
    });
    assert.notEqual(turned, hash);
    const after = (await page.textContent("#command")).split(" ").slice(5).filter((flag) => flag !== "--json");
    assert.ok(after.some((flag) => flag.startsWith("--eye=")), after.join(" "));
    assert.equal(native("torus-knot.glb", picture, ...after).frame_hash, turned, after.join(" "));
    if (shots) await page.screenshot({ path: join(shots, "turned.png") });
    // Keys turn it, too.
    assert.notEqual(await change(() => page.locator("#view").press("ArrowLeft")), turned);
    assert.equal(await change(() => page.click("#reset")), hash);

    // A click names what is there.
    await change(() => page.selectOption("#model", "sports-car"));
    await page.mouse.click(x, y);
    await page.waitForFunction(() => /^part/.test(document.querySelector("#status").textContent));
    assert.match(await page.textContent("#status"), /^part \d+ of \d+, .+: triangle \d+, \d+\.\d\d m away$/);
    if (shots) await page.screenshot({ path: join(shots, "picked.png") });
    await page.mouse.click(box.x + 4, box.y + 4);
    await page.waitForFunction(() => document.querySelector("#status").textContent === "nothing there");
    await change(() => page.selectOption("#material", "candy-red"));
    const red = await page.textContent("#hash");
    const redCommand = (await page.textContent("#command")).split(" ").slice(5).filter((flag) => flag !== "--json");
    assert.equal(native("sports-car.glb", picture, ...redCommand).frame_hash, red, redCommand.join(" "));
    await change(() => page.selectOption("#material", ""));
    await change(() => page.selectOption("#model", "torus-knot"));

    // Files of one's own, one of which refers to the other; and one that is none.
    const files = { "knot.obj": model("torus-knot.obj"), "torus-knot.mtl": Buffer.from("newmtl carbon\nKd 0.8 0.1 0.1\nPr 0.4\n") };
    for (const [name, content] of Object.entries(files)) writeFileSync(join(folder, name), content);
    const own = await change(() => page.setInputFiles("#file", Object.keys(files).map((name) => join(folder, name))));
    assert.equal(native(join(folder, "knot.obj"), picture, ...flags).frame_hash, own);
    const junk = join(folder, "junk.glb");
    writeFileSync(junk, "glTF, but not really");
    await page.evaluate(() => delete document.body.dataset.state);
    await page.setInputFiles("#file", junk);
    await page.waitForFunction(() => document.body.dataset.state === "error");
    assert.match(await page.textContent("#status"), /^junk\.glb: /);
    if (shots) await page.screenshot({ path: join(shots, "error.png") });
    // It lives on.
    await change(() => page.selectOption("#model", "vase"));

    // Dropped.
    const dropped = await change(async () => {
      const data = await page.evaluateHandle(async () => {
        const bytes = await (await fetch("models/rounded-cube.glb")).blob();
        const transfer = new DataTransfer();
        transfer.items.add(new File([bytes], "cube.glb"));
        return transfer;
      });
      await page.dispatchEvent("#stage", "drop", { dataTransfer: data });
    });
    assert.equal(native("rounded-cube.glb", picture, ...flags).frame_hash, dropped);

    await page.emulateMedia({ colorScheme: "dark" });
    if (shots) await page.screenshot({ path: join(shots, "dark.png") });
    await page.setViewportSize({ width: 390, height: 800 });
    if (shots) await page.screenshot({ path: join(shots, "narrow.png"), fullPage: true });
  }));

test("the renderer in a page: worker, page, abort, crash", { timeout: 300_000 }, () =>
  withPage("/scripts/blank.html", async (page) => {
      const found = await page.evaluate(async () => {
        const { about, load, render } = await import("/js/index.js");
        const bytes = await (await fetch("/demo/models/torus-knot.glb")).arrayBuffer();
        const failure = (promise) => promise.then(() => "none", (error) => `${error.name} ${error.code ?? ""}: ${error.message}`);
        const options = { size: 64 };
        const here = await render(bytes, { ...options, worker: false });
        const there = await render(bytes, options);
        const model = await load(bytes, options);
        const long = (signal) => render(bytes, { size: 4096, quality: "best", rays: 256, signal });
        const start = performance.now();
        const timeout = await failure(long(AbortSignal.timeout(300)));
        const time = performance.now() - start;
        const limits = { output_pixels: 2 ** 40, frame_bytes: 2 ** 40, decoded_bytes: 2 ** 40 };
        const crash = await failure(render(bytes, { size: 16384, limits }));
        const again = await model.render();
        return {
          lanes: (await about()).lanes,
          here: here.hash,
          there: there.hash,
          again: again.hash,
          png: (await there.png()).length,
          blob: (await there.toBlob()).type,
          timeout,
          time,
          crash,
          hostile: [
            await failure(render("x.glb")),
            await failure(render(new Uint8Array(100))),
            await failure(render(bytes, { sise: 3 })),
          ],
        };
      });
      const expected = await render(model("torus-knot.glb"), { size: 64 });
      assert.equal(found.lanes, "simd128");
      for (const which of ["here", "there", "again"]) assert.equal(found[which], expected.hash, which);
      assert.equal(found.png, (await expected.png()).length);
      assert.equal(found.blob, "image/png");
      assert.match(found.timeout, /^TimeoutError/);
      assert.ok(found.time < 5000);
      assert.match(found.crash, /^OvercoatError crash: .*started anew/);
      assert.match(found.hostile[0], /^OvercoatError options: the model: expected the bytes/);
      assert.match(found.hostile[1], /^OvercoatError input: /);
      assert.match(found.hostile[2], /^OvercoatError options: sise/);
  }));

test("the element", { timeout: 300_000 }, () =>
  withPage("/scripts/blank.html", async (page) => {
    const settled = (state) =>
      page.waitForFunction((wanted) => document.querySelector("overcoat-image").state === wanted, state, { timeout: 60_000 });
    const hash = () => page.evaluate(() => document.querySelector("overcoat-image").image?.hash);
    const set = (name, value) =>
      page.evaluate(([n, v]) => document.querySelector("overcoat-image").setAttribute(n, v), [name, value]);
    await page.evaluate(async () => {
      await import("/js/element.js");
      globalThis.events = [];
      document.body.innerHTML = `<div style="height: 3000px"></div>
        <overcoat-image src="/demo/models/torus-knot.glb" alt="A knot" width="80" height="60" shading="gltf" view="front"></overcoat-image>`;
      const element = document.querySelector("overcoat-image");
      for (const name of ["load", "error"]) element.addEventListener(name, () => events.push(name));
    });
    await page.waitForTimeout(300);
    assert.equal(await page.getAttribute("overcoat-image", "state"), "waiting", "nobody sees it");
    await page.locator("overcoat-image").scrollIntoViewIfNeeded();
    await settled("done");
    const options = { size: [80, 60], shading: "gltf", camera: { view: "front" } };
    assert.equal(await hash(), (await render(model("torus-knot.glb"), options)).hash);
    assert.equal(await page.evaluate(() => document.querySelector("overcoat-image").shadowRoot.querySelector("canvas").ariaLabel), "A knot");
    if (shots) await page.screenshot({ path: join(shots, "element.png") });

    await set("shading", "three");
    await page.waitForFunction(() => events.length === 2);
    await settled("done");
    assert.equal(await hash(), (await render(model("torus-knot.glb"), { ...options, shading: "three" })).hash);

    await set("quality", "ultra");
    await settled("error");
    assert.match(await page.evaluate(() => document.querySelector("overcoat-image").shadowRoot.textContent), /quality/);
    await set("quality", "draft");
    await settled("done");
    await set("src", "/nothing.glb");
    await settled("error");
    assert.match(await page.evaluate(() => document.querySelector("overcoat-image").shadowRoot.textContent), /404/);
    await set("src", "/demo/models/rounded-cube.glb");
    await settled("done");
    assert.deepEqual(await page.evaluate(() => events), ["load", "load", "error", "load", "error", "load"]);
  }));
