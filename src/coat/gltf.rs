//! The Khronos glTF Sample Renderer's composition with clear coat.
