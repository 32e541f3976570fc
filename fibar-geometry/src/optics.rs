//! The law of light along a bent fibre: what a bend absorbs, what a curve lets through.
//!
//! Two laws share the constants of [`LightLaw`]. The **printed** one is `a(r) = c1 + c2·exp(−c3·r)` (Tone 2020, "Light
//! throughput"). Its loss per radian, `r·a(r)`, peaks at `r*` (11.35 mm with the paper's constants) and falls to 0 with r:
//! a kink is free. The **monotone** one continues it below `r*` by `r*·a(r*)/r`, so that a bend costs by the radian there
//! and a kink as much as the costliest bend. Both are extrapolated below 20 mm.
//!
//! [`Throughput`] integrates either along the exact curve; [`discrete`] is the paper's own estimate from control points;
//! [`coupling`] is how the fibres of one LED share its light.

pub mod coupling;
pub mod discrete;
mod kronrod;

use crate::curve::Curve;
use fibar_core::light::LightLaw;
use kronrod::{Estimate, integrate};

/// Either reading of the law, ready to evaluate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Absorption {
    law: LightLaw,
    /// Curvature above which the loss grows by the radian, 1/mm; infinite under the printed law.
    kink_curvature: f64,
    /// Loss per radian there; 0 under the printed law.
    kink_loss: f64,
}

impl Absorption {
    /// The law as printed.
    pub fn printed(law: LightLaw) -> Absorption {
        Absorption { law, kink_curvature: f64::INFINITY, kink_loss: 0.0 }
    }

    /// The monotone law; the printed one where that has no peak.
    pub fn monotone(law: LightLaw) -> Absorption {
        let printed = Absorption::printed(law);
        match costliest_radius(law) {
            Some(radius) => {
                let kink_loss = radius * printed.per_mm(1.0 / radius);
                Absorption { law, kink_curvature: 1.0 / radius, kink_loss }
            }
            None => printed,
        }
    }

    /// Absorption at a curvature (1/mm, not negative), per mm.
    pub fn per_mm(&self, curvature: f64) -> f64 {
        if curvature > self.kink_curvature {
            self.kink_loss * curvature
        } else {
            self.law.c1_per_mm + self.law.c2_per_mm * libm::exp(-self.law.c3_per_mm / curvature)
        }
    }

    /// Absorption at a curvature (1/mm, not negative), per mm, and its derivative by the curvature.
    pub fn with_slope(&self, curvature: f64) -> (f64, f64) {
        let LightLaw { c1_per_mm: c1, c2_per_mm: c2, c3_per_mm: c3, .. } = self.law;
        if curvature > self.kink_curvature {
            return (self.kink_loss * curvature, self.kink_loss);
        }
        let exponent = c3 / curvature;
        if exponent > 40.0 {
            return (c1, 0.0);
        }
        let bend = c2 * libm::exp(-exponent);
        (c1 + bend, bend * c3 / (curvature * curvature))
    }

    /// Distance from which the camera sees a marker whose fibre loses this much, `c5·exp(−½·loss)`, mm.
    pub fn d_cam_mm(&self, loss: f64) -> f64 {
        self.law.c5_mm * libm::exp(-0.5 * loss)
    }

    /// The constants.
    pub fn law(&self) -> LightLaw {
        self.law
    }

    /// Loss of a corner without length that turns by an angle, rad.
    pub fn of_corner(&self, angle: f64) -> f64 {
        self.kink_loss * angle
    }
}

/// The radius `r*` of the costliest bend per radian, the peak of `r·a(r)`, mm; `None` when there is no peak because the
/// straight loss outweighs the bend's (`c1 ≥ c2·e⁻²`).
pub fn costliest_radius(law: LightLaw) -> Option<f64> {
    let LightLaw { c1_per_mm: c1, c2_per_mm: c2, c3_per_mm: c3, .. } = law;
    let slope = |r: f64| c1 + c2 * libm::exp(-c3 * r) * (1.0 - c3 * r);
    let (mut rising, mut falling) = (1.0 / c3, 2.0 / c3);
    if !(c3 > 0.0 && slope(rising) > 0.0 && slope(falling) < 0.0) {
        return None;
    }
    for _ in 0..60 {
        let middle = 0.5 * (rising + falling);
        *if slope(middle) > 0.0 { &mut rising } else { &mut falling } = middle;
    }
    Some(rising)
}

/// How exactly to integrate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThroughputOptions {
    /// Error allowed in `∫a ds` of a whole curve; 1e-6 is 0.5e-6 of d_cam.
    pub tolerance: f64,
}

impl Default for ThroughputOptions {
    fn default() -> Self {
        ThroughputOptions { tolerance: 1e-6 }
    }
}

/// What becomes of the light along one curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Throughput {
    /// `∫a ds` with the corners' share.
    pub loss: f64,
    /// Estimated error of `loss`.
    pub error: f64,
    /// Distance from which the camera sees the marker: `c5·exp(−½·loss)`, mm (Tone 2020, eq. for `d_cam`).
    pub d_cam_mm: f64,
}

impl Throughput {
    /// Integrates span by span; a joint where the tangent jumps costs its turning angle.
    pub fn of(curve: &Curve, absorption: &Absorption, options: ThroughputOptions) -> Throughput {
        let breaks = curve.breaks();
        let tolerance = options.tolerance / breaks.len() as f64;
        let per_parameter = |u: f64| {
            let jet = curve.jet(u);
            absorption.per_mm(jet.curvature()) * jet.velocity.length()
        };
        let spans = breaks.windows(2).map(|w| integrate(&per_parameter, (w[0], w[1]), tolerance));
        let Estimate { value, error } = spans.fold(Estimate::default(), Estimate::plus);
        let corners = breaks.windows(3).map(|w| absorption.of_corner(corner_angle(curve, w)));
        let loss = corners.fold(value, |sum, corner| sum + corner);
        Throughput { loss, error, d_cam_mm: absorption.d_cam_mm(loss) }
    }
}

/// Angle between the tangents on either side of the middle one of three breaks, rad; 0 below what the probing step turns.
fn corner_angle(curve: &Curve, breaks: &[f64]) -> f64 {
    const STEP: f64 = 1e-7;
    const SMALLEST_CORNER: f64 = 1e-4;
    let before = curve.tangent(breaks[1] - STEP * (breaks[1] - breaks[0]));
    let after = curve.tangent(breaks[1] + STEP * (breaks[2] - breaks[1]));
    let angle = libm::atan2(before.cross(after).length(), before.dot(after));
    if angle > SMALLEST_CORNER { angle } else { 0.0 }
}

/// Share of a curve's length whose bend radius is below `radius` mm, to about 1/256 of a span.
pub fn share_below_radius(curve: &Curve, radius: f64) -> f64 {
    let whole = curve.length();
    if whole > 0.0 { length_below_radius(curve, radius) / whole } else { 0.0 }
}

fn length_below_radius(curve: &Curve, radius: f64) -> f64 {
    const PARTS: u32 = 256;
    let part = |w: &[f64], k: u32| {
        let width = (w[1] - w[0]) / f64::from(PARTS);
        let jet = curve.jet(w[0] + (f64::from(k) + 0.5) * width);
        if jet.radius() < radius { jet.velocity.length() * width } else { 0.0 }
    };
    let span = |w: &[f64]| (0..PARTS).fold(0.0, |sum, k| sum + part(w, k));
    curve.breaks().windows(2).fold(0.0, |sum, w| sum + span(w))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2};

    const LAW: LightLaw = LightLaw::TONE_2020;

    #[test]
    fn the_costliest_radius_is_the_peak_of_loss_per_radian() {
        let radius = costliest_radius(LAW).unwrap();
        assert!((radius - 11.35).abs() < 0.01, "{radius}");
        let per_radian = |r: f64| r * Absorption::printed(LAW).per_mm(1.0 / r);
        assert!(
            per_radian(radius) > per_radian(radius * 1.001)
                && per_radian(radius) > per_radian(radius / 1.001)
        );
        assert!((per_radian(radius) - 3.11).abs() < 0.01);
        assert_eq!(costliest_radius(LightLaw { c1_per_mm: 0.2, ..LAW }), None);
    }

    #[test]
    fn the_laws_agree_above_the_peak_and_only_the_printed_one_forgives_a_kink() {
        let (printed, monotone) = (Absorption::printed(LAW), Absorption::monotone(LAW));
        for radius in [f64::INFINITY, 100.0, 51.0, 20.0, 11.4] {
            assert_eq!(printed.per_mm(1.0 / radius), monotone.per_mm(1.0 / radius), "{radius}");
        }
        for radius in [11.3, 5.0, 1.0, 0.01] {
            let loss = radius * monotone.per_mm(1.0 / radius);
            assert!((loss - 3.11).abs() < 0.01 && loss > radius * printed.per_mm(1.0 / radius), "{radius}");
        }
        assert_eq!(printed.of_corner(FRAC_PI_2), 0.0);
        let factor = libm::exp(-0.5 * monotone.of_corner(FRAC_PI_2));
        assert!((factor - 0.087).abs() < 5e-4, "a right angle costs {factor}");
    }

    fn d_cam(curve: &Curve, absorption: Absorption) -> f64 {
        let throughput = Throughput::of(curve, &absorption, ThroughputOptions::default());
        assert!(throughput.error <= 1e-6, "{throughput:?}");
        throughput.d_cam_mm
    }

    /// A quarter circle as one rational quadratic.
    fn quarter(radius: f64) -> Curve {
        let points = [DVec3::X, DVec3::X + DVec3::Y, DVec3::Y].map(|p| p * radius);
        Curve::new(2, vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0], &points, &[1.0, FRAC_1_SQRT_2, 1.0]).unwrap()
    }

    #[test]
    fn straight_lines_and_circles_follow_the_closed_form() {
        let line = Curve::clamped_uniform(3, &[0.0, 1.0, 7.0, 8.0, 40.0].map(|z| DVec3::Z * z)).unwrap();
        let exact = 6224.0 * libm::exp(-0.5 * 40.0 * 2.214e-2);
        assert!((d_cam(&line, Absorption::printed(LAW)) - exact).abs() < 1e-4 * exact);
        for radius in [3.0, 11.0, 20.0, 51.0, 300.0] {
            for absorption in [Absorption::printed(LAW), Absorption::monotone(LAW)] {
                let loss = FRAC_PI_2 * radius * absorption.per_mm(1.0 / radius);
                let exact = 6224.0 * libm::exp(-0.5 * loss);
                let got = d_cam(&quarter(radius), absorption);
                assert!((got - exact).abs() < 1e-6 * exact, "r = {radius}: {got} is not {exact}");
            }
        }
    }

    #[test]
    fn a_corner_costs_its_angle() {
        let points = [DVec3::ZERO, DVec3::X * 10.0, DVec3::new(10.0, 10.0, 0.0)];
        let corner = Curve::clamped_uniform(1, &points).unwrap();
        let straight = 6224.0 * libm::exp(-0.5 * 20.0 * 2.214e-2);
        assert!((d_cam(&corner, Absorption::printed(LAW)) - straight).abs() < 1e-6);
        let bent = d_cam(&corner, Absorption::monotone(LAW));
        assert!((bent / straight - 0.087).abs() < 5e-4, "{}", bent / straight);
    }

    #[test]
    fn a_tight_s_bend_is_integrated_to_its_stated_error() {
        let zigzag = [0.0, 1.0, -1.0, 3.0, 0.0, 0.5, 0.0];
        let points: Vec<DVec3> =
            zigzag.iter().enumerate().map(|(k, y)| DVec3::new(2.0 * k as f64, *y, 0.0)).collect();
        let curve = Curve::clamped_uniform(3, &points).unwrap();
        let absorption = Absorption::monotone(LAW);
        let loss = |tolerance| Throughput::of(&curve, &absorption, ThroughputOptions { tolerance });
        let (coarse, fine) = (loss(1e-4), loss(1e-11));
        assert!((coarse.loss - fine.loss).abs() <= 1e-4 && fine.error < 1e-11, "{coarse:?} {fine:?}");
    }

    #[test]
    fn the_share_below_a_radius_is_that_of_the_arc() {
        assert!((share_below_radius(&quarter(19.9), 20.0) - 1.0).abs() < 1e-5);
        assert_eq!(share_below_radius(&quarter(20.1), 20.0), 0.0);
    }
}
