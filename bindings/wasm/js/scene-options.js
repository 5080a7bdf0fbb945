// Options of what a Scene is asked: which keys of a description are the scene's, and which a call takes.
import { OvercoatError, what } from "./error.js";
import { describe, takeApart } from "./options.js";

const wrong = (message) => new OvercoatError(message, "options");

/** Keys of a description that are the scene's, and what sets them. */
const OF_THE_SCENE = {
  env: "setEnvironment()", env_rotation_deg: "setEnvironment()", env_intensity: "setEnvironment()",
  light: "addLight()", lights: "remove()", material: "setMaterial()", materials: "setMaterial()",
  animation: "addModel()", loop: "addModel()", up: "addModel()", time: "setPose()",
};

/** Options of a picture of a scene. */
export function pictureOptions(options) {
  const taken = takeApart(options);
  for (const [key, setter] of Object.entries(OF_THE_SCENE)) {
    if (key in taken.description) throw wrong(`${key}: is the scene's, by ${setter}`);
  }
  if (taken.files.length > 0) throw wrong("files: come with what refers to them, by addModel(), addMaterial() and setEnvironment()");
  return taken;
}

/** Options of a call that takes these keys of a description, and files. */
export function takeOwn(options, keys) {
  const { description, files } = takeApart(options);
  const known = [...keys, "files"];
  const unknown = Object.keys(options ?? {}).find((key) => options[key] !== undefined && !known.includes(key));
  if (unknown !== undefined) throw wrong(`${unknown}: there is no such key here; known are ${known.join(", ")}`);
  return { description, files };
}

/** A light as JSON. */
export function describeLight(light) {
  if (typeof light !== "object" || light === null || Array.isArray(light)) {
    throw wrong(`light: expected an object, found ${what(light)}`);
  }
  return describe(light);
}
