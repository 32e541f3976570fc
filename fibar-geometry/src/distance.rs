//! Distance to a surface.
