//! Minimising a smooth function of many variables: L-BFGS (Liu & Nocedal 1989), steps found by halving.
//!
//! Made for courses of fibres: variables are lengths in mm, a step longer than `longest_step` of any of them is cut, and
//! progress is judged by the fall of the value. Serial and free of randomness.

use std::collections::VecDeque;

/// How to minimise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MinimiseOptions {
    /// Most steps.
    pub iterations: usize,
    /// Done when the value has fallen by less than this within `patience` steps.
    pub least_gain: f64,
    /// Steps over which the fall is measured.
    pub patience: usize,
    /// Longest change of a variable in one step.
    pub longest_step: f64,
}

/// Pairs of steps and changes of the gradient that are remembered.
const MEMORY: usize = 12;

/// Moves `x` downhill and returns the value there. `f` gives the value at a place and fills in its gradient.
pub fn minimise(
    f: &mut impl FnMut(&[f64], &mut [f64]) -> f64,
    x: &mut Vec<f64>,
    options: MinimiseOptions,
) -> f64 {
    let mut gradient = vec![0.0; x.len()];
    let mut value = f(x, &mut gradient);
    let mut memory = Memory::default();
    let mut past = VecDeque::from([value]);
    for _ in 0..options.iterations {
        let direction = memory.direction(&gradient, options.longest_step);
        let Some(next) = descend(f, x, (value, &gradient), &direction) else {
            if memory.is_empty() {
                break;
            }
            memory = Memory::default();
            continue;
        };
        memory.learn(x, &gradient, &next);
        (*x, gradient, value) = (next.x, next.gradient, next.value);
        past.push_back(value);
        if past.len() > options.patience && past[0] - value < options.least_gain {
            break;
        }
        past.drain(..past.len().saturating_sub(options.patience));
    }
    value
}

/// A place that was tried, and what was found there.
struct Trial {
    x: Vec<f64>,
    gradient: Vec<f64>,
    value: f64,
}

/// The first of the halved steps that falls by a ten-thousandth of what the slope promises (Armijo); none if none does.
fn descend(
    f: &mut impl FnMut(&[f64], &mut [f64]) -> f64,
    x: &[f64],
    (value, gradient): (f64, &[f64]),
    direction: &[f64],
) -> Option<Trial> {
    const PROMISE: f64 = 1e-4;
    const HALVINGS: u32 = 20;
    let slope = dot(gradient, direction);
    if slope >= 0.0 || slope.is_nan() {
        return None;
    }
    let mut step = 1.0;
    let mut trial = Trial { x: x.to_vec(), gradient: vec![0.0; x.len()], value };
    for _ in 0..HALVINGS {
        for ((to, from), d) in trial.x.iter_mut().zip(x).zip(direction) {
            *to = from + step * d;
        }
        trial.value = f(&trial.x, &mut trial.gradient);
        if trial.value <= value + PROMISE * step * slope {
            return Some(trial);
        }
        step *= 0.5;
    }
    None
}

/// What L-BFGS remembers.
#[derive(Default)]
struct Memory {
    /// Steps, changes of the gradient, and one over their product; newest last.
    pairs: VecDeque<(Vec<f64>, Vec<f64>, f64)>,
}

impl Memory {
    fn is_empty(&self) -> bool {
        self.pairs.is_empty()
    }

    /// The two-loop recursion, cut to the longest step.
    fn direction(&self, gradient: &[f64], longest_step: f64) -> Vec<f64> {
        let mut d: Vec<f64> = gradient.iter().map(|g| -g).collect();
        let mut shares = Vec::with_capacity(self.pairs.len());
        for (s, y, inverse) in self.pairs.iter().rev() {
            let share = inverse * dot(s, &d);
            add(&mut d, -share, y);
            shares.push(share);
        }
        if let Some((_, y, inverse)) = self.pairs.back() {
            let scale = 1.0 / (inverse * dot(y, y));
            d.iter_mut().for_each(|d| *d *= scale);
        }
        for ((s, y, inverse), share) in self.pairs.iter().zip(shares.iter().rev()) {
            let rest = share - inverse * dot(y, &d);
            add(&mut d, rest, s);
        }
        let longest = d.iter().fold(0.0f64, |longest, d| longest.max(d.abs()));
        let limit = if self.pairs.is_empty() { 0.05 * longest_step } else { longest_step };
        if longest > limit {
            d.iter_mut().for_each(|d| *d *= limit / longest);
        }
        d
    }

    fn learn(&mut self, x: &[f64], gradient: &[f64], next: &Trial) {
        let step: Vec<f64> = next.x.iter().zip(x).map(|(a, b)| a - b).collect();
        let change: Vec<f64> = next.gradient.iter().zip(gradient).map(|(a, b)| a - b).collect();
        let product = dot(&step, &change);
        if product > 1e-12 * dot(&change, &change) {
            self.pairs.push_back((step, change, 1.0 / product));
        }
        if self.pairs.len() > MEMORY {
            self.pairs.pop_front();
        }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |sum, (a, b)| sum + a * b)
}

fn add(to: &mut [f64], factor: f64, what: &[f64]) {
    to.iter_mut().zip(what).for_each(|(to, what)| *to += factor * what);
}

#[cfg(test)]
mod tests {
    use super::*;

    const OPTIONS: MinimiseOptions =
        MinimiseOptions { iterations: 500, least_gain: 1e-14, patience: 10, longest_step: 1.0 };

    #[test]
    fn rosenbrocks_valley_is_followed_to_its_end() {
        let mut valley = |x: &[f64], gradient: &mut [f64]| {
            let (a, b) = (1.0 - x[0], x[1] - x[0] * x[0]);
            gradient.copy_from_slice(&[-2.0 * a - 400.0 * x[0] * b, 200.0 * b]);
            a * a + 100.0 * b * b
        };
        let mut x = vec![-1.2, 1.0];
        assert!(minimise(&mut valley, &mut x, OPTIONS) < 1e-12, "{x:?}");
    }

    #[test]
    fn a_stiff_bowl_of_many_variables_is_solved() {
        let mut bowl = |x: &[f64], gradient: &mut [f64]| {
            let mut value = 0.0;
            for (k, (x, g)) in x.iter().zip(gradient).enumerate() {
                let (stiffness, off) = ((1 + k * k) as f64, x - k as f64);
                value += stiffness * off * off;
                *g = 2.0 * stiffness * off;
            }
            value
        };
        let mut x = vec![0.0; 30];
        assert!(minimise(&mut bowl, &mut x, OPTIONS) < 1e-9, "{x:?}");
    }

    #[test]
    fn at_the_bottom_nothing_moves() {
        let mut flat = |_: &[f64], gradient: &mut [f64]| {
            gradient.fill(0.0);
            3.0
        };
        let mut x = vec![1.0, 2.0];
        assert_eq!((minimise(&mut flat, &mut x, OPTIONS), x), (3.0, vec![1.0, 2.0]));
    }
}
