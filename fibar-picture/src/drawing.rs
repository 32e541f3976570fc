//! An orthographic drawing with a depth buffer.
//!
//! What is nearer hides what is farther, whatever the order of the calls; only [`ghost`](Drawing::ghost) is paper to all the rest.

use crate::canvas::Canvas;
use crate::colour::{Colour, PAPER, mix, shade};
use crate::raster;
use crate::view::View;
use fibar_core::artefact::mesh::TriangleMesh;
use glam::{DVec2, DVec3};

/// A square picture of things in the body's frame.
pub struct Drawing {
    view: View,
    canvas: Canvas,
    /// Depth of what each pixel shows, mm; infinite for paper.
    depth: Vec<f64>,
}

impl Drawing {
    /// Blank paper seen by `view`.
    pub fn new(view: View) -> Drawing {
        let canvas = Canvas::new(view.side, view.side);
        Drawing { view, canvas, depth: vec![f64::INFINITY; view.side * view.side] }
    }

    /// The view.
    pub fn view(&self) -> &View {
        &self.view
    }

    /// The finished picture.
    pub fn into_canvas(self) -> Canvas {
        self.canvas
    }

    /// A solid surface; `colour` of a vertex, mixed across each triangle.
    pub fn mesh(&mut self, mesh: &TriangleMesh, colour: impl Fn(usize) -> Colour) {
        for (triangle, indices) in mesh.triangles.iter().enumerate() {
            let colours = indices.map(|v| colour(v as usize));
            let (corners, facing) = self.seen(mesh, triangle);
            raster::fill(corners, self.view.side, |fragment| {
                let mixed = std::array::from_fn(|c| (0..3).map(|k| colours[k][c] * fragment.shares[k]).sum());
                self.mark(fragment.pixel, fragment.depth, shade(mixed, facing));
            });
        }
    }

    /// The pale shape of a mesh, behind everything else: its rims are darker than what faces the viewer.
    pub fn ghost(&mut self, mesh: &TriangleMesh) {
        const RIM: Colour = [0.80, 0.84, 0.88];
        let side = self.view.side;
        let mut nearest = vec![(f64::INFINITY, 1.0); side * side];
        for triangle in 0..mesh.triangles.len() {
            let (corners, facing) = self.seen(mesh, triangle);
            raster::fill(corners, side, |fragment| {
                if fragment.depth < nearest[fragment.pixel].0 {
                    nearest[fragment.pixel] = (fragment.depth, facing);
                }
            });
        }
        let shown = |pixel: &usize| nearest[*pixel].0.is_finite() && self.depth[*pixel].is_infinite();
        for pixel in (0..side * side).filter(shown) {
            let colour = mix(RIM, PAPER, 1.0 - 0.75 * nearest[pixel].1);
            self.canvas.blend(pixel % side, pixel / side, colour, 1.0);
        }
    }

    /// A shaded ball.
    pub fn ball(&mut self, centre: DVec3, radius_mm: f64, colour: Colour) {
        self.rod([centre; 2], radius_mm, [colour; 2]);
    }

    /// A shaded tube through points near one another; a colour for each.
    pub fn tube(&mut self, points: &[DVec3], radius_mm: f64, colours: &[Colour]) {
        for (ends, colours) in points.windows(2).zip(colours.windows(2)) {
            self.rod([ends[0], ends[1]], radius_mm, [colours[0], colours[1]]);
        }
    }

    /// A ball swept along a chord.
    fn rod(&mut self, ends: [DVec3; 2], radius_mm: f64, colours: [Colour; 2]) {
        let [from, to] = ends.map(|end| self.view.project(end));
        let (start, along) = (from.truncate(), (to - from).truncate());
        let radius = radius_mm * self.view.pixels_per_mm;
        let (low, high) = (start.min(to.truncate()) - radius, start.max(to.truncate()) + radius);
        let side = self.view.side;
        let range = |low: f64, high: f64| low.max(0.0) as usize..((high.max(-1.0) + 1.0) as usize).min(side);
        for (y, x) in range(low.y, high.y).flat_map(|y| range(low.x, high.x).map(move |x| (y, x))) {
            let arm = DVec2::new(x as f64 + 0.5, y as f64 + 0.5) - start;
            let share = (arm.dot(along) / along.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
            let height = radius * radius - (arm - share * along).length_squared();
            if height >= 0.0 {
                let facing = height.sqrt() / radius;
                let depth = from.z + share * (to.z - from.z) - facing * radius_mm;
                self.mark(y * side + x, depth, shade(mix(colours[1], colours[0], share), facing));
            }
        }
    }

    /// Corners in the picture and how much the triangle is turned to the viewer.
    fn seen(&self, mesh: &TriangleMesh, triangle: usize) -> ([DVec3; 3], f64) {
        let corners = mesh.corners(triangle);
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero();
        (corners.map(|corner| self.view.project(corner)), self.view.facing(normal))
    }

    fn mark(&mut self, pixel: usize, depth: f64, colour: Colour) {
        if depth < self.depth[pixel] {
            self.depth[pixel] = depth;
            self.canvas.blend(pixel % self.view.side, pixel / self.view.side, colour, 1.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RED: Colour = [1.0, 0.0, 0.0];
    const BLUE: Colour = [0.0, 0.0, 1.0];

    /// Which channel is strongest in the middle of a drawing of two balls on the line of sight.
    fn check(red_at: f64, blue_at: f64, expected: usize) {
        let view = View::new(DVec3::Y, (DVec3::splat(-10.0), DVec3::splat(10.0)), 40);
        let mut drawing = Drawing::new(view);
        drawing.ball(DVec3::Y * red_at, 2.0, RED);
        drawing.ball(DVec3::Y * blue_at, 2.0, BLUE);
        let middle = drawing.into_canvas().at(20, 20);
        let strongest = (0..3).max_by(|&a, &b| middle[a].total_cmp(&middle[b])).unwrap();
        assert_eq!(strongest, expected, "{middle:?}");
    }

    #[test]
    fn nearer_hides_farther_in_either_order() {
        check(-5.0, 5.0, 0);
        check(5.0, -5.0, 2);
    }

    #[test]
    fn tube_is_as_wide_as_it_is() {
        let view = View::new(DVec3::Y, (DVec3::splat(-10.0), DVec3::splat(10.0)), 400);
        let mut drawing = Drawing::new(view);
        drawing.tube(&[DVec3::NEG_Z * 8.0, DVec3::ZERO, DVec3::Z * 8.0], 1.0, &[RED; 3]);
        let canvas = drawing.into_canvas();
        let inked = (0..400).filter(|&x| canvas.at(x, 200) != PAPER).count() as f64;
        assert!((inked - 2.0 * view.pixels_per_mm).abs() <= 2.0, "{inked} px wide");
    }
}
