//! Velvet after Ashikhmin and Premoze.
