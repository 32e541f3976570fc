//! Solids: closed meshes, their booleans, sweeps along curves and insets.
//!
//! The one room with C++ in it: upstream Manifold behind a bridge of our own. It deliberately knows nothing of files,
//! stages or fibres; `sweep-solids` puts roles and LEDs together. Lengths mm, angles rad, right-handed.
//!
//! Results depend on the arguments alone: Manifold runs serially, callers may run it from many threads.

mod solid;

mod behind;
mod inset;
mod layer;
mod miter;
mod nearness;
mod tube;

mod elbow;
mod polyline;
mod runs;

mod ball;
mod grid;
mod specks;

mod bridge;
mod error;

pub use error::SolidError;
pub use grid::Grid;
pub use inset::{InsetOptions, inset};
pub use solid::Solid;
pub use tube::{Axis, AxisOptions, Layer};
