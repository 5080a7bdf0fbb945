/**
 * Why there is no picture. `code` is "options" (what was asked for is wrong), "input" (a file is, or something exceeds a
 * limit), "crash" (the module ended and was started anew; models are loaded again by themselves) or "golden" (a picture is
 * not as expected).
 */
export class OvercoatError extends Error {
  constructor(message, code = "input", options = undefined) {
    super(message, options);
    this.name = "OvercoatError";
    this.code = code;
  }
}

/** What a value is, for messages. */
export function what(value) {
  if (value === null) return "null";
  if (value === undefined) return "nothing";
  if (typeof value === "string") return "a string";
  if (Array.isArray(value)) return "an array";
  if (typeof value === "object") return `an object (${value.constructor?.name ?? "without a class"})`;
  return typeof value === "function" ? "a function" : `a ${typeof value} (${String(value)})`;
}
