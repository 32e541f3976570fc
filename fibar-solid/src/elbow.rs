//! Elbows: what fills the gap between the flat ends of two straight tubes that meet at a joint under any turn.
//!
//! ```text
//! b     axis of the turn θ, through the joint       t, ρ   coordinates of a cross-section along b and outwards
//! ```
//!
//! On the outer side of the turn the cross-section is turned about `b` from the one end to the other, in steps of `Δ`,
//! and touched from outside: the rings half-way between the steps are stretched outwards by 1/cos(Δ/2). So each facet is
//! as far from the joint as the side of the cross-section it comes from. On the inner side the tubes overlap, and nothing
//! is missing.
//!
//! A turn of nearly 180° would leave the elbow concave; it gets a polyhedral ball around
//! the cross-section's corners instead, under which the walls hold as well.

use crate::SolidError;
use crate::ball::ball_corners;
use crate::polyline::angle;
use glam::DVec3;

/// Turn from which on a ball takes the elbow's place, rad.
const HAIRPIN: f64 = 2.6;

/// How far an elbow reaches into its tubes, as a share of their radius.
const SINK: f64 = 0.005;

/// Two flat ends of the same cross-section at one joint.
pub struct Elbow {
    /// Where the axes meet.
    pub joint: DVec3,
    /// Direction of the tube that ends.
    pub before: DVec3,
    /// Direction of the tube that starts.
    pub after: DVec3,
    /// Corners of the end, as seen from the joint.
    pub end: Vec<DVec3>,
    /// The same corners, carried over by the least rotation.
    pub start: Vec<DVec3>,
    /// Greatest step Δ, rad.
    pub max_turn: f64,
}

/// Corners of a convex solid that fills the elbow; `circumradius` is that of the cross-section.
pub fn elbow_corners(
    elbow: &Elbow,
    circumradius: f64,
    ball_frequency: usize,
) -> Result<Vec<DVec3>, SolidError> {
    let turn = angle(elbow.before, elbow.after);
    if turn > HAIRPIN {
        let ball = ball_corners(ball_frequency)?;
        return Ok(ball.into_iter().map(|corner| elbow.joint + corner * circumradius).collect());
    }
    let about =
        elbow.before.cross(elbow.after).try_normalize().unwrap_or(elbow.before.any_orthonormal_vector());
    let outwards = elbow.before.cross(about).normalize();
    let section = outer_half(&elbow.end, about, outwards);
    let mut corners = shared_corners(elbow, outwards);
    let steps = (turn / elbow.max_turn).ceil().max(1.0) as usize;
    let step = turn / steps as f64;
    for k in 0..steps {
        let (sine, cosine) = libm::sincos((k as f64 + 0.5) * step);
        let ray = (outwards * cosine + elbow.before * sine) / libm::cos(0.5 * step);
        corners.extend(section.iter().map(|&(t, rho)| elbow.joint + about * t + ray * rho));
    }
    Ok(corners)
}

/// The outer corners of both ends, to the bit where the tubes have them, and the same sunk into the tubes: solids that only
/// touch need not merge.
fn shared_corners(elbow: &Elbow, outwards: DVec3) -> Vec<DVec3> {
    let Elbow { joint, before, after, .. } = *elbow;
    let outer = elbow.end.iter().zip(&elbow.start).filter(|(end, _)| end.dot(outwards) > 0.0);
    let sunk = |corner: DVec3, into: DVec3| joint + corner * (1.0 - SINK) + into * (SINK * corner.length());
    outer
        .flat_map(|(&end, &start)| [joint + end, joint + start, sunk(end, -before), sunk(start, after)])
        .collect()
}

/// The part of a cross-section with ρ ≥ 0, as (t, ρ).
fn outer_half(section: &[DVec3], about: DVec3, outwards: DVec3) -> Vec<(f64, f64)> {
    let flat: Vec<(f64, f64)> =
        section.iter().map(|corner| (corner.dot(about), corner.dot(outwards))).collect();
    let mut half = Vec::new();
    for (k, &(t, rho)) in flat.iter().enumerate() {
        let (next_t, next_rho) = flat[(k + 1) % flat.len()];
        if rho > 0.0 {
            half.push((t, rho));
        }
        if (rho > 0.0) != (next_rho > 0.0) {
            half.push((t + (next_t - t) * rho / (rho - next_rho), 0.0));
        }
    }
    half
}
