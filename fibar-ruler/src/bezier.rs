//! One rational Bézier piece: points, derivatives, halves, and what its control polygon says about it.
//!
//! With positive weights the piece lies in the convex hull of its control points, is no longer than its control polygon
//! and turns no more than it (de Casteljau's algorithm only cuts corners); all bounds below rest on that.

use glam::{DVec3, DVec4};

/// A rational Bézier curve over `t` in 0..=1.
#[derive(Clone, Debug, PartialEq)]
pub struct Bezier {
    /// Control points times their weight, and the weight: `(w·x, w·y, w·z, w)`; at least two, every weight positive.
    pub homogeneous: Vec<DVec4>,
}

/// Position and the first two derivatives by the parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jet {
    /// Position, mm.
    pub point: DVec3,
    /// First derivative, mm per unit of `t`.
    pub first: DVec3,
    /// Second derivative, mm per unit of `t`².
    pub second: DVec3,
}

impl Bezier {
    /// A piece whose weights are all one.
    pub fn polynomial(points: &[DVec3]) -> Bezier {
        Bezier { homogeneous: points.iter().map(|p| p.extend(1.0)).collect() }
    }

    /// The control points, mm.
    pub fn control_points(&self) -> impl DoubleEndedIterator<Item = DVec3> + '_ {
        self.homogeneous.iter().map(|h| h.truncate() / h.w)
    }

    /// Where the piece starts, mm.
    pub fn start(&self) -> DVec3 {
        project(self.homogeneous[0])
    }

    /// Where the piece ends, mm.
    pub fn end(&self) -> DVec3 {
        project(self.homogeneous[self.homogeneous.len() - 1])
    }

    /// The point at `t`, mm.
    pub fn point(&self, t: f64) -> DVec3 {
        self.jet(t).point
    }

    /// Position and derivatives at `t`, by de Casteljau's algorithm and the quotient rule.
    pub fn jet(&self, t: f64) -> Jet {
        let degree = self.homogeneous.len() - 1;
        let mut row = self.homogeneous.clone();
        while row.len() > 3 {
            row = corner_cut(&row, t);
        }
        let second = match row.as_slice() {
            [a, b, c] => (*a - *b - *b + *c) * (degree * (degree - 1)) as f64,
            _ => DVec4::ZERO,
        };
        while row.len() > 2 {
            row = corner_cut(&row, t);
        }
        let first = (row[1] - row[0]) * degree as f64;
        divide(row[0].lerp(row[1], t), first, second)
    }

    /// The two parts before and after `t`.
    pub fn split(&self, t: f64) -> (Bezier, Bezier) {
        let count = self.homogeneous.len();
        let (mut left, mut right) = (Vec::with_capacity(count), Vec::with_capacity(count));
        let mut row = self.homogeneous.clone();
        while let (Some(first), Some(last)) = (row.first(), row.last()) {
            left.push(*first);
            right.push(*last);
            row = corner_cut(&row, t);
        }
        right.reverse();
        (Bezier { homogeneous: left }, Bezier { homogeneous: right })
    }

    /// Length of the control polygon, mm: at least the length of the piece.
    pub fn polygon_length(&self) -> f64 {
        self.legs().map(DVec3::length).sum()
    }

    /// Sum of the angles between the legs of the control polygon, rad: at least what the piece turns.
    pub fn polygon_turning(&self) -> f64 {
        let legs: Vec<DVec3> = self.legs().filter(|leg| *leg != DVec3::ZERO).collect();
        legs.windows(2).map(|pair| angle_between(pair[0], pair[1])).sum()
    }

    /// Tangent at the start (not normalised), even where the derivative vanishes; none if the piece is a point.
    pub fn start_direction(&self) -> Option<DVec3> {
        let start = self.start();
        self.control_points().map(|p| p - start).find(|d| *d != DVec3::ZERO)
    }

    /// Tangent at the end (not normalised), even where the derivative vanishes; none if the piece is a point.
    pub fn end_direction(&self) -> Option<DVec3> {
        let end = self.end();
        self.control_points().rev().map(|p| end - p).find(|d| *d != DVec3::ZERO)
    }

    fn legs(&self) -> impl Iterator<Item = DVec3> + '_ {
        self.control_points().zip(self.control_points().skip(1)).map(|(a, b)| b - a)
    }
}

impl Jet {
    /// Curvature, 1/mm; infinite where the derivative vanishes.
    pub fn curvature(&self) -> f64 {
        let speed = self.first.length();
        if speed == 0.0 {
            return f64::INFINITY;
        }
        let tangent = self.first / speed;
        tangent.cross(self.second).length() / (speed * speed)
    }
}

/// Angle between two directions, rad, accurate near 0 and π.
pub fn angle_between(a: DVec3, b: DVec3) -> f64 {
    let (a, b) = (a.normalize_or_zero(), b.normalize_or_zero());
    libm::atan2(a.cross(b).length(), a.dot(b))
}

fn project(h: DVec4) -> DVec3 {
    h.truncate() / h.w
}

fn corner_cut(row: &[DVec4], t: f64) -> Vec<DVec4> {
    row.windows(2).map(|pair| pair[0].lerp(pair[1], t)).collect()
}

/// Derivatives of `A/w` from those of `(A, w)`.
fn divide(value: DVec4, first: DVec4, second: DVec4) -> Jet {
    let point = value.truncate() / value.w;
    let velocity = (first.truncate() - point * first.w) / value.w;
    let acceleration = (second.truncate() - velocity * (2.0 * first.w) - point * second.w) / value.w;
    Jet { point, first: velocity, second: acceleration }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2};

    /// A quarter of the circle of radius 30 mm about the origin.
    fn quarter_circle() -> Bezier {
        let corner = DVec3::new(30.0, 30.0, 0.0).extend(1.0) * FRAC_1_SQRT_2;
        Bezier { homogeneous: vec![(DVec3::X * 30.0).extend(1.0), corner, (DVec3::Y * 30.0).extend(1.0)] }
    }

    #[test]
    fn a_quarter_circle_has_its_radius_everywhere() {
        let arc = quarter_circle();
        for k in 0..=16 {
            let jet = arc.jet(f64::from(k) / 16.0);
            assert!((jet.point.length() - 30.0).abs() < 1e-12);
            assert!((jet.curvature() - 1.0 / 30.0).abs() < 1e-12);
            assert!(jet.first.dot(jet.point).abs() < 1e-10);
        }
        assert!((arc.polygon_turning() - FRAC_PI_2).abs() < 1e-12);
    }

    #[test]
    fn halves_are_the_whole() {
        let cubic = Bezier::polynomial(&[DVec3::ZERO, DVec3::X, DVec3::new(3.0, 2.0, 1.0), DVec3::Z * 4.0]);
        for whole in [quarter_circle(), cubic] {
            let (left, right) = whole.split(0.3);
            for k in 0..=8 {
                let t = f64::from(k) / 8.0;
                assert!(left.point(t).distance(whole.point(0.3 * t)) < 1e-12);
                assert!(right.point(t).distance(whole.point(0.3 + 0.7 * t)) < 1e-12);
            }
            assert!(left.polygon_length() + right.polygon_length() < whole.polygon_length());
            assert!(left.polygon_turning() + right.polygon_turning() <= whole.polygon_turning() + 1e-12);
        }
    }

    #[test]
    fn a_direction_exists_where_the_derivative_vanishes() {
        let piece = Bezier::polynomial(&[DVec3::ZERO, DVec3::ZERO, DVec3::X, DVec3::Y]);
        assert_eq!(piece.start_direction(), Some(DVec3::X));
        assert_eq!(piece.jet(0.0).curvature(), f64::INFINITY);
        assert_eq!(Bezier::polynomial(&[DVec3::X, DVec3::X]).end_direction(), None);
    }
}
