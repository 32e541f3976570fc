//! Pictures that stages publish.
//!
//! A [`Drawing`] is an orthographic view of the object with a depth buffer: meshes, balls, tubes. A [`Chart`] is a diagram of
//! curves. Both end on a [`Canvas`], which takes discs, lines, text and a legend, and becomes a PNG. Plain code on plain
//! numbers: the same picture has the same bytes on every machine. Nothing here reads or writes files.

#![warn(missing_docs)]

pub mod canvas;
pub mod chart;
pub mod colour;
pub mod drawing;
pub mod legend;
pub mod raster;
pub mod text;
pub mod view;

pub use canvas::Canvas;
pub use chart::Chart;
pub use colour::Colour;
pub use drawing::Drawing;
pub use view::View;
