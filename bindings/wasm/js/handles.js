// Names of what is in a scene, which stay while other things come and go.
import { OvercoatError, what } from "./error.js";

/** "an instance", for messages. */
const a = (kind) => (/^[aeiou]/.test(kind) ? `an ${kind}` : `a ${kind}`);

let handles = 0;

/** Names a part of one scene until it is removed. */
export class Handle {
  #scene;
  #kind;
  #number = ++handles;

  constructor(kind, scene) {
    this.#kind = kind;
    this.#scene = scene;
  }

  /** "model", "instance", "mesh", "material" or "light". */
  get kind() {
    return this.#kind;
  }

  /** The scene that it is in. */
  get scene() {
    return this.#scene;
  }

  /** @internal */
  get number() {
    return this.#number;
  }

  static is(value) {
    return typeof value === "object" && value !== null && #kind in value;
  }
}

/** A material, and what it is called in its file. */
export class MaterialHandle extends Handle {
  constructor(scene, name = "") {
    super("material", scene);
    this.name = name;
  }
}

/** A model: what it is, as of load(); its parts in the order of the file, and the seconds of its animation. */
export class ModelHandle extends Handle {
  instances = [];
  materials = [];
  lights = [];
  duration = null;
  info;

  constructor(scene) {
    super("model", scene);
  }
}

/** The handle, if it is one of that scene and of one of the kinds. */
export function checked(name, value, scene, ...kinds) {
  if (!Handle.is(value)) {
    throw new OvercoatError(`${name}: expected the handle of ${kinds.map(a).join(" or ")}, found ${what(value)}`, "options");
  }
  if (!kinds.includes(value.kind)) {
    throw new OvercoatError(`${name}: expected the handle of ${kinds.map(a).join(" or ")}, found that of ${a(value.kind)}`, "options");
  }
  if (value.scene !== scene) throw new OvercoatError(`${name}: the ${value.kind} is one of another scene`, "options");
  return value;
}

/** Handles of one world of the module, by their numbers there and the other way round. */
export class Names {
  #numbers = new Map();
  #handles = new Map();

  add(handle, number) {
    this.#numbers.set(handle, number);
    // Numbers are of one kind: an instance and a light may have the same.
    this.#handles.set(`${handle.kind} ${number}`, handle);
  }

  delete(handle) {
    this.#handles.delete(`${handle.kind} ${this.#numbers.get(handle)}`);
    this.#numbers.delete(handle);
  }

  number(handle) {
    const number = this.#numbers.get(handle);
    if (number === undefined) {
      throw new OvercoatError(`the ${handle.kind} is not there: it has been removed`, "options");
    }
    return number;
  }

  handle(kind, number) {
    return this.#handles.get(`${kind} ${number}`);
  }
}
