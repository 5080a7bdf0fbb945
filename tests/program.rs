//! The command line program as its users meet it.
//!
//! One binary of many files, each a promise: linking takes longer than most of them run.

mod action;
mod cli;
mod corpus;
mod default_picture;
mod golden_command;
mod memory;
mod moving;
mod outputs;
mod sandbox;
mod terminals;
mod translate;
