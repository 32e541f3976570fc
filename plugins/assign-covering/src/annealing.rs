//! Simulated annealing (Kirkpatrick, Gelatt & Vecchi 1983): when a change for the worse is taken.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// A temperature that falls by the same factor with every move.
pub struct Cooling {
    temperature: f64,
    factor: f64,
}

impl Cooling {
    /// From `hot` to `cold` within a number of moves; in the unit of the cost.
    pub fn new(hot: f64, cold: f64, moves: u32) -> Cooling {
        let factor = libm::pow(cold / hot, 1.0 / f64::from(moves.max(1)));
        Cooling { temperature: hot, factor }
    }

    /// One move on: whether a rise of the cost is taken. No rise always is.
    pub fn takes(&mut self, rise: f64, rng: &mut ChaCha8Rng) -> bool {
        self.temperature *= self.factor;
        rise <= 0.0 || rng.random::<f64>() < libm::exp(-rise / self.temperature)
    }
}
