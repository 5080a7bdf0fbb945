// <overcoat-image src="model.glb" alt="A red car"></overcoat-image>: a picture of a 3D file, drawn when it is seen.
import { load } from "./index.js";
import { qualities, shadingModels } from "./names.js";

/** Attributes that are keys of a description, and how their text is read. */
const text = (value) => value;
const number = (value) => (value.trim() === "" || Number.isNaN(Number(value)) ? value : Number(value));
const KEYS = {
  shading: text,
  quality: text,
  background: text,
  ground: text,
  "tone-mapping": text,
  exposure: number,
  material: text,
  env: text,
  "env-rotation-deg": number,
  "env-intensity": number,
  samples: number,
  animation: number,
  time: number,
  up: text,
};
/** Attributes of the camera. */
const CAMERA = { view: text, "fov-y-deg": number, "ortho-height": number };
/** A change of these is another model. */
const SOURCES = ["src", "env"];

const STYLE = `
  :host { display: inline-block; position: relative; width: 256px; aspect-ratio: 1; }
  :host([hidden]) { display: none; }
  canvas { width: 100%; height: 100%; display: block; }
  [part="error"] { display: none; position: absolute; inset: 0; overflow: auto; font: 14px/1.4 system-ui, sans-serif; padding: 1em; }
  :host([state="error"]) [part="error"] { display: block; }
  :host([state="error"]) canvas { visibility: hidden; }
`;

const fetchBytes = async (url, signal) => {
  const response = await fetch(url, { signal });
  if (!response.ok) throw new Error(`${url}: ${response.status} ${response.statusText}`);
  return new Uint8Array(await response.arrayBuffer());
};

const Base = globalThis.HTMLElement ?? class {};

/** The element. `image` is the picture that is shown, `state` one of "waiting", "drawing", "done" and "error". */
export class OvercoatImageElement extends Base {
  static observedAttributes = [...SOURCES, ...Object.keys(KEYS), ...Object.keys(CAMERA), "alt", "width", "height"];

  #canvas;
  #message;
  #model;
  #seen = false;
  #cancel;
  #queued = false;
  #watching = [];
  #drawnSide = "";
  image;

  connectedCallback() {
    if (!this.shadowRoot) {
      this.attachShadow({ mode: "open" }).innerHTML =
        `<style>${STYLE}</style><canvas part="image" role="img"></canvas><div part="error" role="alert"><slot name="error"></slot><span></span></div>`;
      this.#canvas = this.shadowRoot.querySelector("canvas");
      this.#message = this.shadowRoot.querySelector("span");
    }
    this.#label();
    this.#measure();
    this.state = "waiting";
    const seen = new IntersectionObserver((entries) => {
      this.#seen = entries.at(-1).isIntersecting;
      if (this.#seen) this.redraw();
    });
    const sized = new ResizeObserver(() => this.#side().join() !== this.#drawnSide && this.redraw());
    this.#watching = [seen, sized];
    for (const watcher of this.#watching) watcher.observe(this);
  }

  disconnectedCallback() {
    for (const watcher of this.#watching) watcher.disconnect();
    this.#seen = false;
    this.#cancel?.abort();
    this.#forget();
  }

  attributeChangedCallback(name, before, after) {
    if (before === after || !this.shadowRoot) return;
    if (name === "alt") return this.#label();
    if (name === "width" || name === "height") this.#measure();
    if (SOURCES.includes(name)) this.#forget();
    this.#drawnSide = "";
    this.redraw();
  }

  get state() {
    return this.getAttribute("state") ?? "waiting";
  }

  set state(state) {
    this.setAttribute("state", state);
  }

  /** Draws anew, once whatever else changes in this turn has changed, if the element is seen. */
  redraw() {
    if (this.#queued || !this.#seen) return;
    this.#queued = true;
    queueMicrotask(() => {
      this.#queued = false;
      if (this.isConnected && this.#seen && this.#side().join() !== this.#drawnSide) this.#draw();
    });
  }

  async #draw() {
    const src = this.getAttribute("src");
    if (!src) return;
    this.#cancel?.abort();
    const cancel = (this.#cancel = new AbortController());
    const { signal } = cancel;
    const side = this.#side();
    this.#drawnSide = side.join();
    this.state = "drawing";
    try {
      this.#model ??= this.#open(src);
      const model = await this.#model;
      signal.throwIfAborted();
      const image = await model.render({ ...this.#options(), size: side, signal });
      if (signal.aborted) return;
      this.#canvas.width = image.width;
      this.#canvas.height = image.height;
      this.#canvas.getContext("2d").putImageData(image.toImageData(), 0, 0);
      this.image = image;
      this.state = "done";
      this.dispatchEvent(new Event("load"));
    } catch (error) {
      if (signal.aborted) return;
      this.image = undefined;
      // A file that could not be had may be there the next time.
      this.#forget();
      this.#message.textContent = error.message;
      this.state = "error";
      this.dispatchEvent(new ErrorEvent("error", { error, message: error.message }));
    }
  }

  async #open(src) {
    const env = this.getAttribute("env");
    const files = {};
    if (env && env !== "studio" && env !== "none") files[env] = await fetchBytes(new URL(env, document.baseURI));
    const url = new URL(src, document.baseURI);
    return load(await fetchBytes(url), { files });
  }

  #forget() {
    this.#model?.then((model) => model.free()).catch(() => {});
    this.#model = undefined;
  }

  #options() {
    const read = (keys) =>
      Object.fromEntries(
        Object.entries(keys)
          .filter(([name]) => this.hasAttribute(name))
          .map(([name, form]) => [name.replaceAll("-", "_"), form(this.getAttribute(name))]),
      );
    const options = read(KEYS);
    const camera = read(CAMERA);
    return Object.keys(camera).length > 0 ? { ...options, camera } : options;
  }

  /** Pixels of the screen, at most what the renderer draws. */
  #side() {
    const { width, height } = this.getBoundingClientRect();
    return [width, height].map((side) => Math.max(1, Math.min(8192, Math.round(side * devicePixelRatio))));
  }

  #measure() {
    for (const name of ["width", "height"]) {
      const pixels = Number(this.getAttribute(name));
      this.style[name] = this.hasAttribute(name) && pixels > 0 ? `${pixels}px` : "";
    }
    this.style.aspectRatio = this.hasAttribute("width") && this.hasAttribute("height") ? "auto" : "";
  }

  #label() {
    this.#canvas?.setAttribute("aria-label", this.getAttribute("alt") ?? "");
  }

  static shadingModels = shadingModels;
  static qualities = qualities;
}

if (globalThis.customElements && !customElements.get("overcoat-image")) {
  customElements.define("overcoat-image", OvercoatImageElement);
}
