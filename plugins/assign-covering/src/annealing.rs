//! Simulated annealing (Kirkpatrick, Gelatt & Vecchi 1983): when a change for the worse is taken, and which of several
//! searches counts.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

/// The cheapest outcome of several searches, each with random numbers of its own; of equals the first.
pub fn best_of_starts<T: Send>(
    starts: u32,
    seed: u64,
    search: impl Fn(ChaCha8Rng) -> T + Sync,
    cost: impl Fn(&T) -> f64,
) -> Option<T> {
    let begin = |start: u32| {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(u64::from(start));
        search(rng)
    };
    let found: Vec<T> = (0..starts).into_par_iter().map(begin).collect();
    found.into_iter().reduce(|best, other| if cost(&other) < cost(&best) { other } else { best })
}

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
