//! The law of light integrated along a curve.
