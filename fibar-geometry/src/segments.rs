//! Where two straight segments come closest (Ericson, *Real-Time Collision Detection*, 2005, section 5.1.9).

use glam::DVec3;

/// The closest approach of two segments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Approach {
    /// Where on the first segment, 0 to 1.
    pub s: f64,
    /// Where on the second segment, 0 to 1.
    pub t: f64,
    /// From the place on the second to that on the first, mm.
    pub arm: DVec3,
}

/// The closest approach of the segments `p` and `q`, which may be points.
pub fn approach(p: [DVec3; 2], q: [DVec3; 2]) -> Approach {
    const POINT: f64 = 1e-18; // mm²
    let (u, v, w) = (p[1] - p[0], q[1] - q[0], p[0] - q[0]);
    let (a, e, b) = (u.length_squared(), v.length_squared(), u.dot(v));
    let (c, f) = (u.dot(w), v.dot(w));
    let share = |top: f64, bottom: f64| if bottom > POINT { (top / bottom).clamp(0.0, 1.0) } else { 0.0 };
    let mut s = share(b * f - c * e, a * e - b * b);
    let mut t = if e > POINT { (b * s + f) / e } else { 0.0 };
    if !(0.0..=1.0).contains(&t) {
        t = t.clamp(0.0, 1.0);
        s = share(b * t - c, a);
    } else if e <= POINT {
        s = share(-c, a);
    }
    Approach { s, t, arm: p[0] + s * u - (q[0] + t * v) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(p: [[f64; 3]; 2], q: [[f64; 3]; 2], distance: f64) {
        let (p, q) = (p.map(DVec3::from), q.map(DVec3::from));
        for (p, q) in [(p, q), (q, p), ([p[1], p[0]], q), (p, [q[1], q[0]])] {
            let found = approach(p, q);
            assert!((found.arm.length() - distance).abs() < 1e-12, "{found:?} is not {distance}");
            let arm = p[0].lerp(p[1], found.s) - q[0].lerp(q[1], found.t);
            assert!((arm - found.arm).length() < 1e-12, "{found:?}");
        }
    }

    #[test]
    fn segments_in_all_positions() {
        let x = [[0.0, 0.0, 0.0], [10.0, 0.0, 0.0]];
        check(x, [[5.0, -5.0, 3.0], [5.0, 5.0, 3.0]], 3.0); // crossing above
        check(x, [[2.0, 4.0, 0.0], [8.0, 4.0, 0.0]], 4.0); // side by side
        check(x, [[12.0, 1.0, 0.0], [20.0, 1.0, 0.0]], 5f64.sqrt()); // one behind the other
        check(x, [[13.0, 4.0, 0.0], [13.0, 9.0, 0.0]], 5.0); // end to end
        check(x, [[4.0, 2.0, 0.0], [4.0, 9.0, 0.0]], 2.0); // end to middle
        check(x, [[4.0, 2.0, 0.0], [4.0, 2.0, 0.0]], 2.0); // a point
        check([[1.0, 1.0, 1.0]; 2], [[1.0, 1.0, 3.0]; 2], 2.0); // two points
    }

    #[test]
    fn no_sampled_pair_of_places_is_closer() {
        for case in 0..200 {
            let at = |k: usize| {
                let t = (case * 7 + k) as f64;
                DVec3::new(libm::sin(t * 1.7), libm::sin(t * 2.3 + 1.0), libm::sin(t * 3.1 + 2.0)) * 5.0
            };
            let (p, q) = ([at(0), at(1)], [at(2), at(3)]);
            let found = approach(p, q).arm.length();
            for n in 0..441 {
                let (s, t) = ((n % 21) as f64 / 20.0, (n / 21) as f64 / 20.0);
                let sampled = p[0].lerp(p[1], s).distance(q[0].lerp(q[1], t));
                assert!(found <= sampled + 1e-12, "case {case}: {found} > {sampled}");
            }
        }
    }
}
