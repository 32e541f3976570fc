//! `clearance.bend`: the tightest bend of each axis, as a bound on its exact curvature.
//!
//! Notation, in this file only: a rational Bézier piece is `A(t)/w(t)`. With `D = w·A′ − w′·A` and
//! `N = w·(A′×A″) + w′·(A″×A) + w″·(A×A′)` its curvature is `κ = |N|·w³/|D|³`. N, D and w are polynomials in Bernstein
//! form, so their coefficients bound κ over the whole piece; the piece is halved until that bound is at most 0.1 % above
//! a value that κ takes.

use crate::bernstein::{derivative, product};
use crate::judgement::{Judgement, Rule};
use crate::strand::Strand;
use fibar_core::artefact::verdict::Place;
use fibar_ruler::bezier::Bezier;
use glam::DVec3;
use rayon::prelude::*;

/// A bound on a curvature and where it is met.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Bend {
    curvature: f64,
    point: DVec3,
}

/// How much a bound may exceed the curvature itself, as a share.
const SHARE: f64 = 1e-3;
/// Anything straighter than this is straight, 1/mm.
const STRAIGHT: f64 = 1e-6;
/// A piece with a control polygon shorter than this is a point, mm.
const POINT_MM: f64 = 1e-6;
/// Tangents that differ by more than this between pieces make a corner, whose radius is 0; rad.
const CORNER: f64 = 1e-6;

/// Measures every fibre.
pub fn judge(strands: &[Strand], at_least: f64) -> Option<Judgement> {
    let places = strands.par_iter().map(tightest).collect();
    let rule = Rule {
        name: "clearance.bend",
        metric: "clearance.min_bend_radius_mm",
        at_least,
        subject: "bend radius of a fibre's axis",
    };
    rule.judge(places)
}

fn tightest(strand: &Strand) -> Place {
    let mut worst = Bend { curvature: STRAIGHT, point: strand.curve.start() };
    for piece in &strand.curve.pieces {
        raise(piece, &mut worst);
    }
    let sharp = strand.curve.corners().find(|corner| corner.angle > CORNER);
    let (value, position) = match sharp {
        Some(corner) => (0.0, corner.point),
        None => (1.0 / worst.curvature, worst.point),
    };
    let what = match sharp {
        Some(corner) => format!("fibre {}, a corner of {:.3}°", strand.id, corner.angle.to_degrees()),
        None => format!("fibre {}", strand.id),
    };
    Place { position, value, what }
}

/// Raises `worst` to the greatest curvature of a piece, if that is greater.
fn raise(piece: &Bezier, worst: &mut Bend) {
    let bound = curvature_bound(piece);
    if bound <= worst.curvature {
        return;
    }
    let jet = piece.jet(0.5);
    let length = piece.polygon_length();
    if bound <= jet.curvature() * (1.0 + SHARE) {
        *worst = Bend { curvature: bound, point: jet.point };
    } else if length < POINT_MM {
        let curvature = piece.polygon_turning() / length.max(f64::MIN_POSITIVE);
        if curvature > worst.curvature {
            *worst = Bend { curvature, point: jet.point };
        }
    } else {
        let (first, second) = piece.split(0.5);
        raise(&first, worst);
        raise(&second, worst);
    }
}

/// A curvature that the piece nowhere exceeds, 1/mm; infinite if the bound cannot be had from the coefficients.
fn curvature_bound(piece: &Bezier) -> f64 {
    let start = piece.start();
    let points: Vec<DVec3> = piece.homogeneous.iter().map(|h| h.truncate() - start * h.w).collect();
    let weights: Vec<f64> = piece.homogeneous.iter().map(|h| h.w).collect();
    if points.len() < 3 {
        return 0.0;
    }
    let (points_1, weights_1) = (derivative(&points), derivative(&weights));
    let (points_2, weights_2) = (derivative(&points_1), derivative(&weights_1));
    let scale = |w: f64, v: DVec3| v * w;
    let velocity = difference(&product(&weights, &points_1, scale), &product(&weights_1, &points, scale));
    let turns = [
        product(&weights, &product(&points_1, &points_2, DVec3::cross), scale),
        product(&weights_1, &product(&points_2, &points, DVec3::cross), scale),
        product(&weights_2, &product(&points, &points_1, DVec3::cross), scale),
    ];
    let turn =
        (0..turns[0].len()).map(|k| (turns[0][k] + turns[1][k] + turns[2][k]).length()).fold(0.0, f64::max);
    let forward = velocity.iter().sum::<DVec3>().normalize_or_zero();
    let slowest = velocity.iter().map(|v| v.dot(forward)).fold(f64::INFINITY, f64::min);
    let heaviest = weights.iter().copied().fold(0.0, f64::max);
    if slowest > 0.0 { turn * cube(heaviest / slowest) } else { f64::INFINITY }
}

fn difference(a: &[DVec3], b: &[DVec3]) -> Vec<DVec3> {
    a.iter().zip(b).map(|(a, b)| *a - *b).collect()
}

fn cube(x: f64) -> f64 {
    x * x * x
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::strand::tests::strand;
    use glam::DVec4;
    use rand::RngExt;
    use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};

    fn random_piece(rng: &mut ChaCha8Rng) -> Bezier {
        let mut point = || DVec3::from_array([0; 3].map(|_| rng.random_range(0.0..40.0)));
        let points = [point(), point(), point(), point()];
        let weighted = points.map(|p| {
            let w = rng.random_range(0.5..2.0);
            DVec4::from((p * w, w))
        });
        Bezier { homogeneous: weighted.to_vec() }
    }

    #[test]
    fn no_sample_bends_more_than_the_bound_and_the_bound_is_tight() {
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        for _ in 0..40 {
            let piece = random_piece(&mut rng);
            let mut worst = Bend { curvature: STRAIGHT, point: DVec3::ZERO };
            raise(&piece, &mut worst);
            let sampled =
                (0..=20_000).map(|k| piece.jet(f64::from(k) / 20_000.0).curvature()).fold(0.0, f64::max);
            assert!(sampled <= worst.curvature * (1.0 + 1e-9), "{sampled} exceeds {worst:?}");
            assert!(worst.curvature <= sampled * (1.0 + 2.0 * SHARE), "{worst:?} is far above {sampled}");
        }
    }

    #[track_caller]
    fn check(piece: &[DVec3], radius: f64) {
        let mut worst = Bend { curvature: STRAIGHT, point: DVec3::ZERO };
        raise(&Bezier::polynomial(piece), &mut worst);
        let found = 1.0 / worst.curvature;
        assert!((found - radius).abs() <= 2.0 * SHARE * radius + 1e-3, "{found} instead of {radius}");
    }

    #[test]
    fn parabolas_cusps_and_straight_lines() {
        let (x, y) = (DVec3::X, DVec3::Y);
        check(&[DVec3::ZERO, x * 10.0, x * 10.0 + y * 10.0], 7.071);
        check(&[DVec3::ZERO, x * 30.0 + y * 30.0, y * 30.0, x * 30.0], 0.0);
        check(&[DVec3::ZERO, DVec3::ZERO, x * 10.0, x * 20.0], 1.0 / STRAIGHT);
        check(&[DVec3::ZERO, x, x * 7.0, x * 20.0], 1.0 / STRAIGHT);
    }

    #[test]
    fn a_corner_has_no_radius() {
        let bent = strand(1, 1, vec![DVec3::ZERO, DVec3::X * 9.0, DVec3::new(9.0, 9.0, 0.0)]);
        let found = tightest(&bent);
        assert_eq!((found.value, found.position), (0.0, DVec3::X * 9.0));
    }
}
