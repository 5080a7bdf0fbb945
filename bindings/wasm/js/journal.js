// What was done to a scene, as far as it still counts: a module that was started anew is brought to the same state by it.

/** Numbers of keys that nothing takes the place of. */
let last = 0;
const unique = () => `entry ${++last}`;

/** Made before everything else: they need nothing, and have no place in the order of drawing. */
const isSubstance = ({ makes }) => makes?.kind === "mesh" || makes?.kind === "material";

/**
 * Entries `{ operation, args, makes, about, parts }`: what the module is asked, with handles among the arguments; the handle that
 * it makes, or the one that it changes; handles of a model's parts that came with it.
 */
export class Journal {
  #entries = new Map();
  /** The model of each part. */
  #owners = new Map();
  /** What was done before a removal that is an entry of its own stays. */
  #barrier = 0;

  /** In the order in which they are to be done. */
  *[Symbol.iterator]() {
    const all = [...this.#entries.values()];
    yield* all.filter(isSubstance);
    yield* all.filter((entry) => !isSubstance(entry));
  }

  /** The model that a handle is a part of. */
  owner(handle) {
    return this.#owners.get(handle);
  }

  /** Adds an entry. It takes the place of the last one with the same key. */
  add(entry, key = unique()) {
    for (const part of entry.parts ?? []) this.#owners.set(part, entry.makes ?? entry.about);
    const place = `${this.#barrier} ${key}`;
    this.#entries.delete(place);
    this.#entries.set(place, entry);
  }

  /** Another mesh or material (`argument` 0 or 1) of an instance. One that was made of both begins with it. */
  addSubstance(entry, key, argument) {
    const [instance, substance] = entry.args;
    const made = [...this.#entries.values()].find(({ makes }) => makes === instance);
    if (made === undefined || this.#owners.has(substance)) return this.add(entry, key);
    made.args = made.args.with(argument, substance);
    this.#entries.delete(`${this.#barrier} ${key}`);
  }

  /** A pose takes the place of the one before, unless that has brought parts, or some were changed since. */
  addPose(entry, key) {
    const all = [...this.#entries];
    const before = this.#entries.get(`${this.#barrier} ${key}`);
    if (before !== undefined) {
      const since = all.slice(all.findIndex(([, other]) => other === before) + 1);
      if (before.parts.length > 0 || since.some(([, { about }]) => this.#owners.get(about) === entry.about)) {
        this.#entries = new Map(all.map(([name, other]) => [other === before ? unique() : name, other]));
      }
    }
    this.add(entry, key);
  }

  /** Takes out all that is about a handle and its parts; or adds the removal, if something else was made of them. */
  remove(handle, entry) {
    const isOf = (other) => other !== undefined && (other === handle || this.#owners.get(other) === handle);
    const isAbout = ({ makes, about }) => isOf(makes) || isOf(about);
    const isUsed = [...this.#entries.values()].some((other) => !isAbout(other) && other.args.some(isOf));
    if (isUsed || this.#owners.has(handle)) {
      this.add(entry);
      if (isUsed) this.#barrier++;
      return;
    }
    for (const [key, other] of this.#entries) if (isAbout(other)) this.#entries.delete(key);
    for (const part of [...this.#owners.keys()].filter(isOf)) this.#owners.delete(part);
  }
}
