//! Boxes around boxes around triangles: nearest triangle to a point, segment or triangle.

use crate::contact::{Contact, Probe, Triangle};
use glam::DVec3;

/// A tree of boxes over triangles; the same triangles in the same order give the same tree.
#[derive(Clone, Debug)]
pub struct Bvh {
    nodes: Vec<Node>,
    triangles: Vec<Triangle>,
    /// Where each of `triangles` stood in the list that was given.
    order: Vec<u32>,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    low: DVec3,
    high: DVec3,
    /// First of its triangles.
    from: u32,
    /// One past its last triangle.
    to: u32,
    /// Its second child; the first one follows the node itself. 0 for a leaf.
    second: u32,
}

/// A nearest triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The bridge to it.
    pub contact: Contact,
    /// Its place in the list that the tree was built from.
    pub triangle: u32,
}

const LEAF: usize = 4;

impl Bvh {
    /// A tree over triangles, halving by the median of centroids along the widest axis.
    pub fn of(triangles: &[Triangle]) -> Bvh {
        let mut order: Vec<u32> = (0..triangles.len() as u32).collect();
        let mut nodes = Vec::with_capacity(triangles.len());
        if !order.is_empty() {
            build(triangles, &mut order, 0, &mut nodes);
        }
        let triangles = order.iter().map(|&t| triangles[t as usize]).collect();
        Bvh { nodes, triangles, order }
    }

    /// The shortest bridge to any triangle, if it is shorter than `below`.
    pub fn nearest(&self, probe: &impl Probe, below: f64) -> Option<Contact> {
        self.nearest_hit(probe, below).map(|hit| hit.contact)
    }

    /// The same, with the triangle.
    pub fn nearest_hit(&self, probe: &impl Probe, below: f64) -> Option<Hit> {
        let (low, high) = probe.bounds();
        let gap_to = |n: usize| gap(low, high, self.nodes[n].low, self.nodes[n].high);
        let (mut below, mut best) = (below, None);
        let mut stack = Vec::with_capacity(64);
        if !self.nodes.is_empty() {
            stack.push((gap_to(0), 0));
        }
        while let Some((bound, here)) = stack.pop() {
            if bound >= below {
                continue;
            }
            let node = &self.nodes[here];
            if node.second == 0 {
                self.search_leaf(node, probe, &mut below, &mut best);
                continue;
            }
            let (first, second) = (here + 1, node.second as usize);
            let children = [(gap_to(first), first), (gap_to(second), second)];
            let nearer = usize::from(children[1].0 < children[0].0);
            stack.push(children[1 - nearer]);
            stack.push(children[nearer]);
        }
        best
    }

    /// Whether any triangle stands strictly between two points. A sight that grazes an edge may go either way.
    pub fn blocks(&self, from: DVec3, to: DVec3) -> bool {
        let mut stack = Vec::with_capacity(64);
        stack.extend((!self.nodes.is_empty()).then_some(0));
        while let Some(here) = stack.pop() {
            let node: &Node = &self.nodes[here];
            if !crosses_box(from, to, node.low, node.high) {
                continue;
            }
            if node.second == 0 {
                let leaf = &self.triangles[node.from as usize..node.to as usize];
                if leaf.iter().any(|triangle| crosses_triangle(from, to, triangle)) {
                    return true;
                }
            } else {
                stack.extend([node.second as usize, here + 1]);
            }
        }
        false
    }

    fn search_leaf(&self, node: &Node, probe: &impl Probe, below: &mut f64, best: &mut Option<Hit>) {
        for k in node.from as usize..node.to as usize {
            if probe.at_least(&self.triangles[k]) >= *below {
                continue;
            }
            let contact = probe.contact(&self.triangles[k]);
            if contact.distance < *below {
                *below = contact.distance;
                *best = Some(Hit { contact, triangle: self.order[k] });
            }
        }
    }
}

/// Whether a segment may meet a box: the separating axes of the box's sides and of their cross products with the segment.
fn crosses_box(from: DVec3, to: DVec3, low: DVec3, high: DVec3) -> bool {
    let (half, arm) = (0.5 * (high - low), 0.5 * (to - from));
    let middle = 0.5 * (from + to) - 0.5 * (low + high);
    let reach = arm.abs();
    if middle.abs().cmpgt(half + reach).any() {
        return false;
    }
    let (side, span) = (
        middle.cross(arm).abs(),
        DVec3::new(
            half.y * reach.z + half.z * reach.y,
            half.z * reach.x + half.x * reach.z,
            half.x * reach.y + half.y * reach.x,
        ),
    );
    !side.cmpgt(span * (1.0 + 1e-9) + 1e-9).any()
}

/// Whether the segment's ends lie on either side of the triangle's plane and the segment passes its three edges on one side:
/// signs of volumes of tetrahedra.
fn crosses_triangle(from: DVec3, to: DVec3, [a, b, c]: &Triangle) -> bool {
    let volume = |p: DVec3, q: DVec3, r: DVec3, s: DVec3| (q - p).cross(r - p).dot(s - p);
    if volume(*a, *b, *c, from) * volume(*a, *b, *c, to) >= 0.0 {
        return false;
    }
    let sides = [(a, b), (b, c), (c, a)].map(|(p, q)| volume(from, to, *p, *q));
    sides.iter().all(|s| *s >= 0.0) || sides.iter().all(|s| *s <= 0.0)
}

fn build(triangles: &[Triangle], order: &mut [u32], from: u32, nodes: &mut Vec<Node>) {
    let boxes = order.iter().map(|&t| triangles[t as usize].bounds());
    let (low, high) = boxes.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))).expect("a node holds a triangle");
    let here = nodes.len();
    nodes.push(Node { low, high, from, to: from + order.len() as u32, second: 0 });
    if order.len() <= LEAF {
        return;
    }
    let centre = |t: u32| triangles[t as usize].iter().sum::<DVec3>();
    let axis = widest_axis(order.iter().map(|&t| centre(t)));
    let middle = order.len() / 2;
    order
        .select_nth_unstable_by(middle, |&a, &b| centre(a)[axis].total_cmp(&centre(b)[axis]).then(a.cmp(&b)));
    let (left, right) = order.split_at_mut(middle);
    build(triangles, left, from, nodes);
    nodes[here].second = nodes.len() as u32;
    build(triangles, right, from + middle as u32, nodes);
}

fn widest_axis(points: impl Iterator<Item = DVec3>) -> usize {
    let empty = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (low, high) = points.fold(empty, |(low, high), p| (low.min(p), high.max(p)));
    (high - low).max_position()
}

/// Distance between two boxes, mm.
fn gap(low: DVec3, high: DVec3, other_low: DVec3, other_high: DVec3) -> f64 {
    (other_low - high).max(low - other_high).max(DVec3::ZERO).length()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::Segment;
    use rand::RngExt;
    use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};

    fn random_triangles(rng: &mut ChaCha8Rng, count: usize) -> Vec<Triangle> {
        let mut point = |size: f64| DVec3::from_array([0; 3].map(|_| rng.random_range(0.0..size)));
        let mut triangle = || {
            let corner = point(10.0);
            [corner, corner + point(1.0), corner + point(1.0)]
        };
        (0..count).map(|_| triangle()).collect()
    }

    #[test]
    fn sights_are_blocked_by_what_the_list_holds() {
        let mut rng = ChaCha8Rng::seed_from_u64(9);
        let triangles = random_triangles(&mut rng, 300);
        let tree = Bvh::of(&triangles);
        let mut blocked = 0;
        for _ in 0..2000 {
            let mut point = || DVec3::from_array([0; 3].map(|_| rng.random_range(-2.0..13.0)));
            let sight = Segment(point(), point());
            let meets = triangles.iter().any(|t| sight.contact(t).distance == 0.0);
            assert_eq!(tree.blocks(sight.0, sight.1), meets, "{sight:?}");
            blocked += usize::from(meets);
        }
        assert!((200..1800).contains(&blocked), "{blocked}");
        assert!(!Bvh::of(&[]).blocks(DVec3::ZERO, DVec3::X));
    }

    #[test]
    fn the_tree_finds_what_the_list_holds() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let triangles = random_triangles(&mut rng, 500);
        let tree = Bvh::of(&triangles);
        let check = |probe: &dyn Fn(&Triangle) -> Contact, found: Option<Hit>| {
            let least = triangles.iter().map(|t| probe(t).distance).fold(f64::INFINITY, f64::min);
            let hit = found.unwrap();
            assert_eq!(hit.contact.distance, least);
            assert_eq!(probe(&triangles[hit.triangle as usize]), hit.contact);
        };
        for probe in random_triangles(&mut rng, 200) {
            check(&|t| probe[0].contact(t), tree.nearest_hit(&probe[0], f64::INFINITY));
            let segment = Segment(probe[0], probe[1]);
            check(&|t| segment.contact(t), tree.nearest_hit(&segment, f64::INFINITY));
            check(&|t| probe.contact(t), tree.nearest_hit(&probe, f64::INFINITY));
        }
        assert_eq!(tree.nearest(&DVec3::splat(-5.0), 5.0), None);
        assert_eq!(Bvh::of(&[]).nearest(&DVec3::ZERO, f64::INFINITY), None);
    }
}
