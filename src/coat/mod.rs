//! Clear-coat materials exactly as published shading models evaluate them: one file per model.

pub mod urp;
