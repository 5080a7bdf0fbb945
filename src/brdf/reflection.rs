//! Directions in which environments are looked up.
