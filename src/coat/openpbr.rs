//! The OpenPBR surface: coat over a metallic or glossy-diffuse base.
