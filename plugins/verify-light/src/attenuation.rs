//! The law integrated along an exact curve.
//!
//! Each Bézier piece is halved until its control polygon turns less than 0.2 rad: the piece turns no more than that, so no
//! kink can hide between the nodes of the quadrature. What still turns more when it has shrunk to a micrometre is a kink
//! and costs its angle, as does a corner between pieces.

use crate::law::MonotoneLaw;
use fibar_core::light::CALIBRATED_RADIUS_MM;
use fibar_ruler::bezier::{Bezier, angle_between};
use fibar_ruler::curve::Curve;
use fibar_ruler::quadrature::{Estimate, integrate};

/// What a fibre loses, and how much of it bends tighter than the calibration's prints.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Attenuation {
    /// `∫a ds` by the monotone law.
    pub monotone: Estimate,
    /// `∫a ds` by the law as printed, where kinks are free.
    pub printed: f64,
    /// Arc length, mm.
    pub length_mm: f64,
    /// Arc length with a bend radius below [`CALIBRATED_RADIUS_MM`], mm.
    pub tight_mm: f64,
}

/// A piece that turns less than this is smooth enough for quadrature, rad.
const SMOOTH_TURN: f64 = 0.2;
/// A piece with a control polygon shorter than this is a point, mm.
const POINT_MM: f64 = 1e-6;
/// Error allowed per smooth piece: to `∫a ds`, and in mm to its length.
const TOLERANCE: f64 = 1e-9;
/// Error allowed per smooth piece to the length that bends too tightly, mm.
const TIGHT_TOLERANCE_MM: f64 = 1e-4;

impl Attenuation {
    /// Integrates from end to end.
    pub fn along(curve: &Curve, law: &MonotoneLaw) -> Attenuation {
        let mut sum = Attenuation::default();
        curve.pieces.iter().for_each(|piece| sum.add_piece(piece, law));
        let turned: f64 = curve.corners().map(|corner| corner.angle).sum();
        sum.monotone.value += law.loss_per_radian * turned;
        sum
    }

    fn add_piece(&mut self, piece: &Bezier, law: &MonotoneLaw) {
        let turning = piece.polygon_turning();
        if turning <= SMOOTH_TURN {
            self.add_smooth(piece, law);
        } else if piece.polygon_length() < POINT_MM {
            self.monotone.value += law.loss_per_radian * turning;
        } else {
            let (first, second) = piece.split(0.5);
            self.add_piece(&first, law);
            self.add_piece(&second, law);
            self.monotone.value += law.loss_per_radian * cusp_between(&first, &second);
        }
    }

    fn add_smooth(&mut self, piece: &Bezier, law: &MonotoneLaw) {
        if piece.polygon_length() == 0.0 {
            return;
        }
        let weighed = |t: f64, weight: &dyn Fn(f64) -> f64| {
            let jet = piece.jet(t);
            let speed = jet.first.length();
            if speed > 0.0 { speed * weight(jet.curvature()) } else { 0.0 }
        };
        let is_tight = |curvature: f64| if curvature * CALIBRATED_RADIUS_MM > 1.0 { 1.0 } else { 0.0 };
        self.monotone = self.monotone + integrate(TOLERANCE, &|t| weighed(t, &|k| law.monotone(k)));
        self.printed += integrate(TOLERANCE, &|t| weighed(t, &|k| law.printed(k))).value;
        self.length_mm += integrate(TOLERANCE, &|t| weighed(t, &|_| 1.0)).value;
        self.tight_mm += integrate(TIGHT_TOLERANCE_MM, &|t| weighed(t, &is_tight)).value;
    }
}

/// Angle of a cusp that sits exactly where a piece was split, rad; nothing to speak of anywhere else.
fn cusp_between(first: &Bezier, second: &Bezier) -> f64 {
    let directions = first.end_direction().zip(second.start_direction());
    directions.map_or(0.0, |(before, after)| angle_between(before, after))
}

#[cfg(test)]
mod tests {
    use super::*;
    use fibar_core::light::LightLaw;
    use glam::DVec3;
    use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2, PI};

    fn law() -> MonotoneLaw {
        MonotoneLaw::of(LightLaw::TONE_2020)
    }

    fn curve(points: &[DVec3]) -> Curve {
        Curve { pieces: vec![Bezier::polynomial(points)] }
    }

    fn quarter_circle(radius: f64) -> Curve {
        let corner = (DVec3::new(radius, radius, 0.0)).extend(1.0) * FRAC_1_SQRT_2;
        let ends = [DVec3::X * radius, DVec3::Y * radius].map(|p| p.extend(1.0));
        Curve { pieces: vec![Bezier { homogeneous: vec![ends[0], corner, ends[1]] }] }
    }

    #[track_caller]
    fn check(curve: &Curve, monotone: f64, length_mm: f64, tight_mm: f64) {
        let found = Attenuation::along(curve, &law());
        assert!((found.monotone.value - monotone).abs() < 1e-6, "{found:?}: ∫a ds should be {monotone}");
        assert!((found.length_mm - length_mm).abs() < 1e-5, "{found:?}: length should be {length_mm}");
        assert!((found.tight_mm - tight_mm).abs() < 1e-2, "{found:?}: {tight_mm} mm should be tight");
        assert!(found.monotone.error < 1e-6);
    }

    #[test]
    fn straight_and_round_fibres_by_hand() {
        check(&curve(&[DVec3::ZERO, DVec3::X * 40.0]), 40.0 * 2.214e-2, 40.0, 0.0);
        for radius in [5.0, 12.0, 30.0, 51.0] {
            let length = radius * FRAC_PI_2;
            let tight = if radius < 20.0 { length } else { 0.0 };
            check(&quarter_circle(radius), length * law().monotone(1.0 / radius), length, tight);
        }
    }

    #[test]
    fn the_best_and_the_worst_right_angle() {
        let factor = |curve: &Curve| libm::exp(-0.5 * Attenuation::along(curve, &law()).monotone.value);
        assert!((factor(&quarter_circle(51.0)) - 0.329).abs() < 0.001);
        assert!((factor(&quarter_circle(1e-3)) - 0.087).abs() < 0.001);
    }

    #[test]
    fn kinks_cost_their_angle_wherever_they_hide() {
        let straight = 40.0 * 2.214e-2;
        let right_angle = law().loss_per_radian * FRAC_PI_2;
        let corner = [DVec3::ZERO, DVec3::X * 20.0, DVec3::new(20.0, 20.0, 0.0)];
        let two_lines =
            Curve { pieces: vec![Bezier::polynomial(&corner[..2]), Bezier::polynomial(&corner[1..])] };
        check(&two_lines, straight + right_angle, 40.0, 0.0);
        let there_and_back = curve(&[DVec3::ZERO, DVec3::X * 40.0, DVec3::ZERO]);
        check(&there_and_back, straight + law().loss_per_radian * PI, 40.0, 0.0);
    }

    #[test]
    fn printed_law_lets_a_kink_go_free() {
        let tiny = Attenuation::along(&quarter_circle(1e-3), &law());
        assert!(tiny.printed < 2e-3 && tiny.monotone.value > 4.8);
    }
}
