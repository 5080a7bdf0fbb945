//! Unity HDRP Lit with clear coat.
