//! Whose fibres would be in each other's way: the best courses of two pairs of an LED and a place, and how deep one lies in the
//! other's room.
//!
//! `∫ (NEAR_MM − d(s))₊ ds` along one course, `d` the distance to the other, and the same the other way round. Measured on routed objects
//! (docs/assign-covering.md): a fibre without clashes keeps 99 % of its light, and each mm² costs `∫a ds` another [`LOSS_PER_MM2`].

use fibar_core::artefact::courses::Courses;
use fibar_core::artefact::sites::Sites;
use fibar_core::artefact::sockets::Sockets;
use fibar_geometry::curve::Curve;
use fibar_plugin::StageError;
use glam::DVec3;
use std::sync::atomic::{AtomicU32, Ordering};

/// Axes nearer than this clash, mm: the outer Ø of a fibre and half as much again.
const NEAR_MM: f64 = 6.0;
/// Between the samples of a course, mm.
const STEP_MM: f64 = 3.0;
/// Samples in a row that share a ball.
const ROW: usize = 5;
/// What a clash adds to the losses `∫a ds` of both fibres together, 1/mm².
pub const LOSS_PER_MM2: f64 = 0.0008;
/// Clashes are whole multiples of this, so that sums do not depend on their order, mm².
pub const GRAIN_MM2: f64 = 1.0 / 16.0;
/// Up to so many pairs of courses what was found is kept: 256 MB.
const KEPT: usize = 1 << 26;
/// Not found yet.
const UNKNOWN: u32 = u32::MAX;

/// The courses of all sites by all codes.
pub struct Clashes {
    /// By site, then by code from 1.
    tubes: Vec<Option<Tube>>,
    codes: usize,
    /// By the later course of a pair, then by the earlier one.
    found: Vec<AtomicU32>,
}

impl Clashes {
    /// The courses of all sites, which must be those that the courses were made for.
    pub fn new(courses: &Courses, sockets: &Sockets, sites: &Sites) -> Result<Clashes, StageError> {
        let mut by_code = vec![0; sockets.sockets.len()];
        for socket in &sockets.sockets {
            let place = courses.leds.iter().position(|led| *led == socket.led);
            let strange =
                || StageError::input(format!("the courses know nothing of LED {}", socket.led)).hint(HINT);
            by_code[socket.pattern.0 as usize - 1] = place.ok_or_else(strange)?;
        }
        let mut tubes = Vec::with_capacity(sites.sites.len() * by_code.len());
        for site in &sites.sites {
            let strange = || {
                StageError::input("the courses know nothing of a site")
                    .hint(HINT)
                    .place_mm(site.position.to_array())
            };
            let reached = courses.target_at(site.position).ok_or_else(strange)?;
            tubes.extend(by_code.iter().map(|&led| Tube::along(&reached.curves[led])));
        }
        let pairs = pair_number(0, tubes.len());
        let found =
            if pairs <= KEPT { (0..pairs).map(|_| AtomicU32::new(UNKNOWN)).collect() } else { vec![] };
        Ok(Clashes { tubes, codes: by_code.len(), found })
    }

    /// How much two fibres are in each other's way, each a site and its code, in multiples of [`GRAIN_MM2`]. Those of one code may
    /// run together.
    pub fn between(&self, (site, code): (usize, u8), (other, other_code): (usize, u8)) -> u32 {
        if code == other_code {
            return 0;
        }
        let place = |site: usize, code: u8| site * self.codes + usize::from(code) - 1;
        let (a, b) = (place(site, code), place(other, other_code));
        let (a, b) = (a.min(b), a.max(b));
        let kept = self.found.get(pair_number(a, b));
        let known = kept.map_or(UNKNOWN, |kept| kept.load(Ordering::Relaxed));
        if known != UNKNOWN {
            return known;
        }
        let clash = match (&self.tubes[a], &self.tubes[b]) {
            (Some(a), Some(b)) => ((a.depth_in(b) + b.depth_in(a)) / GRAIN_MM2).round() as u32,
            _ => 0,
        };
        if let Some(kept) = kept {
            // Whoever finds it finds the same.
            kept.store(clash, Ordering::Relaxed);
        }
        clash
    }
}

/// Pairs of an earlier and a later of some things, in a row: (0, 0), (0, 1), (1, 1), (0, 2), …
fn pair_number(earlier: usize, later: usize) -> usize {
    later * (later + 1) / 2 + earlier
}

const HINT: &str = "put bound-light between place-visibility, socket-led and this stage";

/// A course as samples at even steps.
struct Tube {
    samples: Vec<DVec3>,
    rows: Vec<Ball>,
    step: f64,
}

/// A ball around some samples in a row.
struct Ball {
    centre: DVec3,
    radius: f64,
    samples: std::ops::Range<usize>,
}

impl Tube {
    /// Along the cubic of these control points; none without points.
    fn along(points: &[[f64; 3]]) -> Option<Tube> {
        let points: Vec<DVec3> = points.iter().map(|p| DVec3::from(*p)).collect();
        let curve = Curve::clamped_uniform(3, &points).ok()?;
        let (samples, step) = even_samples(&curve);
        let ball = |first: usize| {
            let samples_of = first..(first + ROW).min(samples.len());
            let covered = &samples[samples_of.clone()];
            let centre = covered.iter().copied().sum::<DVec3>() / covered.len() as f64;
            let radius = covered.iter().fold(0.0, |r: f64, p| r.max(p.distance(centre)));
            Ball { centre, radius, samples: samples_of }
        };
        let rows = (0..samples.len()).step_by(ROW).map(ball).collect();
        Some(Tube { samples, rows, step })
    }

    /// `∫ (NEAR − d)₊ ds` along this one, mm².
    fn depth_in(&self, other: &Tube) -> f64 {
        let mut depth = 0.0;
        for row in &self.rows {
            let near = |ball: &&Ball| {
                let reach = NEAR_MM + row.radius + ball.radius;
                ball.centre.distance_squared(row.centre) < reach * reach
            };
            let near: Vec<&Ball> = other.rows.iter().filter(near).collect();
            if near.is_empty() {
                continue;
            }
            for sample in &self.samples[row.samples.clone()] {
                let around = near.iter().flat_map(|ball| &other.samples[ball.samples.clone()]);
                let nearest =
                    around.fold(NEAR_MM * NEAR_MM, |least, p| p.distance_squared(*sample).min(least));
                depth += (NEAR_MM - nearest.sqrt()) * self.step;
            }
        }
        depth
    }
}

/// Places at even steps of about [`STEP_MM`], and that step.
fn even_samples(curve: &Curve) -> (Vec<DVec3>, f64) {
    const PARTS: u32 = 8;
    let mut line = vec![curve.point(curve.domain().0)];
    for span in curve.breaks().windows(2) {
        let at = |k: u32| span[0] + (span[1] - span[0]) * f64::from(k) / f64::from(PARTS);
        line.extend((1..=PARTS).map(|k| curve.point(at(k))));
    }
    let length: f64 = line.windows(2).map(|w| w[0].distance(w[1])).sum();
    let count = (length / STEP_MM).round().max(1.0);
    let step = length / count;
    let mut samples = vec![];
    let mut walked = 0.0;
    for leg in line.windows(2) {
        let long = leg[0].distance(leg[1]);
        // Each sample in the middle of its step.
        while (samples.len() as f64 + 0.5) * step <= walked + long && long > 0.0 {
            samples.push(leg[0].lerp(leg[1], ((samples.len() as f64 + 0.5) * step - walked) / long));
        }
        walked += long;
    }
    (samples, step)
}

#[cfg(test)]
mod tests {
    use super::*;
    use fibar_core::artefact::courses::Reached;
    use fibar_core::artefact::sites::Site;
    use fibar_core::artefact::sockets::{Hole, Socket};
    use fibar_core::{LedId, PatternId};

    /// A straight cubic.
    fn straight(from: [f64; 3], to: [f64; 3]) -> Vec<[f64; 3]> {
        let (from, to) = (DVec3::from(from), DVec3::from(to));
        (0..6).map(|k| from.lerp(to, [0.0, 1.0, 3.0, 6.0, 8.0, 9.0][k] / 9.0).to_array()).collect()
    }

    /// Two sites whose courses by either LED are these.
    fn clashes(curves: [[Vec<[f64; 3]>; 2]; 2], leds: [u32; 2]) -> Result<Clashes, String> {
        let places = [DVec3::X, DVec3::Y];
        let site = |p: DVec3| Site { position: p, normal: DVec3::Z, suitability_rad: 1.0 };
        let sites = Sites::new(DVec3::ZERO, places.map(site).to_vec(), vec![]);
        let socket = |led: u32| Socket {
            led: LedId(led),
            pattern: PatternId(led + 1),
            position: DVec3::X * f64::from(led),
            axis: DVec3::Z,
        };
        let sockets = Sockets::new(Hole { diameter_mm: 5.2, depth_mm: 8.6 }, [0, 1].map(socket).to_vec());
        let reached = places.into_iter().zip(curves);
        let reached = reached.map(|(position, curves)| Reached { position, curves: curves.to_vec() });
        Clashes::new(&Courses::new(leds.map(LedId).to_vec(), reached.collect()), &sockets, &sites)
            .map_err(|e| e.to_string())
    }

    #[test]
    fn a_clash_is_the_depth_in_the_other_s_room_along_both() {
        let up = || straight([0.0, 0.0, 0.0], [0.0, 0.0, 60.0]);
        let check = |other: Vec<[f64; 3]>, expected: f64, within: f64| {
            let clashes = clashes([[up(), vec![]], [up(), other]], [0, 1]).unwrap();
            let found = f64::from(clashes.between((0, 1), (1, 2))) * GRAIN_MM2;
            assert!((found - expected).abs() <= within, "{found}, not {expected}");
            assert_eq!(clashes.between((1, 2), (0, 1)), clashes.between((0, 1), (1, 2)));
            assert_eq!(clashes.between((0, 1), (1, 1)), 0, "one code may run together");
            assert_eq!(clashes.between((0, 2), (1, 1)), 0, "no course, no clash");
        };
        check(straight([4.0, 0.0, 0.0], [4.0, 0.0, 60.0]), 2.0 * 2.0 * 60.0, 0.1);
        check(straight([7.0, 0.0, 0.0], [7.0, 0.0, 60.0]), 0.0, 0.0);
        // At right angles in one point: 2 · ∫ (6 − |s|) ds, less what samples 3 mm apart miss.
        check(straight([-30.0, 0.0, 30.0], [30.0, 0.0, 30.0]), 2.0 * 36.0, 12.0);
    }

    #[test]
    fn strange_courses_are_refused() {
        let none = || [vec![], vec![]];
        let error = clashes([none(), none()], [0, 7]).err().unwrap();
        assert!(error.contains("nothing of LED 1"), "{error}");
    }
}
