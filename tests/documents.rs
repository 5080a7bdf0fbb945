//! Documents tell the truth about the tree and the program.
//!
//! One binary of many files, each a promise: linking takes longer than most of them run.

mod addresses;
mod architecture;
mod book;
mod links;
mod pages;
mod readme;
mod wording;
