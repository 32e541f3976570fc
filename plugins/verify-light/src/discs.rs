//! Discs that overlap: what of a weighted plane belongs to each, where every place is dealt evenly among the discs over it.
//!
//! The plane is cut into lines. Along one, the discs are chords; between two neighbouring ends of chords the same discs lie
//! over every place, so that a stretch is dealt at once.

use glam::DVec2;

/// A circle with its inside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    /// Its centre, mm.
    pub centre: DVec2,
    /// Its radius, mm.
    pub radius: f64,
}

/// Lines per radius of the smallest disc.
const LINES: f64 = 128.0;

/// `∫ weight/n` over each disc, `n` the number of discs over a place. `weight` takes places in the discs' plane.
pub fn deal(discs: &[Disc], weight: &impl Fn(DVec2) -> f64) -> Vec<f64> {
    let low = discs.iter().map(|d| d.centre.y - d.radius).fold(f64::INFINITY, f64::min);
    let high = discs.iter().map(|d| d.centre.y + d.radius).fold(f64::NEG_INFINITY, f64::max);
    let smallest = discs.iter().map(|d| d.radius).fold(f64::INFINITY, f64::min);
    let mut shares = vec![0.0; discs.len()];
    if discs.is_empty() {
        return shares;
    }
    let lines = ((high - low) / smallest * LINES).ceil();
    let step = (high - low) / lines;
    for k in 0..lines as u32 {
        let y = low + (f64::from(k) + 0.5) * step;
        deal_line(discs, y, &|x| step * weight(DVec2::new(x, y)), &mut shares);
    }
    shares
}

fn deal_line(discs: &[Disc], y: f64, weight: &impl Fn(f64) -> f64, shares: &mut [f64]) {
    let chords: Vec<Option<(f64, f64)>> = discs.iter().map(|disc| disc.chord(y)).collect();
    let mut ends: Vec<f64> = chords.iter().flatten().flat_map(|&(from, to)| [from, to]).collect();
    ends.sort_by(f64::total_cmp);
    for stretch in ends.windows(2) {
        let middle = 0.5 * (stretch[0] + stretch[1]);
        let over = |chord: &Option<(f64, f64)>| chord.is_some_and(|(from, to)| from < middle && middle < to);
        let count = chords.iter().filter(|chord| over(chord)).count();
        if count == 0 {
            continue;
        }
        let part = simpson(weight, stretch[0], stretch[1]) / count as f64;
        let owners = shares.iter_mut().zip(&chords).filter(|(_, chord)| over(chord));
        owners.for_each(|(share, _)| *share += part);
    }
}

fn simpson(f: &impl Fn(f64) -> f64, from: f64, to: f64) -> f64 {
    let at = |k: u32| f(from + (to - from) * f64::from(k) / 8.0);
    let sum = at(0) + at(8) + 4.0 * (at(1) + at(3) + at(5) + at(7)) + 2.0 * (at(2) + at(4) + at(6));
    sum * (to - from) / 24.0
}

impl Disc {
    /// Where a line of equal `y` enters and leaves.
    fn chord(&self, y: f64) -> Option<(f64, f64)> {
        let height = y - self.centre.y;
        let squared = self.radius * self.radius - height * height;
        (squared > 0.0).then(|| (self.centre.x - squared.sqrt(), self.centre.x + squared.sqrt()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[track_caller]
    fn check(centres: &[[f64; 2]], expected: &[f64]) {
        let discs: Vec<Disc> =
            centres.iter().map(|c| Disc { centre: DVec2::from(*c), radius: 1.0 }).collect();
        let found = deal(&discs, &|_| 1.0);
        assert!(found.iter().zip(expected).all(|(f, e)| (f - e).abs() < 2e-3), "{found:?}, not {expected:?}");
    }

    #[test]
    fn overlaps_are_halved() {
        check(&[[0.0, 0.0]], &[PI]);
        check(&[[0.0, 0.0], [5.0, 0.0]], &[PI, PI]);
        check(&[[3.0, 1.0]; 4], &[PI / 4.0; 4]);
        let lens = 2.0 * PI / 3.0 - 3f64.sqrt() / 2.0; // two unit discs, centres 1 apart
        check(&[[0.0, 0.0], [0.6, 0.8]], &[PI - lens / 2.0; 2]);
    }

    #[test]
    fn weights_count_by_place() {
        let disc = Disc { centre: DVec2::new(2.0, -1.0), radius: 0.5 };
        let moment = deal(&[disc], &|place| place.x)[0] / deal(&[disc], &|_| 1.0)[0];
        assert!((moment - 2.0).abs() < 1e-9, "{moment}");
    }
}
