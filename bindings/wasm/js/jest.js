// import "overcoat/jest": expect(image).toMatchOvercoatGolden("name") in Jest, which has to run ES modules
// (NODE_OPTIONS=--experimental-vm-modules).
import { expect } from "@jest/globals";
import { matchers } from "./golden.js";

expect.extend(matchers);
