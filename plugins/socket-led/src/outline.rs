//! Convex outlines in the plane: what a triangle covers of it between two heights, and how far a point is.

use glam::{DVec2, DVec3};

/// A convex polygon, possibly flat; its corners in turn.
pub struct Outline {
    corners: Vec<DVec2>,
    low: DVec2,
    high: DVec2,
}

/// The part of a triangle between two heights, seen from above; `None` if there is none.
pub fn clip_to_slab(triangle: [DVec3; 3], bottom: f64, top: f64) -> Option<Outline> {
    let above = clip(&triangle, |p| p.z - bottom);
    let corners: Vec<DVec2> = clip(&above, |p| top - p.z).iter().map(|p| p.truncate()).collect();
    (!corners.is_empty()).then(|| Outline::of(corners))
}

/// Sutherland and Hodgman's cut of a polygon by one plane: keeps the side where `height` is not negative.
fn clip(polygon: &[DVec3], height: impl Fn(DVec3) -> f64) -> Vec<DVec3> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (k, &here) in polygon.iter().enumerate() {
        let next = polygon[(k + 1) % polygon.len()];
        let (h, n) = (height(here), height(next));
        if h >= 0.0 {
            kept.push(here);
        }
        if (h < 0.0) != (n < 0.0) {
            kept.push(here.lerp(next, h / (h - n)));
        }
    }
    kept
}

impl Outline {
    /// Of one corner at least.
    pub fn of(corners: Vec<DVec2>) -> Outline {
        let low = corners.iter().fold(DVec2::INFINITY, |low, p| low.min(*p));
        let high = corners.iter().fold(DVec2::NEG_INFINITY, |high, p| high.max(*p));
        Outline { corners, low, high }
    }

    /// Its corners in turn.
    pub fn corners(&self) -> &[DVec2] {
        &self.corners
    }

    /// Distance between the nearest points of two polygons, mm; 0 where they share one.
    pub fn distance_between(&self, other: &Outline) -> f64 {
        let crosses = self.edges().any(|(a, b)| other.edges().any(|(c, d)| cross(a, b, c, d)));
        let nearest = |of: &Outline, to: &Outline| {
            of.corners.iter().map(|corner| to.distance(*corner)).fold(f64::INFINITY, f64::min)
        };
        if crosses { 0.0 } else { nearest(self, other).min(nearest(other, self)) }
    }

    fn edges(&self) -> impl Iterator<Item = (DVec2, DVec2)> {
        self.corners.iter().copied().zip(self.corners.iter().copied().cycle().skip(1))
    }

    /// Distance to the nearest point of the polygon, mm; 0 inside.
    pub fn distance(&self, point: DVec2) -> f64 {
        if contains(&self.corners, point) {
            return 0.0;
        }
        let edges = self.corners.iter().zip(self.corners.iter().cycle().skip(1));
        edges.map(|(a, b)| distance_to_segment(point, *a, *b)).fold(f64::INFINITY, f64::min)
    }

    /// Whether every point of the polygon is at least so far away.
    pub fn is_beyond(&self, point: DVec2, distance: f64) -> bool {
        let box_distance = (self.low - point).max(point - self.high).max(DVec2::ZERO).length();
        box_distance >= distance || self.distance(point) >= distance
    }
}

/// Whether two segments cross where neither ends.
fn cross(a: DVec2, b: DVec2, c: DVec2, d: DVec2) -> bool {
    let side = |from: DVec2, to: DVec2, point: DVec2| (to - from).perp_dot(point - from);
    side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0
}

/// Whether a point lies in a convex polygon, border included; a flat polygon contains nothing.
pub fn contains(polygon: &[DVec2], point: DVec2) -> bool {
    let edges = || polygon.iter().zip(polygon.iter().cycle().skip(1));
    let turn = |(a, b): (&DVec2, &DVec2)| (*b - *a).perp_dot(point - *a);
    let area: f64 = edges().map(|(a, b)| a.perp_dot(*b)).sum();
    area != 0.0 && edges().all(|edge| turn(edge) * area >= 0.0)
}

fn distance_to_segment(point: DVec2, from: DVec2, to: DVec2) -> f64 {
    let arm = to - from;
    let share = (point - from).dot(arm) / arm.length_squared();
    // A segment of no length gives NaN, which the clamp keeps and `max` replaces by 0.
    point.distance(from + arm * share.clamp(0.0, 1.0).max(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slabs_cut_triangles_short() {
        let triangle = [DVec3::ZERO, DVec3::new(10.0, 0.0, 10.0), DVec3::new(0.0, 10.0, 0.0)];
        let check = |top: f64, at: [f64; 2], distance: f64| {
            let outline = clip_to_slab(triangle, 0.0, top).unwrap();
            assert!((outline.distance(at.into()) - distance).abs() < 1e-12, "{top} {at:?}");
            assert!(outline.is_beyond(at.into(), distance) && !outline.is_beyond(at.into(), distance + 0.1));
        };
        check(10.0, [12.0, 0.0], 2.0);
        check(4.0, [12.0, 0.0], 8.0);
        check(4.0, [1.0, 1.0], 0.0);
        check(0.0, [3.0, 5.0], 3.0);
        assert!(clip_to_slab(triangle, 11.0, 12.0).is_none());
    }

    #[test]
    fn a_wall_seen_from_above_is_a_segment() {
        let wall = [DVec3::ZERO, DVec3::new(4.0, 0.0, 0.0), DVec3::new(4.0, 0.0, 9.0)];
        let outline = clip_to_slab(wall, 0.0, 3.0).unwrap();
        assert_eq!(outline.distance(DVec2::new(2.0, 1.5)), 1.5);
        assert_eq!(outline.distance(DVec2::new(7.0, 4.0)), 5.0);
    }
}
