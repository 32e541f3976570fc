//! Which boxes of a list overlap each other: a tree of eights over their order along a Z curve (Morton 1966), held against itself.

use glam::DVec3;
use rayon::prelude::*;

/// A box in single precision, rounded outwards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LooseBox {
    low: [f32; 3],
    high: [f32; 3],
}

impl LooseBox {
    /// What no box overlaps.
    const NONE: LooseBox = LooseBox { low: [f32::NAN; 3], high: [f32::NAN; 3] };

    /// Around some points, finite.
    pub fn around(points: [DVec3; 3]) -> LooseBox {
        let [a, b, c] = points;
        let (low, high) = (a.min(b).min(c).to_array(), a.max(b).max(c).to_array());
        LooseBox { low: low.map(below), high: high.map(above) }
    }

    fn merged(self, other: LooseBox) -> LooseBox {
        LooseBox {
            low: std::array::from_fn(|axis| self.low[axis].min(other.low[axis])),
            high: std::array::from_fn(|axis| self.high[axis].max(other.high[axis])),
        }
    }
}

/// The greatest single-precision number that is not above.
fn below(x: f64) -> f32 {
    let near = x as f32;
    if f64::from(near) > x { near.next_down() } else { near }
}

fn above(x: f64) -> f32 {
    -below(-x)
}

/// In no group.
pub const LOOSE: u32 = u32::MAX;

/// Calls `visit` with every two boxes that overlap or touch, by their numbers in no certain order, and collects what it gives, in an
/// order that is the same for any number of threads.
pub fn overlaps<T: Send>(boxes: &[LooseBox], visit: impl Fn([u32; 2]) -> Option<T> + Sync) -> Vec<T> {
    overlaps_of_groups(boxes, &vec![LOOSE; boxes.len()], visit)
}

/// The same, but for boxes of the same group. Groups are numbered from 0, or [`LOOSE`].
pub fn overlaps_of_groups<T: Send>(
    boxes: &[LooseBox],
    groups: &[u32],
    visit: impl Fn([u32; 2]) -> Option<T> + Sync,
) -> Vec<T> {
    /// Parts of the work are pairs of nodes this high above the boxes, of 512 boxes each.
    const PART: usize = 3;
    if boxes.is_empty() {
        return Vec::new();
    }
    let order = by_group(&along_curve(boxes), groups);
    let tree = Tree::of(order.iter().map(|&number| (boxes[number as usize], groups[number as usize])));
    let top = tree.levels.len();
    let mut parts = Vec::new();
    tree.descend(top, PART.min(top), [0, 0], &mut |part| parts.push(part));
    let search = |&part: &[usize; 2]| {
        let mut found = Vec::new();
        tree.descend(PART.min(top), 0, part, &mut |pair| found.extend(visit(pair.map(|place| order[place]))));
        found
    };
    let found: Vec<Vec<T>> = parts.par_iter().map(search).collect();
    found.into_iter().flatten().collect()
}

/// The boxes' numbers in the order of their middles along a Z curve.
fn along_curve(boxes: &[LooseBox]) -> Vec<u32> {
    let all = boxes.iter().copied().reduce(LooseBox::merged).unwrap_or(LooseBox::NONE);
    let scale: [f32; 3] = std::array::from_fn(|axis| 1023.0 / (all.high[axis] - all.low[axis]));
    let key = |(number, one): (u32, &LooseBox)| {
        let cell = |axis: usize| {
            let middle = 0.5 * one.low[axis] + 0.5 * one.high[axis];
            // Anything odd becomes a number of the range: the order is a matter of speed only.
            spread((((middle - all.low[axis]) * scale[axis]) as u32).min(1023))
        };
        u64::from(cell(0) | cell(1) << 1 | cell(2) << 2) << 32 | u64::from(number)
    };
    let mut keys: Vec<u64> = (0..).zip(boxes).map(key).collect();
    sort_by_high_half(&mut keys);
    keys.into_iter().map(|key| key as u32).collect()
}

/// Sorts numbers by their groups; within a group their order stays.
fn by_group(order: &[u32], groups: &[u32]) -> Vec<u32> {
    let place = |number: u32| groups[number as usize].wrapping_add(1) as usize;
    let count = order.iter().map(|&number| place(number)).max().unwrap_or(0);
    let mut starts = vec![0u32; count + 1];
    order.iter().for_each(|&number| starts[place(number)] += 1);
    let mut sum = 0;
    starts.iter_mut().for_each(|start| sum += std::mem::replace(start, sum));
    let mut sorted = vec![0; order.len()];
    for &number in order {
        let start = &mut starts[place(number)];
        sorted[*start as usize] = number;
        *start += 1;
    }
    sorted
}

/// Ten bits, two zeros after each.
fn spread(x: u32) -> u32 {
    let x = (x | x << 16) & 0x0300_00ff;
    let x = (x | x << 8) & 0x0300_f00f;
    let x = (x | x << 4) & 0x030c_30c3;
    (x | x << 2) & 0x0924_9249
}

/// Stable, by the lowest 30 bits of the upper half.
fn sort_by_high_half(keys: &mut Vec<u64>) {
    const BITS: u32 = 10;
    let mut sorted = vec![0; keys.len()];
    for shift in [32, 32 + BITS, 32 + 2 * BITS] {
        let digit = |key: u64| (key >> shift) as usize & ((1 << BITS) - 1);
        let mut starts = [0u32; 1 << BITS];
        keys.iter().for_each(|&key| starts[digit(key)] += 1);
        let mut sum = 0;
        starts.iter_mut().for_each(|start| sum += std::mem::replace(start, sum));
        for &key in keys.iter() {
            let start = &mut starts[digit(key)];
            sorted[*start as usize] = key;
            *start += 1;
        }
        std::mem::swap(keys, &mut sorted);
    }
}

/// Eight boxes, side by side so that one instruction compares several.
struct Eight {
    low: [[f32; 8]; 3],
    high: [[f32; 8]; 3],
}

impl Eight {
    fn of(boxes: &[LooseBox]) -> Eight {
        let at = |k: usize| boxes.get(k).copied().unwrap_or(LooseBox::NONE);
        let all: [LooseBox; 8] = std::array::from_fn(at);
        let of_axes = |side: &dyn Fn(&LooseBox) -> [f32; 3]| {
            std::array::from_fn(|axis| std::array::from_fn(|k| side(&all[k])[axis]))
        };
        Eight { low: of_axes(&|one| one.low), high: of_axes(&|one| one.high) }
    }

    fn get(&self, k: usize) -> LooseBox {
        LooseBox { low: self.low.map(|axis| axis[k]), high: self.high.map(|axis| axis[k]) }
    }

    /// A bit for each box that overlaps another.
    #[inline]
    fn overlapping(&self, other: &LooseBox) -> u32 {
        let mut hits: [u32; 8] = std::array::from_fn(|k| 1 << k);
        for axis in 0..3 {
            let (low, high) = (other.low[axis], other.high[axis]);
            for (k, hit) in hits.iter_mut().enumerate() {
                let overlaps = (self.low[axis][k] <= high) & (low <= self.high[axis][k]);
                *hit &= u32::from(overlaps).wrapping_neg();
            }
        }
        hits.iter().sum()
    }
}

/// The nodes of each level are eight of the level below; the lowest are eight boxes.
struct Tree {
    levels: Vec<Vec<Eight>>,
    /// For the boxes and each level of nodes, what group all that is below belongs to.
    groups: Vec<Vec<u32>>,
}

impl Tree {
    fn of(boxes: impl Iterator<Item = (LooseBox, u32)>) -> Tree {
        let mut levels: Vec<Vec<Eight>> = Vec::new();
        let (mut below, lowest): (Vec<LooseBox>, Vec<u32>) = boxes.unzip();
        let mut groups = vec![lowest];
        while levels.is_empty() || below.len() > 1 {
            let merge = |some: &[LooseBox]| some.iter().copied().fold(LooseBox::NONE, LooseBox::merged);
            let common =
                |some: &[u32]| if some.iter().all(|group| *group == some[0]) { some[0] } else { LOOSE };
            groups.push(groups[levels.len()].chunks(8).map(common).collect());
            levels.push(below.chunks(8).map(Eight::of).collect());
            below = below.chunks(8).map(merge).collect();
        }
        Tree { levels, groups }
    }

    fn are_of_one_group(&self, level: usize, [one, other]: [usize; 2]) -> bool {
        let groups = &self.groups[level];
        groups[one] == groups[other] && groups[one] != LOOSE
    }

    /// Every two nodes of level `floor` below two of `level` (or one, held against itself) that overlap and are not of one group, and at
    /// levels above the boxes also every node with itself.
    fn descend(
        &self,
        level: usize,
        floor: usize,
        [one, other]: [usize; 2],
        found: &mut dyn FnMut([usize; 2]),
    ) {
        if self.are_of_one_group(level, [one, other]) {
            return;
        }
        if level == floor {
            return found([one, other]);
        }
        let [a, b] = [one, other].map(|node| &self.levels[level - 1][node]);
        let around = |node: usize| self.levels.get(level).map(|above| above[node / 8].get(node % 8));
        let same = one == other;
        let candidates = match around(other) {
            Some(around) if !same => a.overlapping(&around),
            _ => 0xff,
        };
        for k in bits(candidates) {
            let own = a.get(k);
            let later = if same { 0xfe << k } else { 0xff };
            for m in bits(b.overlapping(&own) & later) {
                self.descend(level - 1, floor, [8 * one + k, 8 * other + m], found);
            }
            if same && level > 1 && !own.low[0].is_nan() {
                self.descend(level - 1, floor, [8 * one + k; 2], found);
            }
        }
    }
}

/// The numbers of the bits that are set.
fn bits(mut set: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lowest = set.trailing_zeros() as usize;
        set &= set.wrapping_sub(1);
        (lowest < 32).then_some(lowest)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::RngExt;
    use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};

    #[test]
    fn all_and_only_overlapping_boxes_are_found_once() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        for (count, size) in [(0, 1.0), (1, 1.0), (7, 0.5), (9, 0.0), (300, 0.2), (5000, 0.02), (100, 1e299)]
        {
            let mut near = |place: DVec3, reach: f64| {
                place + DVec3::from([0; 3].map(|_| rng.random_range(-reach..=reach)))
            };
            let mut a_box = || {
                let middle = near(DVec3::ZERO, 1.0);
                LooseBox::around([0; 3].map(|_| near(middle, size)))
            };
            let mut boxes: Vec<LooseBox> = (0..count).map(|_| a_box()).collect();
            boxes.extend_from_within(..count / 3);
            let groups: Vec<u32> =
                (0..boxes.len() as u32).map(|k| [k / 40, LOOSE][(k % 7 == 0) as usize]).collect();
            let touch = |a: &LooseBox, b: &LooseBox| {
                (0..3).all(|axis| a.low[axis] <= b.high[axis] && b.low[axis] <= a.high[axis])
            };
            let apart = |a: usize, b: usize| groups[a] == LOOSE || groups[a] != groups[b];
            let all = (0..boxes.len()).flat_map(|a| (a + 1..boxes.len()).map(move |b| [a, b]));
            let expected: Vec<[usize; 2]> =
                all.filter(|&[a, b]| apart(a, b) && touch(&boxes[a], &boxes[b])).collect();
            let sorted = |[a, b]: [u32; 2]| Some([a.min(b), a.max(b)].map(|number| number as usize));
            let mut found = overlaps_of_groups(&boxes, &groups, sorted);
            found.sort_unstable();
            assert_eq!(found, expected, "{count} boxes of {size}");
        }
    }

    #[test]
    fn boxes_are_rounded_outwards() {
        for x in [0.1, -0.1, 1.0, 1e-50, -1e-50, 1e300, -1e300, 16_777_217.0] {
            assert!(f64::from(below(x)) <= x && x <= f64::from(above(x)), "{x}");
        }
    }
}
