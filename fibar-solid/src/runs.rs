//! Where a tube about a polyline must be cut to stay a valid solid.

use crate::polyline::angle;
use glam::DVec3;
use std::f64::consts::PI;
use std::ops::Range;

/// Segments that one mitred tube each can follow, in order. `reach` is the circumradius of the tube, mm.
///
/// Joints at which a mitre is impossible, or that turn by more than `max_turn`, end a run, and so does a polyline that
/// comes back to itself.
pub fn cut_into_runs(points: &[DVec3], reach: f64, max_turn: f64) -> Vec<Range<usize>> {
    let inner = points.windows(3).map(|p| angle(p[1] - p[0], p[2] - p[1]));
    let turns: Vec<f64> = std::iter::once(0.0).chain(inner).chain([0.0]).collect();
    let slack: Vec<f64> = turns.iter().map(|turn| reach * libm::tan(0.5 * turn)).collect();
    let mut is_cut: Vec<bool> = turns.iter().map(|&turn| turn > max_turn).collect();
    (is_cut[0], is_cut[points.len() - 1]) = (true, true);
    cut_tight_joints(points, &slack, &mut is_cut);
    cut_near_returns(points, reach, &mut is_cut);
    let cuts: Vec<usize> = (0..points.len()).filter(|&joint| is_cut[joint]).collect();
    cuts.windows(2).map(|cut| cut[0]..cut[1]).collect()
}

/// Cuts until every segment is longer than what the mitres at its ends take off it, `slack` each.
fn cut_tight_joints(points: &[DVec3], slack: &[f64], is_cut: &mut [bool]) {
    let taken = |joint: usize, is_cut: &[bool]| if is_cut[joint] { 0.0 } else { slack[joint] };
    for segment in 0..points.len() - 1 {
        let length = 0.95 * points[segment].distance(points[segment + 1]);
        if taken(segment, is_cut) + taken(segment + 1, is_cut) > length {
            is_cut[segment + 1] = true;
        }
        if taken(segment, is_cut) > length {
            is_cut[segment] = true;
        }
    }
}

/// Cuts between segments of a run that are nearer than two radii, but further apart along the axis than a half circle.
fn cut_near_returns(points: &[DVec3], reach: f64, is_cut: &mut [bool]) {
    let mut stations = vec![0.0];
    points.windows(2).for_each(|p| stations.push(stations[stations.len() - 1] + p[0].distance(p[1])));
    let mut run_start = 0;
    for segment in 0..points.len() - 1 {
        if is_cut[segment] {
            run_start = segment;
        }
        let returns = |earlier: &usize| {
            let far_along = stations[segment] - stations[earlier + 1] > PI * reach;
            far_along && segment_distance(points, *earlier, segment) < 2.02 * reach
        };
        if let Some(earlier) = (run_start..segment).rev().find(returns) {
            run_start = (earlier + 1 + segment).div_ceil(2);
            is_cut[run_start] = true;
        }
    }
}

/// Least distance between two segments of a polyline, mm.
fn segment_distance(points: &[DVec3], one: usize, other: usize) -> f64 {
    let (p, u) = (points[one], points[one + 1] - points[one]);
    let (q, v) = (points[other], points[other + 1] - points[other]);
    let w = p - q;
    let (uu, uv, vv, uw, vw) = (u.dot(u), u.dot(v), v.dot(v), u.dot(w), v.dot(w));
    let determinant = uu * vv - uv * uv;
    let s =
        if determinant > 1e-12 * uu * vv { ((uv * vw - vv * uw) / determinant).clamp(0.0, 1.0) } else { 0.0 };
    let t = ((uv * s + vw) / vv).clamp(0.0, 1.0);
    let s = ((uv * t - uw) / uu).clamp(0.0, 1.0);
    (p + u * s).distance(q + v * t)
}
