//! Area-weighted points of a surface.
