//! The certificate against mutants: a sound routing of which one control point is moved must be found out, with the rule, the
//! fibre and the place, exactly when brute force finds it out too.
//!
//! The oracle shares nothing with the certificate: de Boor's algorithm at [`SAMPLES`] parameters, distances of all samples
//! to all others, the walls of the block by its coordinates, radii of circles through three samples.

use crate::strand::Strand;
use crate::strand::tests::{cube, socket};
use crate::{Params, Scene, bend, ends, gap, socket_gap, wall};
use fibar_core::artefact::routes::Fibre;
use fibar_core::artefact::sockets::{Hole, Sockets};
use fibar_core::artefact::verdict::Finding;
use fibar_core::material::LayerRadii;
use fibar_core::{LedId, MarkerId, PatternId};
use fibar_ruler::surface::ClosedSurface;
use glam::DVec3;
use rand::RngExt;
use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};

const SIZE: f64 = 60.0;
const TIP: f64 = 8.6;
const FIBRES: usize = 5;
const POINTS: usize = 12;
const SAMPLES: usize = 500;
const OUTER: f64 = 1.875;
const SKIN: f64 = 0.4;
/// Where samples and certificate may disagree, mm; of bend radii a share.
const DOUBT: f64 = 0.03;

/// What is asked of the routing.
fn params() -> Params {
    Params {
        min_gap_mm: 0.5,
        min_wall_mm: 0.5,
        min_socket_gap_mm: 0.5,
        min_bend_radius_mm: 12.0,
        arrival_tilt_deg: 20.0,
        ..Params::default()
    }
}

/// Fibres side by side through a block, each swinging to one side on its way.
fn routing() -> Vec<Vec<DVec3>> {
    let fibre = |k: usize| {
        let x = 9.0 * (k as f64 - 2.0);
        let swing = if k.is_multiple_of(2) { 8.0 } else { -8.0 };
        let point = |j: usize| {
            let share = j as f64 / (POINTS - 1) as f64;
            let smooth = share * share * (3.0 - 2.0 * share);
            DVec3::new(x, swing * smooth, TIP + (SIZE - TIP) * share)
        };
        let mut points: Vec<DVec3> = (0..POINTS).map(point).collect();
        points[1] = points[0] + DVec3::Z * 2.5;
        points[POINTS - 2] = points[POINTS - 1] - DVec3::Z * 2.5;
        points
    };
    (0..FIBRES).map(fibre).collect()
}

fn knots() -> Vec<f64> {
    let spans = POINTS - 3;
    (0..POINTS + 4).map(|k| (k as f64 - 3.0).clamp(0.0, spans as f64)).collect()
}

fn strand(k: usize, points: &[DVec3]) -> Strand {
    let fibre = Fibre {
        id: k as u32 + 1,
        marker: MarkerId(k as u32),
        led: LedId(k as u32),
        pattern: PatternId(k as u32 + 1),
        degree: 3,
        knots: knots(),
        points: points.to_vec(),
        weights: vec![1.0; points.len()],
        radii_mm: LayerRadii::TONE_2020,
    };
    Strand::of(&fibre).unwrap()
}

/// All findings of the certificate.
fn certificate(routing: &[Vec<DVec3>]) -> Vec<Finding> {
    let params = params();
    let strands: Vec<Strand> = routing.iter().enumerate().map(|(k, points)| strand(k, points)).collect();
    let body = ClosedSurface::of(&cube(SIZE));
    let places = routing.iter().map(|points| DVec3::new(points[0].x, 0.0, TIP));
    let sockets = places.zip(0..).map(|(place, led)| socket(led, place)).collect();
    let sockets = Sockets::new(Hole { diameter_mm: 5.2, depth_mm: TIP }, sockets);
    let scene = Scene { body: &body, sockets: &sockets, constellation: None };
    let judgements = [
        gap::judge(&strands, params.min_gap_mm),
        wall::judge(&strands, &body, &wall::Rule::of(&params)),
        socket_gap::judge(&strands, &sockets, params.min_socket_gap_mm),
        bend::judge(&strands, params.min_bend_radius_mm),
        ends::judge(&strands, &scene, &ends::Rule::of(&params)),
    ];
    judgements.into_iter().flatten().map(|judgement| judgement.finding).collect()
}

/// A point of the clamped uniform cubic, by de Boor's algorithm.
fn de_boor(points: &[DVec3], u: f64) -> DVec3 {
    let knots = knots();
    let span = (u.floor() as usize).min(POINTS - 4) + 3;
    let mut row: Vec<DVec3> = (0..4).map(|j| points[span - 3 + j]).collect();
    for level in 1..4 {
        for j in (level..4).rev() {
            let (low, high) = (knots[span - 3 + j], knots[span + 1 + j - level]);
            row[j] = row[j - 1].lerp(row[j], (u - low) / (high - low));
        }
    }
    row[3]
}

fn samples(points: &[DVec3]) -> Vec<DVec3> {
    let last = (POINTS - 3) as f64;
    (0..=SAMPLES).map(|k| de_boor(points, last * k as f64 / SAMPLES as f64)).collect()
}

/// What brute force measures of the routing whose fibre `k` is a mutant.
struct Oracle {
    gap: f64,
    wall: f64,
    socket: f64,
    radius: f64,
    start_tilt: f64,
    arrival_tilt: f64,
}

impl Oracle {
    fn of(routing: &[Vec<DVec3>], k: usize) -> Oracle {
        let all: Vec<Vec<DVec3>> = routing.iter().map(|points| samples(points)).collect();
        let mine = &all[k];
        let others = all.iter().enumerate().filter(|(j, _)| *j != k);
        let squares =
            others.flat_map(|(_, o)| o.iter().flat_map(|p| mine.iter().map(|q| p.distance_squared(*q))));
        let foreign = (0..FIBRES).filter(|j| *j != k).map(|j| routing[j][0].x);
        let holes = foreign.flat_map(|x| mine.iter().map(move |p| to_hole(*p, x)));
        Oracle {
            gap: squares.fold(f64::INFINITY, f64::min).sqrt() - 2.0 * OUTER,
            wall: middle(mine).iter().map(|p| depth(*p)).fold(f64::INFINITY, f64::min) - OUTER - SKIN,
            socket: holes.fold(f64::INFINITY, f64::min) - OUTER,
            radius: radii(&routing[k]).fold(f64::INFINITY, f64::min),
            start_tilt: (routing[k][1] - routing[k][0]).angle_between(DVec3::Z),
            arrival_tilt: (routing[k][POINTS - 1] - routing[k][POINTS - 2]).angle_between(DVec3::Z),
        }
    }

    /// Rules that are broken, and rules that hold; what is too near to call is in neither list.
    fn verdict(&self) -> (Vec<&'static str>, Vec<&'static str>) {
        let asked = params();
        let least =
            |rule, value: f64, bound: f64, doubt: f64| (rule, value < bound - doubt, value > bound + doubt);
        let tilts = (self.start_tilt.to_degrees() - asked.start_tilt_deg)
            .max(self.arrival_tilt.to_degrees() - asked.arrival_tilt_deg);
        let calls = [
            least("clearance.gap", self.gap, asked.min_gap_mm, DOUBT),
            least("clearance.wall", self.wall, asked.min_wall_mm, DOUBT),
            least("clearance.socket", self.socket, asked.min_socket_gap_mm, DOUBT),
            least("clearance.bend", self.radius, asked.min_bend_radius_mm, 12.0 * DOUBT),
            least("clearance.ends", -tilts, 0.0, 1e-6),
        ];
        let broken = calls.iter().filter(|c| c.1).map(|c| c.0).collect();
        (broken, calls.iter().filter(|c| c.2).map(|c| c.0).collect())
    }
}

/// Samples away from the ends: beyond 2.5 mm of arc, and before the last 2.5 mm with outer radius and skin.
fn middle(samples: &[DVec3]) -> &[DVec3] {
    let walk = |arc: f64, legs: &mut dyn Iterator<Item = f64>| {
        let mut left = arc;
        legs.take_while(|leg| {
            left -= leg;
            left > 0.0
        })
        .count()
    };
    let legs = || samples.windows(2).map(|w| w[0].distance(w[1]));
    let first = walk(2.5, &mut legs()) + 1;
    let last = samples.len() - 1 - walk(2.5 + OUTER + SKIN, &mut legs().rev()) - 1;
    &samples[first..last.max(first + 1)]
}

/// Depth of a point in the block, mm; negative outside.
fn depth(p: DVec3) -> f64 {
    let half = SIZE / 2.0;
    let inside = (half - p.x.abs()).min(half - p.y.abs()).min(p.z).min(SIZE - p.z);
    if inside >= 0.0 {
        return inside;
    }
    let low = DVec3::new(-half, -half, 0.0);
    -p.distance(p.clamp(low, low + SIZE))
}

/// Distance to the hole of an LED at `x`, mm.
fn to_hole(p: DVec3, x: f64) -> f64 {
    let beside = ((p.x - x) * (p.x - x) + p.y * p.y).sqrt() - 2.6;
    beside.max(0.0).hypot((p.z - TIP).max(0.0))
}

/// Radii of circles through three points close together, at every sample.
fn radii(points: &[DVec3]) -> impl Iterator<Item = f64> {
    const STEP: f64 = 1e-4;
    let last = (POINTS - 3) as f64;
    (0..=SAMPLES).map(move |k| {
        let u = (last * k as f64 / SAMPLES as f64).clamp(STEP, last - STEP);
        let [before, here, after] = [u - STEP, u, u + STEP].map(|u| de_boor(points, u));
        let (u, v) = (here - before, after - here);
        u.length() * v.length() * (u + v).length() / (2.0 * u.cross(v).length()).max(1e-24)
    })
}

/// Moves a control point and holds the certificate against the oracle; returns the rules that broke.
#[track_caller]
fn check(fibre: usize, point: usize, by: DVec3) -> Vec<&'static str> {
    let mut mutant = routing();
    mutant[fibre][point] += by;
    let (broken, holding) = Oracle::of(&mutant, fibre).verdict();
    let findings = certificate(&mutant);
    let of = |rule: &str| findings.iter().find(|f| f.rule == rule).unwrap();
    let mutation = format!("point {point} of fibre {} moved by {by}", fibre + 1);
    for rule in &holding {
        assert!(of(rule).holds, "{mutation}: {:?} is a false alarm", of(rule));
    }
    for rule in &broken {
        let finding = of(rule);
        let first = &finding.places[0];
        assert!(!finding.holds, "{mutation}: {rule} goes unnoticed: {finding:?}");
        let names = format!("{} ", first.what.replace([',', ':'], " "));
        assert!(
            names.contains(&format!(" {} ", fibre + 1)),
            "{mutation}: {:?} names another fibre",
            first.what
        );
        let near =
            samples(&mutant[fibre]).iter().map(|p| p.distance(first.position)).fold(f64::INFINITY, f64::min);
        assert!(near < OUTER + 0.5, "{mutation}: the place {} is {near} mm off the fibre", first.position);
    }
    broken
}

#[test]
fn the_routing_itself_is_certified() {
    for finding in certificate(&routing()) {
        assert!(finding.holds, "{finding:?}");
    }
    for fibre in 0..FIBRES {
        assert_eq!(Oracle::of(&routing(), fibre).verdict().0, Vec::<&str>::new());
    }
}

#[test]
fn every_kind_of_nudge_is_found_out() {
    let breaks = |rule: &str, fibre: usize, point: usize, by: [f64; 3]| {
        let broken = check(fibre, point, DVec3::from(by));
        assert!(broken.contains(&rule), "{rule} is not among {broken:?}");
    };
    breaks("clearance.wall", 4, 6, [20.0, 0.0, 0.0]);
    breaks("clearance.wall", 0, 6, [-60.0, 0.0, 0.0]);
    breaks("clearance.gap", 1, 6, [13.0, 9.0, 0.0]);
    breaks("clearance.gap", 3, 7, [-13.0, 17.0, 0.0]);
    breaks("clearance.bend", 2, 5, [0.0, 6.0, 0.0]);
    breaks("clearance.bend", 2, 5, [0.0, 0.0, 9.0]);
    breaks("clearance.socket", 1, 2, [14.0, 5.0, -14.0]);
    breaks("clearance.ends", 2, 1, [0.1, 0.0, 0.0]);
    breaks("clearance.ends", 2, POINTS - 2, [0.0, 1.2, 0.0]);
}

#[test]
fn random_nudges_break_what_brute_force_says_and_nothing_else() {
    let mut chance = ChaCha8Rng::seed_from_u64(20);
    let mut seen = std::collections::BTreeMap::<&str, u32>::new();
    for _ in 0..160 {
        let (fibre, point) = (chance.random_range(0..FIBRES), chance.random_range(1..POINTS - 1));
        let size = [0.3, 2.0, 20.0, 40.0][chance.random_range(0..4)];
        let by = DVec3::from_array([0; 3].map(|_| chance.random_range(-size..size)));
        let broken = check(fibre, point, by);
        let key = if broken.is_empty() { vec!["none"] } else { broken };
        key.into_iter().for_each(|rule| *seen.entry(rule).or_default() += 1);
    }
    let rules = ["none", "clearance.gap", "clearance.wall", "clearance.bend", "clearance.ends"];
    assert!(rules.iter().all(|rule| seen.get(rule).is_some_and(|n| *n >= 3)), "too tame: {seen:?}");
}
