//! Filament's standard and cloth models with clear coat, as its shaders are today.
