//! Triangles over rims drawn in a plane: a polygon with others inside it, and points between.

use glam::{DVec2, DVec3};
use spade::{ConstrainedDelaunayTriangulation, HasPosition, Point2, Triangulation};

/// A plane with axes of its own.
#[derive(Clone, Copy, Debug)]
pub struct Plane {
    /// A point of it, mm.
    pub origin: DVec3,
    /// Unit normal; a ring around it is counter-clockwise when seen against it.
    pub normal: DVec3,
    right: DVec3,
    up: DVec3,
}

impl Plane {
    /// The plane of a ring's vector area (Newell), and that area, mm²; nothing for a ring without area.
    pub fn of(ring: &[DVec3]) -> Option<(Plane, f64)> {
        let origin = ring.iter().sum::<DVec3>() / ring.len().max(1) as f64;
        let next = ring.iter().cycle().skip(1);
        let area = ring.iter().zip(next).map(|(a, b)| (a - origin).cross(b - origin)).sum::<DVec3>() / 2.0;
        let normal = area.try_normalize()?;
        Some((Plane::across(origin, normal), area.length()))
    }

    /// Through a point, across a unit normal.
    pub fn across(origin: DVec3, normal: DVec3) -> Plane {
        let (right, up) = normal.any_orthonormal_pair();
        Plane { origin, normal, right, up }
    }

    /// Place in the plane, and height above it, mm.
    pub fn draw(&self, place: DVec3) -> (DVec2, f64) {
        let arm = place - self.origin;
        (DVec2::new(arm.dot(self.right), arm.dot(self.up)), arm.dot(self.normal))
    }

    /// The inverse of [`draw`](Self::draw).
    pub fn lift(&self, at: DVec2, height: f64) -> DVec3 {
        self.origin + at.x * self.right + at.y * self.up + height * self.normal
    }
}

/// Whether a point lies in a polygon: a ray from it meets an odd number of sides.
pub fn is_inside(ring: &[DVec2], point: DVec2) -> bool {
    let next = ring.iter().cycle().skip(1);
    let meets = |(a, b): &(&DVec2, &DVec2)| {
        (a.y > point.y) != (b.y > point.y) && point.x < (b.x - a.x) * (point.y - a.y) / (b.y - a.y) + a.x
    };
    ring.iter().zip(next).filter(meets).count() % 2 == 1
}

/// Counter-clockwise triangles between rings and through points, by index into all of them in their order. Nothing if rings meet each
/// other or themselves.
pub fn fill(rings: &[Vec<DVec2>], points: &[DVec2]) -> Option<Vec<[usize; 3]>> {
    let mut drawing: ConstrainedDelaunayTriangulation<Tagged> = ConstrainedDelaunayTriangulation::new();
    let mut handles = Vec::new();
    for (index, at) in rings.iter().flatten().chain(points).enumerate() {
        let handle = drawing.insert(Tagged { at: Point2::new(at.x, at.y), index }).ok()?;
        handles.push(handle);
    }
    if drawing.num_vertices() != handles.len() {
        return None;
    }
    let mut first = 0;
    for ring in rings {
        for k in 0..ring.len() {
            let [from, to] = [k, (k + 1) % ring.len()].map(|k| handles[first + k]);
            if !drawing.can_add_constraint(from, to) {
                return None;
            }
            drawing.add_constraint(from, to);
        }
        first += ring.len();
    }
    let triangles = drawing.inner_faces().filter_map(|face| {
        let middle = face.center();
        let inside =
            rings.iter().filter(|ring| is_inside(ring, DVec2::new(middle.x, middle.y))).count() % 2 == 1;
        inside.then(|| face.vertices().map(|vertex| vertex.data().index))
    });
    let triangles: Vec<[usize; 3]> = triangles.collect();
    // Euler: what has fewer or more was not drawn as a disc with holes.
    (triangles.len() + 4 == first + 2 * rings.len() + 2 * points.len()).then_some(triangles)
}

struct Tagged {
    at: Point2<f64>,
    index: usize,
}

impl HasPosition for Tagged {
    type Scalar = f64;
    fn position(&self) -> Point2<f64> {
        self.at
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(half: f64) -> Vec<DVec2> {
        [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|p| DVec2::from(p) * half).to_vec()
    }

    /// Triangles, and their area.
    fn check(rings: &[Vec<DVec2>], points: &[DVec2], expected: Option<(usize, f64)>) {
        let all: Vec<DVec2> = rings.iter().flatten().chain(points).copied().collect();
        let area = |[a, b, c]: &[usize; 3]| (all[*b] - all[*a]).perp_dot(all[*c] - all[*a]) / 2.0;
        let found = fill(rings, points).map(|t| (t.len(), t.iter().map(area).sum::<f64>()));
        assert_eq!(found, expected);
    }

    #[test]
    fn rings_are_filled_between() {
        check(&[square(1.0)], &[], Some((2, 4.0)));
        check(&[square(1.0)], &[DVec2::ZERO], Some((4, 4.0)));
        check(&[square(2.0), square(1.0)], &[], Some((8, 12.0)));
        check(&[square(1.0)], &[DVec2::splat(1.0)], None);
        let bow = [[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.0]].map(DVec2::from).to_vec();
        check(&[bow], &[], None);
        let arrow = [[0.0, 0.0], [4.0, 2.0], [0.0, 4.0], [2.0, 2.0]].map(DVec2::from).to_vec();
        check(&[arrow], &[], Some((2, 4.0)));
    }

    #[test]
    fn planes_draw_and_lift() {
        let ring = [[1.0, 0.0, 2.0], [0.0, 1.0, 2.0], [-1.0, 0.0, 2.0], [0.0, -1.0, 2.0]].map(DVec3::from);
        let (plane, area) = Plane::of(&ring).unwrap();
        assert_eq!((plane.normal, area), (DVec3::Z, 2.0));
        let place = DVec3::new(0.3, -0.4, 5.0);
        let (at, height) = plane.draw(place);
        assert!(height == 3.0 && plane.lift(at, height).distance(place) < 1e-15);
        assert!(Plane::of(&[DVec3::X; 3]).is_none());
    }
}
