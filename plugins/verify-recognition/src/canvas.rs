//! A picture in memory, and as PNG.

/// sRGB, 0 to 1.
pub type Colour = [f64; 3];

/// Pixels, row by row from the top.
pub struct Canvas {
    width: usize,
    pixels: Vec<Colour>,
}

impl Canvas {
    /// A picture of one colour.
    pub fn new(width: usize, height: usize, colour: Colour) -> Canvas {
        Canvas { width, pixels: vec![colour; width * height] }
    }

    /// Paints a pixel; outside the picture nothing happens.
    pub fn set(&mut self, x: usize, y: usize, colour: Colour) {
        let height = self.pixels.len() / self.width;
        if x < self.width && y < height {
            self.pixels[y * self.width + x] = colour;
        }
    }

    /// Paints a filled disc.
    pub fn disc(&mut self, x: f64, y: f64, radius: f64, colour: Colour) {
        let around = |c: f64| (c - radius).floor().max(0.0) as usize..=(c + radius).ceil().max(0.0) as usize;
        for py in around(y) {
            for px in around(x) {
                let (dx, dy) = (px as f64 + 0.5 - x, py as f64 + 0.5 - y);
                if dx * dx + dy * dy <= radius * radius {
                    self.set(px, py, colour);
                }
            }
        }
    }

    /// The picture as an eight-bit RGB PNG.
    pub fn to_png(&self) -> Vec<u8> {
        let height = self.pixels.len() / self.width;
        let byte = |c: &f64| (c.clamp(0.0, 1.0) * 255.0).round() as u8;
        let bytes: Vec<u8> = self.pixels.iter().flatten().map(byte).collect();
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
