// Curves as SVG: axes, a band for the interval of the referee, and lines.
const SVG = "http://www.w3.org/2000/svg";

/** Dashes of the first nine models, and of those beyond. */
const DASHES = ["", "7 4", "2 3"];

/** Stroke of the model of a number: colour, then dashes. */
export const stroke = (k) => ({ stroke: `var(--c${k % 9})`, "stroke-dasharray": DASHES[Math.floor(k / 9) % 3] });

/** An element of SVG. */
export function element(name, attributes = {}, text = "") {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  if (attributes.stroke) {
    // Attributes know no variables.
    made.removeAttribute("stroke");
    made.style.stroke = attributes.stroke;
  }
  made.textContent = text;
  return made;
}

/** Round steps of an axis: 1, 2 or 5 times a power of ten, about so many of them. */
export function ticks([first, last], about) {
  const rough = (last - first) / about;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = power * ([1, 2, 5].find((s) => s * power >= rough) ?? 10);
  const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const found = [];
  for (let k = Math.ceil(first / step - 1e-9); k * step <= last + 1e-9 * step; k++) found.push((k * step).toFixed(digits));
  return found;
}

/** Draws into an SVG element of the width of its place. `lines` have `points` of [x, y], `band` is a closed outline or nothing. */
export function draw(svg, { xs, ys, xLabel, yLabel, lines, band }) {
  const width = Math.max(280, svg.parentElement.clientWidth - 28);
  const height = Math.round(Math.min(440, Math.max(230, 0.58 * width)));
  const box = { left: 58, right: width - 10, top: 10, bottom: height - 44 };
  const place = ([first, last], from, to) => (value) => from + ((value - first) / (last - first)) * (to - from);
  const [x, y] = [place(xs, box.left, box.right), place(ys, box.bottom, box.top)];
  // Beyond the edge lines are cut off there.
  const within = (value) => Math.min(ys[1], Math.max(ys[0], value));
  const path = (points) => points.map(([a, b]) => `${x(a).toFixed(1)},${y(within(b)).toFixed(1)}`).join(" ");
  const parts = [];
  for (const tick of ticks(xs, width / 70)) {
    parts.push(element("line", { class: "grid", x1: x(tick), x2: x(tick), y1: box.top, y2: box.bottom }));
    parts.push(element("text", { x: x(tick), y: box.bottom + 17, "text-anchor": "middle" }, tick));
  }
  for (const tick of ticks(ys, height / 60)) {
    const zero = Number(tick) === 0 ? "zero" : "grid";
    parts.push(element("line", { class: zero, x1: box.left, x2: box.right, y1: y(tick), y2: y(tick) }));
    parts.push(element("text", { x: box.left - 7, y: y(tick) + 4, "text-anchor": "end" }, tick));
  }
  parts.push(element("text", { x: (box.left + box.right) / 2, y: height - 8, "text-anchor": "middle" }, xLabel));
  const middle = (box.top + box.bottom) / 2;
  parts.push(element("text", { transform: `translate(13 ${middle}) rotate(-90)`, "text-anchor": "middle" }, yLabel));
  if (band) parts.push(element("polygon", { class: "band", points: path(band) }));
  for (const { points, ...attributes } of lines) parts.push(element("polyline", { points: path(points), ...attributes }));
  svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
  svg.replaceChildren(...parts);
}
