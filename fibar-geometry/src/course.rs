//! A fibre's axis in the making: a cubic of equal knot spans whose ends are held, and what it costs at its nodes.
//!
//! A [`Course`] leaves its LED along the socket's axis and arrives along its marker's normal. What may change is an
//! unconstrained vector of [variables](Course::variables): the place of the mouth under the LED, the lengths of the end legs, the
//! tilt of arrival, and the control points between. Costs are sums over [`nodes`](nodes::Nodes), Gauss points of every span;
//! their gradients flow back to the variables. Limits are soft here ([`costs`]); whether a curve keeps them is decided by
//! [`crate::room`] on the curve itself.

pub mod costs;
pub mod nodes;

use crate::curve::{Curve, clamped_uniform_knots};
use glam::DVec3;

/// Where a fibre starts and ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ends {
    /// The LED's tip, mm.
    pub tip: DVec3,
    /// Unit vector from the LED into the body.
    pub axis: DVec3,
    /// The marker, mm.
    pub marker: DVec3,
    /// Outward unit normal there.
    pub normal: DVec3,
}

/// What the ends may do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Freedom {
    /// How far from the LED's tip, square to its axis, a fibre may start, mm.
    pub mouth_radius: f64,
    /// Tangent of the angle to the normal at which a fibre may arrive.
    pub tilt: f64,
}

/// The axis of one fibre.
#[derive(Clone, Debug, PartialEq)]
pub struct Course {
    /// Where it starts and ends.
    pub ends: Ends,
    /// What the ends may do.
    pub freedom: Freedom,
    /// Control points, from LED to marker, mm; at least [`FEWEST_POINTS`].
    pub points: Vec<DVec3>,
}

/// Degree of the curve.
pub const DEGREE: usize = 3;
/// Fewest control points: two legs and two points between.
pub const FEWEST_POINTS: usize = 6;
/// Variables before the inner points, and after them.
const LEADING: usize = 3;
const TRAILING: usize = 3;

impl Course {
    /// A course of `count` control points near a polyline from the LED to the marker, which is taken at equal steps; the
    /// end legs have the length that makes the speed even.
    pub fn along((ends, freedom): (Ends, Freedom), line: &[DVec3], count: usize) -> Course {
        let count = count.max(FEWEST_POINTS);
        let spans = (count - DEGREE) as f64;
        let length: f64 = line.windows(2).map(|w| w[0].distance(w[1])).sum();
        let leg = length / (3.0 * spans);
        // Greville abscissae: where on an even straight line the control points lie.
        let at = |k: usize| match k {
            1 => leg,
            k if k + 2 == count => length - leg,
            k => ((k as f64 - 1.0).clamp(0.0, spans)) / spans * length,
        };
        let mut points: Vec<DVec3> = (0..count).map(|k| point_at(line, at(k))).collect();
        let shift = points[0] - ends.tip;
        points[0] =
            ends.tip + (shift - ends.axis * shift.dot(ends.axis)).clamp_length_max(freedom.mouth_radius);
        points[1] = points[0] + leg * ends.axis;
        points[count - 2] = ends.marker - leg * ends.normal;
        points[count - 1] = ends.marker;
        Course { ends, freedom, points }
    }

    /// The curve.
    pub fn curve(&self) -> Curve {
        Curve::clamped_uniform(DEGREE, &self.points).expect("a course has six points or more")
    }

    /// Knots of the curve.
    pub fn knots(&self) -> Vec<f64> {
        clamped_uniform_knots(DEGREE, self.points.len())
    }

    /// The variables of a course of `count` control points.
    pub fn variable_count(count: usize) -> usize {
        LEADING + 3 * (count - 4) + TRAILING
    }

    /// What may change, as a vector: place of the mouth (2, mm), length of the first leg (mm), inner control points (mm), length
    /// of the last leg (mm), tilt of arrival (2).
    pub fn variables(&self) -> Vec<f64> {
        let count = self.points.len();
        let (e1, e2) = self.ends.axis.any_orthonormal_pair();
        let (f1, f2) = self.ends.normal.any_orthonormal_pair();
        let mouth = self.points[0] - self.ends.tip;
        let leg = self.points[1] - self.points[0];
        let arrival = self.ends.marker - self.points[count - 2];
        let last = arrival.dot(self.ends.normal);
        let tilt = arrival / last.max(1e-9);
        let tilt = Disc(self.freedom.tilt).to_plane([tilt.dot(f1), tilt.dot(f2)]);
        let mouth = Disc(self.freedom.mouth_radius).to_plane([mouth.dot(e1), mouth.dot(e2)]);
        let mut variables = vec![mouth[0], mouth[1], leg.dot(self.ends.axis)];
        variables.extend(self.points[2..count - 2].iter().flat_map(|p| p.to_array()));
        variables.extend([last, tilt[0], tilt[1]]);
        variables
    }

    /// Sets the control points from variables.
    pub fn set_variables(&mut self, variables: &[f64]) {
        let count = self.points.len();
        let (e1, e2) = self.ends.axis.any_orthonormal_pair();
        let (f1, f2) = self.ends.normal.any_orthonormal_pair();
        let mouth = Disc(self.freedom.mouth_radius).of_plane([variables[0], variables[1]]);
        self.points[0] = self.ends.tip + mouth[0] * e1 + mouth[1] * e2;
        self.points[1] = self.points[0] + variables[2] * self.ends.axis;
        let inner = variables[LEADING..variables.len() - TRAILING].chunks_exact(3);
        for (point, v) in self.points[2..count - 2].iter_mut().zip(inner) {
            *point = DVec3::new(v[0], v[1], v[2]);
        }
        let [last, a, b] = [0, 1, 2].map(|k| variables[variables.len() - TRAILING + k]);
        let tilt = Disc(self.freedom.tilt).of_plane([a, b]);
        let arrival = self.ends.normal + tilt[0] * f1 + tilt[1] * f2;
        self.points[count - 2] = self.ends.marker - last * arrival;
        self.points[count - 1] = self.ends.marker;
    }

    /// Adds the gradient by the variables to `gradient`, given that by the control points.
    pub fn pull_back(&self, variables: &[f64], by_points: &[DVec3], gradient: &mut [f64]) {
        let count = self.points.len();
        let (e1, e2) = self.ends.axis.any_orthonormal_pair();
        let (f1, f2) = self.ends.normal.any_orthonormal_pair();
        let mouth = by_points[0] + by_points[1];
        let length = gradient.len();
        let mouth = Disc(self.freedom.mouth_radius)
            .pull_back([variables[0], variables[1]], [mouth.dot(e1), mouth.dot(e2)]);
        gradient[0] += mouth[0];
        gradient[1] += mouth[1];
        gradient[2] += by_points[1].dot(self.ends.axis);
        let inner = gradient[LEADING..length - TRAILING].chunks_exact_mut(3);
        for (g, by) in inner.zip(&by_points[2..count - 2]) {
            (g[0], g[1], g[2]) = (g[0] + by.x, g[1] + by.y, g[2] + by.z);
        }
        let arrival = self.ends.marker - self.points[count - 2];
        let last = arrival.dot(self.ends.normal);
        let by = -by_points[count - 2];
        gradient[length - 3] += by.dot(arrival) / last.max(1e-9);
        let at = [variables[length - 2], variables[length - 1]];
        let tilt = Disc(self.freedom.tilt).pull_back(at, [by.dot(f1) * last, by.dot(f2) * last]);
        gradient[length - 2] += tilt[0];
        gradient[length - 1] += tilt[1];
    }

    /// Cost of legs that are too short; its gradient by the variables is added.
    pub fn leg_cost(&self, variables: &[f64], gradient: &mut [f64]) -> f64 {
        const SHORTEST_LEG: f64 = 1.0;
        let mut cost = 0.0;
        for k in [LEADING - 1, variables.len() - TRAILING] {
            let lack = SHORTEST_LEG - variables[k];
            if lack > 0.0 {
                cost += lack * lack;
                gradient[k] -= 2.0 * lack;
            }
        }
        cost
    }
}

/// A disc of this radius as the image of the whole plane: `radius·v/√(1 + v²)`. So limits of the ends hold always.
struct Disc(f64);

impl Disc {
    /// The place on the disc.
    fn of_plane(&self, [a, b]: [f64; 2]) -> [f64; 2] {
        let scale = self.0 / (1.0 + a * a + b * b).sqrt();
        [a * scale, b * scale]
    }

    /// A variable for a place; one near the rim or outside is drawn in, so that it can move.
    fn to_plane(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        const NEAR_RIM: f64 = 0.98;
        if self.0 <= 0.0 {
            return [0.0; 2];
        }
        let (x, y) = (x / self.0, y / self.0);
        let square = x * x + y * y;
        let inwards = if square > NEAR_RIM * NEAR_RIM { NEAR_RIM / square.sqrt() } else { 1.0 };
        let (x, y) = (x * inwards, y * inwards);
        let scale = 1.0 / (1.0 - x * x - y * y).sqrt();
        [x * scale, y * scale]
    }

    /// The gradient by the variable, given that by the place.
    fn pull_back(&self, [a, b]: [f64; 2], [x, y]: [f64; 2]) -> [f64; 2] {
        let square = 1.0 + a * a + b * b;
        let scale = self.0 / square.sqrt();
        let along = (a * x + b * y) / square;
        [scale * (x - along * a), scale * (y - along * b)]
    }
}

/// The point of a polyline at an arc length from its start.
fn point_at(line: &[DVec3], mut arc: f64) -> DVec3 {
    for w in line.windows(2) {
        let leg = w[0].distance(w[1]);
        if arc <= leg && leg > 0.0 {
            return w[0].lerp(w[1], arc / leg);
        }
        arc -= leg;
    }
    line[line.len() - 1]
}
