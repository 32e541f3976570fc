//! Squared distances from planes, summed over area (Garland & Heckbert 1997).

use glam::{DMat2, DMat3, DVec2, DVec3};

/// Weight of a vertex's own place beside the planes around it: it settles where on a flat face a vertex comes to lie.
const ANCHOR: f64 = 1e-4;

/// Planes around a vertex, and where it came from.
#[derive(Clone, Copy, Debug, Default)]
pub struct Quadric {
    planes: Square,
    anchors: Square,
}

/// A quadratic function of a place, `x·Ax + 2 b·x + c`, mm⁴.
#[derive(Clone, Copy, Debug, Default)]
struct Square {
    a: DMat3,
    b: DVec3,
    c: f64,
}

impl Quadric {
    /// The plane of a triangle, weighed by its area, as its `corner` takes part in it.
    pub fn of_corner(triangle: [DVec3; 3], corner: usize) -> Quadric {
        let [p, q, r] = triangle;
        let cross = (q - p).cross(r - p);
        let area = 0.5 * cross.length();
        let normal = cross.normalize_or_zero();
        let at = triangle[corner];
        let offset = normal.dot(at);
        let weight = ANCHOR * area;
        Quadric {
            planes: Square { a: outer(normal) * area, b: -normal * offset * area, c: offset * offset * area },
            anchors: Square { a: DMat3::IDENTITY * weight, b: -at * weight, c: at.length_squared() * weight },
        }
    }

    /// What a place costs by the planes alone.
    pub fn distance_at(&self, x: DVec3) -> f64 {
        self.planes.at(x)
    }

    /// What a place costs, old places included.
    pub fn at(&self, x: DVec3) -> f64 {
        (self.planes + self.anchors).at(x)
    }

    /// Where it costs least.
    pub fn lowest(&self) -> Option<DVec3> {
        let sum = self.planes + self.anchors;
        let place = sum.a.inverse() * -sum.b;
        place.is_finite().then_some(place)
    }

    /// Where it costs least in the plane of a height.
    pub fn lowest_at_height(&self, z: f64) -> Option<DVec3> {
        let sum = self.planes + self.anchors;
        let flat = DMat2::from_cols(sum.a.x_axis.truncate(), sum.a.y_axis.truncate());
        let pull: DVec2 = -sum.b.truncate() - sum.a.z_axis.truncate() * z;
        let place = flat.inverse() * pull;
        place.is_finite().then_some(place.extend(z))
    }
}

impl std::ops::Add for Quadric {
    type Output = Quadric;

    fn add(self, other: Quadric) -> Quadric {
        Quadric { planes: self.planes + other.planes, anchors: self.anchors + other.anchors }
    }
}

impl Square {
    fn at(&self, x: DVec3) -> f64 {
        (x.dot(self.a * x) + 2.0 * self.b.dot(x) + self.c).max(0.0)
    }
}

impl std::ops::Add for Square {
    type Output = Square;

    fn add(self, other: Square) -> Square {
        Square { a: self.a + other.a, b: self.b + other.b, c: self.c + other.c }
    }
}

fn outer(n: DVec3) -> DMat3 {
    DMat3::from_cols(n * n.x, n * n.y, n * n.z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_planes_meet_in_a_corner() {
        let corner = DVec3::new(40.0, -30.0, 20.0);
        let wall = |u: DVec3, v: DVec3| [corner + u, corner + u + v * 3.0, corner + u + v - u.cross(v)];
        let walls = [(DVec3::X, DVec3::Y), (DVec3::Y, DVec3::Z), (DVec3::Z, DVec3::X)].map(|(u, v)| {
            let [a, _, _] = wall(u, v);
            Quadric::of_corner([a, a + u * 3.0, a + v * 3.0], 0)
        });
        let sum = walls[0] + walls[1] + walls[2];
        let lowest = sum.lowest().unwrap();
        // The walls z = 20, x = 40 and y = −30, as far as the anchors at (41, …) let go.
        assert!(lowest.distance(corner) < 1e-3, "{lowest}");
        assert!(sum.at(corner) < 1e-2 && sum.at(corner + DVec3::X) > 4.0);
        let flat = sum.lowest_at_height(25.0).unwrap();
        assert!(flat.z == 25.0 && flat.distance(corner.with_z(25.0)) < 1e-3, "{flat}");
    }
}
