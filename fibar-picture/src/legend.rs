//! Legends: what colours mean.

use crate::canvas::Canvas;
use crate::colour::{Colour, scale};
use crate::text::{Anchor, Letters};
use glam::DVec2;

/// Height of one line of a legend, px.
pub const LINE_PX: usize = 20;

impl Canvas {
    /// A row of named colours from a corner on; returns the column after the last.
    pub fn swatches(&mut self, entries: &[(&str, Colour)], [left, top]: [usize; 2]) -> usize {
        let [letter, _] = Letters::Small.cell();
        entries.iter().fold(left, |x, (name, colour)| {
            self.rectangle([x, top + 3], [14, 14], *colour);
            let at = DVec2::new(x as f64 + 20.0, (top + LINE_PX / 2) as f64);
            self.text(name, at, Anchor::Left, Letters::Small);
            x + 20 + letter * name.chars().count() + 16
        })
    }

    /// The scale of [`scale`] as a bar between two captions; returns the column after it.
    pub fn scale_bar(&mut self, [low, high]: [&str; 2], [left, top]: [usize; 2]) -> usize {
        const BAR_PX: usize = 160;
        let [letter, _] = Letters::Small.cell();
        let middle = (top + LINE_PX / 2) as f64;
        let bar = left + letter * low.chars().count() + 8;
        self.text(low, DVec2::new(left as f64, middle), Anchor::Left, Letters::Small);
        for x in 0..BAR_PX {
            self.rectangle([bar + x, top + 3], [1, 14], scale(x as f64 / (BAR_PX - 1) as f64));
        }
        self.text(high, DVec2::new((bar + BAR_PX + 8) as f64, middle), Anchor::Left, Letters::Small);
        bar + BAR_PX + 8 + letter * high.chars().count() + 16
    }
}
