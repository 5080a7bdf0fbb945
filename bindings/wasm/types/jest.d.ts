import type { OvercoatMatchers } from "./golden.js";

declare module "expect" {
  interface Matchers<R extends void | Promise<void>> extends OvercoatMatchers<R> {}
}
