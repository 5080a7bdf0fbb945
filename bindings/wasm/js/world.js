// What a Scene is in the module: changed in the order in which it was asked, and made again where the module was started anew.
import { LOST } from "./engine.js";
import { OvercoatError } from "./error.js";
import { Handle, MaterialHandle, Names } from "./handles.js";
import { Journal } from "./journal.js";

let worlds = 0;

/** The part of a model that a list of the module names. */
const PARTS = { instance: "instances", material: "materials", light: "lights" };

/** What is promised, or at once the reason of a signal, however long it has to wait for its turn. */
function orAborted(signal, done) {
  if (signal === undefined) return done;
  return new Promise((resolve, reject) => {
    const stop = () => reject(signal.reason);
    signal.addEventListener("abort", stop, { once: true });
    done.then(resolve, reject).finally(() => signal.removeEventListener("abort", stop));
  });
}

export class World {
  host;
  #id = ++worlds;
  #limits;
  #journal = new Journal();
  #names = new Names();
  /** Whether the module has all of the journal. */
  #isWhole = false;
  #isFreed = false;
  #tail = Promise.resolve();
  /** What was said of the environment. */
  #environment = { description: {}, files: [[], []] };

  constructor(host, limits) {
    this.host = host;
    this.#limits = limits;
  }

  /** Adds what has a handle. `args`, here and below, is an array or the promise of one. */
  make(handle, operation, args) {
    return this.#next(args, async (args) => {
      const entry = { operation, args, makes: handle };
      this.#done(entry, await this.#send(entry));
      this.#journal.add(entry);
      return handle;
    });
  }

  addModel(model, args) {
    return this.#next(args, async (args) => {
      const entry = { operation: "add_model", args, makes: model, parts: [] };
      this.#done(entry, await this.#send(entry));
      this.#journal.add(entry);
      return model;
    });
  }

  /** Changes what has a handle. What is not `isWhole` needs what was done before. */
  change(handle, operation, args, isWhole = true) {
    return this.#next(args, async (args) => {
      const entry = { operation, args, about: handle };
      await this.#send(entry);
      this.#journal.add(entry, isWhole ? this.#key(entry) : undefined);
    });
  }

  changeSubstance(instance, operation, args) {
    return this.#next(args, async (args) => {
      const entry = { operation, args, about: instance };
      await this.#send(entry);
      this.#journal.addSubstance(entry, this.#key(entry), operation === "set_instance_mesh" ? 0 : 1);
    });
  }

  pose(model, seconds) {
    return this.#next([model, seconds], async (args) => {
      const entry = { operation: "set_pose", args, about: model, parts: [] };
      this.#done(entry, await this.#send(entry));
      this.#journal.addPose(entry, this.#key(entry));
    });
  }

  environment(description, files) {
    return this.#next(files, async (files) => {
      const own = this.#environment;
      await this.#send({ operation: "set_environment", args: [JSON.stringify(description), ...files] });
      this.#environment = { description: { ...own.description, ...description }, files: "env" in description ? files : own.files };
      const args = [JSON.stringify(this.#environment.description), ...this.#environment.files];
      this.#journal.add({ operation: "set_environment", args }, "environment");
    });
  }

  remove(handle) {
    return this.#next([handle.kind, handle], async (args) => {
      const entry = { operation: "remove", args, about: handle };
      this.#done(entry, await this.#send(entry));
      this.#journal.remove(handle, entry);
    });
  }

  /** Asks something that changes nothing. */
  ask(operation, args) {
    return this.#next(args, (args) => this.#send({ operation, args }));
  }

  draw(request, signal) {
    return orAborted(signal, this.#next([], () => this.#ask("drawWorld", () => request, { signal })));
  }

  pick(request, signal) {
    const picked = this.#next([], async () => {
      const hit = JSON.parse(await this.#ask("pick", () => request, { signal }));
      if (hit === null) return null;
      const of = (kind) => (hit[kind] === null ? null : (this.#names.handle(kind, hit[kind]) ?? null));
      return { ...hit, instance: of("instance"), model: of("model"), material: of("material") };
    });
    return orAborted(signal, picked);
  }

  free() {
    if (this.#isFreed) return;
    this.#isFreed = true;
    this.#journal = new Journal();
    this.host.run("freeWorld", { id: this.#id }).catch(() => {});
  }

  /** Does something after all that was asked before. */
  #next(args, work) {
    const given = Promise.resolve(args);
    // It is looked at when its turn has come.
    given.catch(() => {});
    const done = this.#tail.then(async () => work(await given));
    this.#tail = done.catch(() => {});
    return done;
  }

  #key({ operation, about }) {
    return `${operation} ${about.number}`;
  }

  /** An entry, with the numbers that its handles have now. */
  #send({ operation, args }) {
    const numbers = () => args.map((value) => (Handle.is(value) ? this.#names.number(value) : value));
    return this.#ask("change", () => ({ name: operation, args: numbers() }));
  }

  /** Asks the module, which is given the scene first if it has been started anew, before or while it is asked. */
  async #ask(operation, request, options) {
    for (;;) {
      options?.signal?.throwIfAborted();
      if (this.#isFreed) throw new OvercoatError("the scene was freed", "options");
      try {
        if (!this.#isWhole) await this.#restore();
        return await this.host.run(operation, { id: this.#id, ...request() }, options);
      } catch (error) {
        if (error?.code !== LOST) throw error;
        this.#isWhole = false;
      }
    }
  }

  async #restore() {
    const id = this.#id;
    await this.host.run("beginWorld", { id, limits: this.#limits });
    this.#names = new Names();
    for (const entry of this.#journal) {
      const args = entry.args.map((value) => (Handle.is(value) ? this.#names.number(value) : value));
      this.#done(entry, await this.host.run("change", { id, name: entry.operation, args }));
    }
    this.#isWhole = true;
  }

  /** Takes the names from what the module has answered. */
  #done(entry, answer) {
    const { operation, makes, about, parts } = entry;
    if (parts !== undefined) this.#takeParts(entry, JSON.parse(answer));
    else if (makes !== undefined) this.#names.add(makes, answer);
    else if (operation === "remove") {
      const model = this.#journal.owner(about);
      const list = PARTS[about.kind];
      if (model !== undefined) model[list] = model[list].filter((part) => part !== about);
      this.#names.delete(about);
    }
  }

  #takeParts({ makes, about, parts }, found) {
    const model = makes ?? about;
    if (makes !== undefined) {
      this.#names.add(model, BigInt(found.model));
      model.info = found.info;
    }
    // When it is done again, what comes has its handles.
    let known = 0;
    const take = (kind, number, make) => {
      const own = this.#names.handle(kind, number);
      if (own !== undefined) return own;
      const part = (parts[known] ??= make());
      known++;
      this.#names.add(part, BigInt(number));
      return part;
    };
    const of = (kind) => (number) => take(kind, number, () => new Handle(kind, model.scene));
    model.instances = found.instances.map(of("instance"));
    model.materials = found.materials.map(([number, name]) => take("material", number, () => new MaterialHandle(model.scene, name)));
    model.lights = found.lights.map(of("light"));
    model.duration = found.duration;
  }
}
