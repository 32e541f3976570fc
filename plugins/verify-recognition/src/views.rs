//! Held-out views: random directions, distances, aims and rolls, never those of the lookup table.

use crate::params::Params;
use fibar_track::pose::Pose;
use glam::{DVec2, DVec3};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use std::f64::consts::TAU;

/// Where a camera stands.
#[derive(Clone, Copy, Debug)]
pub struct Viewpoint {
    /// Camera centre, mm.
    pub eye: DVec3,
    /// What it looks at, mm.
    pub target: DVec3,
    /// Its roll, rad.
    pub roll_rad: f64,
}

impl Viewpoint {
    /// A random viewpoint around `middle`, even over the directions above the lowest.
    pub fn random(chance: &mut Chance, middle: DVec3, params: &Params) -> Viewpoint {
        let height = chance.within(libm::sin(params.lowest_view_deg.to_radians()), 1.0);
        let (azimuth, radius) = (chance.within(0.0, TAU), (1.0 - height * height).max(0.0).sqrt());
        let direction = DVec3::new(radius * libm::cos(azimuth), radius * libm::sin(azimuth), height);
        let distance = chance.within(params.nearest_mm, params.farthest_mm);
        let target = middle + chance.in_ball() * params.aim_mm;
        Viewpoint { eye: middle + direction * distance, target, roll_rad: chance.within(0.0, TAU) }
    }

    /// Camera from object, as the camera is held.
    pub fn pose(&self) -> Pose {
        Pose::looking(self.eye, self.target, self.roll_rad)
    }

    /// Camera from object, held upright.
    pub fn upright_pose(&self) -> Pose {
        Pose::looking(self.eye, self.target, 0.0)
    }
}

/// Random numbers of one view: a seed and the view's number give them, whatever thread asks.
pub struct Chance(ChaCha8Rng);

impl Chance {
    /// The numbers of view `stream`.
    pub fn new(seed: u64, stream: u64) -> Chance {
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        generator.set_stream(stream);
        Chance(generator)
    }

    /// Evenly from `low` to below `high`.
    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64 * (high - low)
    }

    /// Evenly in the unit ball.
    pub fn in_ball(&mut self) -> DVec3 {
        loop {
            let point = DVec3::from_array(std::array::from_fn(|_| self.within(-1.0, 1.0)));
            if point.length_squared() <= 1.0 {
                return point;
            }
        }
    }

    /// Two independent standard normal variates, by Box and Muller.
    pub fn normal_pair(&mut self) -> DVec2 {
        let radius = (-2.0 * libm::log(1.0 - self.within(0.0, 1.0))).sqrt();
        let angle = self.within(0.0, TAU);
        DVec2::new(radius * libm::cos(angle), radius * libm::sin(angle))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_even_above_the_lowest() {
        let params = Params { lowest_view_deg: 30.0, ..Params::default() };
        let views: Vec<Viewpoint> =
            (0..4000).map(|k| Viewpoint::random(&mut Chance::new(3, k), DVec3::ONE, &params)).collect();
        let heights = views.iter().map(|v| (v.eye - DVec3::ONE).normalize().z);
        assert!(heights.clone().all(|z| z >= 0.5 - 1e-9));
        let mean = heights.sum::<f64>() / views.len() as f64;
        assert!((mean - 0.75).abs() < 0.01, "area of a sphere is even in height: {mean}");
        let distances = views.iter().map(|v| v.eye.distance(DVec3::ONE));
        assert!(distances.clone().all(|d| (600.0..1400.0).contains(&d)));
    }

    #[test]
    fn a_view_depends_on_seed_and_number_alone() {
        let view =
            |seed, k| Viewpoint::random(&mut Chance::new(seed, k), DVec3::ZERO, &Params::default()).eye;
        assert_eq!(view(1, 7), view(1, 7));
        assert_ne!(view(1, 7), view(1, 8));
        assert_ne!(view(1, 7), view(2, 7));
    }
}
