//! The places of an object's own LEDs: those from which fibres bring most light to its surface.
//!
//! Candidates stand on a grid over the face, places to be lit are spread over the surface that cameras above the base can see. What a fibre
//! between the two would lose is estimated with a course that settles briefly, walls and bends included, other fibres left out. Then
//! a p-median search: greedily one LED after the other, exchanges while they help (Teitz & Bart 1968), and both once more on a finer grid
//! around what was found. What counts is what cameras see: of each direction above the base the places that face it and can be brightest, as only
//! some of them will be markers. The first LED blinks the m-sequence, which every view has to see, so its light counts everywhere; of the
//! others only the best at each place counts, and none should have to light much more than its share.

use crate::base::Base;
use crate::params::Params;
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_core::artefact::sockets::{Hole, Sockets};
use fibar_core::light::LightLaw;
use fibar_core::material::{LayerRadii, SKIN_THICKNESS_MM};
use fibar_geometry::alone::{Watched, World, hermite, settle};
use fibar_geometry::course::costs::Limits;
use fibar_geometry::course::nodes::Tables;
use fibar_geometry::course::{Course, Ends, Freedom};
use fibar_geometry::distance::Surface;
use fibar_geometry::optics::Absorption;
use fibar_geometry::room::{Keeping, Room, RoomOptions};
use fibar_geometry::sampling::sample_surface;
use fibar_geometry::viewsphere::{Polyhedron, geodesic_directions};
use fibar_plugin::StageError;
use glam::{DVec2, DVec3};
use rand::SeedableRng;
use rayon::prelude::*;

/// About so many candidates, and samples of the surface of which those that cameras may see are lit.
const CANDIDATES: f64 = 90.0;
const SAMPLES: usize = 200;
/// Candidates are no nearer to each other than this at first, mm.
const FINEST_MM: f64 = 4.0;
/// A place lower than this above the LEDs' tips is hardly lit by anything, mm.
const RISE_MM: f64 = 8.0;
/// Cameras stand above the base and see a marker within 60° of its normal: sine of the lowest such normal.
const LOWEST_NORMAL: f64 = -0.866;
/// Least bend radius, mm, and tangent of the tilt of arrival, as routers have them.
const MIN_BEND_RADIUS_MM: f64 = 12.0;
const ARRIVAL_TILT: f64 = 0.364;
/// Share of the places facing a direction that count there: the brightest.
const COUNTED_SHARE: f64 = 0.3;
/// Half of the greatest use is at this `d_cam/c5`.
const DIM: f64 = 0.25;
/// The m-sequence's light beside that of the best other LED.
const M_SEQUENCE_WEIGHT: f64 = 0.2;
/// What uneven territories cost: by the sum of their squared shares.
const UNEVEN: f64 = 0.4;

/// Places of the LEDs on the face, mm, the first for the m-sequence; the body and the base are in the face's frame.
pub fn places(body: &TriangleMesh, base: &Base, params: &Params) -> Result<Vec<DVec2>, StageError> {
    let surface = Surface::new(body).map_err(|e| StageError::input(format!("body: {e}")))?;
    let radii = LayerRadii::TONE_2020;
    let keeping = Keeping { radius: radii.black, skin: SKIN_THICKNESS_MM, wall: 0.0 };
    let hole = Hole { diameter_mm: params.hole_diameter_mm, depth_mm: params.depth_mm };
    let room = Room::new(
        surface,
        &Sockets::new(hole, vec![]),
        keeping,
        RoomOptions { spacing: 2.0, band: 6.0, exact: f64::INFINITY },
    );
    let tables = Tables::all();
    let world = World {
        room: &room,
        absorption: Absorption::monotone(LightLaw::TONE_2020),
        tables: &tables,
        freedom: Freedom { mouth_radius: 1.0, tilt: ARRIVAL_TILT },
        min_bend_radius: MIN_BEND_RADIUS_MM,
    };
    let targets = targets(body, params);
    let views = views(&targets);
    let mut step = (base.area() / CANDIDATES).sqrt().max(FINEST_MM);
    let mut candidates = base.roomy_places(step, params.needed_room_mm());
    let mut chosen: Vec<usize> = vec![];
    for round in 0..3 {
        if round > 0 {
            step /= 2.0;
            let around = chosen.iter().flat_map(|&k| around(candidates[k], step)).collect::<Vec<_>>();
            let kept: Vec<DVec2> = chosen.iter().map(|&k| candidates[k]).collect();
            let fits = |place: &DVec2| base.fits(*place, params.needed_room_mm());
            candidates = kept.into_iter().chain(around.into_iter().filter(fits)).collect();
            chosen = (0..chosen.len()).collect();
        }
        let use_of: Vec<Vec<f64>> =
            candidates.par_iter().map(|place| uses(&world, *place, &targets, params)).collect();
        let task = Task { places: &candidates, use_of: &use_of, views: &views, pitch: params.pitch_mm };
        chosen = task.search(chosen, params.count as usize).ok_or_else(|| crowded(&candidates, params))?;
    }
    Ok(chosen.into_iter().map(|k| candidates[k]).collect())
}

fn crowded(candidates: &[DVec2], params: &Params) -> StageError {
    let message = format!(
        "the face has no room for {} LEDs {} mm apart: {} places were tried",
        params.count,
        params.pitch_mm,
        candidates.len()
    );
    StageError::user(message).param("/pitch_mm").hint(
        "try a smaller pitch_mm or count, a larger fit_mm of source-mesh, or a larger flatten_base_mm of repair-manifold",
    )
}

/// What is to be lit: place and normal.
fn targets(body: &TriangleMesh, params: &Params) -> Vec<(DVec3, DVec3)> {
    const CREASE: f64 = 0.5;
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1);
    let samples = sample_surface(body, SAMPLES, CREASE, &mut rng);
    let lowest = params.depth_mm + RISE_MM;
    let seen = samples.iter().filter(|s| s.normal.z > LOWEST_NORMAL && s.position.z > lowest);
    seen.map(|s| (s.position, s.normal)).collect()
}

/// For each of some directions above the base the targets that face it within 60°.
fn views(targets: &[(DVec3, DVec3)]) -> Vec<Vec<usize>> {
    const COS_EMISSION: f64 = 0.5;
    let mut directions = geodesic_directions(Polyhedron::Icosahedron, 3);
    directions.retain(|d| d.z >= 0.0);
    let facing = |d: &DVec3| (0..targets.len()).filter(|&t| targets[t].1.dot(*d) > COS_EMISSION).collect();
    directions.iter().map(facing).collect()
}

/// The eight neighbours on a finer grid.
fn around(place: DVec2, step: f64) -> Vec<DVec2> {
    let steps = [-1.0, 0.0, 1.0];
    let all = steps.into_iter().flat_map(|x| steps.map(|y| DVec2::new(x, y)));
    all.filter(|offset| *offset != DVec2::ZERO).map(|offset| place + step * offset).collect()
}

/// Of what use an LED here is to each target, between 0 and 1.
fn uses(world: &World, place: DVec2, targets: &[(DVec3, DVec3)], params: &Params) -> Vec<f64> {
    let tip = place.extend(params.depth_mm);
    let of = |&(marker, normal): &(DVec3, DVec3)| {
        let light = libm::exp(-0.5 * loss(world, Ends { tip, axis: DVec3::Z, marker, normal }));
        light / (light + DIM)
    };
    targets.iter().map(of).collect()
}

/// `∫a ds` of a course that settles briefly, broken limits counted.
fn loss(world: &World, ends: Ends) -> f64 {
    const EASES: [f64; 3] = [0.7, 1.1, 1.8];
    const SPAN_MM: f64 = 12.0;
    let limits = Limits {
        curvature: 1.0 / world.min_bend_radius,
        wall_margin: 0.0,
        wall_weight: 0.3,
        bend_weight: 3.0,
        speed_weight: 0.0,
    };
    let nowhere = Watched { walls: vec![], bends: vec![] };
    let settled = EASES.map(|ease| {
        let line = hermite(ends, ease);
        let length: f64 = line.windows(2).map(|w| w[0].distance(w[1])).sum();
        let count = ((length / SPAN_MM).round() as usize + 3).clamp(6, 20);
        let mut course = Course::along((ends, world.freedom), &line, count);
        settle(world, &mut course, &limits, &nowhere, (8, 1e-5))
    });
    settled.into_iter().fold(f64::INFINITY, f64::min)
}

/// Some of the places are to be chosen.
struct Task<'a> {
    places: &'a [DVec2],
    /// By candidate, then by target.
    use_of: &'a [Vec<f64>],
    /// By direction of view, targets that face it.
    views: &'a [Vec<usize>],
    /// Least distance between two, mm.
    pitch: f64,
}

impl Task<'_> {
    /// `count` candidates; none if there is no room for so many.
    fn search(&self, mut chosen: Vec<usize>, count: usize) -> Option<Vec<usize>> {
        while chosen.len() < count {
            let best = self.best_for(&chosen, chosen.len())?;
            chosen.push(best);
        }
        // Every exchange is a gain, so this ends; the limit is for rounding.
        for _ in 0..100 {
            let mut changed = false;
            for slot in 0..chosen.len() {
                let best = self.best_for(&chosen, slot)?;
                let mut next = chosen.clone();
                next[slot] = best;
                if self.value(&next) > self.value(&chosen) + 1e-12 {
                    (chosen, changed) = (next, true);
                }
                let mut next = chosen.clone();
                next.swap(0, slot);
                if self.value(&next) > self.value(&chosen) + 1e-12 {
                    (chosen, changed) = (next, true);
                }
            }
            if !changed {
                break;
            }
        }
        Some(chosen)
    }

    /// The candidate that is best in a slot, all others as they are; of equals the first.
    fn best_for(&self, chosen: &[usize], slot: usize) -> Option<usize> {
        let free = |k: &usize| {
            let apart = |(s, &other): (usize, &usize)| {
                s == slot || self.places[other].distance(self.places[*k]) >= self.pitch * (1.0 - 1e-9)
            };
            chosen.iter().enumerate().all(apart)
        };
        let value = |k: usize| {
            let mut next = chosen.to_vec();
            if slot < next.len() {
                next[slot] = k
            } else {
                next.push(k)
            }
            self.value(&next)
        };
        let valued: Vec<(usize, f64)> = (0..self.places.len()).filter(free).map(|k| (k, value(k))).collect();
        let best = valued.into_iter().reduce(|best, next| if next.1 > best.1 { next } else { best });
        best.map(|(k, _)| k)
    }

    /// The mean over all views of the mean use of the brightest targets there, less what uneven territories cost.
    fn value(&self, chosen: &[usize]) -> f64 {
        let targets = self.use_of.first().map_or(0, Vec::len);
        let mut territory = vec![0usize; chosen.len()];
        let mut seen = |target: usize| {
            let use_of = |slot: usize| self.use_of[chosen[slot]][target];
            let best = (1..chosen.len()).reduce(|a, b| if use_of(b) > use_of(a) { b } else { a });
            best.iter().for_each(|&best| territory[best] += 1);
            M_SEQUENCE_WEIGHT * use_of(0) + best.map_or(0.0, use_of)
        };
        let uses: Vec<f64> = (0..targets).map(&mut seen).collect();
        let sum: f64 = self.views.iter().map(|facing| brightest_mean(facing, &uses)).sum();
        let share = |count: &usize| *count as f64 / targets.max(1) as f64;
        let uneven: f64 = territory.iter().map(|count| share(count) * share(count)).sum();
        sum / self.views.len().max(1) as f64 - UNEVEN * uneven
    }
}

/// The mean of the brightest of some targets.
fn brightest_mean(facing: &[usize], uses: &[f64]) -> f64 {
    let mut found: Vec<f64> = facing.iter().map(|&t| uses[t]).collect();
    found.sort_unstable_by(|a, b| b.total_cmp(a));
    found.truncate((COUNTED_SHARE * found.len() as f64).ceil() as usize);
    found.iter().sum::<f64>() / found.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::frustum;
    use fibar_core::artefact::mesh::TriangleMesh;

    fn run(body: &TriangleMesh, params: &Params) -> Result<Vec<DVec2>, String> {
        let base = Base::new(body, params.flatness_mm, params.depth_mm + params.lead_mm);
        places(body, &base, params).map_err(|e| e.to_string())
    }

    /// A block of 30 × 120 × 60 mm.
    fn long_block() -> TriangleMesh {
        let mut body = frustum(15.0, 15.0, 60.0);
        body.vertices.iter_mut().for_each(|v| v.y *= 4.0);
        body
    }

    #[test]
    fn leds_spread_along_a_long_body_and_keep_their_distances() {
        let params = Params { count: 4, pitch_mm: 10.0, ..Params::default() };
        let found = run(&long_block(), &params).unwrap();
        assert_eq!(found.len(), 4);
        assert!(found[0].length() < 20.0, "the m-sequence is for all sides: {found:?}");
        let ys: Vec<f64> = found[1..].iter().map(|p| p.y).collect();
        let spread =
            ys.iter().copied().fold(f64::MIN, f64::max) - ys.iter().copied().fold(f64::MAX, f64::min);
        assert!(spread > 40.0, "{found:?}");
        for (k, a) in found.iter().enumerate() {
            assert!(a.x.abs() <= 15.0 - 3.6 + 1e-9 && a.y.abs() <= 60.0 - 3.6 + 1e-9, "{a}");
            assert!(found[..k].iter().all(|b| b.distance(*a) >= 10.0 - 1e-6), "{found:?}");
        }
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        assert_eq!(pool.install(|| run(&long_block(), &params)), Ok(found));
    }

    #[test]
    fn too_many_are_refused() {
        let error = run(&frustum(9.0, 9.0, 40.0), &Params::default()).unwrap_err();
        assert!(error.contains("no room for 7 LEDs 14 mm apart"), "{error}");
    }
}
