//! A picture in memory, and as PNG.

use crate::palette::{BACKGROUND, Colour};

/// Pixels, row by row from the top.
pub struct Canvas {
    width: usize,
    pixels: Vec<Colour>,
}

impl Canvas {
    /// A blank picture.
    pub fn new(width: usize, height: usize) -> Canvas {
        Canvas { width, pixels: vec![BACKGROUND; width * height] }
    }

    /// The picture whose pixel `k` is `paint(k)`.
    pub fn painted(width: usize, height: usize, paint: impl Fn(usize) -> Colour) -> Canvas {
        Canvas { width, pixels: (0..width * height).map(paint).collect() }
    }

    /// Copies a smaller picture to where its upper left corner shall be.
    pub fn paste(&mut self, other: &Canvas, left: usize, top: usize) {
        for (row, pixels) in other.pixels.chunks_exact(other.width).enumerate() {
            let start = (top + row) * self.width + left;
            self.pixels[start..start + other.width].copy_from_slice(pixels);
        }
    }

    /// The picture as an eight-bit RGB PNG.
    pub fn to_png(&self) -> Vec<u8> {
        let height = self.pixels.len() / self.width;
        let bytes: Vec<u8> =
            self.pixels.iter().flatten().map(|c| (c.clamp(0.0, 1.0) * 255.0).round() as u8).collect();
        let mut png = Vec::new();
        let mut encoder = png::Encoder::new(&mut png, self.width as u32, height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        let mut writer = encoder.write_header().expect("a Vec takes every byte");
        writer.write_image_data(&bytes).expect("as many bytes as the header says");
        writer.finish().expect("a Vec takes every byte");
        png
    }
}
