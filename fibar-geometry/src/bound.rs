//! The least light any fibre between two ends must lose: a bound from below that holds for every curve.
//!
//! ```text
//! ∫a ds  =  λ·D + ∫(a − λ·t) ds                              for any force λ, since ∫t ds = D, the way from end to end
//!        ≥  λ·D + min over m of (c1 − |λ| cos m − δ)·L + ∫w|dt|    L the length, m the least angle of the tangent to λ
//!           w = g(δ + |λ|(cos m − cos ∠(t, λ)))               g(x) = min over κ ≤ κmax of (a(κ) − c1 + x)/κ,  δ ≥ 0
//! ```
//!
//! The second line takes `μ = c1 − |λ| cos m − δ` out of the integrand, which leaves at least `κ·w`. The tangent wanders over the
//! unit sphere from the socket's axis to the normal, and `w` makes its way there cost something ([`pull`]). The length is
//! not known: the bound is the least over all lengths of the best over λ. That matters. Without it long fibres and
//! short ones could be mixed to have D in the mean, and the turns of the long ones, which hardly cost, would pay for all.
//!
//! For one λ the right side is a least of lines in L, so between two lengths it is no less than at one of them: lengths are taken in
//! bins, the one that holds the bound down is halved. Every λ gives a bound; the best of some is taken. All sums are taken from the side that keeps it one. The
//! body's walls are left out, so the bound holds with them, too; how the ends may move is allowed for.

mod pull;
pub mod reach;

use crate::course::{Ends, Freedom};
use crate::optics::Absorption;
use glam::DVec3;
use pull::{Pull, Radian, Turn};
use std::f64::consts::PI;

/// Strengths of the force that are tried, relative to c1.
const STRENGTHS: [f64; 12] = [0.0, 0.4, 0.7, 0.92, 1.0, 1.25, 1.6, 2.2, 3.0, 4.2, 6.0, 9.0];

/// Bounds for all pairs under one law of light and one least bend radius.
pub struct LeastLoss {
    pulls: Vec<Pull>,
    c1: f64,
}

impl LeastLoss {
    /// Prepares the tables.
    pub fn new(absorption: &Absorption, min_bend_radius: f64) -> LeastLoss {
        let c1 = absorption.law().c1_per_mm;
        let strongest = STRENGTHS[STRENGTHS.len() - 1];
        let radian = Radian::new(absorption, min_bend_radius, (2.0 * strongest + 1.0) * c1);
        let pulls = STRENGTHS.iter().map(|share| Pull::new(absorption, &radian, *share)).collect();
        LeastLoss { pulls, c1 }
    }

    /// `∫a ds` that no curve between these ends goes below; at most `enough`, since lengths that lose more are not looked at.
    /// The bin that holds the bound down is halved and tried from further forces, as often as `attempts` says.
    pub fn between(&self, ends: Ends, freedom: Freedom, enough: f64, attempts: usize) -> f64 {
        let pair = Pair::of(ends, freedom);
        let starts = self.starts(&pair);
        let (mut bins, longest) = self.bins(&pair, starts[0], enough);
        let enough = enough.min(self.c1 * longest);
        for _ in 0..attempts {
            let weakest = bins.iter().enumerate().min_by(|a, b| a.1.value.total_cmp(&b.1.value));
            let Some((k, bin)) = weakest.filter(|(_, bin)| bin.value < enough) else { break };
            if bin.is_wide(starts.len()) {
                let [shorter, longer] = bin.halves();
                bins[k] = self.look(&pair, shorter);
                bins.push(self.look(&pair, longer));
                continue;
            }
            let Some(start) = starts.get(bin.tried) else { break };
            let (value, force) = self.best_force(&pair, bin.lengths, *start);
            let tried = bin.tried + 1;
            bins[k] =
                if value > bin.value { Bin { value, force, tried, ..*bin } } else { Bin { tried, ..*bin } };
        }
        bins.iter().fold(enough, |least, bin| least.min(bin.value))
    }

    /// Bins from the shortest length on to the one that loses `enough` by itself, each tried from the force found for the one
    /// before; and the length where they end.
    fn bins(&self, pair: &Pair, start: (usize, DVec3), enough: f64) -> (Vec<Bin>, f64) {
        const SHORTEST: f64 = 1e-3;
        const RATIO: f64 = 1.3;
        const MOST: usize = 80;
        let mut shorter = (pair.way.length() - pair.mouth_radius).max(SHORTEST);
        let mut force = start;
        let mut bins = vec![];
        while self.c1 * shorter < enough && bins.len() < MOST {
            let longer = shorter * RATIO;
            let bin = self.look(pair, Bin { lengths: [shorter, longer], value: 0.0, force, tried: 0 });
            force = bin.force;
            shorter = longer;
            bins.push(bin);
        }
        (bins, shorter)
    }

    /// Tries a bin from the force that it knows. A fibre loses c1 per mm at least.
    fn look(&self, pair: &Pair, bin: Bin) -> Bin {
        let (value, force) = self.best_force(pair, bin.lengths, bin.force);
        Bin { value: value.max(self.c1 * bin.lengths[0]), force, ..bin }
    }

    /// Forces to start from: stretched fibres pull along the chord; those with too little room are pushed together.
    fn starts(&self, pair: &Pair) -> [(usize, DVec3); 7] {
        let chord = pair.way.normalize_or(pair.start);
        let across = (pair.start + pair.finish).normalize_or(chord);
        let apart = (pair.start - pair.finish).normalize_or(-chord);
        let strength = |share: f64| STRENGTHS.partition_point(|s| *s < share);
        [
            (strength(2.0), chord),
            (strength(1.0), chord),
            (strength(0.5), -chord),
            (strength(0.5), apart),
            (strength(0.5), across),
            (strength(3.0), across),
            (strength(6.0), across),
        ]
    }

    /// The best bound over forces, for lengths between two: a pattern search.
    fn best_force(&self, pair: &Pair, lengths: [f64; 2], start: (usize, DVec3)) -> (f64, (usize, DVec3)) {
        const LARGEST_STEP: f64 = 0.2;
        const SMALLEST_STEP: f64 = 0.04;
        const GAIN: f64 = 1e-3;
        let (mut force, mut step) = (start, LARGEST_STEP);
        let (mut best, mut guess) = self.bound(pair, force, lengths, 0, f64::NEG_INFINITY);
        while step > SMALLEST_STEP {
            let (strength, direction) = force;
            let (a, b) = direction.any_orthonormal_pair();
            let turned = [a, -a, b, -b].map(|side| (strength, (direction + step * side).normalize()));
            let weaker = (strength.saturating_sub(1), direction);
            let stronger = ((strength + 1).min(STRENGTHS.len() - 1), direction);
            let before = best;
            for tried in turned.into_iter().chain([weaker, stronger]) {
                let (value, place) = self.bound(pair, tried, lengths, guess, best + GAIN);
                if value > best + GAIN {
                    (best, force, guess) = (value, tried, place);
                }
            }
            if best == before {
                step *= 0.5;
            }
        }
        (best, force)
    }

    /// The bound by one force, the mouth anywhere under the LED; for `guess` and `floor` see [`Pull::least`].
    fn bound(
        &self,
        pair: &Pair,
        (strength, direction): (usize, DVec3),
        lengths: [f64; 2],
        guess: usize,
        floor: f64,
    ) -> (f64, usize) {
        let pull = &self.pulls[strength];
        let across = direction - direction.dot(pair.start) * pair.start;
        let along = direction.dot(pair.way) - across.length() * pair.mouth_radius;
        let base = pull.strength * along;
        let (least, place) = pull.least(&pair.turn(direction), lengths, guess, floor - base);
        (base + least, place)
    }
}

/// What is known of all fibres whose lengths lie between two.
#[derive(Clone, Copy)]
struct Bin {
    /// mm.
    lengths: [f64; 2],
    /// `∫a ds` that none of them goes below.
    value: f64,
    /// Strength and direction of the force that says so.
    force: (usize, DVec3),
    /// How many starts have been tried.
    tried: usize,
}

impl Bin {
    /// Whether to halve it rather than try further starts, of which there are so many.
    fn is_wide(&self, starts: usize) -> bool {
        const NARROW: f64 = 1.06;
        const NARROWEST: f64 = 1.01;
        let narrow = if self.tried < starts { NARROW } else { NARROWEST };
        self.lengths[1] > narrow * self.lengths[0]
    }

    /// Its shorter and its longer lengths, with their best starts known.
    fn halves(&self) -> [Bin; 2] {
        let [shorter, longer] = self.lengths;
        let middle = 0.5 * (shorter + longer);
        [[shorter, middle], [middle, longer]].map(|lengths| Bin { lengths, ..*self })
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

    /// The ends as seen from a pole.
    fn turn(&self, pole: DVec3) -> Turn {
        let to = angle_between(self.finish, pole);
        let around = azimuth_between(self.start, self.finish, pole) - spread(self.tilt, to);
        Turn {
            from: angle_between(self.start, pole),
            to: ((to - self.tilt).max(0.0), (to + self.tilt).min(PI)),
            around: around.max(0.0),
            between: (angle_between(self.start, self.finish) - self.tilt).max(0.0),
        }
    }
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
    use crate::alone::{self, AloneOptions, World};
    use crate::course::Course;
    use crate::course::nodes::Tables;
    use crate::distance::Surface;
    use crate::optics::{Throughput, ThroughputOptions};
    use crate::room::{Keeping, Room, RoomOptions};
    use fibar_core::artefact::sockets::{Hole, Socket, Sockets};
    use fibar_core::id::{LedId, PatternId};
    use fibar_core::light::LightLaw;

    const FIRM: Freedom = Freedom { mouth_radius: 0.0, tilt: 0.0 };
    const ATTEMPTS: usize = 40;

    fn absorption() -> Absorption {
        Absorption::monotone(LightLaw::TONE_2020)
    }

    fn ends(marker: DVec3, normal: DVec3) -> Ends {
        Ends { tip: DVec3::ZERO, axis: DVec3::Z, marker, normal: normal.normalize() }
    }

    struct Random(u64);

    impl Random {
        fn vector(&mut self, size: f64) -> DVec3 {
            let mut next = || {
                self.0 =
                    self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (self.0 >> 33) as f64 / f64::from(1u32 << 31) - 0.5
            };
            size * DVec3::new(next(), next(), next())
        }
    }

    #[track_caller]
    fn check(marker: DVec3, normal: DVec3, exact: f64, tightness: f64) {
        let bound = LeastLoss::new(&absorption(), 12.0).between(ends(marker, normal), FIRM, 20.0, ATTEMPTS);
        assert!(bound <= exact + 1e-9 && bound >= tightness * exact, "{bound} of {exact}");
    }

    #[test]
    fn straight_ways_and_wide_turns_are_bounded_tightly() {
        let c1 = LightLaw::TONE_2020.c1_per_mm;
        check(DVec3::Z * 80.0, DVec3::Z, 80.0 * c1, 1.0 - 1e-9);
        // A right angle costs at least 1.4166 per rad, whatever the room: as a quarter circle of 51 mm.
        let arc = |radius: f64| absorption().per_mm(1.0 / radius) * radius * std::f64::consts::FRAC_PI_2;
        check(DVec3::new(51.0, 0.0, 51.0), DVec3::X, arc(51.0), 0.99);
        // There and back: half a circle.
        check(DVec3::X * 102.0, -DVec3::Z, 2.0 * arc(51.0), 0.99);
        // Less room than the best corner needs.
        check(DVec3::new(30.0, 0.0, 30.0), DVec3::X, arc(30.0), 0.85);
    }

    #[test]
    fn mouths_and_tilts_only_lower_the_bound() {
        let bounds = LeastLoss::new(&absorption(), 12.0);
        let ends = ends(DVec3::new(40.0, 10.0, 50.0), DVec3::new(1.0, 0.3, -0.2));
        let between =
            |mouth_radius, tilt| bounds.between(ends, Freedom { mouth_radius, tilt }, 20.0, ATTEMPTS);
        assert!(between(1.6, 0.0) < between(0.0, 0.0) && between(0.0, 0.3) < between(0.0, 0.0));
        // More attempts never loosen it, and what is enough is not exceeded.
        let tries = [0, 3, 10, 40].map(|attempts| bounds.between(ends, FIRM, 20.0, attempts));
        assert!(tries.is_sorted(), "{tries:?}");
        assert_eq!(bounds.between(ends, FIRM, 1.5, ATTEMPTS), 1.5);
    }

    #[test]
    fn light_that_costs_nothing_straight_has_a_bound_all_the_same() {
        let free = Absorption::monotone(LightLaw { c1_per_mm: 0.0, ..LightLaw::TONE_2020 });
        let bound = LeastLoss::new(&free, 12.0).between(ends(DVec3::X, DVec3::X), FIRM, 20.0, ATTEMPTS);
        assert_eq!(bound, 0.0);
    }

    /// No curve, however it winds, loses less; the curves are those of random control points.
    #[test]
    fn no_curve_goes_below() {
        let mut random = Random(1);
        let law = absorption();
        for case in 0..60 {
            let (marker, normal) = (random.vector(120.0), random.vector(1.0));
            let (wander, count) = (random.vector(60.0), 7 + case % 5);
            if normal.length() < 1e-3 {
                continue;
            }
            let ends = ends(marker, normal);
            let line = [DVec3::ZERO, ends.marker * 0.3 + wander, ends.marker * 0.8 - wander, ends.marker];
            let curve = Course::along((ends, FIRM), &line, count).curve();
            let tightest = crate::alone::tightest_curvature(&curve);
            let loss = Throughput::of(&curve, &law, ThroughputOptions::default()).loss;
            let bound = LeastLoss::new(&law, 1.0 / (1.05 * tightest)).between(ends, FIRM, loss + 1.0, 6);
            assert!(bound <= loss, "case {case}: {bound} exceeds {loss}");
        }
    }

    /// A room so wide that nothing is near.
    fn wide_room() -> Room {
        let surface = Surface::new(&crate::distance::tests::cube(500.0)).expect("a cube");
        let hole = Hole { diameter_mm: 5.0, depth_mm: 5.0 };
        let away = DVec3::splat(-400.0);
        let socket = Socket { led: LedId(0), pattern: PatternId(0), position: away, axis: DVec3::Z };
        let keeping = Keeping { radius: 1.0, skin: 0.4, wall: 0.0 };
        Room::new(
            surface,
            &Sockets::new(hole, vec![socket]),
            keeping,
            RoomOptions { spacing: 25.0, band: 50.0, exact: f64::INFINITY },
        )
    }

    /// The best curves found without walls reach it nearly: what is lost to it elsewhere is lost to walls.
    #[test]
    fn the_best_curves_come_close() {
        let (room, tables) = (wide_room(), Tables::all());
        let freedom = Freedom { mouth_radius: 1.625, tilt: 0.36 };
        let absorption = absorption();
        let world = World { room: &room, absorption, tables: &tables, freedom, min_bend_radius: 12.0 };
        let bounds = LeastLoss::new(&absorption, 12.0);
        let options = AloneOptions { span: 7.5, iterations: 120, rounds: 6, least_gain: 1e-5 };
        let mut random = Random(3);
        let mut shares = vec![];
        for case in 0..24 {
            let marker = random.vector(120.0) + DVec3::Z * 50.0;
            let ends = ends(marker, marker.normalize() + random.vector(1.0));
            let Some(best) = alone::find(&world, ends, None, 2, &options) else { continue };
            let loss = best.throughput.loss;
            let bound = bounds.between(ends, freedom, loss + 0.5, ATTEMPTS);
            assert!(bound <= loss + 1e-6, "case {case}: {bound} exceeds {loss}");
            shares.push(libm::exp(-0.5 * (loss - bound)));
        }
        shares.sort_by(f64::total_cmp);
        let (quarter, half) = (shares[shares.len() / 4], shares[shares.len() / 2]);
        assert!(shares.len() > 20 && quarter > 0.8 && half > 0.95, "{shares:?}");
    }
}
