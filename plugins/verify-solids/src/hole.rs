//! The part of a line inside an LED's hole.

use fibar_core::artefact::sockets::{Hole, Socket};
use glam::DVec3;

/// The stretch of the line through `point` along +X that lies inside the hole, from and to, as x.
pub fn stretch(point: DVec3, socket: &Socket, hole: &Hole) -> Option<(f64, f64)> {
    let from_tip = point - socket.position;
    let (rise, height) = (socket.axis.x, from_tip.dot(socket.axis));
    let within_depth = between(rise, height, -hole.depth_mm, 0.0)?;
    let across = DVec3::X - socket.axis * rise;
    let beside = from_tip - socket.axis * height;
    let within_radius = near(across, beside, 0.5 * hole.diameter_mm)?;
    let (from, to) = (within_depth.0.max(within_radius.0), within_depth.1.min(within_radius.1));
    (from < to).then_some((point.x + from, point.x + to))
}

/// Where `rise·t + start` lies between two bounds.
fn between(rise: f64, start: f64, low: f64, high: f64) -> Option<(f64, f64)> {
    if rise.abs() < 1e-12 {
        return (low < start && start < high).then_some((f64::NEG_INFINITY, f64::INFINITY));
    }
    let (a, b) = ((low - start) / rise, (high - start) / rise);
    Some((a.min(b), a.max(b)))
}

/// Where `across·t + beside` is shorter than the radius.
fn near(across: DVec3, beside: DVec3, radius: f64) -> Option<(f64, f64)> {
    let (a, b, c) = (across.length_squared(), across.dot(beside), beside.length_squared() - radius * radius);
    if a < 1e-24 {
        return (c < 0.0).then_some((f64::NEG_INFINITY, f64::INFINITY));
    }
    let discriminant = b * b - a * c;
    (discriminant > 0.0).then(|| ((-b - discriminant.sqrt()) / a, (-b + discriminant.sqrt()) / a))
}

#[cfg(test)]
mod tests {
    use super::*;
    use fibar_core::{LedId, PatternId};

    #[track_caller]
    fn check(axis: DVec3, y: f64, z: f64, expected: Option<(f64, f64)>) {
        let socket =
            Socket { led: LedId(0), pattern: PatternId(1), position: DVec3::new(1.0, 0.0, 8.0), axis };
        let hole = Hole { diameter_mm: 5.0, depth_mm: 8.0 };
        let found = stretch(DVec3::new(0.0, y, z), &socket, &hole);
        let close = |(a, b): (f64, f64), (c, d): (f64, f64)| (a - c).abs() < 1e-12 && (b - d).abs() < 1e-12;
        assert!(found.zip(expected).map_or(found == expected, |(a, b)| close(a, b)), "{found:?}");
    }

    #[test]
    fn lines_across_beside_and_along_a_hole() {
        check(DVec3::Z, 0.0, 4.0, Some((-1.5, 3.5)));
        check(DVec3::Z, 1.5, 4.0, Some((-1.0, 3.0)));
        check(DVec3::Z, 0.0, 8.5, None);
        check(DVec3::Z, 2.5, 4.0, None);
        check(DVec3::X, 0.0, 9.0, Some((-7.0, 1.0)));
        check(DVec3::X, 0.0, 11.0, None);
    }
}
