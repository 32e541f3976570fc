//! NURBS curves.
