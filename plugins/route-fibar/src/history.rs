//! The terms of the objective at every iteration.

use crate::objective::Terms;
use std::fmt::Write;

/// One iteration; the first is the initial routing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    /// Not weighted.
    pub terms: Terms,
    /// Their weighted sum.
    pub objective: f64,
    /// Mean over the fibres.
    pub mean_e_cam: f64,
}

/// All iterations.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct History {
    entries: Vec<Entry>,
    best: usize,
    last_gain: usize,
    target: f64,
}

impl History {
    /// Appends an iteration; whether it is the best so far. A gain is counted when the objective falls by the relative
    /// `least_gain` since the last gain.
    pub fn add(&mut self, entry: Entry, least_gain: f64) -> bool {
        let number = self.entries.len();
        self.entries.push(entry);
        let better = number == 0 || entry.objective < self.entries[self.best].objective;
        if better {
            self.best = number;
        }
        if number == 0 || entry.objective < self.target {
            self.last_gain = number;
            self.target = entry.objective - least_gain * entry.objective.abs();
        }
        better
    }

    /// Iterations since the last gain.
    pub fn since_gain(&self) -> usize {
        self.entries.len().saturating_sub(1) - self.last_gain
    }

    /// Iterations after the initial routing.
    pub fn iterations(&self) -> usize {
        self.entries.len().saturating_sub(1)
    }

    /// The initial routing; there is always one.
    pub fn first(&self) -> Entry {
        self.entries[0]
    }

    /// The iteration of the least objective.
    pub fn best(&self) -> Entry {
        self.entries[self.best]
    }

    /// A table with one line per iteration.
    pub fn to_csv(&self) -> String {
        let mut csv = String::from("iteration,objective,cam,fib,surf,reg_mm,mean_e_cam\n");
        for (k, Entry { terms, objective, mean_e_cam }) in self.entries.iter().enumerate() {
            let Terms { cam, fib, surf, reg } = terms;
            writeln!(csv, "{k},{objective},{cam},{fib},{surf},{reg},{mean_e_cam}").expect("strings take all");
        }
        csv
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_best_and_the_last_gain_are_kept_apart() {
        let mut history = History::default();
        let mut add = |objective| {
            let better = history.add(Entry { terms: Terms::default(), objective, mean_e_cam: 0.5 }, 0.1);
            (better, history.since_gain())
        };
        assert_eq!(add(10.0), (true, 0));
        assert_eq!(add(9.5), (true, 1)); // better, but no gain
        assert_eq!(add(9.7), (false, 2));
        assert_eq!(add(8.9), (true, 0));
        assert_eq!(
            (history.best().objective, history.first().objective, history.iterations()),
            (8.9, 10.0, 3)
        );
        assert_eq!(history.to_csv().lines().count(), 5);
    }
}
