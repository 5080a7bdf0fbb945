//! GGX and its visibility in their textbook forms, isotropic and anisotropic, without any engine's guards.
