//! The four moves of a control point (Tone 2020, eq. for the heuristic and the authors' formulas in its LaTeX source).
//!
//! ```text
//! l = Σ± (|x± − x| − L)·(x± − x)/|x± − x|         shorter, and evenly so
//! r = L²·Σ± (x − c±)/|x − c±|²                    rounder
//! f = Σ (x − y)/|x − y|  over |x − y| < threshold  away from other patterns' control points y
//! s = −(p − x)/|p − x|   if   |p − x| < threshold  away from the closest surface point p
//! ```
//! `x±` are the neighbours on the chain, `c±` the centres of the circles *of the neighbours*, `L` the sectional shortest
//! length. Since x lies on both circles, r is L² times their curvatures, outwards.

use glam::DVec3;

/// Moves along one chain.
pub struct Chain<'a> {
    points: &'a [DVec3],
    /// The sectional shortest length `L`, mm.
    section: f64,
    /// Centres of the circles of the inner points, from the second on; `None` where the chain is straight.
    centres: Vec<Option<DVec3>>,
}

impl<'a> Chain<'a> {
    /// Prepares a chain of five points or more.
    pub fn of(points: &'a [DVec3]) -> Chain<'a> {
        let (second, before_last) = (points[1], points[points.len() - 2]);
        let section = second.distance(before_last) / (points.len() - 3) as f64;
        Chain {
            points,
            section,
            centres: points.windows(3).map(|w| circumcentre([w[0], w[1], w[2]])).collect(),
        }
    }

    /// `l` of an inner point, mm.
    pub fn shorten(&self, k: usize) -> DVec3 {
        let towards = |other: DVec3| {
            let leg = other - self.points[k];
            (leg.length() - self.section) * leg.normalize_or_zero()
        };
        towards(self.points[k - 1]) + towards(self.points[k + 1])
    }

    /// `r` of an inner point that is not next to an end, mm.
    pub fn round(&self, k: usize) -> DVec3 {
        let away = |centre: Option<DVec3>| {
            let arm = centre.map_or(DVec3::ZERO, |c| self.points[k] - c);
            arm / arm.length_squared().max(f64::MIN_POSITIVE)
        };
        self.section * self.section * (away(self.centres[k - 2]) + away(self.centres[k]))
    }
}

/// `f`: the sum of unit vectors from those of `others` that are closer than `threshold` mm.
pub fn part(point: DVec3, others: impl Iterator<Item = DVec3>, threshold: f64) -> DVec3 {
    let close = others.map(|other| point - other).filter(|v| v.length_squared() < threshold * threshold);
    close.fold(DVec3::ZERO, |sum, v| sum + v.normalize_or_zero())
}

/// `s`: one step inwards where the surface is closer than `threshold` mm.
pub fn leave_surface((depth, inwards): (f64, DVec3), threshold: f64) -> DVec3 {
    if depth < threshold { inwards } else { DVec3::ZERO }
}

/// Centre of the circle through three points, `None` when they are on a line to rounding.
fn circumcentre([a, b, c]: [DVec3; 3]) -> Option<DVec3> {
    const STRAIGHT: f64 = 1e-24;
    let (u, v) = (a - b, c - b);
    let cross = u.cross(v);
    let (uu, vv) = (u.length_squared(), v.length_squared());
    let straight = cross.length_squared() <= STRAIGHT * uu * vv;
    (!straight).then(|| b + (uu * v - vv * u).cross(cross) / (2.0 * cross.length_squared()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn arc(radius: f64, step: f64) -> Vec<DVec3> {
        (0..9).map(|k| f64::from(k) * step).map(|t| radius * DVec3::new(t.cos(), t.sin(), 0.0)).collect()
    }

    #[test]
    fn three_points_have_their_circle() {
        let centre = DVec3::new(3.0, -2.0, 7.0);
        let at = |t: f64| centre + 5.0 * DVec3::new(t.cos(), 0.6 * t.sin(), 0.8 * t.sin());
        assert!(circumcentre([at(0.1), at(0.9), at(2.5)]).unwrap().distance(centre) < 1e-12);
        assert_eq!(circumcentre([DVec3::ZERO, DVec3::X, DVec3::X * 3.0]), None);
        assert_eq!(circumcentre([DVec3::ZERO, DVec3::X, DVec3::X]), None);
    }

    #[test]
    fn on_an_arc_l_pulls_in_and_r_pushes_out() {
        let points = arc(20.0, 0.3);
        let chain = Chain::of(&points);
        let outwards = points[4] / 20.0;
        let leg = points[0].distance(points[1]);
        let (l, r) = (chain.shorten(4), chain.round(4));
        assert!((l + outwards * (leg - chain.section) * leg / 20.0).length() < 1e-12, "{l}");
        assert!((r - outwards * 2.0 * chain.section.powi(2) / 20.0).length() < 1e-12, "{r}");
    }

    #[test]
    fn a_straight_even_chain_rests() {
        let points: Vec<DVec3> = [0.0, 2.5, 4.5, 6.5, 8.5, 11.0].map(|z| DVec3::Z * z).to_vec();
        let chain = Chain::of(&points);
        for k in 2..4 {
            assert!((chain.shorten(k) + chain.round(k)).length() < 1e-12);
        }
    }

    #[test]
    fn f_counts_the_close_and_s_the_shallow() {
        let others = [DVec3::X, DVec3::X * 3.0, DVec3::Y * 2.9].into_iter();
        assert!((part(DVec3::ZERO, others, 3.0) + DVec3::X + DVec3::Y).length() < 1e-12);
        assert_eq!(part(DVec3::X, std::iter::once(DVec3::X), 3.0), DVec3::ZERO);
        assert_eq!(leave_surface((2.9, DVec3::Z), 3.0), DVec3::Z);
        assert_eq!(leave_surface((3.1, DVec3::Z), 3.0), DVec3::ZERO);
    }
}
