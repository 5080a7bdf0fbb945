// Draws the scenes of a conformance pack with three.js in a headless Chromium, by WebGL.
//
//     npm install three puppeteer-core
//     node three.mjs PACK PICTURES [--scenes LIST] [--chromium PATH]
//
// Each scene is the pack's glTF file as GLTFLoader reads it, under its lamp or under the pack's map by PMREMGenerator; nothing
// is set beyond glTF. Pictures are shaded once in the middle of each pixel, as a canvas without antialiasing is.

import { createServer } from 'node:http';
import { readFile, mkdir, writeFile } from 'node:fs/promises';
import { existsSync, readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import path from 'node:path';
import puppeteer from 'puppeteer-core';

const USAGE = 'usage: node three.mjs PACK PICTURES [--scenes LIST] [--chromium PATH]';

function parsed(given) {
  const options = { scenes: '', chromium: process.env.CHROMIUM ?? 'chromium' };
  const places = [];
  for (let k = 0; k < given.length; k += 1) {
    const name = given[k].startsWith('--') ? given[k].slice(2) : null;
    if (name === null) places.push(given[k]);
    else if (name in options && k + 1 < given.length) options[name] = given[(k += 1)];
    else fail(USAGE);
  }
  if (places.length !== 2) fail(USAGE);
  return { pack: path.resolve(places[0]), pictures: path.resolve(places[1]), ...options };
}

function fail(line) {
  console.error(line);
  process.exit(2);
}

function executable(name) {
  const folders = name.includes('/') ? [''] : process.env.PATH.split(':');
  const found = folders.map((folder) => path.join(folder, name)).find((file) => existsSync(file));
  return found ?? fail(`${name}: no such program; --chromium PATH says where it is`);
}

// Drawing, in the page. Returns R, G and B from the bottom row.
const PAGE = `<!doctype html><link rel="icon" href="data:,"><script type="importmap">
{"imports": {"three": "/three/build/three.module.js", "three/addons/": "/three/examples/jsm/"}}
</script><script type="module">
import * as THREE from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { EXRLoader } from 'three/addons/loaders/EXRLoader.js';

const renderer = new THREE.WebGLRenderer({ antialias: false });
renderer.toneMapping = THREE.NoToneMapping;
const generator = new THREE.PMREMGenerator(renderer);

window.draw = async (name, size) => {
  const file = await new GLTFLoader().loadAsync('/pack/scenes/' + name + '.gltf');
  const description = await (await fetch('/pack/scenes/' + name + '.json')).json();
  const { cameras: [camera] } = file;
  const scene = new THREE.Scene();
  scene.add(file.scene);
  if (description.light.kind === 'environment') {
    const map = await new EXRLoader().loadAsync('/pack/scenes/' + description.light.file);
    map.mapping = THREE.EquirectangularReflectionMapping;
    scene.environment = generator.fromEquirectangular(map).texture;
  }
  camera.aspect = 1;
  camera.updateProjectionMatrix();
  const target = new THREE.WebGLRenderTarget(size, size, { type: THREE.FloatType });
  renderer.setRenderTarget(target);
  renderer.setClearColor(0, 0);
  renderer.render(scene, camera);
  const pixels = new Float32Array(4 * size * size);
  renderer.readRenderTargetPixels(target, 0, 0, size, size, pixels);
  const problem = renderer.getContext().getError();
  if (problem) throw new Error('WebGL error ' + problem);
  return Array.from(pixels.filter((_, k) => k % 4 < 3));
};
window.about = () => {
  const context = renderer.getContext();
  const info = context.getExtension('WEBGL_debug_renderer_info');
  return 'three.js r' + THREE.REVISION + ', ' + context.getParameter(info ? info.UNMASKED_RENDERER_WEBGL : context.RENDERER);
};
window.ready = true;
</script>`;

const TYPES = { '.js': 'text/javascript', '.gltf': 'model/gltf+json', '.json': 'application/json' };

// Files of the pack and of three.js, to this machine only.
function serve(pack) {
  const three = path.dirname(path.dirname(createRequire(import.meta.url).resolve('three')));
  const roots = { pack, three };
  const server = createServer(async (request, response) => {
    const asked = path.posix.normalize(decodeURIComponent(new URL(request.url, 'http://x').pathname));
    const [, root, ...rest] = asked.split('/');
    if (asked === '/') return response.setHeader('content-type', 'text/html').end(PAGE);
    try {
      const file = path.join(roots[root], ...rest);
      const bytes = await readFile(file);
      response.setHeader('content-type', TYPES[path.extname(file)] ?? 'application/octet-stream').end(bytes);
    } catch {
      response.writeHead(404).end();
    }
  });
  return new Promise((resolve) => server.listen(0, '127.0.0.1', () => resolve(server)));
}

// An OpenEXR file of 32-bit floats, scan lines without compression; the values are from the bottom row, the file from the top.
function exr(size, values) {
  const text = (string) => Buffer.from(`${string}\0`, 'latin1');
  const numbers = (kind, ...list) => {
    const buffer = Buffer.alloc(4 * list.length);
    list.forEach((v, k) => (kind === 'f' ? buffer.writeFloatLE(v, 4 * k) : buffer.writeInt32LE(v, 4 * k)));
    return buffer;
  };
  const attribute = (name, kind, value) => Buffer.concat([text(name), text(kind), numbers('i', value.length), value]);
  const channel = (name) => Buffer.concat([text(name), numbers('i', 2, 0, 1, 1)]);
  const window = numbers('i', 0, 0, size - 1, size - 1);
  const header = Buffer.concat([
    numbers('i', 20000630, 2),
    attribute('channels', 'chlist', Buffer.concat([...['B', 'G', 'R'].map(channel), Buffer.alloc(1)])),
    attribute('compression', 'compression', Buffer.alloc(1)),
    attribute('dataWindow', 'box2i', window),
    attribute('displayWindow', 'box2i', window),
    attribute('lineOrder', 'lineOrder', Buffer.alloc(1)),
    attribute('pixelAspectRatio', 'float', numbers('f', 1)),
    attribute('screenWindowCenter', 'v2f', numbers('f', 0, 0)),
    attribute('screenWindowWidth', 'float', numbers('f', 1)),
    Buffer.alloc(1),
  ]);
  const row = 12 * size;
  const table = Buffer.alloc(8 * size);
  const rows = [];
  for (let y = 0; y < size; y += 1) {
    table.writeBigUInt64LE(BigInt(header.length + table.length + y * (row + 8)), 8 * y);
    const from = 3 * size * (size - 1 - y);
    const line = values.slice(from, from + 3 * size);
    const planes = [2, 1, 0].map((c) => numbers('f', ...line.filter((_, k) => k % 3 === c)));
    rows.push(numbers('i', y, row), ...planes);
  }
  return Buffer.concat([header, table, ...rows]);
}

async function main() {
  const options = parsed(process.argv.slice(2));
  const version = path.join(options.pack, 'VERSION');
  if (!existsSync(version)) fail(`${options.pack}: no conformance pack; expected VERSION and scenes.tsv in it`);
  const size = Number(/^size (\d+)$/m.exec(readFileSync(version, 'utf8'))[1]);
  const list = readFileSync(path.join(options.pack, 'scenes.tsv'), 'utf8').trim().split('\n').slice(1);
  const known = list.map((line) => line.split('\t')[0]);
  const asked = options.scenes ? options.scenes.split(',') : known;
  const strange = asked.find((name) => !known.includes(name));
  if (strange !== undefined) fail(`no scene ${strange}; there are ${known.join(', ')}`);
  await mkdir(options.pictures, { recursive: true });
  const server = await serve(options.pack);
  const browser = await puppeteer.launch({
    executablePath: executable(options.chromium),
    args: ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist'],
  });
  try {
    const page = await browser.newPage();
    page.on('console', (message) => message.type() === 'error' && console.error(message.text()));
    page.on('pageerror', (error) => console.error(String(error)));
    await page.goto(`http://127.0.0.1:${server.address().port}/`);
    await page.waitForFunction('window.ready', { timeout: 60000 });
    for (const name of asked) {
      const values = await page.evaluate((n, s) => window.draw(n, s), name, size);
      const file = path.join(options.pictures, `${name}.exr`);
      await writeFile(file, exr(size, values));
      const middle = 3 * (size * (size >> 1) + (size >> 1));
      console.log(`${file}: middle ${values.slice(middle, middle + 3).map((v) => v.toFixed(4)).join(' ')}`);
    }
    console.log(await page.evaluate(() => window.about()));
  } finally {
    await browser.close();
    server.close();
  }
}

await main();
