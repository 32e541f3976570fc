//! A diagram of curves over two axes.

use crate::canvas::Canvas;
use crate::colour::{Colour, FAINT, INK};
use crate::legend::LINE_PX;
use crate::text::{Anchor, Letters};
use glam::DVec2;

/// Room for captions around the axes: left, top, right, bottom, px.
const MARGINS: [f64; 4] = [84.0, 56.0, 24.0, 48.0];

/// Curves, what they are called and what the axes mean.
#[derive(Clone, Debug, Default)]
pub struct Chart<'a> {
    /// Heading.
    pub title: &'a str,
    /// What the horizontal axis counts, with its unit.
    pub x: &'a str,
    /// What the vertical axis counts, with its unit.
    pub y: &'a str,
    /// Name, colour and points of each curve, in the order of drawing. Points that are not finite are left out.
    pub curves: Vec<(&'a str, Colour, Vec<DVec2>)>,
}

impl Chart<'_> {
    /// Draws the diagram at a size in px.
    pub fn draw(&self, width: usize, height: usize) -> Canvas {
        let mut canvas = Canvas::new(width, height);
        let frame = Frame::around(self, width as f64, height as f64);
        frame.draw_grid(&mut canvas);
        for (_, colour, points) in &self.curves {
            let points: Vec<DVec2> = finite(points).map(|p| frame.place(p)).collect();
            canvas.polyline(&points, 2.0, *colour);
        }
        self.write_captions(&mut canvas, &frame);
        canvas
    }

    fn write_captions(&self, canvas: &mut Canvas, frame: &Frame) {
        let middle = (frame.low.x + frame.high.x) / 2.0;
        canvas.text(self.title, DVec2::new(middle, 18.0), Anchor::Middle, Letters::Large);
        let below = canvas.height() as f64 - 12.0;
        canvas.text(self.x, DVec2::new(middle, below), Anchor::Middle, Letters::Small);
        canvas.text(self.y, DVec2::new(8.0, frame.high.y - 14.0), Anchor::Left, Letters::Small);
        let names: Vec<(&str, Colour)> =
            self.curves.iter().map(|(name, colour, _)| (*name, *colour)).collect();
        let [letter, _] = Letters::Small.cell();
        let length: usize = names.iter().map(|(name, _)| 36 + letter * name.chars().count()).sum();
        let left = (frame.high.x as usize).saturating_sub(length);
        canvas.swatches(&names, [left, frame.high.y as usize - LINE_PX - 4]);
    }
}

/// Where the axes lie in the picture and what they span.
struct Frame {
    /// Lower left corner, px.
    low: DVec2,
    /// Upper right corner, px.
    high: DVec2,
    /// Values at the lower left corner.
    least: DVec2,
    /// Values at the upper right corner.
    most: DVec2,
}

impl Frame {
    fn around(chart: &Chart, width: f64, height: f64) -> Frame {
        let [left, top, right, bottom] = MARGINS;
        let all = || chart.curves.iter().flat_map(|(_, _, points)| finite(points));
        let least = all().reduce(DVec2::min).unwrap_or(DVec2::ZERO);
        let most = all().reduce(DVec2::max).unwrap_or(DVec2::ONE);
        // An axis without extent would have no scale.
        let most = DVec2::new(
            if most.x > least.x { most.x } else { least.x + 1.0 },
            if most.y > least.y { most.y } else { least.y + 1.0 },
        );
        Frame { low: DVec2::new(left, height - bottom), high: DVec2::new(width - right, top), least, most }
    }

    fn place(&self, value: DVec2) -> DVec2 {
        self.low + (value - self.least) / (self.most - self.least) * (self.high - self.low)
    }

    fn draw_grid(&self, canvas: &mut Canvas) {
        for x in ticks(self.least.x, self.most.x) {
            let at = self.place(DVec2::new(x, self.least.y));
            canvas.line([at, at.with_y(self.high.y)], 1.0, FAINT);
            canvas.text(&caption(x), at + DVec2::Y * 12.0, Anchor::Middle, Letters::Small);
        }
        for y in ticks(self.least.y, self.most.y) {
            let at = self.place(DVec2::new(self.least.x, y));
            canvas.line([at, at.with_x(self.high.x)], 1.0, FAINT);
            canvas.text(&caption(y), at - DVec2::X * 6.0, Anchor::Right, Letters::Small);
        }
        canvas.line([self.low, self.low.with_x(self.high.x)], 1.5, INK);
        canvas.line([self.low, self.low.with_y(self.high.y)], 1.5, INK);
    }
}

fn finite(points: &[DVec2]) -> impl Iterator<Item = DVec2> {
    points.iter().copied().filter(|point| point.is_finite())
}

/// Round numbers between two values, about six: multiples of 1, 2 or 5 times a power of ten.
fn ticks(least: f64, most: f64) -> Vec<f64> {
    let rough = (most - least) / 6.0;
    let power = libm::pow(10.0, libm::floor(libm::log10(rough)));
    let step = [1.0, 2.0, 5.0, 10.0].into_iter().map(|m| m * power).find(|&step| step >= rough);
    let step = step.unwrap_or(10.0 * power);
    let (first, last) = ((least / step).ceil(), (most / step).floor());
    (0..=(last - first).max(0.0) as usize).map(|k| (first + k as f64) * step).collect()
}

/// A number as short as it can be told from its neighbours.
fn caption(value: f64) -> String {
    let rounded: f64 = format!("{value:.5e}").parse().expect("a number that was just written");
    if rounded != 0.0 && !(1e-3..1e6).contains(&rounded.abs()) {
        format!("{rounded:e}")
    } else {
        format!("{rounded}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(least: f64, most: f64, expected: &[&str]) {
        let captions: Vec<String> = ticks(least, most).into_iter().map(caption).collect();
        assert_eq!(captions, expected);
    }

    #[test]
    fn ticks_are_round_numbers_inside() {
        check(0.0, 1.0, &["0", "0.2", "0.4", "0.6", "0.8", "1"]);
        check(-3.0, 12.0, &["0", "5", "10"]);
        check(31019.0, 33100.0, &["31500", "32000", "32500", "33000"]);
        check(0.0, 6e7, &["0", "1e7", "2e7", "3e7", "4e7", "5e7", "6e7"]);
    }

    #[test]
    fn curve_without_extent_is_drawn() {
        let point = vec![DVec2::new(3.0, 3.0), DVec2::new(f64::NAN, 0.0)];
        let chart = Chart { curves: vec![("one", [1.0, 0.0, 0.0], point)], ..Chart::default() };
        assert_eq!(chart.draw(300, 200).width(), 300);
        assert_eq!(Chart::default().draw(300, 200).height(), 200);
    }
}
