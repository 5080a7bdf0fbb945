//! Velvet after Ashikhmin and Premoze with anisotropic GGX.
