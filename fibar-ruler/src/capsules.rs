//! A tree of capsules around a curve: every part of the curve lies within `slack` of the chord of its node.
//!
//! Searches descend only where the capsules leave room for something nearer than what is already known, so that their
//! answer is a bound that nothing on the exact curve can undercut, not the least of some samples.

use crate::bezier::Bezier;
use crate::bvh::Bvh;
use crate::contact::{Contact, Segment};
use crate::curve::Curve;
use glam::DVec3;

/// A curve enclosed in capsules, coarse ones holding finer ones.
#[derive(Clone, Debug)]
pub struct CapsuleTree {
    nodes: Vec<Capsule>,
}

/// A part of the curve: no point of it is further than `slack` mm from the chord between its ends, and no point of the
/// chord further than that from it.
#[derive(Clone, Debug)]
pub struct Capsule {
    /// Straight line between the ends of the part, mm.
    pub chord: Segment,
    /// Radius of the capsule, mm.
    pub slack: f64,
    children: Option<[usize; 2]>,
}

/// The halving stops here even if the slack asked for is not reached.
const DEEPEST: u32 = 40;

impl CapsuleTree {
    /// Encloses a curve, the finest capsules being at most `slack` mm wide in radius.
    pub fn enclose(curve: &Curve, slack: f64) -> CapsuleTree {
        let mut tree = CapsuleTree { nodes: Vec::new() };
        tree.add_run(&curve.pieces, slack);
        tree
    }

    /// The finest capsules, in order along the curve.
    pub fn leaves(&self) -> impl Iterator<Item = &Capsule> {
        self.nodes.iter().filter(|node| node.children.is_none())
    }

    /// The shortest bridge to another curve, if one may be shorter than `below`. `distance` is a lower bound for the exact
    /// curves; the exact distance exceeds it by at most twice the sum of both slacks.
    pub fn nearest(&self, other: &CapsuleTree, below: f64) -> Option<Contact> {
        let mut search = Search { below, best: None };
        self.descend(0, other, 0, &mut search);
        search.best
    }

    /// The shortest bridge to a mesh, if one may be shorter than `below`; a lower bound likewise, at most twice the slack
    /// under the exact distance.
    pub fn nearest_on_mesh(&self, mesh: &Bvh, below: f64) -> Option<Contact> {
        let measure = |chord: &Segment, below: f64| mesh.nearest(chord, below);
        self.nearest_by(&measure, below)
    }

    /// The same against anything that can measure a chord: `measure(chord, below)` gives the shortest bridge if one is
    /// shorter than `below`.
    pub fn nearest_by(
        &self,
        measure: &impl Fn(&Segment, f64) -> Option<Contact>,
        below: f64,
    ) -> Option<Contact> {
        let mut search = Search { below, best: None };
        self.descend_by(0, measure, &mut search);
        search.best
    }

    fn add_run(&mut self, pieces: &[Bezier], slack: f64) -> usize {
        if let [piece] = pieces {
            return self.add_piece(piece, slack, DEEPEST);
        }
        let node = self.add(pieces);
        let (left, right) = pieces.split_at(pieces.len() / 2);
        let children = [self.add_run(left, slack), self.add_run(right, slack)];
        self.nodes[node].children = Some(children);
        node
    }

    fn add_piece(&mut self, piece: &Bezier, slack: f64, depth: u32) -> usize {
        let node = self.add(std::slice::from_ref(piece));
        if self.nodes[node].slack > slack && depth > 0 {
            let (left, right) = piece.split(0.5);
            let children =
                [self.add_piece(&left, slack, depth - 1), self.add_piece(&right, slack, depth - 1)];
            self.nodes[node].children = Some(children);
        }
        node
    }

    fn add(&mut self, pieces: &[Bezier]) -> usize {
        let chord = Segment(pieces[0].start(), pieces[pieces.len() - 1].end());
        let points = pieces.iter().flat_map(Bezier::control_points);
        let slack = points.map(|p| Segment(p, p).to_segment(&chord).distance).fold(0.0, f64::max);
        self.nodes.push(Capsule { chord, slack, children: None });
        self.nodes.len() - 1
    }

    fn descend(&self, here: usize, other: &CapsuleTree, there: usize, search: &mut Search) {
        let (a, b) = (&self.nodes[here], &other.nodes[there]);
        let contact = a.chord.to_segment(&b.chord);
        let bound = contact.distance - a.slack - b.slack;
        if bound >= search.below {
            return;
        }
        let pairs = match (a.children, b.children) {
            (None, None) => return search.found(contact, bound),
            (Some(halves), Some(_)) if a.slack >= b.slack => halves.map(|h| (h, there)),
            (Some(halves), None) => halves.map(|h| (h, there)),
            (_, Some(halves)) => halves.map(|h| (here, h)),
        };
        let ahead = |(h, t): (usize, usize)| {
            let (a, b) = (&self.nodes[h], &other.nodes[t]);
            a.chord.to_segment(&b.chord).distance - a.slack - b.slack
        };
        let [first, second] = if ahead(pairs[1]) < ahead(pairs[0]) { [pairs[1], pairs[0]] } else { pairs };
        self.descend(first.0, other, first.1, search);
        self.descend(second.0, other, second.1, search);
    }

    fn descend_by(
        &self,
        here: usize,
        measure: &impl Fn(&Segment, f64) -> Option<Contact>,
        search: &mut Search,
    ) {
        let node = &self.nodes[here];
        let Some(contact) = measure(&node.chord, search.below + node.slack) else { return };
        match node.children {
            None => search.found(contact, contact.distance - node.slack),
            Some(halves) => halves.into_iter().for_each(|half| self.descend_by(half, measure, search)),
        }
    }
}

/// The best so far.
struct Search {
    below: f64,
    best: Option<Contact>,
}

impl Search {
    fn found(&mut self, contact: Contact, bound: f64) {
        if bound < self.below {
            self.below = bound;
            self.best = Some(Contact { distance: bound, ..contact });
        }
    }
}

impl Capsule {
    /// Middle of the chord, mm.
    pub fn middle(&self) -> DVec3 {
        self.chord.0.midpoint(self.chord.1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::RngExt;
    use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};

    const SLACK: f64 = 1e-4;

    fn curve(points: &[DVec3]) -> Curve {
        Curve { pieces: vec![Bezier::polynomial(points)] }
    }

    fn random_curve(rng: &mut ChaCha8Rng) -> Curve {
        let mut point = || DVec3::new(rng.random_range(0.0..50.0), rng.random_range(0.0..50.0), rng.random());
        curve(&[point(), point(), point(), point()])
    }

    #[test]
    fn no_sample_undercuts_the_bound_and_the_bound_is_tight() {
        let mut rng = ChaCha8Rng::seed_from_u64(11);
        for _ in 0..40 {
            let (a, b) = (random_curve(&mut rng), random_curve(&mut rng));
            let [one, other] = [&a, &b].map(|c| CapsuleTree::enclose(c, SLACK));
            let found = one.nearest(&other, f64::INFINITY).unwrap();
            let samples = |c: &Curve| -> Vec<DVec3> {
                (0..=300).map(|k| c.pieces[0].point(f64::from(k) / 300.0)).collect()
            };
            let (p, q) = (samples(&a), samples(&b));
            let least = p.iter().flat_map(|p| q.iter().map(|q| p.distance(*q))).fold(f64::INFINITY, f64::min);
            assert!(found.distance <= least, "{} is undercut by {least}", found.distance);
            assert!(found.near.distance(found.far) - found.distance <= 2.0 * SLACK + 1e-12);
            assert_eq!(one.nearest(&other, found.distance), None, "nothing is shorter than the shortest");
        }
    }

    #[test]
    fn parallel_arcs_keep_their_distance() {
        let arc = |r: f64| {
            let corner = DVec3::new(r, r, 0.0).extend(1.0) * std::f64::consts::FRAC_1_SQRT_2;
            let ends = [DVec3::X * r, DVec3::Y * r].map(|p| p.extend(1.0));
            Curve { pieces: vec![Bezier { homogeneous: vec![ends[0], corner, ends[1]] }] }
        };
        let [inner, outer] = [30.0, 33.75].map(|r| CapsuleTree::enclose(&arc(r), SLACK));
        let found = inner.nearest(&outer, f64::INFINITY).unwrap();
        assert!((3.75 - 4.0 * SLACK..=3.75).contains(&found.distance), "{found:?}");
    }

    #[test]
    fn a_doubled_back_curve_is_enclosed() {
        let hairpin = curve(&[DVec3::ZERO, DVec3::X * 40.0, DVec3::X * 40.0, DVec3::Y * 1e-6]);
        let tree = CapsuleTree::enclose(&hairpin, SLACK);
        let far = curve(&[DVec3::X * 35.0, DVec3::X * 36.0]);
        let found = tree.nearest(&CapsuleTree::enclose(&far, SLACK), f64::INFINITY).unwrap();
        let tip = (0..=1000).map(|k| hairpin.pieces[0].point(f64::from(k) / 1000.0).x).fold(0.0, f64::max);
        assert!((found.distance - (35.0 - tip)).abs() < 1e-3, "{found:?}, tip at {tip}");
    }
}
