//! The holes that take the LEDs, and the cavities beside them.

use fibar_core::artefact::sockets::{Cavity, Hole, Section, Socket, Sockets};
use fibar_solid::{Solid, SolidError};
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// How far a hole is cut beyond the base, mm, so that nothing thin stays in its mouth.
const BEYOND_BASE_MM: f64 = 1.0;

/// All holes and cavities, from the LEDs' tips and the ceilings back through the base.
pub fn holes(sockets: &Sockets, chord_error: f64) -> Result<Solid, SolidError> {
    let holes: Vec<Solid> = sockets
        .sockets
        .iter()
        .map(|socket| hole(socket, sockets.hole, chord_error))
        .chain(sockets.cavities.iter().map(|cavity| hollow(cavity, chord_error)))
        .collect::<Result<_, _>>()?;
    Solid::union(&holes)
}

/// A prism around the round hole: an LED of the hole's diameter fits.
fn hole(socket: &Socket, hole: Hole, chord_error: f64) -> Result<Solid, SolidError> {
    let (across, up) = socket.axis.any_orthonormal_pair();
    let rim: Vec<DVec3> = rim(hole.diameter_mm / 2.0, chord_error)
        .map(|[u, v]| socket.position + across * u + up * v)
        .collect();
    prism(&rim, -socket.axis * (hole.depth_mm + BEYOND_BASE_MM))
}

/// The cavity itself, or a prism around it if it is round.
fn hollow(cavity: &Cavity, chord_error: f64) -> Result<Solid, SolidError> {
    let up = cavity.axis.cross(cavity.across);
    let place = |[u, v]: [f64; 2]| cavity.position + cavity.across * u + up * v;
    let rim: Vec<DVec3> = match cavity.section {
        Section::Circle { diameter_mm } => rim(diameter_mm / 2.0, chord_error).map(place).collect(),
        Section::Rectangle { width_mm: w, length_mm: l } => {
            [[-w, -l], [w, -l], [w, l], [-w, l]].map(|[u, v]| place([u / 2.0, v / 2.0])).to_vec()
        }
    };
    prism(&rim, -cavity.axis * (cavity.depth_mm + BEYOND_BASE_MM))
}

/// Corners around a circle, no further off it than the chord error.
fn rim(radius: f64, chord_error: f64) -> impl Iterator<Item = [f64; 2]> {
    let sides = (PI / libm::acos(radius / (radius + chord_error))).ceil().clamp(12.0, 256.0) as usize;
    let circumradius = radius / libm::cos(PI / sides as f64);
    (0..sides).map(move |k| {
        let (sine, cosine) = libm::sincos(TAU * k as f64 / sides as f64);
        [cosine * circumradius, sine * circumradius]
    })
}

/// Between a convex outline and its copy.
fn prism(outline: &[DVec3], to_copy: DVec3) -> Result<Solid, SolidError> {
    let corners: Vec<DVec3> = outline.iter().flat_map(|corner| [*corner, *corner + to_copy]).collect();
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

    #[test]
    fn a_cavity_ends_at_its_ceiling() {
        let check = |section: Section, area: f64| {
            let cavity = Cavity {
                name: "board".into(),
                position: DVec3::new(3.0, -2.0, 8.0),
                axis: DVec3::Z,
                across: DVec3::Y,
                section,
                depth_mm: 8.0,
            };
            let solid = hollow(&cavity, 0.02).unwrap();
            let (low, high) = solid.bounds().unwrap();
            assert!((low.z + 1.0).abs() < 1e-12 && (high.z - 8.0).abs() < 1e-12);
            assert!((solid.volume() / (9.0 * area) - 1.0).abs() < 5e-3, "{solid:?}");
        };
        check(Section::Rectangle { width_mm: 20.0, length_mm: 30.0 }, 600.0);
        check(Section::Circle { diameter_mm: 20.0 }, PI * 100.0);
    }
}
