// The page: controls, what they say, and the plot of what the worker finds.
import { errors, meanError, radiance, rows } from "./figures.js";
import { draw, element, stroke } from "./plot.js";
import { CHOICES, COLORS, MODELS, NUMBERS, command, defaults, fromHash, hasIndex, toHash, varies } from "./state.js";

/** Words for values whose names say too little. */
const WORDS = {
  direct: "from one direction",
  white: "white, from everywhere",
  overhead: "soft box overhead",
  lambert: "lambert: matt",
  interface: "interface: plastic",
  seen: "seen: plastic by its look",
  convention: "convention: engines' plastic",
  error: "error of the models",
  view: "angle of view",
  light: "angle of light",
};
/** Names of the radiance under each light. */
const QUANTITIES = { white: "directional albedo", overhead: "radiance", direct: "BRDF times cosine" };
const UNITS = { view: "angle of view, degrees", light: "angle of light, degrees; below 0 on the viewer's side" };

/** Milliseconds that sliders have to rest before something is measured. */
const REST = 80;

const $ = (selector) => document.querySelector(selector);
let state = fromHash(location.hash);
let asked = 0;
let paused = false;
let timer;
/** True while something has changed that is not measured yet. */
let unmeasured = false;
/** What the plot shows: a state, values, models' radiance, the referee's, and walks so far. */
let shown;
/** What is measured, not to be shown before it has something to show. */
let begun;

const workers = ["walks", "models"].map((part) => {
  const worker = new Worker(new URL("./worker.js", import.meta.url), { type: "module" });
  worker.onmessage = ({ data }) => receive(data);
  worker.onerror = (event) => fail(event.message ?? "the walks cannot be started");
  return { part, worker };
});
const tell = () => workers.forEach(({ part, worker }) => worker.postMessage({ part, id: asked, state, paused }));

function slider(name, [least, most, step], label, update) {
  const place = document.createElement("span");
  place.className = "slider";
  const input = document.createElement("input");
  Object.assign(input, { type: "range", min: least, max: most, step, name });
  if (label) input.ariaLabel = label;
  const output = document.createElement("output");
  place.append(input, output);
  input.addEventListener("input", () => update(Number(input.value)));
  return place;
}

function buildSliders() {
  for (const label of document.querySelectorAll("[data-number]")) {
    const name = label.dataset.number;
    label.append(slider(name, NUMBERS[name].slice(1), "", (value) => change({ [name]: value })));
  }
  for (const group of document.querySelectorAll("[data-color]")) {
    const name = group.dataset.color;
    const channels = document.createElement("div");
    channels.className = "channels";
    for (const [c, channel] of ["red", "green", "blue"].entries()) {
      const update = (value) => change({ [name]: state[name].with(c, value) });
      const place = slider(`${name}-${channel}`, COLORS[name].slice(1), `${group.ariaLabel}, ${channel}`, update);
      const letter = document.createElement("abbr");
      letter.textContent = channel[0];
      letter.title = channel;
      place.prepend(letter);
      channels.append(place);
    }
    const swatch = document.createElement("span");
    swatch.className = "swatch";
    const head = document.createElement("span");
    head.append(...group.childNodes, " ", swatch);
    group.append(head, channels);
  }
}

function buildChoices() {
  for (const [name, values] of Object.entries(CHOICES)) {
    const select = $(`select[name=${name}]`);
    for (const value of values) select.add(new Option(WORDS[value] ?? String(value).replace("-", " "), value));
    const isNumber = typeof values[0] === "number";
    select.addEventListener("change", () => change({ [name]: isNumber ? Number(select.value) : select.value }));
  }
  for (const [k, model] of MODELS.entries()) {
    const label = document.createElement("label");
    const box = document.createElement("input");
    Object.assign(box, { type: "checkbox", name: "model", value: model });
    box.addEventListener("change", () => {
      change({ models: MODELS.filter((name) => $(`[name=model][value=${name}]`).checked) });
    });
    const key = element("svg", { viewBox: "0 0 26 10", "aria-hidden": "true" });
    key.append(element("line", { x1: 0, x2: 26, y1: 5, y2: 5, ...stroke(k) }));
    label.append(box, key, model, document.createElement("output"));
    $("#models").append(label);
  }
}

/** Brings every control in line with the state: its value, and whether it has any effect. */
function showState() {
  const over = varies(state);
  for (const name of Object.keys(CHOICES)) $(`select[name=${name}]`).value = state[name];
  for (const name of Object.keys(NUMBERS)) setSlider(name, state[name]);
  for (const name of Object.keys(COLORS)) {
    for (const [c, channel] of ["red", "green", "blue"].entries()) setSlider(`${name}-${channel}`, state[name][c]);
  }
  for (const box of document.querySelectorAll("[name=model]")) box.checked = state.models.includes(box.value);
  const [r, g, b] = state.color;
  $("[data-color=color] .swatch").style.background = `color(srgb-linear ${r} ${g} ${b})`;
  const deep = state.extinction.map((c) => Math.exp(-2 * c * state.thickness));
  $("[data-color=extinction] .swatch").style.background = `color(srgb-linear ${deep.join(" ")})`;
  const matt = state.base === "lambert";
  const idle = {
    angle: over === "light" || state.light !== "direct",
    light: over === "light",
    thickness: state.extinction.every((c) => c === 0),
    "base-ior": !hasIndex(state),
    "base-roughness": matt,
    specular: matt || state.base === "metal",
  };
  for (const input of $("#controls").elements) {
    if (!input.name || input.name === "over") continue;
    input.disabled = Boolean(idle[input.name]) || input.name.replace(/-(red|green|blue)$/, "") === over;
  }
  $("option[value=base-ior]").disabled = !hasIndex(state);
  $("#command").textContent = command(state);
}

function setSlider(name, value) {
  const input = $(`input[name=${name}]`);
  input.value = value;
  input.nextElementSibling.textContent = value;
}

/** Takes new values, and measures when they have rested for a while. What only the plot shows needs no measurement. */
function change(values) {
  const measures = Object.keys(values).some((name) => name !== "show" && name !== "channel");
  unmeasured ||= measures;
  state = { ...state, ...values };
  showState();
  paint();
  clearTimeout(timer);
  timer = setTimeout(() => {
    history.replaceState(null, "", `#${toHash(state)}`);
    if (unmeasured) ask();
  }, REST);
}

function ask() {
  asked++;
  unmeasured = false;
  pause(false);
  begun = { state: { ...state }, done: 0 };
  document.body.dataset.state = "busy";
  tell();
}

function pause(value) {
  paused = value;
  $("#pause").ariaPressed = String(paused);
  $("#pause").textContent = paused ? "Go on" : "Pause";
}

function receive(data) {
  if (data.kind === "missing") {
    return fail("The walks are not built: run bindings/coat-lab/build.sh, and open this page from a server.");
  }
  if (data.id !== asked) return;
  if (data.kind === "failed") return fail(data.message);
  const { kind, id, ...found } = data;
  Object.assign(begun, found);
  if (kind === "begun") say("");
  // The slice before stays until walks and models of this one are there; at first there is none, and models take some seconds.
  if (begun.done > 0 && (begun.models || !shown?.models)) shown = begun;
  if (!begun.models && begun.done > 0 && !shown?.models) say("Models are being prepared.");
  else if (kind === "models") say("");
  if (begun.done >= state.samples && begun.models) document.body.dataset.state = "done";
  paint();
}

function fail(text) {
  say(text, true);
  document.body.dataset.state = "error";
}

function say(text, isError = false) {
  $("#status").textContent = text;
  $("#status").classList.toggle("error", isError);
}

/** Draws before the screen does, once for whatever has come. */
let waiting = false;
function paint() {
  if (waiting || !shown) return;
  waiting = true;
  requestAnimationFrame(() => {
    waiting = false;
    paintNow();
  });
}

function paintNow() {
  const { done } = shown;
  // Of the state now, what needs no measurement; models that are not there yet are left out.
  const of = { ...shown.state, show: state.show, channel: state.channel, ...(shown.models ? {} : { models: [] }) };
  const over = varies(of);
  const table = rows(shown, of.channel);
  const isError = of.show === "error" && done > 0;
  const found = isError ? errors(table) : radiance(table);
  const lines = found.models.map((points, m) => ({ points, ...stroke(MODELS.indexOf(of.models[m])) }));
  lines.push({ points: found.referee, class: "referee" });
  draw($("#plot"), {
    xs: [shown.values[0], shown.values.at(-1)],
    ys: found.ys,
    xLabel: UNITS[over] ?? over.replace("-", " "),
    yLabel: `${isError ? "error in percent" : QUANTITIES[over === "light" ? "direct" : of.light]} (${of.channel})`,
    lines,
    band: found.band,
  });
  paintNumbers(of, table, done);
  paintTable(of, table, over);
}

function paintNumbers(of, table, done) {
  const percent = (x) => `${(100 * x).toFixed(1)} %`;
  const told = [];
  for (const label of document.querySelectorAll("#models label")) {
    const m = of.models.indexOf(label.querySelector("input").value);
    const error = m < 0 ? undefined : meanError(table, m);
    const text = error ? `${percent(error.size)} (${error.bias < 0 ? "" : "+"}${percent(error.bias)})` : "";
    label.querySelector("output").textContent = text;
    if (text) told.push(`${of.models[m]} is off by ${percent(error.size)}`);
  }
  const lit = table.filter((row) => row.mean > 0);
  const noise = lit.reduce((sum, row) => sum + row.half / row.mean, 0) / Math.max(1, lit.length);
  $("#progress").value = done / of.samples;
  $("#done").textContent = done > 0 ? `${done.toLocaleString("en")} walks, ± ${percent(noise)}` : "no walks yet";
  const over = varies(of).replace("-", " ");
  $("#plot").ariaLabel = `Curves over ${over} of the referee and ${of.models.length} models. Mean errors: ${told.join(", ")}.`;
}

function paintTable(of, table, over) {
  if (!$("#numbers").open) return;
  const cell = (name, text) => Object.assign(document.createElement(name), { textContent: text });
  const line = (cells) => {
    const made = document.createElement("tr");
    made.append(...cells);
    return made;
  };
  const digits = (x) => (x === undefined ? "" : x.toFixed(4));
  const head = document.createElement("thead");
  head.append(line([over.replace("-", " "), "referee", "±", ...of.models].map((text) => cell("th", text))));
  const body = document.createElement("tbody");
  for (const row of table) {
    const numbers = [row.mean, row.half, ...row.models].map((x) => cell("td", digits(x)));
    body.append(line([cell("th", Number(row.value.toFixed(3))), ...numbers]));
  }
  $("#numbers table").replaceChildren(head, body);
}

buildSliders();
buildChoices();
showState();
ask();
$("#reset").addEventListener("click", () => change(defaults()));
$("#pause").addEventListener("click", () => {
  pause(!paused);
  tell();
});
$("#copy").addEventListener("click", async () => {
  const text = $("#command").textContent;
  try {
    await navigator.clipboard.writeText(text);
    say("The command is copied.");
  } catch {
    getSelection().selectAllChildren($("#command"));
    say("The command is selected: copy it from there.");
  }
});
$("#controls").addEventListener("submit", (event) => event.preventDefault());
$("#numbers").addEventListener("toggle", paint);
addEventListener("resize", paint);
addEventListener("hashchange", () => change(fromHash(location.hash)));
