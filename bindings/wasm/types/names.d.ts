// Made of crates/description/src/scene.schema.json by scripts/types.mjs.

export declare const shadingModels: readonly string[];
export declare const qualities: readonly string[];
export declare const toneCurves: readonly string[];
export declare const builtinMaterials: readonly string[];
export declare const backgrounds: readonly string[];
export declare const views: readonly string[];
