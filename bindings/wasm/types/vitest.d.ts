import type { OvercoatMatchers } from "./golden.js";

declare module "vitest" {
  interface Matchers<T = any> extends OvercoatMatchers<T> {}
}
