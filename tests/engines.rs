//! Shading models against numbers of the engines' own code.
//!
//! A binary apart from the other tests of models, so that both compile at the same time: either is one large unit of code.

mod reference;
mod tables;
