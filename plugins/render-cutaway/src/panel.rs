//! One panel of the picture: solids drawn through a depth buffer.
//!
//! A plane at right angles to the view cuts a solid where an odd number of its faces lie behind the plane along a pixel's
//! ray: then the plane's point is inside. So the cut face needs no boolean.

use crate::Part;
use fibar_core::LedId;
use fibar_core::material::Role;
use fibar_picture::colour::{Colour, PAPER, hue, mix, role as role_colour, shade};
use fibar_picture::raster::{self, Fragment};
use fibar_picture::{Canvas, Drawing, View};

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
                None => behind(parts, &layers, pixel, PAPER),
            }
        })
    }

    /// All fibres, inside the pale shape of the object.
    pub fn seen_through(parts: &[Part], view: &View) -> Canvas {
        let mut drawing = Drawing::new(*view);
        let of = |role: Role| parts.iter().filter(move |part| part.solid.role == role);
        for part in of(Role::Black) {
            drawing.mesh(&part.mesh, |_| solid_colour(part));
        }
        of(Role::Skin).for_each(|part| drawing.ghost(&part.mesh));
        drawing.into_canvas()
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
    Some(shade(solid_colour(part), layer.facing[pixel]))
}

/// What a part looks like from outside: its LED's hue, else its role's colour.
fn solid_colour(part: &Part) -> Colour {
    part.solid.led.map_or(role_colour(part.solid.role), led_colour)
}

/// What a part looks like where the plane cuts it.
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
            let facing = view.facing(normal);
            raster::fill(corners.map(|c| view.project(c)), view.side, |fragment| {
                layer.mark(fragment, facing, plane);
            });
        }
        layer
    }

    fn mark(&mut self, Fragment { pixel, depth, .. }: Fragment, facing: f64, plane: f64) {
        if depth < plane {
            return;
        }
        self.inside[pixel] = !self.inside[pixel];
        if depth < self.depth[pixel] {
            (self.depth[pixel], self.facing[pixel]) = (depth, facing);
        }
    }
}

/// The LED's hue.
fn led_colour(led: LedId) -> Colour {
    hue(led.0 as usize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use fibar_core::artefact::mesh::TriangleMesh;
    use fibar_core::artefact::solids::Solid;
    use glam::DVec3;

    /// A box from −half to +half.
    fn part(half: DVec3) -> Part {
        let vertices: Vec<DVec3> = (0..8u32)
            .map(|k| half * DVec3::from([0, 1, 2].map(|axis| if k >> axis & 1 == 1 { 1.0 } else { -1.0 })))
            .collect();
        let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        let solid = Solid {
            role: Role::Filler,
            led: None,
            pattern: None,
            part: None,
            colour: None,
            file: "box.ply".into(),
            volume_mm3: 0.0,
        };
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
