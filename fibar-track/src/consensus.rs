//! A pose from correspondences of which some are wrong: LO-RANSAC (Fischler & Bolles 1981; Chum, Matas & Kittler, DAGM 2003,
//! "Locally Optimized RANSAC") over P3P.

use crate::camera::Camera;
use crate::p3p;
use crate::pose::Pose;
use crate::refinement::{Correspondence, Fit, Uncertainty, refine};
use crate::twin::better_of_twins;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// How to search.
#[derive(Clone, Copy, Debug)]
pub struct ConsensusOptions {
    /// A correspondence agrees with a pose when its blob is at most this far from where the pose puts it, px.
    pub gate_px: f64,
    /// Chance with which a sample of three right ones shall have been drawn.
    pub confidence: f64,
    /// Samples drawn at most.
    pub max_samples: usize,
    /// For the samples.
    pub seed: u64,
}

impl Default for ConsensusOptions {
    fn default() -> ConsensusOptions {
        ConsensusOptions { gate_px: 3.0, confidence: 0.999, max_samples: 400, seed: 0 }
    }
}

/// A pose and what speaks for it.
#[derive(Clone, Debug)]
pub struct Estimate {
    /// Camera from object.
    pub pose: Pose,
    /// Indices of the correspondences that agree, rising.
    pub inliers: Vec<usize>,
    /// Root mean square distance of the inliers' blobs from where the pose puts them, px.
    pub rms_px: f64,
    /// Covariance by the inliers.
    pub uncertainty: Uncertainty,
    /// How many times the square error the mirror twin has; near 1 the orientation is ambiguous, infinite without twin.
    pub twin_margin: f64,
}

/// The pose that most correspondences agree with; `None` if no four do.
pub fn find_consensus(
    camera: &Camera,
    seen: &[Correspondence],
    options: &ConsensusOptions,
) -> Option<Estimate> {
    let mut random = ChaCha8Rng::seed_from_u64(options.seed);
    let mut best: Option<(Fit, Vec<usize>)> = None;
    let (mut drawn, mut needed, mut most) = (0, options.max_samples, 3);
    while drawn < needed && seen.len() >= 4 {
        drawn += 1;
        let sample = draw_three(&mut random, seen.len()).map(|k| seen[k]);
        let bearings = sample.map(|s| camera.bearing(s.pixel));
        for pose in p3p::solve(bearings, sample.map(|s| s.point)).iter() {
            let count = seen.iter().filter(|s| agrees(camera, pose, s, options.gate_px)).count();
            if count <= most {
                continue;
            }
            most = count;
            let Some(local) = optimise(camera, pose, seen, options.gate_px) else { continue };
            if best.as_ref().is_none_or(|b| is_better(&local, b)) {
                needed = needed.min(samples_needed(local.1.len(), seen.len(), options));
                best = Some(local);
            }
        }
    }
    best.map(|(fit, agreeing)| conclude(camera, fit, agreeing, seen))
}

fn is_better((fit, agreeing): &(Fit, Vec<usize>), (other, most): &(Fit, Vec<usize>)) -> bool {
    agreeing.len() > most.len() || (agreeing.len() == most.len() && fit.error_px2 < other.error_px2)
}

/// Refines on all that agree within twice the gate, then within the gate, while their number grows.
fn optimise(
    camera: &Camera,
    start: &Pose,
    seen: &[Correspondence],
    gate_px: f64,
) -> Option<(Fit, Vec<usize>)> {
    let mut pose = *start;
    let mut best: Option<(Fit, Vec<usize>)> = None;
    for widening in [2.0, 1.0, 1.0] {
        let agreeing = inliers(camera, &pose, seen, widening * gate_px);
        let chosen: Vec<Correspondence> = agreeing.iter().map(|&k| seen[k]).collect();
        let fit = refine(camera, &pose, &chosen, 8)?;
        pose = fit.pose;
        let agreeing = inliers(camera, &pose, seen, gate_px);
        if agreeing.len() >= 4 && best.as_ref().is_none_or(|b| is_better(&(fit, agreeing.clone()), b)) {
            best = Some((fit, agreeing));
        }
    }
    best
}

fn conclude(camera: &Camera, fit: Fit, inliers: Vec<usize>, seen: &[Correspondence]) -> Estimate {
    let chosen: Vec<Correspondence> = inliers.iter().map(|&k| seen[k]).collect();
    let (fit, twin_margin) =
        better_of_twins(camera, refine(camera, &fit.pose, &chosen, 20).unwrap_or(fit), &chosen, 20);
    let rms_px = (fit.error_px2 / chosen.len() as f64).sqrt();
    Estimate { pose: fit.pose, inliers, rms_px, uncertainty: fit.uncertainty, twin_margin }
}

fn inliers(camera: &Camera, pose: &Pose, seen: &[Correspondence], gate_px: f64) -> Vec<usize> {
    (0..seen.len()).filter(|&k| agrees(camera, pose, &seen[k], gate_px)).collect()
}

fn agrees(camera: &Camera, pose: &Pose, seen: &Correspondence, gate_px: f64) -> bool {
    let z = pose.apply(seen.point);
    z.z > 0.0 && camera.project(z).distance_squared(seen.pixel) <= gate_px * gate_px
}

/// Samples until three right ones of `right` among `all` have been drawn with the wanted confidence.
fn samples_needed(right: usize, all: usize, options: &ConsensusOptions) -> usize {
    let share = right as f64 / all as f64;
    let miss = 1.0 - share * share * share;
    if miss <= 0.0 { 1 } else { (libm::log(1.0 - options.confidence) / libm::log(miss)).ceil() as usize }
}

fn draw_three(random: &mut ChaCha8Rng, count: usize) -> [usize; 3] {
    let mut draw = |below: usize| (random.next_u64() % below as u64) as usize;
    let (a, mut b, mut c) = (draw(count), draw(count - 1), draw(count - 2));
    b += usize::from(b >= a);
    for taken in [a.min(b), a.max(b)] {
        c += usize::from(c >= taken);
    }
    [a, b, c]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::{Random, random_pose};
    use glam::DVec2;

    #[test]
    fn draws_are_three_of_all() {
        let mut random = ChaCha8Rng::seed_from_u64(4);
        let draws: std::collections::BTreeSet<[usize; 3]> =
            (0..2000).map(|_| draw_three(&mut random, 4)).collect();
        assert_eq!(draws.len(), 24, "every ordered triple of four, and nothing else");
        assert!(draws.iter().all(|[a, b, c]| a != b && b != c && a != c));
    }

    #[test]
    fn wrong_correspondences_are_outvoted() {
        let camera = Camera::centred(1100.0, 720.0, 540.0);
        let mut random = Random::new(9);
        let check = |count: usize, wrong: usize, noise_px: f64, random: &mut Random| {
            let pose = random_pose(random, 500.0..1200.0);
            let mut seen = Vec::new();
            for k in 0..count {
                let point = random.in_ball(70.0);
                let pixel = camera.project(pose.apply(point)) + random.noise(noise_px);
                let lost = DVec2::new(random.within(60.0..200.0), random.within(60.0..200.0));
                seen.push(Correspondence { point, pixel: if k < wrong { pixel + lost } else { pixel } });
            }
            let found = find_consensus(&camera, &seen, &ConsensusOptions::default()).expect("a pose");
            assert!(
                (wrong..count).filter(|k| !found.inliers.contains(k)).count() <= 1,
                "{:?}",
                found.inliers
            );
            let (turn, shift) = (found.uncertainty.turn_rad(), found.uncertainty.along_sight_mm());
            let off = found.pose.translation.distance(pose.translation);
            assert!(found.pose.angle_to(&pose) <= 6.0 * turn * noise_px + 1e-6);
            assert!(off <= 6.0 * noise_px * (shift + 100.0 * turn) + 1e-3, "{off} mm");
        };
        for _ in 0..30 {
            check(12, 0, 0.0, &mut random);
            check(12, 5, 0.2, &mut random);
            check(20, 10, 0.3, &mut random);
        }
    }

    #[test]
    fn too_few_have_no_pose() {
        let camera = Camera::centred(1100.0, 720.0, 540.0);
        let at = |x: f64| Correspondence { point: glam::DVec3::X * x, pixel: DVec2::splat(x) };
        let check = |seen: &[Correspondence]| {
            assert!(find_consensus(&camera, seen, &ConsensusOptions::default()).is_none());
        };
        check(&[]);
        check(&[at(1.0), at(2.0), at(3.0)]);
        check(&[at(1.0), at(2.0), at(3.0), at(4.0), at(5.0)]);
    }
}
