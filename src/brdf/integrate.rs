//! Directional albedo of specular and sheen lobes, integrated from their definition in double precision.
