// Numbers of a slice as a plot and a table show them. No page and no WebAssembly.

const LUMINANCE = [0.2126, 0.7152, 0.0722];
const CHANNEL = { red: 0, green: 1, blue: 2 };

/** Standard errors to either side in an interval of 95 percent confidence. */
export const CONFIDENCE_95 = 1.959963984540054;

/** One number of three channels, beginning at a place of a list: luminance as the program has it (Rec. 709), or a channel. */
export function pick(channel, list, at = 0) {
  if (channel !== "luminance") return list[at + CHANNEL[channel]];
  return LUMINANCE[0] * list[at] + LUMINANCE[1] * list[at + 1] + LUMINANCE[2] * list[at + 2];
}

/**
 * Rows of a table, one for each value of what varies: the value, the referee's mean, half its interval, and each model. Before the first
 * walk mean and interval are undefined, and while models are not there yet there are none.
 */
export function rows({ values, models, truth }, channel) {
  return values.map((value, k) => ({
    value,
    mean: truth && pick(channel, truth[k]),
    half: truth && CONFIDENCE_95 * pick(channel, truth[k], 3),
    models: Array.from({ length: models ? models[k].length / 3 : 0 }, (_, m) => pick(channel, models[k], 3 * m)),
  }));
}

/** Mean relative error of model number m: without its sign, and with it. Where the referee sees nothing there is none. */
export function meanError(rows, m) {
  const lit = rows.filter((row) => row.mean > 0);
  if (lit.length === 0) return undefined;
  const errors = lit.map((row) => row.models[m] / row.mean - 1);
  const mean = (list) => list.reduce((sum, x) => sum + x, 0) / list.length;
  return { size: mean(errors.map(Math.abs)), bias: mean(errors) };
}

/** Radiance over the value, with room for all, but for no more than twice the referee's, as in the program's plots. */
export function radiance(rows) {
  const most = (list) => list.reduce((a, b) => (b > a ? b : a), 1e-6);
  const truth = most(rows.map((row) => row.mean ?? 0));
  const all = most(rows.flatMap((row) => [row.mean ?? 0, ...row.models]));
  const known = rows[0].mean !== undefined;
  return {
    ys: [0, 1.08 * (known ? Math.min(all, 2 * truth) : all)],
    models: rows[0].models.map((_, m) => rows.map((row) => [row.value, row.models[m]])),
    referee: known ? rows.map((row) => [row.value, row.mean]) : [],
    band: known ? outline(rows, (row) => row.mean, (row) => row.half) : undefined,
  };
}

/** Error of the models in percent of the referee's radiance, and the referee's own interval. */
export function errors(rows) {
  const lit = rows.filter((row) => row.mean > 0);
  if (lit.length === 0) return { ys: [-100, 100], models: [], referee: [], band: undefined };
  const models = rows[0].models.map((_, m) => lit.map((row) => [row.value, 100 * (row.models[m] / row.mean - 1)]));
  const all = models.flat().map(([, off]) => off);
  const [least, most] = [Math.max(-100, Math.min(-5, ...all)), Math.min(200, Math.max(5, ...all))];
  const room = 0.05 * (most - least);
  return {
    ys: [least - room, most + room],
    models,
    referee: lit.map((row) => [row.value, 0]),
    band: outline(lit, () => 0, (row) => (100 * row.half) / row.mean),
  };
}

/** The outline of an interval: along its upper edge and back along the lower one. */
function outline(rows, middle, half) {
  const edge = (sign) => (row) => [row.value, middle(row) + sign * half(row)];
  return [...rows.map(edge(1)), ...rows.map(edge(-1)).reverse()];
}
