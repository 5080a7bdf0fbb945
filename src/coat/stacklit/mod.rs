//! Unity HDRP StackLit: two lobes and diffuse under a coat, combined by the adding operator.

pub mod haze;
