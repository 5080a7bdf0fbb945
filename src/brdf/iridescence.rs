//! Thin-film interference as Unity HDRP evaluates it.
