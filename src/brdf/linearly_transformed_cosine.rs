//! Light from polygons and lines by linearly transformed cosines.
