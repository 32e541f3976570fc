//! The holes that take the LEDs.

use fibar_core::artefact::sockets::{Hole, Socket, Sockets};
use fibar_solid::{Solid, SolidError};
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// How far a hole is cut beyond the base, mm, so that nothing thin stays in its mouth.
const BEYOND_BASE_MM: f64 = 1.0;

/// All holes, from the LEDs' tips back through the base.
pub fn holes(sockets: &Sockets, chord_error: f64) -> Result<Solid, SolidError> {
    let holes: Vec<Solid> = sockets
        .sockets
        .iter()
        .map(|socket| hole(socket, sockets.hole, chord_error))
        .collect::<Result<_, _>>()?;
    Solid::union(&holes)
}

/// A prism around the round hole: an LED of the hole's diameter fits.
fn hole(socket: &Socket, hole: Hole, chord_error: f64) -> Result<Solid, SolidError> {
    let radius = hole.diameter_mm / 2.0;
    let sides = (PI / libm::acos(radius / (radius + chord_error))).ceil().clamp(12.0, 256.0) as usize;
    let circumradius = radius / libm::cos(PI / sides as f64);
    let (across, up) = socket.axis.any_orthonormal_pair();
    let back = -socket.axis * (hole.depth_mm + BEYOND_BASE_MM);
    let rim = |k: usize| {
        let (sine, cosine) = libm::sincos(TAU * k as f64 / sides as f64);
        socket.position + (across * cosine + up * sine) * circumradius
    };
    let corners: Vec<DVec3> = (0..sides).map(rim).flat_map(|corner| [corner, corner + back]).collect();
    Solid::hull(&corners)
}

#[cfg(test)]
mod tests {
    use super::*;
    use fibar_core::id::{LedId, PatternId};

    #[test]
    fn a_hole_ends_at_the_tip_and_takes_the_led() {
        let hole = Hole { diameter_mm: 5.2, depth_mm: 8.0 };
        let socket = Socket {
            led: LedId(0),
            pattern: PatternId(1),
            position: DVec3::new(3.0, -2.0, 8.0),
            axis: DVec3::Z,
        };
        let solid = holes(&Sockets::new(hole, vec![socket]), 0.02).unwrap();
        let (low, high) = solid.bounds().unwrap();
        assert_eq!((low.z, high.z), (-1.0, 8.0));
        let round = PI * 2.6 * 2.6 * 9.0;
        assert!(solid.volume() > round && solid.volume() < round * 1.02);
    }
}
