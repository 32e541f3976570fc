//! Pairs of triangles that are near enough to cross, by a tree of boxes walked against itself.
//!
//! The triangles are sorted along a Morton curve and the tree lies over that order, with no pointer: node `k` of a level covers the
//! nodes `2k` and `2k + 1` of the next. Pairs that share a side are left out: they cannot cross.

use fibar_core::artefact::mesh::TriangleMesh;
use glam::DVec3;
use rayon::prelude::*;

/// Triangles in a leaf.
const LEAF: usize = 4;

/// Pairs whose boxes meet, the lower number first; the order is the tree's.
pub fn near_pairs(mesh: &TriangleMesh) -> Vec<[u32; 2]> {
    match Tree::of(mesh) {
        Some(tree) => tree.pairs(mesh),
        None => Vec::new(),
    }
}

/// A box of single precision, rounded outwards.
#[derive(Clone, Copy)]
struct Span {
    low: [f32; 3],
    high: [f32; 3],
}

impl Span {
    const NOTHING: Span = Span { low: [f32::INFINITY; 3], high: [f32::NEG_INFINITY; 3] };

    fn around(corners: &[DVec3; 3]) -> Span {
        let low = corners[0].min(corners[1]).min(corners[2]);
        let high = corners[0].max(corners[1]).max(corners[2]);
        Span {
            low: low.to_array().map(|x| (x as f32).next_down()),
            high: high.to_array().map(|x| (x as f32).next_up()),
        }
    }

    fn with(self, other: &Span) -> Span {
        Span {
            low: std::array::from_fn(|axis| self.low[axis].min(other.low[axis])),
            high: std::array::from_fn(|axis| self.high[axis].max(other.high[axis])),
        }
    }

    fn meets(&self, other: &Span) -> bool {
        // Without branches: most answers are hard to foresee.
        (self.low[0] <= other.high[0])
            & (other.low[0] <= self.high[0])
            & (self.low[1] <= other.high[1])
            & (other.low[1] <= self.high[1])
            & (self.low[2] <= other.high[2])
            & (other.low[2] <= self.high[2])
    }
}

struct Tree {
    /// Triangles along the curve, and their boxes.
    order: Vec<u32>,
    boxes: Vec<Span>,
    /// From the root, alone in its level, to the leaves.
    levels: Vec<Vec<Span>>,
}

/// Two nodes of a level.
type Meeting = [u32; 2];

impl Tree {
    fn of(mesh: &TriangleMesh) -> Option<Tree> {
        let (low, high) = mesh.bounds()?;
        let size = (high - low).max_element().max(f64::MIN_POSITIVE);
        let code = |t: u32| {
            let middle = mesh.corners(t as usize).iter().sum::<DVec3>() / 3.0;
            morton((middle - low) / size)
        };
        let mut along: Vec<(u64, u32)> =
            (0..mesh.triangles.len() as u32).into_par_iter().map(|t| (code(t), t)).collect();
        along.par_sort_unstable();
        let order: Vec<u32> = along.into_iter().map(|(_, t)| t).collect();
        let boxes: Vec<Span> = order.par_iter().map(|&t| Span::around(&mesh.corners(t as usize))).collect();
        let cover = |spans: &[Span]| spans.iter().fold(Span::NOTHING, |all, span| all.with(span));
        let mut levels = vec![boxes.chunks(LEAF).map(cover).collect::<Vec<Span>>()];
        while let Some(last) = levels.last().filter(|last| last.len() > 1) {
            levels.push(last.chunks(2).map(cover).collect());
        }
        levels.reverse();
        Some(Tree { order, boxes, levels })
    }

    fn pairs(&self, mesh: &TriangleMesh) -> Vec<[u32; 2]> {
        // Down to a level with work for every thread, then each of its meetings alone.
        const FORK: usize = 7;
        let leaves = self.levels.len() - 1;
        let fork = leaves.min(FORK);
        let mut meetings: Vec<Meeting> = Vec::new();
        self.walk(0, [0, 0], fork, &mut |meeting| meetings.push(meeting));
        let below = |meeting: &Meeting| {
            let mut pairs = Vec::new();
            self.walk(fork, *meeting, leaves, &mut |leaf| self.pairs_of(leaf, mesh, &mut pairs));
            pairs
        };
        let pairs: Vec<Vec<[u32; 2]>> = meetings.par_iter().map(below).collect();
        pairs.concat()
    }

    /// Visits the meetings of nodes of a level that come from one of a level above.
    fn walk(&self, level: usize, [one, other]: Meeting, to: usize, visit: &mut impl FnMut(Meeting)) {
        let meets = |level: usize, one: u32, other: u32| {
            let nodes = &self.levels[level];
            let (one, other) = (nodes.get(one as usize), nodes.get(other as usize));
            one.zip(other).is_some_and(|(one, other)| one.meets(other))
        };
        if level == to {
            visit([one, other]);
            return;
        }
        let (below, [a, b]) = (level + 1, [2 * one, 2 * other]);
        let next = [[a, b], [a, b + 1], [a + 1, b + 1], [a + 1, b]];
        // A node against itself meets its halves in three ways, not four.
        let ways = if one == other { 3 } else { 4 };
        for meeting in next.into_iter().take(ways).filter(|[one, other]| meets(below, *one, *other)) {
            self.walk(below, meeting, to, visit);
        }
    }

    fn pairs_of(&self, [one, other]: Meeting, mesh: &TriangleMesh, pairs: &mut Vec<[u32; 2]>) {
        let within = |leaf: u32| {
            let first = leaf as usize * LEAF;
            first..(first + LEAF).min(self.order.len())
        };
        for k in within(one) {
            let first = if one == other { k + 1 } else { within(other).start };
            for l in (first..within(other).end).filter(|&l| self.boxes[k].meets(&self.boxes[l])) {
                let [a, b] = [self.order[k], self.order[l]];
                if !share_a_side(mesh.triangles[a as usize], mesh.triangles[b as usize]) {
                    pairs.push([a.min(b), a.max(b)]);
                }
            }
        }
    }
}

fn share_a_side(one: [u32; 3], other: [u32; 3]) -> bool {
    one.iter().filter(|v| other.contains(v)).count() >= 2
}

/// Place along a Morton curve of a point of the unit cube, 21 bits an axis.
fn morton(place: DVec3) -> u64 {
    let [x, y, z] = place.to_array().map(|x| spread((x * f64::from((1 << 21) - 1)) as u64));
    x | y << 1 | z << 2
}

/// Two zeros between each of the lowest 21 bits.
fn spread(mut bits: u64) -> u64 {
    bits &= 0x1f_ffff;
    for (shift, mask) in [
        (32, 0x001f_0000_0000_ffff),
        (16, 0x001f_0000_ff00_00ff),
        (8, 0x100f_00f0_0f00_f00f),
        (4, 0x10c3_0c30_c30c_30c3),
        (2, 0x1249_2492_4924_9249),
    ] {
        bits = (bits | bits << shift) & mask;
    }
    bits
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{ball, block, moved, octahedron, together};

    /// The same pairs as by comparing every triangle with every other.
    fn check(mesh: &TriangleMesh) {
        let spans: Vec<Span> = (0..mesh.triangles.len()).map(|t| Span::around(&mesh.corners(t))).collect();
        let mut expected = Vec::new();
        for (a, b) in (0..spans.len()).flat_map(|a| (a + 1..spans.len()).map(move |b| (a, b))) {
            if spans[a].meets(&spans[b]) && !share_a_side(mesh.triangles[a], mesh.triangles[b]) {
                expected.push([a as u32, b as u32]);
            }
        }
        let mut found = near_pairs(mesh);
        found.sort_unstable();
        assert_eq!(found, expected);
    }

    #[test]
    fn every_pair_is_found_once() {
        check(&TriangleMesh::default());
        check(&octahedron(1.0));
        check(&TriangleMesh { triangles: octahedron(1.0).triangles[..1].to_vec(), ..octahedron(1.0) });
        check(&together(&[ball(10.0, 8), moved(ball(10.0, 8), [5.0, 3.0, 1.0])]));
        check(&together(&[
            block([0.0; 3], [100.0; 3]),
            ball(10.0, 9),
            moved(ball(1.0, 5), [99.0, 1.0, 2.0]),
        ]));
    }

    #[test]
    fn bits_are_spread() {
        assert_eq!(spread(0b111), 0b1_001_001);
        assert_eq!(morton(DVec3::ONE), (1 << 63) - 1);
    }
}
