//! Control points sorted into cells, so that those near a place are found without asking all.

use glam::{DVec3, IVec3};

/// Most cells along an axis.
const MOST_CELLS: f64 = 100.0;

/// A snapshot of points in cubic cells.
pub struct Cells {
    low: DVec3,
    size: f64,
    counts: IVec3,
    /// Where the members of each cell start in `members`, and one end.
    starts: Vec<u32>,
    /// Numbers of the points, cell after cell, rising within a cell.
    members: Vec<u32>,
}

impl Cells {
    /// Sorts finite points into cells no smaller than `reach` mm.
    pub fn of(points: &[DVec3], reach: f64) -> Cells {
        let (low, high) = bounds(points);
        let size = reach.max((high - low).max_element() / MOST_CELLS).max(f64::MIN_POSITIVE);
        let counts = ((high - low) / size).floor().as_ivec3() + 1;
        let mut cells = Cells { low, size, counts, starts: vec![], members: vec![0; points.len()] };
        cells.fill(points);
        cells
    }

    /// Numbers of all points that may be within `reach` of a place, in a fixed order; some are further.
    pub fn near(&self, place: DVec3) -> impl Iterator<Item = usize> {
        let middle = self.cell(place);
        let (from, to) = ((middle - 1).max(IVec3::ZERO), (middle + 1).min(self.counts - 1));
        let rows = (from.z..=to.z).flat_map(move |z| (from.y..=to.y).map(move |y| (y, z)));
        rows.flat_map(move |(y, z)| {
            let [first, last] = [from.x, to.x].map(|x| self.number(IVec3::new(x, y, z)));
            self.members[self.starts[first] as usize..self.starts[last + 1] as usize]
                .iter()
                .map(|&k| k as usize)
        })
    }

    /// Counting sort.
    fn fill(&mut self, points: &[DVec3]) {
        let numbers: Vec<usize> = points.iter().map(|p| self.number(self.cell(*p))).collect();
        self.starts = vec![0; self.counts.element_product() as usize + 1];
        numbers.iter().for_each(|n| self.starts[n + 1] += 1);
        for n in 1..self.starts.len() {
            self.starts[n] += self.starts[n - 1];
        }
        let mut next = self.starts.clone();
        for (k, n) in numbers.into_iter().enumerate() {
            self.members[next[n] as usize] = k as u32;
            next[n] += 1;
        }
    }

    fn cell(&self, place: DVec3) -> IVec3 {
        ((place - self.low) / self.size).floor().as_ivec3().clamp(IVec3::ZERO, self.counts - 1)
    }

    fn number(&self, cell: IVec3) -> usize {
        ((cell.z * self.counts.y + cell.y) * self.counts.x + cell.x) as usize
    }
}

fn bounds(points: &[DVec3]) -> (DVec3, DVec3) {
    let first = points.first().copied().unwrap_or_default();
    points.iter().fold((first, first), |(low, high), p| (low.min(*p), high.max(*p)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nobody_within_reach_is_missed_and_nobody_comes_twice() {
        let at = |k: u32| {
            let t = f64::from(k);
            DVec3::new((t * 0.7).sin(), (t * 1.3).cos(), (t * 0.31).sin() * 2.0) * 30.0
        };
        let points: Vec<DVec3> = (0..500).map(at).collect();
        for reach in [0.1, 4.0, 25.0, 500.0] {
            let cells = Cells::of(&points, reach);
            for place in &points {
                let mut near: Vec<usize> = cells.near(*place).collect();
                near.sort_unstable();
                assert!(near.is_sorted_by(|a, b| a < b), "twice");
                let within = (0..points.len()).filter(|&k| points[k].distance(*place) <= reach);
                assert!(within.into_iter().all(|k| near.binary_search(&k).is_ok()), "missed at {reach}");
            }
        }
        assert_eq!(Cells::of(&[], 1.0).near(DVec3::ONE).count(), 0);
    }
}
