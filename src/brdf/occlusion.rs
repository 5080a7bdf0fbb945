//! Ambient and specular occlusion.
