//! The paper's estimate of a route's light from its control points (Tone 2020, "Route optimization").
//!
//! Every inner control point stands for an arc of the circle through it and its neighbours:
//! `E_cam = ∏ exp(−½·l·a(r))`, `l` half the length of the two legs. It shares the printed law's flaw: kinks are free.

use fibar_core::light::LightLaw;
use glam::DVec3;

/// `E_cam` of a route (eq. for `E_cam`), 0 to 1; times c5 it is a distance.
pub fn e_cam(law: &LightLaw, points: &[DVec3]) -> f64 {
    let loss = points.windows(3).fold(0.0, |sum, w| sum + Arc::through([w[0], w[1], w[2]]).loss(law));
    libm::exp(-0.5 * loss)
}

/// `E_cam`, and `weight` times its gradient added to `gradient`, per mm, one entry per control point.
pub fn e_cam_with_gradient(law: &LightLaw, points: &[DVec3], weight: f64, gradient: &mut [DVec3]) -> f64 {
    let value = e_cam(law, points);
    for (k, w) in points.windows(3).enumerate() {
        let [before, after] = Arc::through([w[0], w[1], w[2]]).loss_gradient(law);
        let factor = -0.5 * value * weight;
        gradient[k] -= factor * before;
        gradient[k + 1] += factor * (before - after);
        gradient[k + 2] += factor * after;
    }
    value
}

/// The arc that a control point stands for.
struct Arc {
    /// From the point before, and to the point after, mm.
    legs: [DVec3; 2],
    /// Their lengths, kept off 0, mm.
    lengths: [f64; 2],
    /// Length of `legs[0] + legs[1]`, kept off 0, mm.
    chord: f64,
    /// Cross product of the legs, and its length, mm².
    cross: (DVec3, f64),
    /// Of the circle through the three points, 1/mm.
    curvature: f64,
}

impl Arc {
    /// The circle's curvature is `2·|u × v| / (|u|·|v|·|u + v|)`; straight legs have 0, an about-turn a finite one.
    fn through([before, here, after]: [DVec3; 3]) -> Arc {
        const SHORTEST: f64 = 1e-12;
        let legs = [here - before, after - here];
        let lengths = legs.map(|leg| leg.length().max(SHORTEST));
        let chord = (legs[0] + legs[1]).length().max(SHORTEST);
        let cross = legs[0].cross(legs[1]);
        let area = cross.length();
        Arc {
            legs,
            lengths,
            chord,
            cross: (cross, area),
            curvature: 2.0 * area / (lengths[0] * lengths[1] * chord),
        }
    }

    /// `l` (eq. for `l_pf`), mm.
    fn length(&self) -> f64 {
        0.5 * (self.lengths[0] + self.lengths[1])
    }

    /// `a` (eq. for `a_pf`), per mm, and its derivative by the curvature.
    fn absorption(&self, law: &LightLaw) -> (f64, f64) {
        let bend = law.c2_per_mm * libm::exp(-law.c3_per_mm / self.curvature);
        let slope = if bend > 0.0 { bend * law.c3_per_mm / (self.curvature * self.curvature) } else { 0.0 };
        (law.c1_per_mm + bend, slope)
    }

    /// `l·a`.
    fn loss(&self, law: &LightLaw) -> f64 {
        self.length() * self.absorption(law).0
    }

    /// Gradient of `l·a` by either leg, per mm.
    fn loss_gradient(&self, law: &LightLaw) -> [DVec3; 2] {
        let (absorption, slope) = self.absorption(law);
        let bend = self.curvature_gradient();
        [0, 1].map(|k| {
            let by_length = 0.5 * absorption * self.legs[k] / self.lengths[k];
            by_length + self.length() * slope * bend[k]
        })
    }

    /// Gradient of the curvature by either leg, 1/mm²; 0 where the legs are straight.
    fn curvature_gradient(&self) -> [DVec3; 2] {
        let (cross, area) = self.cross;
        if area == 0.0 {
            return [DVec3::ZERO; 2];
        }
        let across = [self.legs[1].cross(cross), cross.cross(self.legs[0])];
        let along_chord = (self.legs[0] + self.legs[1]) / (self.chord * self.chord);
        [0, 1].map(|k| {
            let along_leg = self.legs[k] / (self.lengths[k] * self.lengths[k]);
            self.curvature * (across[k] / (area * area) - along_leg - along_chord)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAW: LightLaw = LightLaw::TONE_2020;

    #[test]
    fn a_straight_route_loses_by_its_length_less_half_the_end_legs() {
        let points = [0.0, 2.0, 5.0, 9.0, 10.0].map(|z| DVec3::Z * z);
        let exact = libm::exp(-0.5 * 2.214e-2 * (10.0 - 1.0 - 0.5));
        assert!((e_cam(&LAW, &points) - exact).abs() < 1e-12);
    }

    #[test]
    fn points_on_a_circle_see_its_radius() {
        for radius in [12.0, 20.0, 51.0] {
            let at = |k: i32| {
                radius * DVec3::new(libm::cos(0.1 * f64::from(k)), libm::sin(0.1 * f64::from(k)), 0.0)
            };
            let points: Vec<DVec3> = (0..=10).map(at).collect();
            let leg = points[0].distance(points[1]);
            let exact = libm::exp(-0.5 * 9.0 * leg * (2.214e-2 + 7.478e-1 * libm::exp(-9.584e-2 * radius)));
            assert!((e_cam(&LAW, &points) - exact).abs() < 1e-9, "{radius}");
        }
    }

    #[test]
    fn the_gradient_is_that_of_finite_differences() {
        let points: Vec<DVec3> = (0..9)
            .map(f64::from)
            .map(|k| DVec3::new(3.0 * k, libm::sin(0.8 * k) * 4.0, libm::cos(1.3 * k) * 2.0))
            .collect();
        let mut gradient = vec![DVec3::ZERO; points.len()];
        let value = e_cam_with_gradient(&LAW, &points, -2.0, &mut gradient);
        assert_eq!(value, e_cam(&LAW, &points));
        for (k, axis) in (0..points.len()).flat_map(|k| DVec3::AXES.map(|axis| (k, axis))) {
            let moved = |step: f64| {
                let mut points = points.clone();
                points[k] += step * axis;
                e_cam(&LAW, &points)
            };
            let difference = -2.0 * (moved(1e-5) - moved(-1e-5)) / 2e-5;
            let error = (gradient[k].dot(axis) - difference).abs();
            assert!(
                error < 1e-7 * (1.0 + difference.abs()),
                "point {k}, {axis}: {} is not {difference}",
                gradient[k]
            );
        }
    }

    #[test]
    fn straight_coincident_and_folded_points_stay_finite() {
        let check = |points: &[DVec3]| {
            let mut gradient = vec![DVec3::ZERO; points.len()];
            let value = e_cam_with_gradient(&LAW, points, 1.0, &mut gradient);
            assert!(
                value.is_finite() && gradient.iter().all(|g| g.is_finite()),
                "{points:?}: {value} {gradient:?}"
            );
        };
        check(&[DVec3::ZERO, DVec3::X, DVec3::X * 2.0]);
        check(&[DVec3::ZERO, DVec3::X, DVec3::X, DVec3::Y]);
        check(&[DVec3::ZERO, DVec3::X, DVec3::ZERO]);
        check(&[DVec3::ZERO, DVec3::X, DVec3::new(1e-9, 1e-9, 0.0), DVec3::Z]);
    }
}
