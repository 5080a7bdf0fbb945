// The sliders' values: as an object, in the address of the page, and as a command line. No page and no WebAssembly.

/** Models: one of each engine, then the others. */
export const MODELS = [
  "stacklit-d", "openpbr", "three", "filament", "urp17", "stacklit", "standard", "gltf", "babylon",
  "hdrp-lit", "gltf-sampled", "three-legacy", "filament-2018", "filament-mobile", "urp-desktop", "urp-mobile", "velvet", "filament-cloth",
];

/** What is beneath the coat: readings of plastic, or a metal. */
export const BASES = ["lambert", "interface", "seen", "convention", "metal"];

/** Quantities that vary, with their ranges. */
export const OVER = {
  view: [0, 85],
  light: [-85, 85],
  coat: [0, 1],
  "coat-roughness": [0, 1],
  "coat-ior": [1, 2],
  thickness: [0, 4],
  "base-roughness": [0, 1],
  "base-ior": [1, 2],
  color: [0, 1],
  specular: [0, 1],
};

/** Kinds of light; an angle makes the last one complete. */
const LIGHTS = ["white", "overhead", "direct"];
const STEPS = [18, 35, 69];
const SAMPLES = [1024, 4096, 16384, 65536, 262144];
const SHOW = ["radiance", "error"];
const CHANNELS = ["luminance", "red", "green", "blue"];

/** Numbers of sliders: default, least, most, step. */
export const NUMBERS = {
  view: [30, 0, 85, 1],
  angle: [30, -85, 85, 1],
  coat: [1, 0, 1, 0.01],
  "coat-roughness": [0.1, 0, 1, 0.01],
  "coat-ior": [1.5, 1, 2.5, 0.01],
  thickness: [1, 0, 4, 0.05],
  "base-roughness": [0.5, 0, 1, 0.01],
  "base-ior": [1.5, 1, 2.5, 0.01],
  specular: [1, 0, 1, 0.01],
};

/** Colours of three sliders: default, least, most, step. */
export const COLORS = {
  color: [[0.18, 0.18, 0.18], 0, 1, 0.01],
  extinction: [[0, 0, 0], 0, 3, 0.05],
};

/** Values of the lists of choices, in the order of the lists. */
export const CHOICES = {
  over: Object.keys(OVER),
  base: BASES,
  light: LIGHTS,
  steps: STEPS,
  samples: SAMPLES,
  show: SHOW,
  channel: CHANNELS,
};

/** The values before anybody moves anything: lacquer over a grey of 18 percent. */
export function defaults() {
  const state = { over: "view", base: "interface", light: "white", steps: 35, samples: 65536, show: "radiance", channel: "luminance" };
  for (const [name, [value]] of Object.entries(NUMBERS)) state[name] = value;
  for (const [name, [value]] of Object.entries(COLORS)) state[name] = [...value];
  state.models = MODELS.slice(0, 6);
  return state;
}

/** The state as the part of an address behind `#`: what is not the default. */
export function toHash(state) {
  const first = defaults();
  return Object.keys(first)
    .filter((name) => String(state[name]) !== String(first[name]))
    .map((name) => `${name}=${state[name]}`)
    .join("&");
}

/** The state of an address. What is unknown or out of its range is the default. */
export function fromHash(hash) {
  const state = defaults();
  for (const pair of hash.replace(/^#/, "").split("&")) {
    const [name, text] = pair.split("=");
    if (text === undefined || !Object.hasOwn(state, name)) continue;
    if (name === "models") {
      state.models = MODELS.filter((model) => text.split(",").includes(model));
    } else if (CHOICES[name]) {
      const choice = CHOICES[name].find((choice) => String(choice) === text);
      if (choice !== undefined) state[name] = choice;
    } else if (COLORS[name]) {
      const [, least, most] = COLORS[name];
      const channels = text.split(",").map(number);
      if (channels.length === 3 && channels.every((c) => c >= least && c <= most)) state[name] = channels;
    } else {
      const [, least, most] = NUMBERS[name];
      const value = number(text);
      if (value >= least && value <= most) state[name] = value;
    }
  }
  return state;
}

const number = (text) => (text.trim() === "" ? NaN : Number(text));

/** True if what is beneath the coat has an index of its own. */
export const hasIndex = (state) => state.base === "interface" || state.base === "seen";

/** The quantity that varies: the one that is chosen, unless the base lacks it. */
export const varies = (state) => (state.over === "base-ior" && !hasIndex(state) ? "view" : state.over);

/** The light as the program names it. That which varies in its angle comes from one direction. */
export function light(state) {
  if (varies(state) === "light") return "0";
  return state.light === "direct" ? String(state.angle) : state.light;
}

/** Thickness of the coat: without extinction it is nothing, unless it varies. */
export const thickness = (state) => (state.extinction.every((c) => c === 0) ? 0 : state.thickness);

/** Option and value of everything about the surface that is not the program's default. */
function options(state) {
  const over = varies(state);
  const told = { "coat": "1", "coat-roughness": "0.1", "coat-ior": "1.5", "base-roughness": "0.5", "specular": "1" };
  const words = [];
  const say = (name, value) => words.push(`--${name} ${value}`);
  if (over !== "view") {
    say("over", over);
    say("view", state.view);
  }
  if (over !== "light" && state.light !== "white") say("light", light(state));
  if (state.base === "metal") words.push("--metal");
  else if (state.base !== "interface") say("base", state.base);
  if (hasIndex(state) && over !== "base-ior" && state["base-ior"] !== 1.5) say("base-ior", state["base-ior"]);
  if (over !== "color") say("color", state.color);
  for (const [name, first] of Object.entries(told)) {
    if (name !== over && String(state[name]) !== first) say(name, state[name]);
  }
  if (state.extinction.some((c) => c !== 0)) {
    say("extinction", state.extinction);
    if (over !== "thickness" && state.thickness !== 1) say("thickness", state.thickness);
  }
  if (state.steps !== 18) say("steps", state.steps);
  return words;
}

/** The command that prints the same numbers. */
export function command(state) {
  const words = [...options(state), `--samples ${state.samples}`];
  if (state.models.length > 0) words.push(`--models ${state.models}`);
  return `overcoat lab ${words.join(" ")}`;
}

/** Fills a Setup of the WebAssembly module. */
export function fill(setup, state) {
  for (const name of Object.keys(NUMBERS)) {
    if (name !== "angle" && name !== "thickness") setup.number(name, state[name]);
  }
  setup.number("thickness", thickness(state));
  setup.number("steps", state.steps);
  for (const name of Object.keys(COLORS)) setup.channels(name, ...state[name]);
  setup.base(state.base);
  setup.over(varies(state));
  setup.light(light(state));
  for (const model of state.models) setup.model(model);
  return setup;
}
