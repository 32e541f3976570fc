//! Which pixels a triangle covers.
//!
//! Of two triangles that share an edge exactly one owns each pixel on it, so that a closed mesh is crossed an even number of
//! times along every pixel's ray.

use glam::{DVec2, DVec3};

/// A pixel of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fragment {
    /// Number of the pixel, row by row.
    pub pixel: usize,
    /// Depth in its middle, mm.
    pub depth: f64,
    /// Shares of the three corners in its middle; they add up to 1.
    pub shares: [f64; 3],
}

/// Calls `mark` for every pixel of a square picture whose middle a triangle covers. Corners: x and y in px, depth in mm.
pub fn fill([a, b, c]: [DVec3; 3], side: usize, mut mark: impl FnMut(Fragment)) {
    let (p, q, r) = (a.truncate(), b.truncate(), c.truncate());
    let area = (q - p).perp_dot(r - p);
    let (low, high) = (p.min(q).min(r), p.max(q).max(r));
    if area == 0.0 || high.min_element() < 0.5 || low.max_element() > side as f64 {
        return;
    }
    let range = |low: f64, high: f64| {
        (low - 0.5).ceil().max(0.0) as usize..=(high - 0.5).floor().min(side as f64 - 1.0) as usize
    };
    for y in range(low.y, high.y) {
        for x in range(low.x, high.x) {
            let at = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
            if covers(p, q, at, area) && covers(q, r, at, area) && covers(r, p, at, area) {
                let (v, w) = ((at - p).perp_dot(r - p) / area, (q - p).perp_dot(at - p) / area);
                let depth = a.z + v * (b.z - a.z) + w * (c.z - a.z);
                mark(Fragment { pixel: y * side + x, depth, shares: [1.0 - v - w, v, w] });
            }
        }
    }
}

/// Whether a point lies on the inner side of an edge.
fn covers(from: DVec2, to: DVec2, at: DVec2, area: f64) -> bool {
    // Both triangles compute with the edge's ends in the same order, so that rounding cannot tell them apart.
    let forward = (from.x, from.y) <= (to.x, to.y);
    let (low, high) = if forward { (from, to) } else { (to, from) };
    let left = (high - low).perp_dot(at - low) >= 0.0;
    left == (forward == (area > 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every pixel of a fan of triangles around a point is covered exactly once.
    fn check(middle: [f64; 2], rim: &[[f64; 2]]) {
        let mut count = vec![0; 100 * 100];
        for k in 0..rim.len() {
            let corners = [middle, rim[k], rim[(k + 1) % rim.len()]].map(|p| DVec2::from(p).extend(0.0));
            fill(corners, 100, |fragment| count[fragment.pixel] += 1);
        }
        assert!(count.iter().all(|&times| times == 1), "{middle:?}: a pixel missed or covered twice");
    }

    #[test]
    fn shared_edges_have_one_owner() {
        let square = [[-10.0, -10.0], [110.0, -10.0], [110.0, 110.0], [-10.0, 110.0]];
        check([50.0, 50.0], &square);
        check([50.5, 50.5], &square);
        check([33.3, 71.7], &square);
    }
}
