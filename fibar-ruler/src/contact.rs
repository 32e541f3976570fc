//! The shortest bridge between two of: point, segment, triangle. Exact up to rounding, degenerate shapes included.

use glam::DVec3;

/// A straight segment, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment(pub DVec3, pub DVec3);

/// A triangle, mm.
pub type Triangle = [DVec3; 3];

/// The shortest bridge between two things.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Its length, mm; zero where they meet.
    pub distance: f64,
    /// Its end on the first thing, mm.
    pub near: DVec3,
    /// Its end on the second thing, mm.
    pub far: DVec3,
}

/// Something that can be measured against triangles.
pub trait Probe {
    /// Least and greatest coordinates, mm.
    fn bounds(&self) -> (DVec3, DVec3);
    /// The shortest bridge from here to a triangle.
    fn contact(&self, triangle: &Triangle) -> Contact;
    /// A length that the shortest bridge certainly has, cheaper to find.
    fn at_least(&self, _triangle: &Triangle) -> f64 {
        0.0
    }
}

impl Contact {
    fn between(near: DVec3, far: DVec3) -> Contact {
        Contact { distance: near.distance(far), near, far }
    }

    fn meeting(point: DVec3) -> Contact {
        Contact { distance: 0.0, near: point, far: point }
    }

    fn or_shorter(self, other: Contact) -> Contact {
        if other.distance < self.distance { other } else { self }
    }

    fn flipped(self) -> Contact {
        Contact { near: self.far, far: self.near, ..self }
    }
}

impl Probe for DVec3 {
    fn bounds(&self) -> (DVec3, DVec3) {
        (*self, *self)
    }

    fn contact(&self, triangle: &Triangle) -> Contact {
        Contact::between(*self, nearest_on_triangle(*self, triangle).0)
    }
}

impl Probe for Segment {
    fn bounds(&self) -> (DVec3, DVec3) {
        (self.0.min(self.1), self.0.max(self.1))
    }

    fn contact(&self, triangle: &Triangle) -> Contact {
        if let Some(point) = self.piercing(triangle) {
            return Contact::meeting(point);
        }
        let ends = self.0.contact(triangle).or_shorter(self.1.contact(triangle));
        edges(triangle).map(|edge| self.to_segment(&edge)).fold(ends, Contact::or_shorter)
    }
}

impl Probe for Triangle {
    fn bounds(&self) -> (DVec3, DVec3) {
        (self[0].min(self[1]).min(self[2]), self[0].max(self[1]).max(self[2]))
    }

    fn contact(&self, triangle: &Triangle) -> Contact {
        let pierced = edges(self).find_map(|edge| edge.piercing(triangle));
        if let Some(point) = pierced.or_else(|| edges(triangle).find_map(|edge| edge.piercing(self))) {
            return Contact::meeting(point);
        }
        let far_off = Contact { distance: f64::INFINITY, near: self[0], far: triangle[0] };
        let from_here = self.iter().map(|corner| corner.contact(triangle));
        let from_there = triangle.iter().map(|corner| corner.contact(self).flipped());
        let along = edges(self).flat_map(|edge| edges(triangle).map(move |other| edge.to_segment(&other)));
        from_here.chain(from_there).chain(along).fold(far_off, Contact::or_shorter)
    }

    /// From the middle of this triangle straight to the nearest point of the other: all of the other lies beyond that
    /// point, and this one reaches no further than its furthest corner.
    fn at_least(&self, triangle: &Triangle) -> f64 {
        let middle = (self[0] + self[1] + self[2]) / 3.0;
        let bridge = nearest_on_triangle(middle, triangle).0 - middle;
        let length = bridge.length();
        let reach = self.iter().map(|corner| (*corner - middle).dot(bridge)).fold(0.0, f64::max);
        if length > 0.0 { length - reach / length } else { 0.0 }
    }
}

impl Segment {
    /// The shortest bridge between two segments (Ericson 2005, section 5.1.9).
    pub fn to_segment(&self, other: &Segment) -> Contact {
        let (d1, d2, r) = (self.1 - self.0, other.1 - other.0, self.0 - other.0);
        let (a, e, b, c, f) = (d1.dot(d1), d2.dot(d2), d1.dot(d2), d1.dot(r), d2.dot(r));
        let share = |numerator: f64, denominator: f64| {
            if denominator > 0.0 { (numerator / denominator).clamp(0.0, 1.0) } else { 0.0 }
        };
        let s = share(b * f - c * e, a * e - b * b);
        let t = share(b * s + f, e);
        let s = share(b * t - c, a);
        let t_again = share(b * s + f, e);
        Contact::between(self.0 + d1 * s, other.0 + d2 * t_again)
    }

    /// Where the segment goes through the inside of a triangle.
    fn piercing(&self, [a, b, c]: &Triangle) -> Option<DVec3> {
        let normal = (*b - *a).cross(*c - *a);
        let (from, to) = (normal.dot(self.0 - *a), normal.dot(self.1 - *a));
        if from * to >= 0.0 {
            return None;
        }
        let point = self.0.lerp(self.1, from / (from - to));
        let inside =
            [(a, b), (b, c), (c, a)].iter().all(|(p, q)| (**q - **p).cross(point - **p).dot(normal) >= 0.0);
        inside.then_some(point)
    }
}

/// The part of a triangle that a nearest point lies on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feature {
    /// Inside.
    Face,
    /// On the edge from this corner to the next.
    Edge(usize),
    /// This corner.
    Corner(usize),
}

/// The point of a triangle nearest to `point`, and on which part it lies (Ericson 2005, section 5.1.5).
pub fn nearest_on_triangle(point: DVec3, &[a, b, c]: &Triangle) -> (DVec3, Feature) {
    let (ab, ac) = (b - a, c - a);
    let (d1, d2) = (ab.dot(point - a), ac.dot(point - a));
    if d1 <= 0.0 && d2 <= 0.0 {
        return (a, Feature::Corner(0));
    }
    let (d3, d4) = (ab.dot(point - b), ac.dot(point - b));
    if d3 >= 0.0 && d4 <= d3 {
        return (b, Feature::Corner(1));
    }
    let (d5, d6) = (ab.dot(point - c), ac.dot(point - c));
    if d6 >= 0.0 && d5 <= d6 {
        return (c, Feature::Corner(2));
    }
    let (va, vb, vc) = (d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2);
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return (a + ab * (d1 / (d1 - d3)), Feature::Edge(0));
    }
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return (a + ac * (d2 / (d2 - d6)), Feature::Edge(2));
    }
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        return (b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6))), Feature::Edge(1));
    }
    let sum = va + vb + vc;
    (a + ab * (vb / sum) + ac * (vc / sum), Feature::Face)
}

fn edges(t: &Triangle) -> impl Iterator<Item = Segment> {
    [Segment(t[0], t[1]), Segment(t[1], t[2]), Segment(t[2], t[0])].into_iter()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::RngExt;
    use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};

    fn random_point(rng: &mut ChaCha8Rng) -> DVec3 {
        DVec3::new(rng.random_range(-1.0..1.0), rng.random_range(-1.0..1.0), rng.random_range(-1.0..1.0))
    }

    fn random_triangle(rng: &mut ChaCha8Rng) -> Triangle {
        [random_point(rng), random_point(rng), random_point(rng)]
    }

    /// Points all over a triangle, corners and edges included.
    fn grid(t: &Triangle, n: u32) -> Vec<DVec3> {
        let at = |i: u32, j: u32| {
            let (u, v) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
            t[0] + (t[1] - t[0]) * u + (t[2] - t[0]) * v
        };
        (0..=n).flat_map(|i| (0..=n - i).map(move |j| (i, j))).map(|(i, j)| at(i, j)).collect()
    }

    /// No pair of grid points is nearer than the contact, and some pair is about as near.
    #[track_caller]
    fn check(probe: &impl Probe, points: &[DVec3], triangle: &Triangle) {
        let found = probe.contact(triangle);
        assert!((found.near.distance(found.far) - found.distance).abs() < 1e-12);
        let sampled = points.iter().flat_map(|p| grid(triangle, 24).into_iter().map(move |q| p.distance(q)));
        let sampled = sampled.fold(f64::INFINITY, f64::min);
        assert!(probe.at_least(triangle) <= found.distance + 1e-12);
        assert!(found.distance <= sampled + 1e-12, "{} is not the least: {sampled}", found.distance);
        assert!(sampled - found.distance < 0.25, "{} is too small: {sampled}", found.distance);
    }

    #[test]
    fn contacts_are_the_shortest() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        for _ in 0..60 {
            let triangle = random_triangle(&mut rng);
            let other = random_triangle(&mut rng).map(|p| p * 0.5 + DVec3::X * rng.random_range(0.0..2.0));
            check(&other[0], &[other[0]], &triangle);
            let on_segment: Vec<DVec3> =
                (0..=24).map(|k| other[0].lerp(other[1], f64::from(k) / 24.0)).collect();
            check(&Segment(other[0], other[1]), &on_segment, &triangle);
            check(&other, &grid(&other, 24), &triangle);
        }
    }

    #[test]
    fn segments_meet_part_and_degenerate() {
        let check = |a: (DVec3, DVec3), b: (DVec3, DVec3), distance: f64| {
            let found = Segment(a.0, a.1).to_segment(&Segment(b.0, b.1));
            assert!((found.distance - distance).abs() < 1e-12, "{found:?}");
        };
        let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
        check((-x, x), (-y, y), 0.0);
        check((-x, x), (-y + z, y + z), 1.0);
        check((-x, x), (z - x * 5.0, z + x * 5.0), 1.0);
        check((-x, x), (x * 3.0, x * 4.0), 2.0);
        check((x, x), (y, y), std::f64::consts::SQRT_2);
        check((-x, x), (z, z), 1.0);
    }

    #[test]
    fn crossing_triangles_touch() {
        let floor = [DVec3::new(-2.0, -2.0, 0.0), DVec3::new(2.0, -2.0, 0.0), DVec3::new(0.0, 3.0, 0.0)];
        let wall = [DVec3::new(0.0, 0.0, -1.0), DVec3::new(0.1, 0.0, 1.0), DVec3::new(0.0, 0.1, 1.0)];
        assert_eq!(wall.contact(&floor).distance, 0.0);
        assert_eq!(floor.contact(&wall).distance, 0.0);
        let above = wall.map(|p| p + DVec3::Z * 1.5);
        assert!((above.contact(&floor).distance - 0.5).abs() < 1e-12);
    }
}
