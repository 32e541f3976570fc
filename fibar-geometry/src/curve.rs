//! NURBS curves: points, derivatives, curvature, arc length.
//!
//! Evaluation follows Piegl & Tiller, *The NURBS Book*, 2nd ed.: basis functions A2.3, rational derivatives eq. 4.8. What
//! a curve costs in light is in [`crate::optics`]; how it becomes a tube is the sweep's business.

use fibar_core::artefact::routes::Fibre;
use glam::{DVec3, DVec4, Vec4Swizzles};

/// A NURBS curve, mm, over the parameter range [`domain`](Curve::domain).
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    degree: usize,
    knots: Vec<f64>,
    /// Control points times weight, and the weight.
    homogeneous: Vec<DVec4>,
}

/// Position and its first two derivatives with respect to the parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jet {
    /// Position, mm.
    pub position: DVec3,
    /// First derivative, mm per unit of parameter.
    pub velocity: DVec3,
    /// Second derivative, mm per unit of parameter squared.
    pub acceleration: DVec3,
}

/// Why control points, knots and weights are no curve.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CurveError {
    /// Too few points for the degree, or degree 0.
    #[error("a curve of degree {degree} needs at least {needed} control points, has {points}")]
    TooFewPoints {
        /// Degree asked for.
        degree: usize,
        /// Points needed.
        needed: usize,
        /// Points given.
        points: usize,
    },
    /// Knots that fall, are not finite, or are too few or too many.
    #[error("the knots must be finite, rise, and number points + degree + 1")]
    Knots,
    /// Weights that are not positive, or not one per point.
    #[error("the weights must be positive, one per control point")]
    Weights,
}

impl Curve {
    /// A curve from its parts; the lists are as in `routes.json`.
    pub fn new(
        degree: usize,
        knots: Vec<f64>,
        points: &[DVec3],
        weights: &[f64],
    ) -> Result<Curve, CurveError> {
        if degree == 0 || points.len() <= degree {
            return Err(CurveError::TooFewPoints { degree, needed: degree + 1, points: points.len() });
        }
        let sound = knots.iter().all(|k| k.is_finite()) && knots.is_sorted();
        if !sound || knots.len() != points.len() + degree + 1 || knots[degree] >= knots[points.len()] {
            return Err(CurveError::Knots);
        }
        if weights.len() != points.len() || !weights.iter().all(|w| w.is_finite() && *w > 0.0) {
            return Err(CurveError::Weights);
        }
        let homogeneous = std::iter::zip(points, weights).map(|(p, &w)| (*p * w).extend(w)).collect();
        Ok(Curve { degree, knots, homogeneous })
    }

    /// The curve of a fibre, from LED to marker.
    pub fn of_fibre(fibre: &Fibre) -> Result<Curve, CurveError> {
        Curve::new(fibre.degree, fibre.knots.clone(), &fibre.points, &fibre.weights)
    }

    /// The polynomial curve of equal knot spans that starts at the first control point and ends at the last.
    pub fn clamped_uniform(degree: usize, points: &[DVec3]) -> Result<Curve, CurveError> {
        if degree == 0 || points.len() <= degree {
            return Err(CurveError::TooFewPoints { degree, needed: degree + 1, points: points.len() });
        }
        Curve::new(degree, clamped_uniform_knots(degree, points.len()), points, &vec![1.0; points.len()])
    }

    /// First and last parameter.
    pub fn domain(&self) -> (f64, f64) {
        (self.knots[self.degree], self.knots[self.homogeneous.len()])
    }

    /// The distinct knots of the domain: between two neighbours the curve is one rational polynomial.
    pub fn breaks(&self) -> Vec<f64> {
        let mut breaks = self.knots[self.degree..=self.homogeneous.len()].to_vec();
        breaks.dedup();
        breaks
    }

    /// Position at a parameter, mm; parameters beyond the domain are taken as its ends.
    pub fn point(&self, u: f64) -> DVec3 {
        let (span, u) = self.span(u);
        let basis = self.basis(span, u);
        let sum = self.blend(span, &basis[0]);
        sum.xyz() / sum.w
    }

    /// Position, velocity and acceleration at a parameter.
    pub fn jet(&self, u: f64) -> Jet {
        let (span, u) = self.span(u);
        let [a, da, dda] = self.basis(span, u).map(|basis| self.blend(span, &basis));
        let position = a.xyz() / a.w;
        let velocity = (da.xyz() - da.w * position) / a.w;
        let acceleration = (dda.xyz() - 2.0 * da.w * velocity - dda.w * position) / a.w;
        Jet { position, velocity, acceleration }
    }

    /// The first control point that a place depends on, and the values and first two derivatives of the basis functions of
    /// that point and the `degree` after it.
    pub fn basis_at(&self, u: f64) -> (usize, [Vec<f64>; 3]) {
        let (span, u) = self.span(u);
        (span - self.degree, self.basis(span, u))
    }

    /// Unit tangent; zero where the velocity vanishes.
    pub fn tangent(&self, u: f64) -> DVec3 {
        self.jet(u).velocity.normalize_or_zero()
    }

    /// Arc length of the whole curve, mm, to a relative error of about 1e-10 where the curve is regular.
    pub fn length(&self) -> f64 {
        let (first, last) = self.domain();
        self.length_between(first, last)
    }

    /// Arc length between two parameters, mm.
    pub fn length_between(&self, from: f64, to: f64) -> f64 {
        let inner = self.breaks().into_iter().filter(|&u| from < u && u < to);
        let stops: Vec<f64> = std::iter::once(from).chain(inner).chain(std::iter::once(to)).collect();
        stops.windows(2).map(|w| self.integrate(w[0], w[1], &|jet| jet.velocity.length())).sum()
    }

    /// Integral over the parameter of `f` from `a` to `b`, by Gauss–Legendre on eight equal parts.
    ///
    /// Meant for one span between [`breaks`](Curve::breaks), where the integrand is smooth.
    pub fn integrate(&self, a: f64, b: f64, f: &dyn Fn(Jet) -> f64) -> f64 {
        const PARTS: u32 = 8;
        let width = (b - a) / f64::from(PARTS);
        let part = |k: u32| {
            let middle = a + (f64::from(k) + 0.5) * width;
            let at = |(x, w): &(f64, f64)| {
                w * (f(self.jet(middle + 0.5 * width * x)) + f(self.jet(middle - 0.5 * width * x)))
            };
            GAUSS_8.iter().map(at).sum::<f64>() * 0.5 * width
        };
        (0..PARTS).map(part).sum()
    }

    fn blend(&self, span: usize, basis: &[f64]) -> DVec4 {
        let points = &self.homogeneous[span - self.degree..=span];
        std::iter::zip(points, basis).fold(DVec4::ZERO, |sum, (p, b)| sum + *p * *b)
    }

    /// Index of the knot span that holds `u`, and `u` within the domain.
    fn span(&self, u: f64) -> (usize, f64) {
        let (first, last) = self.domain();
        let u = u.clamp(first, last);
        let above = self.knots.partition_point(|&k| k <= u);
        let mut span = above.min(self.homogeneous.len()) - 1;
        while self.knots[span] == self.knots[span + 1] {
            span -= 1;
        }
        (span, u)
    }

    /// Values and first two derivatives of the `degree + 1` basis functions that live on a span (A2.3).
    fn basis(&self, span: usize, u: f64) -> [Vec<f64>; 3] {
        let lower = |degree: usize| self.basis_values(span, u, degree);
        let p = self.degree;
        let values = lower(p);
        let first = self.raise(span, p, &lower(p - 1));
        let second = match p {
            1 => vec![0.0; 2],
            _ => self.raise(span, p, &self.raise(span, p - 1, &lower(p - 2))),
        };
        [values, first, second]
    }

    /// Basis functions `N_{span−degree ..= span, degree}(u)` by the Cox–de Boor recurrence (A2.2).
    fn basis_values(&self, span: usize, u: f64, degree: usize) -> Vec<f64> {
        let mut values = vec![1.0];
        for p in 1..=degree {
            let mut next = vec![0.0; p + 1];
            for (k, value) in values.iter().enumerate() {
                let (left, right) = (self.knots[span + 1 + k - p], self.knots[span + 1 + k]);
                let share = value / (right - left);
                next[k] += (right - u) * share;
                next[k + 1] += (u - left) * share;
            }
            values = next;
        }
        values
    }

    /// One derivative: from coefficients over the basis of `degree − 1` to values over that of `degree`
    /// (`N' = p/(Δ)·N − p/(Δ)·N`, eq. 2.7).
    fn raise(&self, span: usize, degree: usize, lower: &[f64]) -> Vec<f64> {
        let mut raised = vec![0.0; degree + 1];
        for (k, value) in lower.iter().enumerate() {
            let (left, right) = (self.knots[span + 1 + k - degree], self.knots[span + 1 + k]);
            let slope = degree as f64 * value / (right - left);
            raised[k] -= slope;
            raised[k + 1] += slope;
        }
        raised
    }
}

impl Jet {
    /// Curvature `|v × a| / |v|³`, 1/mm; 0 where the velocity vanishes.
    pub fn curvature(&self) -> f64 {
        let speed = self.velocity.length();
        if speed > 0.0 {
            self.velocity.cross(self.acceleration).length() / (speed * speed * speed)
        } else {
            0.0
        }
    }

    /// Radius of curvature, mm; infinite on a straight piece.
    pub fn radius(&self) -> f64 {
        1.0 / self.curvature()
    }
}

/// Knots of equal spans from 0 to 1, `degree + 1` equal ones at either end.
pub fn clamped_uniform_knots(degree: usize, points: usize) -> Vec<f64> {
    let spans = points - degree;
    let knot = |k: usize| (k.saturating_sub(degree).min(spans)) as f64 / spans as f64;
    (0..points + degree + 1).map(knot).collect()
}

/// Positive abscissae and weights of the eight-point Gauss–Legendre rule on [−1, 1].
const GAUSS_8: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_48),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_26),
];

#[cfg(test)]
mod tests {
    use super::*;

    /// Quarter of a circle of radius 10 about the origin: the classical rational quadratic.
    fn quarter() -> Curve {
        let points = [DVec3::X * 10.0, DVec3::new(10.0, 10.0, 0.0), DVec3::Y * 10.0];
        Curve::new(2, vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0], &points, &[1.0, 0.5f64.sqrt(), 1.0]).unwrap()
    }

    #[test]
    fn circle_is_exact() {
        let curve = quarter();
        for k in 0..=20 {
            let jet = curve.jet(f64::from(k) / 20.0);
            assert!((jet.position.length() - 10.0).abs() < 1e-12);
            assert!((jet.radius() - 10.0).abs() < 1e-9, "{}", jet.radius());
            assert!(jet.velocity.dot(jet.position).abs() < 1e-10);
        }
        assert!((curve.length() - 5.0 * std::f64::consts::PI).abs() < 1e-10);
    }

    #[test]
    fn derivatives_are_those_of_the_positions() {
        let points: Vec<DVec3> =
            (0..9).map(|k| DVec3::new(f64::from(k), f64::from(k * k % 5), f64::from(k % 3))).collect();
        for degree in 1..=5 {
            let curve = Curve::clamped_uniform(degree, &points).unwrap();
            for k in 0..50 {
                let (u, h) = (0.0113 + f64::from(k) * 0.0193, 1e-5);
                let (a, b, c) = (curve.point(u - h), curve.jet(u), curve.point(u + h));
                let crosses = curve.breaks().iter().any(|&k| (k - u).abs() <= h);
                let bend = (a - 2.0 * b.position + c) / (h * h);
                assert!(
                    crosses || (b.velocity - (c - a) / (2.0 * h)).length() < 1e-4,
                    "degree {degree} u {u}"
                );
                assert!(crosses || (b.acceleration - bend).length() < 0.05, "degree {degree} u {u}");
            }
            assert_eq!((curve.point(0.0), curve.point(1.0)), (points[0], points[8]));
        }
    }

    #[test]
    fn straight_line_has_its_length_and_no_curvature() {
        let points: Vec<DVec3> = (0..7).map(|k| DVec3::new(0.0, 0.0, f64::from(k * k))).collect();
        let curve = Curve::clamped_uniform(3, &points).unwrap();
        assert!((curve.length() - 36.0).abs() < 1e-9);
        assert_eq!(curve.jet(0.4).radius(), f64::INFINITY);
    }

    #[test]
    fn broken_parts_are_refused() {
        let line = [DVec3::ZERO, DVec3::X];
        let check = |degree, knots: &[f64], weights: &[f64]| {
            Curve::new(degree, knots.to_vec(), &line, weights).unwrap_err()
        };
        assert_eq!(check(0, &[], &[]), CurveError::TooFewPoints { degree: 0, needed: 1, points: 2 });
        assert_eq!(check(2, &[], &[]), CurveError::TooFewPoints { degree: 2, needed: 3, points: 2 });
        assert_eq!(check(1, &[0.0, 0.0, 1.0], &[1.0, 1.0]), CurveError::Knots);
        assert_eq!(check(1, &[0.0, 1.0, 0.0, 1.0], &[1.0, 1.0]), CurveError::Knots);
        assert_eq!(check(1, &[0.0; 4], &[1.0, 1.0]), CurveError::Knots);
        assert_eq!(check(1, &[0.0, 0.0, 1.0, 1.0], &[1.0, 0.0]), CurveError::Weights);
    }
}
