//! What the verifiers measure with.
//!
//! `verify-light`, `verify-clearance` and `verify-solids` judge the work of the stages that build on `fibar-geometry`
//! and `fibar-solid`. So that no mistake of those rooms can hide itself, nothing here is shared with them: curves,
//! distances and meshes are evaluated by other code, from the artefacts alone. No stage that makes something may
//! depend on this room.
//!
//! Read in this order: a [`bezier::Bezier`] is one piece of a fibre, a [`curve::Curve`] the whole of it, a
//! [`capsules::CapsuleTree`] encloses it; a [`contact::Contact`] is the shortest bridge between two things, a
//! [`bvh::Bvh`] finds it among many triangles, a [`surface::ClosedSurface`] also says on which side it is.

pub mod bezier;
pub mod capsules;
pub mod curve;
pub mod quadrature;

pub mod bvh;
pub mod contact;
pub mod surface;
