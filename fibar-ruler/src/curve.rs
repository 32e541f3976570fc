//! The axis of a fibre: its NURBS curve cut into Bézier pieces, exactly.

use crate::bezier::{Bezier, angle_between};
use crate::quadrature::integrate;
use fibar_core::artefact::routes::Fibre;
use glam::{DVec3, DVec4};

/// Error allowed to lengths along a curve, mm.
const LENGTH_TOLERANCE_MM: f64 = 1e-9;

/// A continuous curve of rational Bézier pieces, from LED to marker.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// The pieces in order, at least one; each starts where the one before ends.
    pub pieces: Vec<Bezier>,
}

/// A break in the tangent between two pieces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corner {
    /// Where, mm.
    pub point: DVec3,
    /// Angle between the tangents before and after, rad.
    pub angle: f64,
}

impl Curve {
    /// The axis of a fibre, by inserting every inner knot up to the degree (Boehm 1980). Says where a curve falls apart,
    /// which a knot of multiplicity above the degree can do.
    pub fn of_fibre(fibre: &Fibre) -> Result<Curve, String> {
        let mut spline = Spline::of_fibre(fibre);
        spline.raise_inner_knots();
        let pieces = spline.pieces();
        let jump = pieces.windows(2).find(|pair| pair[0].end().distance(pair[1].start()) > 1e-9);
        match jump {
            Some(pair) => Err(format!("fibre {} is torn apart at {:.3} mm", fibre.id, pair[0].end())),
            None => Ok(Curve { pieces }),
        }
    }

    /// Where the curve starts, mm.
    pub fn start(&self) -> DVec3 {
        self.pieces[0].start()
    }

    /// Where the curve ends, mm.
    pub fn end(&self) -> DVec3 {
        self.pieces[self.pieces.len() - 1].end()
    }

    /// Arc length, mm.
    pub fn length(&self) -> f64 {
        self.pieces.iter().map(length_of).sum()
    }

    /// Direction in which the curve leaves its start; none if it is a point.
    pub fn start_direction(&self) -> Option<DVec3> {
        self.pieces.iter().find_map(Bezier::start_direction).map(DVec3::normalize)
    }

    /// Direction in which the curve reaches its end; none if it is a point.
    pub fn end_direction(&self) -> Option<DVec3> {
        self.pieces.iter().rev().find_map(Bezier::end_direction).map(DVec3::normalize)
    }

    /// Places every `step` mm along the curve, from its start, mm; chords of a 128th of a piece stand for its arc.
    pub fn stations(&self, step: f64) -> Vec<DVec3> {
        let chords = self
            .pieces
            .iter()
            .flat_map(|piece| (0..128).map(|k| [k, k + 1].map(|end| piece.point(f64::from(end) / 128.0))));
        let mut places = vec![self.start()];
        let mut ahead = step;
        for [from, to] in chords {
            let length = from.distance(to);
            while ahead <= length {
                places.push(from.lerp(to, ahead / length));
                ahead += step;
            }
            ahead -= length;
        }
        places
    }

    /// The places between pieces where the tangent breaks, however little.
    pub fn corners(&self) -> impl Iterator<Item = Corner> + '_ {
        let solid: Vec<&Bezier> = self.pieces.iter().filter(|p| p.polygon_length() > 0.0).collect();
        let corner = |pair: &[&Bezier]| {
            let (before, after) = (pair[0].end_direction()?, pair[1].start_direction()?);
            Some(Corner { point: pair[1].start(), angle: angle_between(before, after) })
        };
        solid.windows(2).filter_map(corner).collect::<Vec<_>>().into_iter()
    }

    /// The curve without its first `from_start` and last `from_end` mm; none if nothing is left.
    pub fn trimmed(&self, from_start: f64, from_end: f64) -> Option<Curve> {
        let mut pieces = without_first(self.pieces.clone(), from_start)?;
        pieces = without_first(reversed(pieces), from_end)?;
        Some(Curve { pieces: reversed(pieces) })
    }
}

/// A NURBS curve whose knots may still be single.
struct Spline {
    degree: usize,
    knots: Vec<f64>,
    points: Vec<DVec4>,
}

impl Spline {
    fn of_fibre(fibre: &Fibre) -> Spline {
        let points = fibre.points.iter().zip(&fibre.weights).map(|(p, w)| (*p * *w).extend(*w)).collect();
        Spline { degree: fibre.degree, knots: fibre.knots.clone(), points }
    }

    fn raise_inner_knots(&mut self) {
        let last = self.knots[self.knots.len() - 1];
        let mut k = self.degree + 1;
        while self.knots[k] < last {
            let knot = self.knots[k];
            let count = self.knots[k..].iter().take_while(|u| **u == knot).count();
            (count..self.degree).for_each(|_| self.insert(knot));
            k += count.max(self.degree);
        }
    }

    /// Boehm's knot insertion, once.
    fn insert(&mut self, knot: f64) {
        let (degree, knots) = (self.degree, &self.knots);
        let span = knots.partition_point(|u| *u <= knot) - 1;
        let count = knots[..=span].iter().rev().take_while(|u| **u == knot).count();
        let blend = |i: usize| {
            let share = (knot - knots[i]) / (knots[i + degree] - knots[i]);
            self.points[i - 1].lerp(self.points[i], share)
        };
        let blended: Vec<DVec4> = (span + 1 - degree..=span - count).map(blend).collect();
        self.points.splice(span + 1 - degree..span - count, blended);
        self.knots.insert(span + 1, knot);
    }

    /// The pieces between knots of multiplicity `degree` (or `degree + 1`, where the curve may be torn).
    fn pieces(&self) -> Vec<Bezier> {
        let starts = (self.degree..self.points.len()).filter(|&k| self.knots[k] < self.knots[k + 1]);
        starts.map(|k| Bezier { homogeneous: self.points[k - self.degree..=k].to_vec() }).collect()
    }
}

fn length_of(piece: &Bezier) -> f64 {
    integrate(LENGTH_TOLERANCE_MM, &|t| piece.jet(t).first.length()).value
}

fn reversed(pieces: Vec<Bezier>) -> Vec<Bezier> {
    let turn = |mut piece: Bezier| {
        piece.homogeneous.reverse();
        piece
    };
    pieces.into_iter().rev().map(turn).collect()
}

fn without_first(mut pieces: Vec<Bezier>, mut distance: f64) -> Option<Vec<Bezier>> {
    while !pieces.is_empty() {
        let length = length_of(&pieces[0]);
        if distance < length {
            pieces[0] = pieces[0].split(parameter_at(&pieces[0], distance)).1;
            return Some(pieces);
        }
        distance -= length;
        pieces.remove(0);
    }
    None
}

/// The parameter that `distance` mm from the start has, by bisection.
fn parameter_at(piece: &Bezier, distance: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if length_of(&piece.split(middle).0) < distance { low = middle } else { high = middle }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::*;
    use fibar_core::material::LayerRadii;
    use fibar_core::{LedId, MarkerId, PatternId};
    use rand::RngExt;
    use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};

    fn fibre(degree: usize, knots: Vec<f64>, points: Vec<DVec3>, weights: Vec<f64>) -> Fibre {
        let radii_mm = LayerRadii::TONE_2020;
        let (marker, led, pattern) = (MarkerId(1), LedId(0), PatternId(1));
        Fibre { id: 1, marker, led, pattern, degree, knots, points, weights, radii_mm }
    }

    /// The textbook value: a sum of Cox–de Boor basis functions.
    fn cox_de_boor(fibre: &Fibre, u: f64) -> DVec3 {
        fn basis(knots: &[f64], i: usize, p: usize, u: f64) -> f64 {
            if p == 0 {
                return if knots[i] <= u && u < knots[i + 1] { 1.0 } else { 0.0 };
            }
            let part = |from: f64, to: f64, x: f64| if to > from { x / (to - from) } else { 0.0 };
            part(knots[i], knots[i + p], u - knots[i]) * basis(knots, i, p - 1, u)
                + part(knots[i + 1], knots[i + p + 1], knots[i + p + 1] - u) * basis(knots, i + 1, p - 1, u)
        }
        let terms = (0..fibre.points.len()).map(|i| {
            let n = basis(&fibre.knots, i, fibre.degree, u) * fibre.weights[i];
            (fibre.points[i] * n).extend(n)
        });
        let sum = terms.fold(DVec4::ZERO, |a, b| a + b);
        sum.truncate() / sum.w
    }

    #[test]
    fn pieces_lie_on_the_spline() {
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        for degree in 1..=5 {
            let inner = [0.2, 0.3, 0.3, 0.7, 0.8];
            let knots: Vec<f64> = [vec![0.0; degree + 1], inner.to_vec(), vec![1.0; degree + 1]].concat();
            let count = knots.len() - degree - 1;
            let points = (0..count).map(|_| DVec3::new(rng.random(), rng.random(), rng.random())).collect();
            let weights = (0..count).map(|_| rng.random_range(0.5..2.0)).collect();
            let fibre = fibre(degree, knots, points, weights);
            let Ok(curve) = Curve::of_fibre(&fibre) else {
                assert_eq!(degree, 1, "only the broken line has a knot above its degree");
                continue;
            };
            let breaks = [0.0, 0.2, 0.3, 0.7, 0.8, 1.0];
            assert_eq!(curve.pieces.len(), 5);
            for (piece, span) in curve.pieces.iter().zip(breaks.windows(2)) {
                for t in [0.0, 0.25, 0.5, 0.99] {
                    let u = span[0] + t * (span[1] - span[0]);
                    assert!(
                        piece.point(t).distance(cox_de_boor(&fibre, u)) < 1e-12,
                        "degree {degree} at {u}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_broken_line_has_corners_and_a_length() {
        let points = vec![DVec3::ZERO, DVec3::X * 3.0, DVec3::new(3.0, 4.0, 0.0)];
        let line = Curve::of_fibre(&fibre(1, vec![0.0, 0.0, 0.5, 1.0, 1.0], points, vec![1.0; 3])).unwrap();
        assert!((line.length() - 7.0).abs() < 1e-12);
        let corners: Vec<Corner> = line.corners().collect();
        assert_eq!(corners, [Corner { point: DVec3::X * 3.0, angle: std::f64::consts::FRAC_PI_2 }]);
        let rest = line.trimmed(1.0, 2.0).unwrap();
        assert!(
            rest.start().distance(DVec3::X) < 1e-9 && rest.end().distance(DVec3::new(3.0, 2.0, 0.0)) < 1e-9
        );
        assert_eq!(line.trimmed(4.0, 3.5), None);
    }

    #[test]
    fn stations_are_evenly_spaced_along_the_arc() {
        let corner = DVec3::new(30.0, 30.0, 0.0).extend(1.0) * std::f64::consts::FRAC_1_SQRT_2;
        let ends = [DVec3::X, DVec3::Y].map(|p| (p * 30.0).extend(1.0));
        let arc = Curve { pieces: vec![Bezier { homogeneous: vec![ends[0], corner, ends[1]] }] };
        let places = arc.stations(1.5);
        assert_eq!(places.len(), 32, "47.1 mm hold 31 steps of 1.5 mm");
        for (k, place) in places.iter().enumerate() {
            let angle = k as f64 * 1.5 / 30.0;
            let exact = DVec3::new(libm::cos(angle), libm::sin(angle), 0.0) * 30.0;
            assert!(place.distance(exact) < 2e-3, "{k}: {place} is not {exact}");
        }
    }

    #[test]
    fn trimming_keeps_the_rest_of_the_length() {
        let points = [DVec3::ZERO, DVec3::X * 20.0, DVec3::Y * 30.0, DVec3::Z * 25.0];
        let curve = Curve { pieces: vec![Bezier::polynomial(&points)] };
        let rest = curve.trimmed(2.5, 4.0).unwrap();
        assert!((rest.length() - (curve.length() - 6.5)).abs() < 1e-7);
    }
}
