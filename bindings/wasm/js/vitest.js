// import "overcoat/vitest": expect(image).toMatchOvercoatGolden("name") in Vitest.
import { expect } from "vitest";
import { matchers } from "./golden.js";

expect.extend(matchers);
