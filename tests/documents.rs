//! What documents say of the tree and of the program.
//!
//! One binary of many files, each a promise: linking takes longer than most of them run.

mod architecture;
mod readme;
