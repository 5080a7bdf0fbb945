// The demo page: one model, turned by hand; every picture with its hash and the command that draws it elsewhere; a click names what
// is there.
import { Scene, about, backgrounds, builtinMaterials, qualities, shadingModels, toneCurves } from "../js/index.js";
import { Orbit } from "./orbit.js";

const $ = (id) => document.getElementById(id);
const MODELS = ["sports-car", "material-ball", "torus-knot", "vase", "draped-cloth", "rounded-cube"];
const OWN = "(opened file)";
/** Pixels of a side while the model is turned. */
const DRAFT = 224;

const choose = (id, names, first) =>
  $(id).replaceChildren(...(first === undefined ? [] : [new Option(first, "")]), ...names.map((name) => new Option(name)));
choose("model", MODELS);
choose("shading", shadingModels, "as the model says");
choose("material", builtinMaterials, "as the model says");
choose("quality", qualities);
choose("tone", toneCurves, "default");
choose("background", backgrounds.filter((name) => name !== "grey"));
$("quality").value = "fast";

const orbit = new Orbit($("view"));
/** The scene, the one model in it, and what both were made of. */
let scene;
let model;
let opened;
let fileName;
let drawn;
/** Options of the picture that is shown. */
let shown;
let cancel;
let turning = false;

/** What is chosen, by the keys of a description; what is left at its default is not in it. */
function description() {
  const chosen = {
    shading: $("shading").value,
    material: $("material").value,
    quality: $("quality").value === "fast" ? "" : $("quality").value,
    env: $("env").value === "studio" ? "" : $("env").value,
    env_rotation_deg: Number($("turn").value) || "",
    tone_mapping: $("tone").value,
    background: $("background").value === "transparent" ? "" : $("background").value,
    camera: orbit.camera ?? "",
  };
  return Object.fromEntries(Object.entries(chosen).filter(([, value]) => value !== ""));
}

/** The same picture from the command line. */
function command({ camera, ...options }, size) {
  const flags = Object.entries(options).map(([key, value]) => {
    const name = { env_rotation_deg: "env-rotation", tone_mapping: "tone-map" }[key] ?? key.replaceAll("_", "-");
    return `--${name} ${String(value).startsWith("#") ? `'${value}'` : value}`;
  });
  if (camera) flags.push(`--eye=${camera.eye}`, `--target=${camera.target}`, `--fov ${camera.fov_y_deg}`);
  return ["overcoat render", fileName, "-o picture.png", `--size ${size}`, ...flags, "--json"].join(" ");
}

function say(text, isError = false) {
  $("status").textContent = text;
  $("status").classList.toggle("error", isError);
}

let preparing = Promise.resolve();
/** Brings the scene to what is chosen of it, after all that was chosen before, and returns the rest: options of a picture. */
function prepare({ material, env = "studio", env_rotation_deg = 0, ...options }) {
  const of = scene;
  const done = preparing.then(async () => {
    await of.setEnvironment({ env, env_rotation_deg });
    if (of === scene && opened.material !== material) {
      const { bytes, files } = opened;
      const next = await of.addModel(bytes, { files, material });
      await of.remove(model);
      [model, opened] = [next, { bytes, files, material }];
    }
    return options;
  });
  preparing = done.catch(() => {});
  return done;
}

function show(image, options) {
  shown = options;
  const canvas = $("view");
  canvas.width = image.width;
  canvas.height = image.height;
  canvas.getContext("2d").putImageData(image.toImageData(), 0, 0);
}

/** Draws a small picture while the model is turned, the whole one when it rests. What is asked for last is what counts. */
async function draw() {
  if (!model) return;
  cancel?.abort();
  const current = (cancel = new AbortController());
  const { signal } = current;
  const options = description();
  const size = Number($("size").value);
  try {
    if (turning) {
      await drawTurning();
      return;
    }
    say("drawing…");
    const start = performance.now();
    const picture = { ...(await prepare(options)), size };
    const image = await scene.render({ ...picture, signal });
    const time = performance.now() - start;
    if (signal.aborted) return;
    show(image, picture);
    drawn = image;
    $("hash").textContent = image.hash;
    $("facts").textContent = `${size} × ${size} in ${(time / 1000).toFixed(2)} s; ${model.info.triangles.toLocaleString("en")} triangles`;
    $("command").textContent = command(options, size);
    say(image.warnings.join(" · "));
    judge();
    document.body.dataset.state = "done";
  } catch (error) {
    if (signal.aborted) return;
    document.body.dataset.state = "error";
    say(error.message, true);
  }
}

let busy = false;
let again = false;
/** Drafts one after the other: ending a thread for each would take longer than the draft. */
async function drawTurning() {
  if (busy) {
    again = true;
    return;
  }
  busy = true;
  try {
    do {
      again = false;
      const picture = { ...(await prepare(description())), size: DRAFT, quality: "draft", ground: "none", samples: 4 };
      show(await scene.render(picture), picture);
    } while (again && turning);
  } finally {
    busy = false;
  }
}

function judge() {
  const given = $("server").value.trim().replace(/^.*"frame_hash"\s*:\s*"([^"]*)".*$/s, "$1");
  const verdict = $("verdict");
  const isEqual = given !== "" && given === drawn?.hash;
  verdict.textContent = given === "" ? "" : isEqual ? "Equal: the same bits." : "Another hash: not the same picture.";
  verdict.className = given === "" ? "" : isEqual ? "equal" : "other";
}

async function open(name, bytes, files = {}) {
  document.body.dataset.state = "loading";
  say(`reading ${name}…`);
  cancel?.abort();
  try {
    const next = new Scene();
    const { material } = description();
    const added = await next.addModel(bytes, { files, material });
    scene?.free();
    [scene, model, opened] = [next, added, { bytes, files, material }];
    fileName = /^[\w./-]+$/.test(name) ? name : `'${name.replaceAll("'", "'\\''")}'`;
    orbit.around(model.info.min, model.info.max);
    await draw();
  } catch (error) {
    document.body.dataset.state = "error";
    say(`${name}: ${error.message}`, true);
  }
}

async function openFiles(list) {
  const files = [...list];
  const main = files.find(({ name }) => /\.(glb|gltf|obj|stl|ply|3mf)(\.gz|\.zst)?$/i.test(name)) ?? files[0];
  if (!main) return;
  if (![...$("model").options].some(({ value }) => value === OWN)) $("model").add(new Option(OWN));
  $("model").value = OWN;
  const others = files.filter((file) => file !== main).map((file) => [file.name, file]);
  await open(main.name, main, Object.fromEntries(others));
}

async function openBuiltIn() {
  const name = $("model").value;
  if (name === OWN) return;
  const response = await fetch(`models/${name}.glb`);
  if (!response.ok) return say(`models/${name}.glb: ${response.status} (build.sh copies it)`, true);
  await open(`${name}.glb`, await response.blob());
}

/** Names what is under the pointer. */
async function point({ offsetX, offsetY }) {
  if (!shown) return;
  const canvas = $("view");
  const at = (offset, side, pixels) => Math.min(pixels - 1, Math.max(0, Math.floor((offset / side) * pixels)));
  const hit = await scene.pick(at(offsetX, canvas.clientWidth, canvas.width), at(offsetY, canvas.clientHeight, canvas.height), shown);
  if (hit === null) return say("nothing there");
  const part = `part ${model.instances.indexOf(hit.instance) + 1} of ${model.instances.length}`;
  const name = hit.material?.name ? `, ${hit.material.name}` : "";
  say(`${part}${name}: triangle ${hit.triangle}, ${hit.depth.toFixed(2)} m away`);
}

orbit.addEventListener("point", ({ detail }) => point(detail).catch((error) => say(error.message, true)));
orbit.addEventListener("turn", () => {
  turning = true;
  draw();
});
orbit.addEventListener("rest", () => {
  turning = false;
  draw();
});
for (const id of ["shading", "material", "quality", "env", "tone", "background", "size"]) $(id).addEventListener("change", draw);
$("turn").addEventListener("input", () => {
  $("turn").nextElementSibling.textContent = `${$("turn").value}°`;
  turning = true;
  draw();
});
$("turn").addEventListener("change", () => {
  turning = false;
  draw();
});
$("model").addEventListener("change", openBuiltIn);
$("file").addEventListener("change", () => openFiles($("file").files));
$("server").addEventListener("input", judge);
$("reset").addEventListener("click", () => {
  orbit.reset();
  draw();
});
$("copy").addEventListener("click", () => navigator.clipboard?.writeText($("command").textContent));
$("save").addEventListener("click", async () => {
  if (!drawn) return;
  const link = document.createElement("a");
  link.href = URL.createObjectURL(await drawn.toBlob());
  link.download = "picture.png";
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
});
const stage = $("stage");
for (const name of ["dragenter", "dragover"]) {
  stage.addEventListener(name, (event) => {
    event.preventDefault();
    stage.classList.add("over");
  });
}
stage.addEventListener("dragleave", () => stage.classList.remove("over"));
stage.addEventListener("drop", (event) => {
  event.preventDefault();
  stage.classList.remove("over");
  openFiles(event.dataTransfer.files);
});

about().then(({ version, lanes }) => {
  $("hint").append(` · version ${version}, ${lanes}`);
});
openBuiltIn();
