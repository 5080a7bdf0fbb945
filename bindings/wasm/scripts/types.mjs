// Types and names from the schema of scene files, so that there is one list of keys, values and sentences.
//
// Usage: node scripts/types.mjs [--check]
import { readFileSync, writeFileSync } from "node:fs";

const here = new URL(".", import.meta.url);
const schema = JSON.parse(readFileSync(new URL("../../../crates/description/src/scene.schema.json", here)));

const literal = (value) => JSON.stringify(value);
const comment = (text, indent) => (text ? `${indent}/** ${text}. */\n` : "");

function type(of, indent) {
  if (of.enum) return of.enum.map(literal).join(" | ");
  if (of.const !== undefined) return literal(of.const);
  const choices = of.anyOf ?? of.oneOf;
  if (choices) {
    const names = choices.map((choice) => type(choice, indent));
    // A pattern beside names: editors offer the names, and everything else is allowed.
    const open = names.map((name) => (name === "string" && names.some((n) => n.startsWith('"')) ? "(string & {})" : name));
    return [...new Set(open)].join(" | ");
  }
  switch (of.type) {
    case "string":
      return of.examples ? [...of.examples.map(literal), "(string & {})"].join(" | ") : "string";
    case "integer":
    case "number":
      return "number";
    case "boolean":
      return "boolean";
    case "array": {
      const item = type(of.items, indent);
      if (of.minItems && of.minItems === of.maxItems) return `[${Array(of.minItems).fill(item).join(", ")}]`;
      return /[|&]/.test(item) ? `(${item})[]` : `${item}[]`;
    }
    case "object":
      if (of.properties) return table(of, indent);
      return `Record<string, ${type(of.additionalProperties, indent)}>`;
    default:
      return "unknown";
  }
}

function table(of, indent) {
  const inner = `${indent}  `;
  const required = new Set(of.required ?? []);
  const members = Object.entries(of.properties).map(([name, value]) => {
    return `${comment(value.description, inner)}${inner}${name}${required.has(name) ? "" : "?"}: ${type(value, inner)};\n`;
  });
  return `{\n${members.join("")}${indent}}`;
}

const generated = "// Made of crates/description/src/scene.schema.json by scripts/types.mjs.\n\n";
const properties = { ...schema.properties };
// Of a file: in JavaScript the model comes as bytes.
delete properties.model;
const types = `${generated}/** What a picture shows and how: the keys of scene files, but for the model. Every key may be left out. */
export interface Description ${table({ ...schema, properties }, "")}
`;

const { shading, quality, tone_mapping, material, background, camera } = schema.properties;
const enums = (of) => of.enum ?? of.anyOf.find((choice) => choice.enum).enum;
const lists = {
  shadingModels: enums(shading),
  qualities: enums(quality),
  toneCurves: enums(tone_mapping),
  builtinMaterials: enums(material),
  backgrounds: enums(background),
  views: enums(camera.properties.view),
};
const names =
  generated +
  Object.entries(lists)
    .map(([name, values]) => `export const ${name} = Object.freeze(${JSON.stringify(values, null, 2)});\n`)
    .join("\n");
const nameTypes =
  generated + Object.entries(lists).map(([name]) => `export declare const ${name}: readonly string[];\n`).join("");

for (const [path, text] of [["../types/description.d.ts", types], ["../js/names.js", names], ["../types/names.d.ts", nameTypes]]) {
  const file = new URL(path, here);
  if (process.argv.includes("--check")) {
    if (readFileSync(file, "utf8") !== text) {
      console.error(`${path}: is not what the schema says; node scripts/types.mjs makes it anew`);
      process.exitCode = 1;
    }
  } else {
    writeFileSync(file, text);
  }
}
