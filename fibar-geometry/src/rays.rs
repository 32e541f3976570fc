//! Visibility rays by a BVH.
