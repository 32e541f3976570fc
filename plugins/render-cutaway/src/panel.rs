//! One panel of the picture: solids drawn through a depth buffer.
//!
//! A plane at right angles to the view cuts a solid where an odd number of its faces lie behind the plane along a pixel's
//! ray: then the plane's point is inside. So the cut face needs no boolean.

use crate::Part;
use crate::canvas::Canvas;
use crate::palette::{BACKGROUND, Colour, led_colour, mix, role_colour};
use crate::view::View;
use fibar_core::material::Role;
use glam::{DVec2, DVec3};

/// The two ways to look at the object.
pub struct Panel;

/// What one solid shows at every pixel behind the plane.
struct Layer {
    /// Depth of the nearest face, mm; infinite where there is none.
    depth: Vec<f64>,
    /// How much that face is turned to the viewer.
    facing: Vec<f64>,
    /// Whether the plane's point is inside the solid.
    inside: Vec<bool>,
}

impl Panel {
    /// The object cut by a plane at `cut` between its near and far side.
    pub fn cut_open(parts: &[Part], view: &View, cut: f64) -> Canvas {
        let plane = view.depths.0 + cut.clamp(1e-6, 1.0 - 1e-6) * (view.depths.1 - view.depths.0);
        let layers: Vec<Layer> = parts.iter().map(|part| Layer::draw(part, view, plane)).collect();
        Canvas::painted(view.side, view.side, |pixel| {
            let cut_part = std::iter::zip(parts, &layers).find(|(_, layer)| layer.inside[pixel]);
            match cut_part.map(|(part, _)| part) {
                Some(part) if part.solid.role != Role::Filler => part_colour(part),
                Some(_) => mix(
                    behind(parts, &layers, pixel, role_colour(Role::Filler)),
                    role_colour(Role::Filler),
                    0.75,
                ),
                None => behind(parts, &layers, pixel, BACKGROUND),
            }
        })
    }

    /// All fibres, inside the pale shape of the object.
    pub fn seen_through(parts: &[Part], view: &View) -> Canvas {
        let layers: Vec<Layer> =
            parts.iter().map(|part| Layer::draw(part, view, f64::NEG_INFINITY)).collect();
        Canvas::painted(view.side, view.side, |pixel| {
            let shapes = std::iter::zip(parts, &layers).filter(|(part, _)| part.solid.role == Role::Skin);
            let paper = shapes
                .filter(|(_, layer)| layer.depth[pixel].is_finite())
                .fold(BACKGROUND, |_, (_, layer)| {
                    mix([0.80, 0.84, 0.88], BACKGROUND, 1.0 - 0.75 * layer.facing[pixel])
                });
            nearest(parts, &layers, pixel, |role| role == Role::Black).unwrap_or(paper)
        })
    }
}

/// What is seen behind the plane: fibres first, then the skin, then the paper.
fn behind(parts: &[Part], layers: &[Layer], pixel: usize, paper: Colour) -> Colour {
    let fibre = nearest(parts, layers, pixel, |role| role == Role::Black);
    fibre.or_else(|| nearest(parts, layers, pixel, |role| role == Role::Skin)).unwrap_or(paper)
}

/// Shaded colour of the nearest face of the roles asked for.
fn nearest(parts: &[Part], layers: &[Layer], pixel: usize, wanted: impl Fn(Role) -> bool) -> Option<Colour> {
    let seen =
        std::iter::zip(parts, layers).filter(|(p, l)| wanted(p.solid.role) && l.depth[pixel].is_finite());
    let (part, layer) = seen.min_by(|a, b| a.1.depth[pixel].total_cmp(&b.1.depth[pixel]))?;
    let light = 0.35 + 0.65 * layer.facing[pixel];
    let colour = part.solid.led.map_or(role_colour(part.solid.role), led_colour);
    Some(colour.map(|c| c * light))
}

fn part_colour(part: &Part) -> Colour {
    match (part.solid.role, part.solid.led) {
        (Role::Core, Some(led)) => led_colour(led),
        (role, _) => role_colour(role),
    }
}

impl Layer {
    fn draw(part: &Part, view: &View, plane: f64) -> Layer {
        let pixels = view.side * view.side;
        let mut layer = Layer {
            depth: vec![f64::INFINITY; pixels],
            facing: vec![0.0; pixels],
            inside: vec![false; pixels],
        };
        for triangle in 0..part.mesh.triangles.len() {
            let corners = part.mesh.corners(triangle);
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero();
            layer.draw_triangle(corners.map(|c| view.project(c)), view.facing(normal), view.side, plane);
        }
        layer
    }

    fn draw_triangle(&mut self, [a, b, c]: [DVec3; 3], facing: f64, side: usize, plane: f64) {
        let (p, q, r) = (a.truncate(), b.truncate(), c.truncate());
        let area = (q - p).perp_dot(r - p);
        let range = |lo: f64, hi: f64| {
            (lo - 0.5).ceil().max(0.0) as usize..=(hi - 0.5).floor().min(side as f64 - 1.0) as usize
        };
        let (lo, hi) = (p.min(q).min(r), p.max(q).max(r));
        if area == 0.0 || hi.min_element() < 0.5 || lo.max_element() > side as f64 {
            return;
        }
        for y in range(lo.y, hi.y) {
            for x in range(lo.x, hi.x) {
                let at = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                if covers(p, q, at, area) && covers(q, r, at, area) && covers(r, p, at, area) {
                    let (v, w) = ((at - p).perp_dot(r - p) / area, (q - p).perp_dot(at - p) / area);
                    self.mark(y * side + x, a.z + v * (b.z - a.z) + w * (c.z - a.z), facing, plane);
                }
            }
        }
    }

    fn mark(&mut self, pixel: usize, depth: f64, facing: f64, plane: f64) {
        if depth < plane {
            return;
        }
        self.inside[pixel] = !self.inside[pixel];
        if depth < self.depth[pixel] {
            (self.depth[pixel], self.facing[pixel]) = (depth, facing);
        }
    }
}

/// Whether a point lies on the inner side of an edge; of two triangles that share the edge exactly one owns its points.
fn covers(from: DVec2, to: DVec2, at: DVec2, area: f64) -> bool {
    // Both triangles compute with the edge's ends in the same order, so that rounding cannot tell them apart.
    let forward = (from.x, from.y) <= (to.x, to.y);
    let (low, high) = if forward { (from, to) } else { (to, from) };
    let left = (high - low).perp_dot(at - low) >= 0.0;
    left == (forward == (area > 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use fibar_core::artefact::mesh::TriangleMesh;
    use fibar_core::artefact::solids::Solid;

    /// A box from −half to +half.
    fn part(half: DVec3) -> Part {
        let vertices: Vec<DVec3> = (0..8u32)
            .map(|k| half * DVec3::from([0, 1, 2].map(|axis| if k >> axis & 1 == 1 { 1.0 } else { -1.0 })))
            .collect();
        let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        let solid =
            Solid { role: Role::Filler, led: None, pattern: None, file: "box.ply".into(), volume_mm3: 0.0 };
        Part { solid, mesh: TriangleMesh { vertices, triangles } }
    }

    /// Pixels inside at the plane, of a 10 mm wide box in a 100 px picture whose 92 px show 10 mm.
    fn check(plane: f64, expected: usize) {
        let part = part(DVec3::new(5.0, 4.0, 5.0));
        let view = View::new(DVec3::Y, part.mesh.bounds().unwrap(), 100);
        let layer = Layer::draw(&part, &view, plane);
        assert_eq!(layer.inside.iter().filter(|&&inside| inside).count(), expected);
    }

    #[test]
    fn plane_through_a_box_cuts_its_whole_face() {
        check(0.0, 92 * 92);
        check(3.9, 92 * 92);
        check(4.1, 0);
        check(-4.1, 0);
    }
}
