//! three.js r187: MeshPhysicalMaterial.
