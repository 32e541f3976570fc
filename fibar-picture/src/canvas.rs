//! A picture in memory, and as PNG.
//!
//! Coordinates are pixels, x to the right, y down; the middle of the first pixel is (0.5, 0.5). What lies outside is cut off.

use crate::colour::{Colour, PAPER, mix};
use glam::DVec2;

/// Pixels, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Canvas {
    width: usize,
    pixels: Vec<Colour>,
}

impl Canvas {
    /// Blank paper.
    pub fn new(width: usize, height: usize) -> Canvas {
        Canvas::painted(width, height, |_| PAPER)
    }

    /// The picture whose pixel `k`, counted row by row, is `paint(k)`.
    pub fn painted(width: usize, height: usize, paint: impl Fn(usize) -> Colour) -> Canvas {
        Canvas { width, pixels: (0..width * height).map(paint).collect() }
    }

    /// Width, px.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Height, px.
    pub fn height(&self) -> usize {
        self.pixels.len().checked_div(self.width).unwrap_or(0)
    }

    /// The colour of a pixel inside the picture.
    pub fn at(&self, x: usize, y: usize) -> Colour {
        self.pixels[y * self.width + x]
    }

    /// Lays a colour over a pixel, `cover` of it: 1 hides what was there.
    pub fn blend(&mut self, x: usize, y: usize, colour: Colour, cover: f64) {
        if x < self.width && y < self.height() {
            let pixel = &mut self.pixels[y * self.width + x];
            *pixel = mix(colour, *pixel, cover.clamp(0.0, 1.0));
        }
    }

    /// Copies a picture to where its upper left corner shall be.
    pub fn paste(&mut self, other: &Canvas, [left, top]: [usize; 2]) {
        for y in 0..other.height() {
            (0..other.width).for_each(|x| self.blend(left + x, top + y, other.at(x, y), 1.0));
        }
    }

    /// Paints a filled disc with a smooth rim.
    pub fn disc(&mut self, centre: DVec2, radius: f64, colour: Colour) {
        self.line([centre, centre], 2.0 * radius, colour);
    }

    /// Paints a straight line with round ends and a smooth rim.
    pub fn line(&mut self, [from, to]: [DVec2; 2], width: f64, colour: Colour) {
        let (reach, along) = (width / 2.0 + 1.0, to - from);
        let (low, high) = (from.min(to) - reach, from.max(to) + reach);
        let range =
            |low: f64, high: f64, count: usize| low.max(0.0) as usize..(high.max(0.0) as usize).min(count);
        for y in range(low.y, high.y + 1.0, self.height()) {
            for x in range(low.x, high.x + 1.0, self.width) {
                let arm = DVec2::new(x as f64 + 0.5, y as f64 + 0.5) - from;
                let share = (arm.dot(along) / along.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
                let distance = (arm - share * along).length();
                self.blend(x, y, colour, width / 2.0 - distance + 0.5);
            }
        }
    }

    /// Paints a line through many points.
    pub fn polyline(&mut self, points: &[DVec2], width: f64, colour: Colour) {
        points.windows(2).for_each(|pair| self.line([pair[0], pair[1]], width, colour));
    }

    /// Paints a filled rectangle, its last column and row included.
    pub fn rectangle(&mut self, [left, top]: [usize; 2], [width, height]: [usize; 2], colour: Colour) {
        for y in top..top + height {
            (left..left + width).for_each(|x| self.blend(x, y, colour, 1.0));
        }
    }

    /// The picture at half its size: every pixel the mean of four. Smooths what was drawn twice too large.
    pub fn halved(&self) -> Canvas {
        let (width, height) = (self.width / 2, self.height() / 2);
        Canvas::painted(width, height, |k| {
            let (x, y) = (2 * (k % width), 2 * (k / width));
            let four = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(i, j)| self.at(x + i, y + j));
            std::array::from_fn(|c| four.iter().map(|pixel| pixel[c]).sum::<f64>() / 4.0)
        })
    }

    /// The picture as an eight-bit RGB PNG.
    pub fn to_png(&self) -> Vec<u8> {
        let byte = |c: &f64| (c.clamp(0.0, 1.0) * 255.0).round() as u8;
        let bytes: Vec<u8> = self.pixels.iter().flatten().map(byte).collect();
        let mut png = Vec::new();
        let mut encoder = png::Encoder::new(&mut png, self.width as u32, self.height() as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        let mut writer = encoder.write_header().expect("a Vec takes every byte");
        writer.write_image_data(&bytes).expect("as many bytes as the header says");
        writer.finish().expect("a Vec takes every byte");
        png
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BLACK: Colour = [0.0; 3];

    /// How much ink a line leaves, px².
    fn check(ends: [[f64; 2]; 2], width: f64, expected: f64) {
        let mut canvas = Canvas::painted(60, 40, |_| [1.0; 3]);
        canvas.line(ends.map(DVec2::from), width, BLACK);
        let ink: f64 = canvas.pixels.iter().map(|pixel| 1.0 - pixel[0]).sum();
        assert!((ink - expected).abs() < 0.03 * expected + 1e-9, "{ends:?} left {ink}, not {expected}");
    }

    #[test]
    fn ink_is_the_area_of_the_line() {
        let circle = std::f64::consts::PI * 9.0;
        check([[10.0, 20.0], [50.0, 20.0]], 6.0, 240.0 + circle);
        check([[20.0, 10.0], [40.0, 30.0]], 6.0, 800_f64.sqrt() * 6.0 + circle);
        check([[30.3, 20.7], [30.3, 20.7]], 6.0, circle);
        check([[-20.0, 20.0], [-10.0, 20.0]], 6.0, 0.0);
        check([[-30.0, 20.0], [90.0, 20.0]], 2.0, 120.0);
    }

    #[test]
    fn half_the_size_keeps_the_mean() {
        let canvas = Canvas::painted(4, 2, |k| [k as f64 / 8.0; 3]);
        let half = canvas.halved();
        assert_eq!((half.width(), half.height()), (2, 1));
        assert_eq!(half.at(0, 0)[0], (0.0 + 1.0 + 4.0 + 5.0) / 32.0);
    }
}
