//! Thin-film interference as three.js and the Khronos renderer evaluate it (KHR_materials_iridescence).
