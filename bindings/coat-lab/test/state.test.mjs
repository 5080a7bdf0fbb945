// The page's numbers are the program's: names, ranges, and every bit of models and referee.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readFileSync } from "node:fs";
import test from "node:test";
import { fileURLToPath } from "node:url";
import { CONFIDENCE_95, errors, meanError, pick, radiance, rows } from "../../../docs/src/coat-lab/figures.js";
import { BASES, COLORS, MODELS, NUMBERS, OVER, command, defaults, fill, fromHash, toHash } from "../../../docs/src/coat-lab/state.js";

const dist = new URL("../../../docs/src/coat-lab/dist/", import.meta.url);
const wasm = await import(new URL("overcoat.js", dist));
wasm.initSync({ module: readFileSync(new URL("overcoat_bg.wasm", dist)) });
/** One for all tests, as on the page: what a slice leaves behind must not matter, and its first picture takes seconds. */
const lab = new wasm.Lab();

/** The native program; test.sh says where it is. */
const program = process.env.OVERCOAT ?? fileURLToPath(new URL("../../../target/release/overcoat", import.meta.url));

/** Rows of the program for a command of the page. */
function native(state) {
  const words = command(state).split(" ").slice(1);
  return JSON.parse(execFileSync(program, [...words, "--json", "--threads", "1"], { encoding: "utf8" })).rows;
}

/** The slice of a state as the page measures it, its walks in parts. */
function measured(state, parts) {
  const setup = fill(new wasm.Setup(), state);
  const values = Array.from(lab.begin(setup));
  const models = values.map((_, k) => Array.from(lab.models(k)));
  let truth;
  for (const count of parts) truth = values.map((_, k) => Array.from(lab.walk(k, count)));
  return { values, models, truth };
}

/** States that go through every control. */
const STATES = {
  defaults: {},
  "a slice over the light": {
    over: "light", view: 40, base: "metal", color: [0.9, 0.6, 0.3], "coat-roughness": 0.5, "base-roughness": 0.35,
  },
  "what is seen, below a soft box": {
    base: "seen", "base-ior": 1.7, light: "overhead", coat: 0.8, "coat-roughness": 0.3, color: [0.1, 0.3, 0.6],
  },
  "a coat that absorbs": {
    light: "direct", angle: -20, extinction: [0.1, 0.4, 1], thickness: 0.5, base: "convention", "coat-ior": 1.9,
  },
  thickness: { over: "thickness", extinction: [0.1, 0.4, 1], base: "metal", models: ["stacklit"] },
  "index of the base": { over: "base-ior", view: 0, specular: 0.5, models: [] },
  "index of a base that has none": { over: "base-ior", base: "lambert", "base-ior": 2, specular: 0.5 },
  "every model over the roughness": { over: "coat-roughness", "base-ior": 1.6, models: MODELS, steps: 18, parts: [256, 256] },
};

test("names and ranges are the program's", () => {
  assert.deepEqual([...MODELS].sort(), wasm.models().split(",").sort());
  assert.deepEqual(BASES, [...wasm.bases().split(","), "metal"]);
  const quantities = Object.entries(OVER).map(([name, [first, last]]) => `${name} ${first} ${last}`);
  assert.equal(quantities.join(","), wasm.quantities());
  assert.equal(CONFIDENCE_95, wasm.confidence());
});

for (const [name, values] of Object.entries(STATES)) {
  test(`${name}: the same bits as the program's`, () => {
    const { parts, ...chosen } = { parts: [256, 512, 256], ...values };
    const state = { ...defaults(), samples: parts.reduce((sum, n) => sum + n), ...chosen };
    const expected = native(state);
    // Another slice before changes nothing, and neither do the parts.
    measured(defaults(), [256]);
    const found = measured(state, parts);
    assert.deepEqual(found.values, expected.map((row) => row.value));
    for (const [k, row] of expected.entries()) {
      assert.deepEqual(found.truth[k], [...row.truth, ...row.standard_error, ...row.truth_coat], `value ${row.value}`);
      // Without any the program takes its own choice.
      if (state.models.length === 0) continue;
      assert.deepEqual(found.models[k], row.models.flatMap((model) => model.radiance), `value ${row.value}`);
      assert.deepEqual(row.models.map((model) => model.model), state.models);
    }
  });

  test(`${name}: the address keeps it`, () => {
    const { parts: _, ...chosen } = values;
    const state = { ...defaults(), ...chosen };
    const kept = fromHash(`#${toHash(state)}`);
    assert.deepEqual({ ...kept, models: [...kept.models].sort() }, { ...state, models: [...state.models].sort() });
  });
}

test("addresses that nobody has made are no trouble", () => {
  assert.equal(toHash(defaults()), "");
  const hostile = ["#", "#coat", "#coat=", "#coat=7", "#coat=NaN", "#base=wood", "#color=1,2,3", "#color=0.1,0.2", "#models=x,y",
    "#__proto__=1", "#constructor=1", "#steps=3", "#steps=35.5", "#samples=1e9", "#view=-1&=&&=3"];
  for (const hash of hostile) {
    const state = fromHash(hash);
    if (hash !== "#models=x,y") assert.deepEqual(state, defaults(), hash);
    assert.equal(measured({ ...state, samples: 256 }, [256]).values.length, 35, hash);
  }
  assert.deepEqual(fromHash("#models=x,three").models, ["three"]);
});

test("every end of every slider can be measured", () => {
  const ends = Object.entries(NUMBERS).flatMap(([name, [, least, most]]) => [{ [name]: least }, { [name]: most }]);
  const grey = (value) => [value, value, value];
  const colors = Object.entries(COLORS).flatMap(([name, [, least, most]]) => [{ [name]: grey(least) }, { [name]: grey(most) }]);
  for (const end of [...ends, ...colors]) {
    for (const base of BASES) {
      const light = "angle" in end ? "direct" : "white";
      const state = { ...defaults(), ...end, base, light, steps: 2, models: ["stacklit", "stacklit-d"] };
      const { truth, models } = measured(state, [256]);
      assert.ok([...truth, ...models].flat().every(Number.isFinite), JSON.stringify({ ...end, base }));
    }
  }
});

test("what is out of range is named, and the slice before stays", () => {
  measured(defaults(), [256]);
  assert.throws(() => lab.begin(fill(new wasm.Setup(), { ...defaults(), coat: 7 })), /coat is 7; possible is 0 to 1/);
  assert.throws(() => lab.begin(fill(new wasm.Setup(), { ...defaults(), "coat-roughness": NaN })), /alpha is NaN/);
  assert.equal(lab.walk(34, 256).length, 9);
  assert.throws(() => lab.walk(35, 256), /no value '35'/);
  assert.throws(() => lab.walk(34, 0), /at least one/);
  assert.throws(() => fill(new wasm.Setup(), { ...defaults(), steps: 1e9 }), /steps is 1000000000; possible is 2 to 1000/);
  assert.throws(() => fill(new wasm.Setup(), { ...defaults(), models: ["wood"] }), /no model 'wood'/);
  assert.throws(() => fill(new wasm.Setup(), { ...defaults(), base: "wood" }), /no base 'wood'/);
});

test("figures: luminance, errors, intervals", () => {
  assert.ok(Math.abs(pick("luminance", [9, 1, 1, 1], 1) - 1) < 1e-15);
  assert.equal(pick("blue", [9, 1, 2, 3], 1), 3);
  const truth = [[0.5, 0.5, 0.5, 0.1, 0.1, 0.1, 0, 0, 0], [0, 0, 0, 0, 0, 0, 0, 0, 0]];
  const slice = { values: [0, 1], models: [[0.75, 0.75, 0.75, 0.25, 0.25, 0.25], [1, 1, 1, 1, 1, 1]], truth };
  const table = rows(slice, "green");
  assert.equal(table[0].half, 0.1 * CONFIDENCE_95);
  // Darkness has no relative error.
  assert.deepEqual(meanError(table, 0), { size: 0.5, bias: 0.5 });
  assert.deepEqual(meanError(table, 1), { size: 0.5, bias: -0.5 });
  const shown = radiance(table);
  assert.equal(shown.ys[1], 1.08);
  assert.deepEqual(shown.band[0], [0, 0.5 + table[0].half]);
  assert.deepEqual(errors(table).models, [[[0, 50]], [[0, -50]]]);
  const blank = rows({ ...slice, truth: undefined }, "green");
  assert.equal(meanError(blank, 0), undefined);
  assert.deepEqual(radiance(blank).referee, []);
});
