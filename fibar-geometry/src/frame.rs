//! Rotation-minimising frames along a curve.
