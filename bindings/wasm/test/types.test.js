// The types say what the schema says, and what the module does.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { mkdtempSync, rmSync, symlinkSync, mkdirSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import test from "node:test";
import * as overcoat from "../js/index.js";
import { readFileSync } from "node:fs";
import { here } from "./common.js";

test("types and names are those of the schema", () => {
  const { status, stderr } = spawnSync(process.execPath, [join(here, "scripts/types.mjs"), "--check"], { encoding: "utf8" });
  assert.equal(status, 0, stderr);
});

test("everything that is exported has a type, and nothing else has", () => {
  const typed = ["index", "names", "scene", "three"].flatMap((name) => {
    const text = readFileSync(join(here, `types/${name}.d.ts`), "utf8");
    return [...text.matchAll(/^export declare (?:class|function|const) (\w+)/gm)].map(([, exported]) => exported);
  });
  // Models come from load().
  assert.deepEqual([...typed].sort(), Object.keys(overcoat).sort());
});

test("a program with types compiles, one with mistakes does not", { timeout: 120_000 }, () => {
  const folder = mkdtempSync(join(tmpdir(), "overcoat-types-"));
  mkdirSync(join(folder, "node_modules"));
  symlinkSync(here, join(folder, "node_modules/overcoat"));
  symlinkSync(join(here, "node_modules/vitest"), join(folder, "node_modules/vitest"));
  writeFileSync(join(folder, "package.json"), '{ "type": "module" }');
  const good = `
    import { Scene, createRenderer, fromThree, load, render, OvercoatError, type Handle, type Hit, type RenderedImage } from "overcoat";
    import "overcoat/element";
    import { checkGolden, checkMatch } from "overcoat/golden";
    const bytes = new Uint8Array(3);
    const image: RenderedImage = await render(bytes, { size: 512, quality: "good", shading: "stacklit", camera: { eye: [1, 2, 3] }, env: bytes });
    const data: ImageData = image.toImageData();
    const png: Uint8Array = await image.png();
    const model = await load(bytes, { worker: true, limits: { triangles: 10 } });
    await model.render({ background: "#fff", aovs: ["depth"], light: [{ type: "point", position: [0, 0, 0], intensity: 1 }] });
    const scene: Scene = new Scene({ size: 64, worker: false, limits: { triangles: 10 } });
    const car = await scene.addModel(bytes, { transform: new Float32Array(16), material: "velvet" });
    const mesh: Handle<"mesh"> = await scene.addMesh({ positions: new Float32Array(9), uvs: [0, 0, 1, 0, 1, 1] });
    const paint = await scene.addMaterial({ base_color: "#fff", coat: 1 });
    const one = await scene.addInstance(mesh, paint, new DOMMatrix());
    await scene.addLight({ type: "point", position: [0, 0, 0], intensity: 1 });
    await scene.setEnvironment({ env: bytes, env_rotation_deg: 90 });
    await scene.setTransform(car, await scene.getTransform(one));
    const hit: Hit | null = await scene.pick(3, 4);
    if (hit?.model === car) await scene.setMaterial(car.materials[0]!, null);
    await scene.remove(one);
    const picture: RenderedImage = await (await Scene.load(bytes)).render({ quality: "good" });
    createRenderer().scene().free();
    console.log(picture.hash, car.duration);
    document.createElement("overcoat-image").redraw();
    await checkGolden(image, "name", { folder: "x" });
    const live = await fromThree({ isObject3D: true }, { isObject3D: true, isCamera: true }, { size: 64, renderer: { toneMapping: 4, toneMappingExposure: 1 } });
    const shot: RenderedImage = await live.render({ size: [4, 3] });
    await checkMatch(shot, live, { thresholds: { max_abs: 3 } });
    await scene.addMaterial({ base_color_texture: { data: new Float32Array(12), width: 2, height: 2 } });
    await scene.addMesh({ positions: [0, 0, 0, 1, 0, 0], kind: "lines" });
    console.log(shot.camera.K[0][0], shot.camera.far ?? 0, live.warnings);
    try { throw new Error(); } catch (e) { if (e instanceof OvercoatError) console.log(e.code === "crash", data, png); }
  `;
  writeFileSync(join(folder, "good.ts"), good);
  const bad = ['render(bytes, { sise: 1 })', 'render("a.glb")', 'render(bytes, { quality: "ultra" })', 'render(bytes, { camera: { eye: [1, 2] } })', 'render(bytes, { shading: "phong" })', 'new Scene().addInstance(await new Scene().addMaterial(), await new Scene().addMaterial())', 'new Scene().render({ env: "none" })', 'new Scene().addMesh({ indices: [0, 1, 2] })', 'new Scene().addMesh({ positions: [], kind: "strips" })', 'new Scene().addLight({ type: "sun" })'];
  writeFileSync(join(folder, "bad.ts"), `import { Scene, render } from "overcoat";\nconst bytes = new Uint8Array(3);\n${bad.map((line) => `await ${line};\n`).join("")}`);
  const tsc = (file) =>
    spawnSync(process.execPath, [join(here, "node_modules/typescript/bin/tsc"), "--noEmit", "--strict", "--target", "es2023", "--module", "nodenext", "--lib", "es2023,dom,esnext.disposable", "--types", "", file], { cwd: folder, encoding: "utf8" });
  const compiled = tsc("good.ts");
  assert.equal(compiled.status, 0, compiled.stdout + compiled.stderr);
  const refused = tsc("bad.ts").stdout;
  bad.forEach((line, k) => assert.match(refused, new RegExp(`bad\\.ts\\(${k + 3},`), line));
  rmSync(folder, { recursive: true });
});
