// A slice beside the page, one part a worker: the radiance by models, or the walks, which are refined until there are as many as asked
// for, or another slice is asked for.
import { fill } from "./state.js";

/** Walks are added in parts of this many, whose sums have a fixed order. */
const CHUNK = 256;

/** Milliseconds of work between looks at what has been asked for. */
const TURN = 30;

let lab, Setup;
/** What is asked for: a number that grows, the state, and whether to go on. */
let wanted = 0;
let paused = false;
let resume = () => {};

const ready = import("./dist/overcoat.js").then(async (wasm) => {
  await wasm.default({ module_or_path: new URL("./dist/overcoat_bg.wasm", import.meta.url) });
  ({ Setup } = wasm);
  lab = new wasm.Lab();
});
ready.catch(() => postMessage({ kind: "missing" }));

const turn = () => new Promise((resolve) => setTimeout(resolve));

/** Walks of the next round: a quarter of those before, so that the picture changes often and the rounds are few. */
const next = (done, most) => Math.min(most - done, Math.max(CHUNK, Math.floor(done / 4 / CHUNK) * CHUNK));

/** Looks, once a turn of work is over, at what has been asked for: false if that is something else. */
async function goesOn(id, clock) {
  if (performance.now() - clock.since < TURN) return true;
  await turn();
  while (paused && id === wanted) await new Promise((resolve) => (resume = resolve));
  clock.since = performance.now();
  return id === wanted;
}

/** Begins the slice of a state: values of what varies. */
function begin(state) {
  const setup = fill(new Setup(), state);
  const values = Array.from(lab.begin(setup));
  setup.free();
  return values;
}

/** Models come at once, after four seconds the first time: light is filtered for their lookups. */
async function models(id, state) {
  const clock = { since: performance.now() };
  const found = [];
  for (const k of begin(state).keys()) {
    found.push(Array.from(lab.models(k)));
    if (!(await goesOn(id, clock))) return;
  }
  postMessage({ kind: "models", id, models: found });
}

async function walks(id, state) {
  const clock = { since: performance.now() };
  const values = begin(state);
  postMessage({ kind: "begun", id, values });
  for (let done = 0; done < state.samples; ) {
    const count = next(done, state.samples);
    const truth = [];
    for (const k of values.keys()) {
      truth.push(Array.from(lab.walk(k, count)));
      if (!(await goesOn(id, clock))) return;
    }
    done += count;
    postMessage({ kind: "walked", id, done, truth });
  }
}

onmessage = async ({ data }) => {
  paused = data.paused;
  resume();
  if (data.id === wanted) return;
  const id = (wanted = data.id);
  await ready.catch(() => {});
  // The slice before ends at its next look.
  await turn();
  if (!lab || id !== wanted) return;
  try {
    await (data.part === "models" ? models : walks)(id, data.state);
  } catch (error) {
    postMessage({ kind: "failed", id, message: error.message });
  }
};
