//! Whether the body stands between two points: rays against its triangles through a tree of boxes.
//!
//! Independent of the rays that placed the markers. Triangles are split at the median of their centres along the widest
//! axis; intersection after Möller & Trumbore (1997), "Fast, Minimum Storage Ray/Triangle Intersection".

use fibar_core::artefact::mesh::TriangleMesh;
use glam::DVec3;

/// A body that hides what is behind it.
pub struct Occluder {
    corners: Vec<[DVec3; 3]>,
    nodes: Vec<Node>,
}

struct Node {
    low: DVec3,
    high: DVec3,
    /// Of a leaf its triangles; of a fork the two nodes below.
    content: Content,
}

enum Content {
    Leaf { first: usize, end: usize },
    Fork { right: usize },
}

const LEAF_TRIANGLES: usize = 4;

impl Occluder {
    /// A tree over the mesh's triangles.
    pub fn of(mesh: &TriangleMesh) -> Occluder {
        let mut corners: Vec<[DVec3; 3]> = (0..mesh.triangles.len()).map(|t| mesh.corners(t)).collect();
        let mut nodes = Vec::new();
        let count = corners.len();
        build(&mut nodes, &mut corners, 0..count);
        Occluder { corners, nodes }
    }

    /// Whether nothing lies strictly between two points.
    pub fn is_clear(&self, from: DVec3, to: DVec3) -> bool {
        self.first_hit(from, to, |_| true).is_none()
    }

    /// The nearest triangle on the way: its share of the way and its unit normal.
    pub fn nearest_hit(&self, from: DVec3, to: DVec3) -> Option<(f64, DVec3)> {
        let (share, triangle) = self.first_hit(from, to, |_| false)?;
        let [a, b, c] = self.corners[triangle];
        Some((share, (b - a).cross(c - a).normalize_or_zero()))
    }

    /// The nearest hit, or the first that is good enough.
    fn first_hit(&self, from: DVec3, to: DVec3, enough: impl Fn(f64) -> bool) -> Option<(f64, usize)> {
        let way = to - from;
        let inverse = way.recip();
        let mut best: Option<(f64, usize)> = None;
        let mut stack = vec![0];
        while let Some(index) = stack.pop() {
            let node = &self.nodes[index];
            let limit = best.map_or(1.0, |(share, _)| share);
            if !node.meets(from, inverse, limit) {
                continue;
            }
            let (first, end) = match node.content {
                Content::Fork { right } => {
                    stack.extend([right, index + 1]);
                    continue;
                }
                Content::Leaf { first, end } => (first, end),
            };
            for triangle in first..end {
                let Some(share) = intersect(&self.corners[triangle], from, way) else { continue };
                if best.is_none_or(|(least, _)| share < least) {
                    best = Some((share, triangle));
                }
                if enough(share) {
                    return best;
                }
            }
        }
        best
    }
}

impl Node {
    /// Slab test against the box, from share 0 to `limit` of the way.
    fn meets(&self, from: DVec3, inverse: DVec3, limit: f64) -> bool {
        let (a, b) = ((self.low - from) * inverse, (self.high - from) * inverse);
        // A way within a side's plane gives 0 · ∞: `min` and `max` pass over the NaN, which errs towards a hit.
        let enter = a.x.min(b.x).max(a.y.min(b.y)).max(a.z.min(b.z)).max(0.0);
        let leave = a.x.max(b.x).min(a.y.max(b.y)).min(a.z.max(b.z)).min(limit);
        enter <= leave * (1.0 + 1e-12) + 1e-12
    }
}

/// Appends the tree over a range of triangles, the root first, its left part right behind it.
fn build(nodes: &mut Vec<Node>, corners: &mut [[DVec3; 3]], range: std::ops::Range<usize>) {
    let index = nodes.len();
    let part = &mut corners[range.clone()];
    let bounds = |points: &mut dyn Iterator<Item = DVec3>| {
        points.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)))
    };
    let (low, high) = bounds(&mut part.iter().flatten().copied());
    nodes.push(Node { low, high, content: Content::Leaf { first: range.start, end: range.end } });
    if part.len() <= LEAF_TRIANGLES {
        return;
    }
    let centre = |[a, b, c]: &[DVec3; 3]| *a + *b + *c;
    let (low, high) = bounds(&mut part.iter().map(centre));
    let axis = (high - low).max_position();
    let half = part.len() / 2;
    part.select_nth_unstable_by(half, |a, b| centre(a)[axis].total_cmp(&centre(b)[axis]));
    let middle = range.start + half;
    build(nodes, corners, range.start..middle);
    nodes[index].content = Content::Fork { right: nodes.len() };
    build(nodes, corners, middle..range.end);
}

/// Share of the way at which it pierces a triangle.
fn intersect([a, b, c]: &[DVec3; 3], from: DVec3, way: DVec3) -> Option<f64> {
    let (ab, ac) = (*b - *a, *c - *a);
    let p = way.cross(ac);
    let determinant = ab.dot(p);
    let inverse = 1.0 / determinant;
    let arm = from - *a;
    let u = arm.dot(p) * inverse;
    let q = arm.cross(ab);
    let v = way.dot(q) * inverse;
    let share = ac.dot(q) * inverse;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && share > 0.0 && share < 1.0).then_some(share)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::pebble;
    use crate::views::Chance;

    #[test]
    fn the_tree_sees_what_every_triangle_sees() {
        let mesh = pebble(24);
        let occluder = Occluder::of(&mesh);
        let mut chance = Chance::new(1, 0);
        for _ in 0..3000 {
            let mut point = || DVec3::from_array(std::array::from_fn(|_| chance.within(-90.0, 90.0)));
            let (from, to) = (point(), point());
            let shares =
                (0..mesh.triangles.len()).filter_map(|t| intersect(&mesh.corners(t), from, to - from));
            let nearest = shares.min_by(f64::total_cmp);
            assert_eq!(occluder.nearest_hit(from, to).map(|hit| hit.0), nearest, "{from} {to}");
            assert_eq!(occluder.is_clear(from, to), nearest.is_none());
        }
    }

    #[test]
    fn an_empty_body_hides_nothing() {
        let occluder = Occluder::of(&TriangleMesh::default());
        assert!(occluder.is_clear(DVec3::X, DVec3::NEG_X));
    }
}
