//! Adam (Kingma & Ba, "Adam: a method for stochastic optimization", 2015), algorithm 1.

use glam::DVec3;

const BETA_1: f64 = 0.9;
const BETA_2: f64 = 0.999;
const EPSILON: f64 = 1e-8;

/// The moments of the gradient so far.
pub struct Adam {
    first: Vec<DVec3>,
    second: Vec<DVec3>,
    decay_1: f64,
    decay_2: f64,
}

impl Adam {
    /// For a number of unknown points.
    pub fn of(points: usize) -> Adam {
        Adam {
            first: vec![DVec3::ZERO; points],
            second: vec![DVec3::ZERO; points],
            decay_1: 1.0,
            decay_2: 1.0,
        }
    }

    /// The next step of every point; `rate` is about the longest of a coordinate.
    pub fn step(&mut self, gradient: &[DVec3], rate: f64) -> Vec<DVec3> {
        self.decay_1 *= BETA_1;
        self.decay_2 *= BETA_2;
        let moments = self.first.iter_mut().zip(&mut self.second);
        let step = |((m, v), g): ((&mut DVec3, &mut DVec3), &DVec3)| {
            *m = BETA_1 * *m + (1.0 - BETA_1) * *g;
            *v = BETA_2 * *v + (1.0 - BETA_2) * *g * *g;
            let (mean, square) = (*m / (1.0 - self.decay_1), *v / (1.0 - self.decay_2));
            -rate * mean / (DVec3::from(square.to_array().map(f64::sqrt)) + EPSILON)
        };
        moments.zip(gradient).map(step).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_step_is_the_rate_against_the_gradient() {
        let step = Adam::of(1).step(&[DVec3::new(3.0, -0.02, 0.0)], 0.1)[0];
        assert!((step - DVec3::new(-0.1, 0.1, 0.0)).length() < 1e-6, "{step}");
    }

    #[test]
    fn a_lopsided_bowl_is_descended() {
        let (mut adam, mut x) = (Adam::of(1), DVec3::new(3.0, -2.0, 1.0));
        for k in 0..2000 {
            x += adam.step(&[x * DVec3::new(1.0, 100.0, 0.01)], 0.05 * (1.0 - f64::from(k) / 2000.0))[0];
        }
        assert!(x.length() < 1e-3, "{x}");
    }
}
