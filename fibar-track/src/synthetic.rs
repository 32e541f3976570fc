//! Synthetic problems for the tests: seeded points, poses and noise.

use crate::pose::{Pose, rotation_by};
use fibar_core::artefact::constellation::{Constellation, Marker, Pattern};
use fibar_core::id::{MarkerId, PatternId};
use glam::{DVec2, DVec3};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use std::ops::Range;

/// Numbers out of a seed.
pub struct Random(ChaCha8Rng);

impl Random {
    pub fn new(seed: u64) -> Random {
        Random(ChaCha8Rng::seed_from_u64(seed))
    }

    /// Evenly in a range.
    pub fn within(&mut self, range: Range<f64>) -> f64 {
        range.start + (self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64 * (range.end - range.start)
    }

    /// An index below `count`.
    pub fn below(&mut self, count: usize) -> usize {
        self.within(0.0..count as f64) as usize
    }

    /// Evenly in a ball.
    pub fn in_ball(&mut self, radius: f64) -> DVec3 {
        loop {
            let point = DVec3::from_array(std::array::from_fn(|_| self.within(-1.0..1.0)));
            if point.length_squared() <= 1.0 {
                return point * radius;
            }
        }
    }

    /// Evenly on the unit sphere.
    pub fn direction(&mut self) -> DVec3 {
        loop {
            let point = self.in_ball(1.0);
            if point.length_squared() > 1e-4 {
                return point.normalize();
            }
        }
    }

    /// Two independent normal variates, by Box and Muller.
    pub fn noise(&mut self, sigma: f64) -> DVec2 {
        let radius = (-2.0 * libm::log(1.0 - self.within(0.0..1.0))).sqrt() * sigma;
        let angle = self.within(0.0..std::f64::consts::TAU);
        DVec2::new(radius * libm::cos(angle), radius * libm::sin(angle))
    }
}

/// Markers of seven patterns at random on an ellipsoid, 100 to 140 mm wide, normals outward.
pub fn object(random: &mut Random, markers: u32) -> Constellation {
    let patterns = (1..=7).map(|id| Pattern { id: PatternId(id), bits: vec![true] }).collect();
    let radii = DVec3::new(50.0, 60.0, 70.0);
    let mut marker = |id: u32| {
        let direction = random.direction();
        let pattern = PatternId(1 + random.below(7) as u32);
        let normal = (direction / radii).normalize();
        Marker { id: MarkerId(id), position: direction * radii, normal, pattern, neighbours: vec![] }
    };
    let markers = (1..=markers).map(&mut marker).collect();
    Constellation::new(350.0, patterns, markers)
}

/// A camera somewhere around the origin, looking nearly at it, at any roll.
pub fn random_pose(random: &mut Random, distance: Range<f64>) -> Pose {
    let eye = random.direction() * random.within(distance);
    let aim = random.in_ball(40.0);
    Pose::looking(eye, aim, random.within(0.0..std::f64::consts::TAU))
}

/// A pose a little off, by up to `angle` rad and `shift` mm.
pub fn disturbed(pose: &Pose, random: &mut Random, angle: f64, shift: f64) -> Pose {
    let turn = rotation_by(random.in_ball(angle));
    Pose { rotation: turn * pose.rotation, translation: pose.translation + random.in_ball(shift) }
}
