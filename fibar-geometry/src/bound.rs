//! The least light any fibre between two ends must lose: a bound from below that holds for every curve.
//!
//! ```text
//! ∫a(κ) ds  =  λ·D + ∫(a(κ) − λ·t) ds           for any force λ, since ∫t ds = D, the way from end to end
//!           ≥  λ·D + ∫ w(∠(t, λ)) |dt|            w(θ) = min over κ ≤ κmax of (a(κ) − |λ| cos θ)/κ,  |λ| ≤ c1
//! ```
//!
//! The tangent t wanders over the unit sphere from the socket's axis to the normal, and `w` makes its way there cost something.
//! How much at least is bounded by the ways around the pole λ ([`Force::turning`]). Every λ gives a bound; the best of
//! some is taken. The body's walls are left out, so the bound holds with them, too; how the ends may move is allowed for.
//! All sums are taken from the side that keeps the bound a bound.

use crate::course::{Ends, Freedom};
use crate::optics::Absorption;
use glam::DVec3;
use std::f64::consts::PI;

/// Cells of the angle between tangent and force, 0 to π.
const CELLS: usize = 120;
/// Strengths of the force that are tried, relative to c1.
const STRENGTHS: [f64; 8] = [1.0, 0.97, 0.92, 0.85, 0.75, 0.6, 0.4, 0.2];

/// Bounds for all pairs under one law of light and one least bend radius.
pub struct LeastLoss {
    forces: Vec<Force>,
}

impl LeastLoss {
    /// Prepares the tables.
    pub fn new(absorption: &Absorption, min_bend_radius: f64) -> LeastLoss {
        let force = |strength: &f64| Force::new(absorption, min_bend_radius, *strength);
        LeastLoss { forces: STRENGTHS.iter().map(force).collect() }
    }

    /// `∫a ds` that no curve between these ends goes below.
    pub fn between(&self, ends: Ends, freedom: Freedom) -> f64 {
        let pair = Pair::of(ends, freedom);
        let chord = pair.way.normalize_or(ends.axis);
        // Stretched fibres pull along the chord; those with too little room are pushed together.
        let starts = [chord, -chord, (ends.axis - ends.normal).normalize_or(-chord)];
        let tried = self.forces.iter().flat_map(|force| starts.map(|start| (force, start)));
        tried.fold(0.0, |best, (force, start)| force.best_direction(&pair, start).max(best))
    }
}

/// Two ends and what they may do.
struct Pair {
    way: DVec3,
    start: DVec3,
    finish: DVec3,
    mouth_radius: f64,
    tilt: f64,
}

impl Pair {
    fn of(ends: Ends, freedom: Freedom) -> Pair {
        Pair {
            way: ends.marker - ends.tip,
            start: ends.axis,
            finish: ends.normal,
            mouth_radius: freedom.mouth_radius,
            tilt: libm::atan(freedom.tilt),
        }
    }
}

/// A force of one strength, its direction still open.
struct Force {
    /// |λ|, 1/mm.
    strength: f64,
    /// `w` in each cell of the angle, from below.
    weight: Vec<f64>,
    /// `∫w` from 0 to the lower border of each cell, and to π.
    sum: Vec<f64>,
}

impl Force {
    fn new(absorption: &Absorption, min_bend_radius: f64, share: f64) -> Force {
        let strength = share * absorption.law().c1_per_mm;
        let border = |k: usize| PI * k as f64 / CELLS as f64;
        let weight: Vec<f64> = (0..CELLS)
            .map(|k| cheapest_radian(absorption, 1.0 / min_bend_radius, strength * libm::cos(border(k))))
            .collect();
        let mut sum = vec![0.0];
        for w in &weight {
            sum.push(sum[sum.len() - 1] + w * border(1));
        }
        Force { strength, weight, sum }
    }

    /// The best bound over directions of the force: a pattern search.
    fn best_direction(&self, pair: &Pair, start: DVec3) -> f64 {
        const SMALLEST_STEP: f64 = 0.02;
        let (mut direction, mut step) = (start, 0.3);
        let mut best = self.bound(pair, direction);
        while step > SMALLEST_STEP {
            let (a, b) = direction.any_orthonormal_pair();
            let tried = [a, -a, b, -b].map(|side| (direction + step * side).normalize());
            let (value, found) = tried
                .into_iter()
                .map(|u| (self.bound(pair, u), u))
                .fold((best, direction), |best, next| if next.0 > best.0 { next } else { best });
            if value > best {
                (best, direction) = (value, found);
            } else {
                step *= 0.5;
            }
        }
        best
    }

    /// The bound for one direction; the mouth may lie anywhere under the LED.
    fn bound(&self, pair: &Pair, direction: DVec3) -> f64 {
        let across = direction - direction.dot(pair.start) * pair.start;
        let pull = direction.dot(pair.way) - across.length() * pair.mouth_radius;
        self.strength * pull + self.turning(pair, direction)
    }

    /// `∫w |dt|` over any way of the tangent from the start to within the tilt of the finish, at least.
    ///
    /// With m the least angle to the pole on that way, its radial part is at least ∫w from m to either end, and it turns
    /// around the pole at angles no less than m; both together at least as the hypotenuse, as |∫v| ≤ ∫|v|. A way may also pass
    /// round the back, beyond the angle `far`: then its radial part goes there and returns.
    fn turning(&self, pair: &Pair, pole: DVec3) -> f64 {
        const ROUND_THE_BACK: f64 = 0.7 * PI;
        let from = angle_between(pair.start, pole);
        let to = angle_between(pair.finish, pole);
        let (nearest_to, furthest_to) = ((to - pair.tilt).max(0.0), (to + pair.tilt).min(PI));
        let around = (azimuth_between(pair.start, pair.finish, pole) - spread(pair.tilt, to)).max(0.0);
        let far = ROUND_THE_BACK.max(from).max(furthest_to);
        let behind = 2.0 * self.sum_to(far) - self.sum_to(from) - self.sum_to(furthest_to);
        let last = self.cell(far);
        let mut ring =
            (self.cell(from.min(furthest_to))..=last).fold(f64::INFINITY, |g, k| g.min(self.ring(k)));
        let mut least = behind;
        for k in (0..=self.cell(from.min(furthest_to))).rev() {
            ring = ring.min(self.ring(k));
            let pole_side = self.sum[k + 1];
            let radial =
                (self.sum_to(from) - pole_side).max(0.0) + (self.sum_to(nearest_to) - pole_side).max(0.0);
            least = least.min(libm::hypot(radial, ring * around));
        }
        least
    }

    /// What a radian around the pole costs in a cell, at least.
    fn ring(&self, cell: usize) -> f64 {
        let border = |k: usize| libm::sin(PI * k as f64 / CELLS as f64);
        self.weight[cell] * border(cell).min(border(cell + 1)).max(0.0)
    }

    fn cell(&self, angle: f64) -> usize {
        ((angle / PI * CELLS as f64) as usize).min(CELLS - 1)
    }

    /// `∫w` from 0 to an angle.
    fn sum_to(&self, angle: f64) -> f64 {
        let cell = self.cell(angle);
        self.sum[cell] + self.weight[cell] * (angle - PI * cell as f64 / CELLS as f64)
    }
}

/// `min over κ ≤ most of (a(κ) − gain)/κ`, from below: between two curvatures the lesser numerator over the larger κ.
fn cheapest_radian(absorption: &Absorption, most: f64, gain: f64) -> f64 {
    const RATIO: f64 = 0.99;
    const STEPS: u32 = 600;
    let (mut above, mut least) = (most, f64::INFINITY);
    for _ in 0..STEPS {
        let below = above * RATIO;
        least = least.min((absorption.per_mm(below) - gain).max(0.0) / above);
        above = below;
    }
    least.min((absorption.law().c1_per_mm - gain).max(0.0) / above)
}

/// How far a cone about a direction spreads around the pole, rad; all around if the pole is within.
fn spread(cone: f64, from_pole: f64) -> f64 {
    let sine = libm::sin(from_pole);
    if libm::sin(cone) >= sine { PI } else { libm::asin(libm::sin(cone) / sine) }
}

/// Angle between the planes through the pole and either direction, 0 to π.
fn azimuth_between(a: DVec3, b: DVec3, pole: DVec3) -> f64 {
    let flat = |v: DVec3| v - v.dot(pole) * pole;
    let (a, b) = (flat(a), flat(b));
    if a.length_squared() < 1e-18 || b.length_squared() < 1e-18 { 0.0 } else { angle_between(a, b) }
}

fn angle_between(a: DVec3, b: DVec3) -> f64 {
    libm::atan2(a.cross(b).length(), a.dot(b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::course::Course;
    use crate::optics::{Throughput, ThroughputOptions};
    use fibar_core::light::LightLaw;

    const FIRM: Freedom = Freedom { mouth_radius: 0.0, tilt: 0.0 };

    fn absorption() -> Absorption {
        Absorption::monotone(LightLaw::TONE_2020)
    }

    fn ends(marker: DVec3, normal: DVec3) -> Ends {
        Ends { tip: DVec3::ZERO, axis: DVec3::Z, marker, normal: normal.normalize() }
    }

    #[track_caller]
    fn check(marker: DVec3, normal: DVec3, exact: f64, tightness: f64) {
        let bound = LeastLoss::new(&absorption(), 12.0).between(ends(marker, normal), FIRM);
        assert!(bound <= exact + 1e-9 && bound >= tightness * exact, "{bound} of {exact}");
    }

    #[test]
    fn straight_ways_and_wide_turns_are_bounded_tightly() {
        let c1 = LightLaw::TONE_2020.c1_per_mm;
        check(DVec3::Z * 80.0, DVec3::Z, 80.0 * c1, 1.0 - 1e-9);
        // A right angle costs at least 1.4166 per rad, whatever the room: as a quarter circle of 51 mm.
        let quarter = absorption().per_mm(1.0 / 51.0) * 51.0 * std::f64::consts::FRAC_PI_2;
        check(DVec3::new(51.0, 0.0, 51.0), DVec3::X, quarter, 0.97);
        // There and back: half a circle.
        check(DVec3::X * 102.0, -DVec3::Z, 2.0 * quarter, 0.97);
    }

    #[test]
    fn mouths_and_tilts_only_lower_the_bound() {
        let bounds = LeastLoss::new(&absorption(), 12.0);
        let ends = ends(DVec3::new(40.0, 10.0, 50.0), DVec3::new(1.0, 0.3, -0.2));
        let between = |mouth_radius, tilt| bounds.between(ends, Freedom { mouth_radius, tilt });
        assert!(between(1.6, 0.0) < between(0.0, 0.0) && between(0.0, 0.3) < between(0.0, 0.0));
        assert!(between(0.0, 0.0) - between(1.6, 0.0) < 1.6 * LightLaw::TONE_2020.c1_per_mm + 1e-9);
    }

    /// No curve, however it winds, loses less; the curves are those of random control points.
    #[test]
    fn no_curve_goes_below() {
        let mut state = 1u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as f64 / f64::from(1u32 << 31) - 0.5
        };
        let law = absorption();
        for case in 0..60 {
            let mut vector = |size: f64| size * DVec3::new(random(), random(), random());
            let (marker, normal) = (vector(120.0), vector(1.0));
            if normal.length() < 1e-3 {
                continue;
            }
            let ends = ends(marker, normal);
            let wander = vector(60.0);
            let line = [DVec3::ZERO, ends.marker * 0.3 + wander, ends.marker * 0.8 - wander, ends.marker];
            let course = Course::along((ends, FIRM), &line, 9);
            let curve = course.curve();
            let tightest = crate::alone::tightest_curvature(&curve);
            let loss = Throughput::of(&curve, &law, ThroughputOptions::default()).loss;
            let bound = LeastLoss::new(&law, 1.0 / (1.05 * tightest)).between(ends, FIRM);
            assert!(bound <= loss, "case {case}: {bound} exceeds {loss}");
        }
    }
}
