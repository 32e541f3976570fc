//! A course as cubic Bézier pieces: bounds on its bend and on its stray from chords that hold everywhere, not at samples.
//!
//! Notation: `B(t)` is a piece over 0..1, `v` and `a` its first two derivatives there. `v × a` is quadratic in t, since the cubic
//! term of `v × v′` vanishes for a quadratic v; so `|v × a|²` and `|v|²` are quartics, and their Bernstein coefficients enclose
//! them. `κ² = |v × a|²/|v|⁶`.

use crate::course::DEGREE;
use glam::DVec3;

/// One span of a course.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// Control points, mm.
    pub points: [DVec3; 4],
    /// Its parameters on the course, which go from 0 to 1.
    pub domain: [f64; 2],
}

/// Derivatives of a piece at a place of it, by its own parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PieceJet {
    /// Place, mm.
    pub position: DVec3,
    /// First derivative, mm.
    pub velocity: DVec3,
    /// Second derivative, mm.
    pub acceleration: DVec3,
}

/// The pieces of a course with these control points, in order.
pub fn of(points: &[DVec3]) -> Vec<Piece> {
    let spans = points.len() - DEGREE;
    let piece = |s: usize| {
        let near = &points[s..=s + DEGREE];
        // Knots about the span, in spans; the first and last are fourfold.
        let knots = [-2.0, -1.0, 0.0, 1.0, 2.0, 3.0].map(|k| (s as f64 + k).clamp(0.0, spans as f64));
        let (a, b) = (knots[2], knots[3]);
        let corners = [[a, a, a], [a, a, b], [a, b, b], [b, b, b]];
        let points = corners.map(|arguments| blossom(near, &knots, arguments));
        Piece { points, domain: [a, b].map(|k| k / spans as f64) }
    };
    (0..spans).map(piece).collect()
}

/// The blossom of a span of a cubic at three arguments (de Boor's scheme with one for each level).
fn blossom(points: &[DVec3], knots: &[f64; 6], arguments: [f64; 3]) -> DVec3 {
    let mut values = [points[0], points[1], points[2], points[3]];
    for (level, argument) in arguments.iter().enumerate() {
        for i in 0..DEGREE - level {
            let (low, high) = (knots[i + level], knots[i + DEGREE]);
            values[i] = values[i].lerp(values[i + 1], (argument - low) / (high - low));
        }
    }
    values[0]
}

impl Piece {
    /// Place at 0..1, mm.
    pub fn point(&self, t: f64) -> DVec3 {
        let [a, b, c, d] = self.points;
        let s = 1.0 - t;
        s * s * s * a + 3.0 * s * s * t * b + 3.0 * s * t * t * c + t * t * t * d
    }

    /// Place and derivatives at 0..1.
    pub fn jet(&self, t: f64) -> PieceJet {
        let [a, b, c, d] = self.points;
        let s = 1.0 - t;
        let (u, v, w) = (b - a, c - b, d - c);
        PieceJet {
            position: self.point(t),
            velocity: 3.0 * (s * s * u + 2.0 * s * t * v + t * t * w),
            acceleration: 6.0 * (s * (v - u) + t * (w - v)),
        }
    }

    /// The other way round.
    pub fn reversed(&self) -> Piece {
        let ([a, b, c, d], [from, to]) = (self.points, self.domain);
        Piece { points: [d, c, b, a], domain: [to, from] }
    }

    /// The part between two places of it.
    pub fn between(&self, from: f64, to: f64) -> Piece {
        let at = |t: f64| self.domain[0] + t * (self.domain[1] - self.domain[0]);
        let [a, b, c, d] = self.points;
        let corner = |r: f64, s: f64, t: f64| {
            let (ab, bc, cd) = (a.lerp(b, r), b.lerp(c, r), c.lerp(d, r));
            ab.lerp(bc, s).lerp(bc.lerp(cd, s), t)
        };
        let points =
            [corner(from, from, from), corner(from, from, to), corner(from, to, to), corner(to, to, to)];
        Piece { points, domain: [at(from), at(to)] }
    }

    /// Both halves.
    pub fn halves(&self) -> [Piece; 2] {
        let [a, b, c, d] = self.points;
        let (ab, bc, cd) = (a.midpoint(b), b.midpoint(c), c.midpoint(d));
        let (abc, bcd) = (ab.midpoint(bc), bc.midpoint(cd));
        let middle = abc.midpoint(bcd);
        let [from, to] = self.domain;
        let half = 0.5 * (from + to);
        [
            Piece { points: [a, ab, abc, middle], domain: [from, half] },
            Piece { points: [middle, bcd, cd, d], domain: [half, to] },
        ]
    }

    /// How far the piece may be from its chord, mm: `|B(t) − chord(t)| ≤ ¾·max |e|`, e the arms from the chord's thirds.
    pub fn stray(&self) -> f64 {
        let [a, b, c, d] = self.points;
        let third = (d - a) / 3.0;
        let square = (b - a - third).length_squared().max((d - third - c).length_squared());
        0.75 * square.sqrt()
    }

    /// No less than the piece is long, mm: its control polygon.
    pub fn polygon_length(&self) -> f64 {
        self.points.windows(2).fold(0.0, |sum, w| sum + w[0].distance(w[1]))
    }

    /// No less than the square of the curvature anywhere on the piece, 1/mm²; infinite where the piece may stand still.
    fn squared_curvature_bound(&self) -> f64 {
        let [a, b, c, d] = self.points;
        let (u, v, w) = (b - a, c - b, d - c);
        // v = 3·(u, v, w) in Bernstein form; v × a = 18·(u×v, u×w/2, v×w).
        let turn = [u.cross(v), 0.5 * u.cross(w), v.cross(w)].map(|n| 18.0 * n);
        let most = squares(turn).into_iter().fold(0.0, f64::max);
        let least = squares([u, v, w].map(|v| 3.0 * v)).into_iter().fold(f64::INFINITY, f64::min);
        if least > 0.0 { most / (least * least * least) } else { f64::INFINITY }
    }

    /// The largest squared curvature at the ends and in the middle, and where, 0 to 1.
    fn squared_curvature_somewhere(&self) -> (f64, f64) {
        let at = |t: f64| {
            let jet = self.jet(t);
            let square = jet.velocity.length_squared();
            let area = jet.velocity.cross(jet.acceleration).length_squared();
            if square > 0.0 { (area / (square * square * square), t) } else { (f64::INFINITY, t) }
        };
        [0.0, 1.0].map(at).into_iter().fold(at(0.5), |most, next| if next.0 > most.0 { next } else { most })
    }

    /// Raises `most` to no less than the largest squared curvature of the piece, if that is greater.
    fn raise(&self, most: &mut (f64, f64), depth: u32) {
        const SHARE: f64 = 2e-4; // of the squared curvature, by which the bound may exceed it
        const DEEPEST: u32 = 12; // smaller pieces have lost the digits of their bend
        let bound = self.squared_curvature_bound();
        if bound <= most.0 {
            return;
        }
        let (taken, t) = self.squared_curvature_somewhere();
        if bound <= (1.0 + SHARE) * taken || depth == DEEPEST {
            *most = (bound, self.domain[0] + t * (self.domain[1] - self.domain[0]));
            return;
        }
        self.halves().iter().for_each(|half| half.raise(most, depth + 1));
    }
}

/// Bernstein coefficients of the quartic `|q|²` of a quadratic.
fn squares([a, b, c]: [DVec3; 3]) -> [f64; 5] {
    [a.length_squared(), a.dot(b), (a.dot(c) + 2.0 * b.length_squared()) / 3.0, b.dot(c), c.length_squared()]
}

/// A bound on the curvature of a course, 1/mm: not less anywhere (to rounding, 1e-7), and at most two thousandths above what it takes near the
/// parameter that is returned with it.
pub fn tightest_curvature(pieces: &[Piece]) -> (f64, f64) {
    let mut most = (0.0, 0.0);
    pieces.iter().for_each(|piece| piece.raise(&mut most, 0));
    (most.0.sqrt(), most.1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curve::Curve;

    /// Control points that wind, of some number.
    fn winding(count: usize, case: usize) -> Vec<DVec3> {
        let at = |k: usize| {
            let t = (case * 31 + k * 7) as f64;
            let wobble = DVec3::new(libm::sin(t * 1.7), libm::sin(t * 2.3 + 1.0), libm::sin(t * 3.1 + 2.0));
            7.5 * k as f64 * DVec3::Z + 3.0 * wobble
        };
        (0..count).map(at).collect()
    }

    #[test]
    fn pieces_are_the_curve() {
        for (case, count) in [6, 7, 8, 9, 12, 30].into_iter().enumerate() {
            let points = winding(count, case);
            let curve = Curve::clamped_uniform(DEGREE, &points).unwrap();
            let pieces = of(&points);
            assert_eq!(pieces.len(), count - DEGREE);
            for (piece, t) in pieces.iter().flat_map(|p| [0.0, 0.3, 0.99].map(|t| (p, t))) {
                let [from, to] = piece.domain;
                let (jet, own) = (curve.jet(from + (to - from) * t), piece.jet(t));
                assert!(jet.position.distance(own.position) < 1e-9, "{count}");
                assert!((jet.velocity * (to - from)).distance(own.velocity) < 1e-9, "{count}");
                assert!((jet.acceleration * (to - from).powi(2)).distance(own.acceleration) < 1e-8);
                let part = piece.between(0.2, 0.7);
                assert!(part.point(t).distance(piece.point(0.2 + 0.5 * t)) < 1e-9);
            }
        }
    }

    #[test]
    fn no_sample_bends_more_than_the_bound_and_the_bound_is_tight() {
        for case in 0..100 {
            let points = winding(6 + case % 9, case);
            let curve = Curve::clamped_uniform(DEGREE, &points).unwrap();
            let (bound, _) = tightest_curvature(&of(&points));
            let samples = 20_000;
            let at = |k: usize| curve.jet(k as f64 / samples as f64).curvature();
            let sampled = (0..=samples).fold(0.0f64, |most, k| most.max(at(k)));
            assert!(sampled <= bound * (1.0 + 1e-7) && bound <= sampled * 1.002, "{sampled} {bound}");
        }
    }

    #[test]
    fn the_curve_stays_within_its_stray() {
        for piece in (0..20).flat_map(|case| of(&winding(9, case))) {
            let [a, .., d] = piece.points;
            let far = (0..=100).fold(0.0f64, |most, k| {
                let t = f64::from(k) / 100.0;
                most.max(piece.point(t).distance(a.lerp(d, t)))
            });
            assert!(far <= piece.stray() + 1e-12 && piece.stray() <= 2.7 * far + 1e-9);
        }
    }

    #[test]
    fn a_line_has_no_bend_and_a_cusp_no_bound() {
        let line: Vec<DVec3> = (0..8).map(|k| DVec3::X * f64::from(k)).collect();
        assert_eq!(tightest_curvature(&of(&line)).0, 0.0);
        let mut cusp = line;
        cusp[4..].fill(DVec3::X * 3.0);
        assert_eq!(tightest_curvature(&of(&cusp)).0, f64::INFINITY);
    }
}
