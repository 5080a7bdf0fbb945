// A scene that is kept: models, meshes, materials, instances and lights come and go, and what is in it has handles.
import { isPicture, matrix, meshArrays, pictureBytes } from "./arrays.js";
import { OvercoatError, what } from "./error.js";
import { Handle, MaterialHandle, ModelHandle, checked } from "./handles.js";
import { hostFor } from "./hosts.js";
import { RenderedImage } from "./image.js";
import { bytesOf, describe, fileBytes } from "./options.js";
import { describeLight, pictureOptions, takeOwn } from "./scene-options.js";
import { World } from "./world.js";

const wrong = (message) => new OvercoatError(message, "options");

/** See `types/scene.d.ts`. */
export class Scene {
  #world;
  #options;
  #limits;
  /** What the last picture was asked for. */
  #last = {};

  /** `thread` is that of a renderer of its own. */
  constructor(options = {}, thread) {
    const { worker, limits } = pictureOptions(options);
    if (thread !== undefined && !thread?.run) throw wrong(`options: expected one object, found ${what(thread)} after it`);
    const { signal, worker: _, limits: __, ...others } = options;
    if (signal !== undefined) throw wrong("signal: is an option of render()");
    this.#options = others;
    this.#limits = limits;
    this.#world = new World(thread ?? hostFor(worker, undefined), limits);
  }

  /** A scene with one model in it. */
  static async load(bytes, options) {
    const scene = new Scene(options);
    await scene.addModel(bytes);
    return scene;
  }

  async addModel(bytes, options) {
    const { description, files } = takeOwn(options, ["transform", "animation", "time", "loop", "up", "material", "materials"]);
    const { transform, ...others } = description;
    if (others.animation !== undefined && (others.material ?? others.materials) !== undefined) {
      throw wrong("material: not of a model with an animation; setMaterial() changes those of its handles");
    }
    const rest = [describe(others), matrix("transform", transform)];
    const read = Promise.all([bytesOf(bytes, "the model", this.#limits), this.#files(files)]);
    return this.#world.addModel(new ModelHandle(this), read.then(([content, files]) => [content, ...rest, ...files]));
  }

  async addMesh(mesh) {
    return this.#world.make(new Handle("mesh", this), "add_mesh", meshArrays(mesh, this.#limits));
  }

  async addMaterial(source = null, options) {
    const { json, files } = this.#material(source, options);
    return this.#world.make(new MaterialHandle(this), "add_material", files.then((files) => [json, ...files]));
  }

  async addInstance(mesh, material, transform) {
    const args = [checked("mesh", mesh, this, "mesh"), checked("material", material, this, "material"), matrix("transform", transform)];
    return this.#world.make(new Handle("instance", this), "add_instance", args);
  }

  async addLight(light) {
    return this.#world.make(new Handle("light", this), "add_light", [describeLight(light)]);
  }

  async setTransform(handle, transform) {
    checked("handle", handle, this, "instance", "model");
    if (transform === undefined) throw wrong("transform: expected 16 numbers, column by column, found nothing");
    return this.#world.change(handle, "set_transform", [handle.kind, handle, matrix("transform", transform)]);
  }

  async setVisible(handle, visible) {
    checked("handle", handle, this, "instance", "model");
    if (typeof visible !== "boolean") throw wrong(`visible: expected true or false, found ${what(visible)}`);
    return this.#world.change(handle, "set_visible", [handle.kind, handle, visible]);
  }

  async setPose(model, seconds) {
    checked("model", model, this, "model");
    if (typeof seconds !== "number") throw wrong(`pose: expected seconds from 0 on, found ${what(seconds)}`);
    return this.#world.pose(model, seconds);
  }

  async setMesh(handle, mesh) {
    checked("handle", handle, this, "mesh");
    return this.#world.change(handle, "set_mesh", [handle, ...meshArrays(mesh, this.#limits)]);
  }

  async setMaterial(handle, source, options) {
    checked("handle", handle, this, "material");
    const { json, files, isWhole } = this.#material(source, options);
    return this.#world.change(handle, "set_material", files.then((files) => [handle, json, ...files]), isWhole);
  }

  async setInstanceMesh(instance, mesh) {
    const args = [checked("instance", instance, this, "instance"), checked("mesh", mesh, this, "mesh")];
    return this.#world.changeSubstance(instance, "set_instance_mesh", args);
  }

  async setInstanceMaterial(instance, material) {
    const args = [checked("instance", instance, this, "instance"), checked("material", material, this, "material")];
    return this.#world.changeSubstance(instance, "set_instance_material", args);
  }

  async setLight(handle, light) {
    checked("handle", handle, this, "light");
    return this.#world.change(handle, "set_light", [handle, describeLight(light)]);
  }

  async setEnvironment(options) {
    const { description, files } = takeOwn(options, ["env", "env_rotation_deg", "env_intensity"]);
    if (Object.keys(description).length === 0) throw wrong("options: expected env, env_rotation_deg or env_intensity");
    describe(description);
    return this.#world.environment(description, this.#files(files));
  }

  async remove(handle) {
    checked("handle", handle, this, "model", "instance", "mesh", "material", "light");
    return this.#world.remove(handle);
  }

  async getTransform(handle) {
    checked("handle", handle, this, "instance", "model");
    return this.#world.ask("transform", [handle.kind, handle]);
  }

  async render(options = {}) {
    const { request, signal, given } = this.#picture(options);
    signal?.throwIfAborted();
    const result = await this.#world.draw(request, signal);
    this.#last = given;
    return new RenderedImage(this.#world.host, result);
  }

  async pick(x, y, options) {
    const { request, signal } = this.#picture(options ?? this.#last);
    for (const [name, value] of [["x", x], ["y", y]]) {
      if (!Number.isInteger(value) || value < 0 || value >= 2 ** 32) {
        throw wrong(`${name}: expected a whole number of pixels from 0 on, found ${typeof value === "number" ? value : what(value)}`);
      }
    }
    return this.#world.pick({ description: request.description, x, y }, signal);
  }

  free() {
    this.#world.free();
  }

  [Symbol.dispose ?? Symbol("dispose")]() {
    this.free();
  }

  #picture(options) {
    if (typeof options !== "object" || options === null) throw wrong(`options: expected an object, found ${what(options)}`);
    for (const key of ["worker", "limits"]) {
      if (options[key] !== undefined) throw wrong(`${key}: is an option of the scene`);
    }
    const { description, aovs, linear, signal } = pictureOptions({ ...this.#options, ...options });
    const { signal: _, ...given } = options;
    return { request: { description: describe(description), aovs, linear }, signal, given };
  }

  #material(source, options) {
    const { files } = takeOwn(options, []);
    if (source !== null && typeof source !== "string" && (typeof source !== "object" || Array.isArray(source))) {
      throw wrong(`material: expected a name, an object or null, found ${what(source)}`);
    }
    // What is laid over another needs it, and whether a file is, the library knows.
    const isWhole = typeof source !== "string" && source?.over !== true;
    const pictures = [];
    const json = typeof source === "string" ? JSON.stringify(source) : describe(this.#named(source, pictures));
    const all = this.#files(files).then(([names, contents]) => {
      return [[...names, ...pictures.map(([name]) => name)], [...contents, ...pictures.map(([, content]) => content)]];
    });
    return { json, files: all, isWhole };
  }

  /** The keys of a material with names in place of pictures of numbers. */
  #named(source, pictures) {
    if (source === null) return null;
    const name = (key, picture) => {
      // No file has such a name.
      pictures.push([`array/${pictures.length}`, pictureBytes(key, picture, this.#limits)]);
      return pictures.at(-1)[0];
    };
    const of = ([key, value]) => {
      if (!key.endsWith("_texture")) return [key, value];
      if (isPicture(value)) return [key, name(key, value)];
      return [key, isPicture(value?.file) ? { ...value, file: name(key, value.file) } : value];
    };
    return Object.fromEntries(Object.entries(source).map(of));
  }

  /** Names and contents. */
  async #files(files) {
    const read = await fileBytes({ files, limits: this.#limits });
    return [read.map(([name]) => name), read.map(([, content]) => content)];
  }
}
