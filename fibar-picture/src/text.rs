//! Text on a canvas, in the fixed-width letters of embedded-graphics.

use crate::canvas::Canvas;
use crate::colour::{Colour, INK};
use embedded_graphics::draw_target::DrawTarget;
use embedded_graphics::geometry::{OriginDimensions, Point, Size};
use embedded_graphics::mono_font::iso_8859_1::{FONT_7X13, FONT_10X20};
use embedded_graphics::mono_font::{MonoFont, MonoTextStyle};
use embedded_graphics::pixelcolor::BinaryColor;
use embedded_graphics::text::{Alignment, Baseline, Text, TextStyleBuilder};
use embedded_graphics::{Drawable, Pixel};
use glam::DVec2;

/// Height of a letter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Letters {
    /// 13 px, for ticks and legends.
    Small,
    /// 20 px, for headings.
    Large,
}

/// Which part of the text stands at the point given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// The middle of its left edge.
    Left,
    /// Its middle.
    Middle,
    /// The middle of its right edge.
    Right,
}

impl Letters {
    /// Size of one letter's cell, px.
    pub fn cell(self) -> [usize; 2] {
        let Size { width, height } = self.font().character_size;
        [width as usize, height as usize]
    }

    fn font(self) -> &'static MonoFont<'static> {
        match self {
            Letters::Small => &FONT_7X13,
            Letters::Large => &FONT_10X20,
        }
    }
}

impl Canvas {
    /// Writes one line of text. Letters beyond Latin-1 come out as question marks.
    pub fn text(&mut self, text: &str, at: DVec2, anchor: Anchor, letters: Letters) {
        let alignment = match anchor {
            Anchor::Left => Alignment::Left,
            Anchor::Middle => Alignment::Center,
            Anchor::Right => Alignment::Right,
        };
        let style = TextStyleBuilder::new().alignment(alignment).baseline(Baseline::Middle).build();
        let ink = MonoTextStyle::new(letters.font(), BinaryColor::On);
        let point = Point::new(at.x.round() as i32, at.y.round() as i32);
        let line = Text::with_text_style(text, point, ink, style);
        let Ok(_) = line.draw(&mut Ink { canvas: self, colour: INK });
    }
}

/// A canvas that letters are drawn on.
struct Ink<'a> {
    canvas: &'a mut Canvas,
    colour: Colour,
}

impl OriginDimensions for Ink<'_> {
    fn size(&self) -> Size {
        Size::new(self.canvas.width() as u32, self.canvas.height() as u32)
    }
}

impl DrawTarget for Ink<'_> {
    type Color = BinaryColor;
    type Error = std::convert::Infallible;

    fn draw_iter<I: IntoIterator<Item = Pixel<BinaryColor>>>(
        &mut self,
        pixels: I,
    ) -> Result<(), Self::Error> {
        for Pixel(point, on) in pixels {
            if let (BinaryColor::On, Ok(x), Ok(y)) = (on, usize::try_from(point.x), usize::try_from(point.y))
            {
                self.canvas.blend(x, y, self.colour, 1.0);
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// First and last inked column of a text.
    fn check(anchor: Anchor, expected: std::ops::Range<usize>) {
        let mut canvas = Canvas::new(100, 30);
        canvas.text("III", DVec2::new(50.0, 15.0), anchor, Letters::Large);
        let inked = |x: &usize| (0..30).any(|y| canvas.at(*x, y) == INK);
        let columns: Vec<usize> = (0..100).filter(inked).collect();
        let (first, last) = (columns[0], columns[columns.len() - 1]);
        assert!(expected.start <= first && last < expected.end, "{anchor:?}: columns {first} to {last}");
    }

    #[test]
    fn text_stands_at_its_anchor() {
        check(Anchor::Left, 50..80);
        check(Anchor::Middle, 35..65);
        check(Anchor::Right, 20..51);
    }
}
