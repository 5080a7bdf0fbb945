//! Diffuse reflectance: Lambert, Disney, and the wrapped cosine of transmitted light.
