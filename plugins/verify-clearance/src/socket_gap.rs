//! `clearance.socket`: from a fibre's outer surface to the hole of an LED that does not feed it; `clearance.cavity`: to the
//! compartments beside the LEDs.

use crate::judgement::{Judgement, Rule};
use crate::strand::Strand;
use fibar_core::artefact::sockets::{Cavity, Hole, Section, Socket, Sockets};
use fibar_core::artefact::verdict::Place;
use fibar_ruler::contact::{Contact, Segment};
use glam::DVec3;
use rayon::prelude::*;

/// Measures every fibre against every hole but its own.
pub fn judge(strands: &[Strand], sockets: &Sockets, at_least: f64) -> Option<Judgement> {
    let pairs: Vec<(&Strand, &Socket)> = strands
        .iter()
        .flat_map(|strand| sockets.sockets.iter().map(move |socket| (strand, socket)))
        .filter(|(strand, socket)| strand.led != socket.led)
        .collect();
    let places = pairs.par_iter().filter_map(|(strand, socket)| gap(strand, socket, &sockets.hole)).collect();
    let rule = Rule {
        name: "clearance.socket",
        metric: "clearance.min_socket_gap_mm",
        at_least,
        subject: "gap between a fibre's outer surface and the hole of another LED",
    };
    rule.judge(places)
}

/// Measures every fibre against every cavity, its own LED's beginnings included.
pub fn judge_cavities(strands: &[Strand], sockets: &Sockets, at_least: f64) -> Option<Judgement> {
    let pairs: Vec<(&Strand, &Cavity)> = strands
        .iter()
        .flat_map(|strand| sockets.cavities.iter().map(move |cavity| (strand, cavity)))
        .collect();
    let places = pairs.par_iter().filter_map(|(strand, cavity)| gap_to_cavity(strand, cavity)).collect();
    let rule = Rule {
        name: "clearance.cavity",
        metric: "clearance.min_cavity_gap_mm",
        at_least,
        subject: "gap between a fibre's outer surface and a cavity",
    };
    rule.judge(places)
}

fn gap(strand: &Strand, socket: &Socket, hole: &Hole) -> Option<Place> {
    let what = format!("fibre {} of LED {} and the hole of LED {}", strand.id, strand.led, socket.led);
    gap_to(strand, |point| distance_to_hole(point, socket, hole), what)
}

fn gap_to_cavity(strand: &Strand, cavity: &Cavity) -> Option<Place> {
    let what = format!("fibre {} of LED {} and the cavity \"{}\"", strand.id, strand.led, cavity.name);
    gap_to(strand, |point| distance_to_cavity(point, cavity), what)
}

/// From a fibre to something convex.
fn gap_to(strand: &Strand, distance: impl Fn(DVec3) -> f64, what: String) -> Option<Place> {
    let measure = |chord: &Segment, below: f64| {
        let contact = nearest_on_chord(chord, &distance);
        (contact.distance < below).then_some(contact)
    };
    let axis = strand.capsules.nearest_by(&measure, f64::INFINITY)?;
    Some(Place { position: axis.near, value: axis.distance - strand.radius, what })
}

/// The distance to a convex body is convex along a chord, so its least value is found by thirds.
fn nearest_on_chord(chord: &Segment, to_body: impl Fn(DVec3) -> f64) -> Contact {
    let (mut low, mut high) = (0.0, 1.0);
    let distance = |t: f64| to_body(chord.0.lerp(chord.1, t));
    for _ in 0..60 {
        let third = (high - low) / 3.0;
        let (first, second) = (low + third, high - third);
        if distance(first) <= distance(second) { high = second } else { low = first }
    }
    let near = chord.0.lerp(chord.1, 0.5 * (low + high));
    Contact { distance: distance(0.5 * (low + high)), near, far: near }
}

/// Distance to the cylinder from the LED's tip back through the base, mm; 0 inside.
fn distance_to_hole(point: DVec3, socket: &Socket, hole: &Hole) -> f64 {
    let from_tip = point - socket.position;
    let height = from_tip.dot(socket.axis);
    let beside = (from_tip - socket.axis * height).length() - 0.5 * hole.diameter_mm;
    let beyond = height.max(-height - hole.depth_mm);
    let (beside, beyond) = (beside.max(0.0), beyond.max(0.0));
    (beside * beside + beyond * beyond).sqrt()
}

/// Distance to the prism from its ceiling back through the base, mm; 0 inside.
fn distance_to_cavity(point: DVec3, cavity: &Cavity) -> f64 {
    let from_ceiling = point - cavity.position;
    let height = from_ceiling.dot(cavity.axis);
    let out_of_slab = |offset: f64, half: f64| (offset.abs() - half).max(0.0);
    let beyond = out_of_slab(height + 0.5 * cavity.depth_mm, 0.5 * cavity.depth_mm);
    let beside = match cavity.section {
        Section::Circle { diameter_mm } => {
            DVec3::X * ((from_ceiling - cavity.axis * height).length() - 0.5 * diameter_mm).max(0.0)
        }
        Section::Rectangle { width_mm, length_mm } => DVec3::new(
            out_of_slab(from_ceiling.dot(cavity.across), 0.5 * width_mm),
            out_of_slab(from_ceiling.dot(cavity.axis.cross(cavity.across)), 0.5 * length_mm),
            0.0,
        ),
    };
    beside.with_z(beyond).length()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::strand::tests::{socket, strand};

    #[track_caller]
    fn check(from: DVec3, to: DVec3, gap_mm: f64) {
        let hole = Hole { diameter_mm: 5.0, depth_mm: 8.0 };
        let found = gap(&strand(1, 2, vec![from, to]), &socket(1, DVec3::Z * 8.0), &hole).unwrap();
        assert!((found.value - gap_mm).abs() < 1e-9, "{found:?} instead of {gap_mm}");
    }

    #[test]
    fn fibres_beside_above_and_through_a_hole() {
        check(DVec3::new(10.0, -9.0, 4.0), DVec3::new(10.0, 9.0, 4.0), 7.5 - 1.875);
        check(DVec3::new(-9.0, 0.0, 11.0), DVec3::new(9.0, 0.0, 11.0), 3.0 - 1.875);
        check(DVec3::new(5.5, 0.0, 12.0), DVec3::new(5.5, 0.0, 20.0), 5.0 - 1.875);
        check(DVec3::new(-9.0, 0.0, 2.0), DVec3::new(9.0, 0.0, 12.0), -1.875);
    }

    #[test]
    fn fibres_beside_above_and_through_a_cavity() {
        let check = |section: Section, from: [f64; 3], to: [f64; 3], gap_mm: f64| {
            let cavity = Cavity {
                name: "board".into(),
                position: DVec3::Z * 6.0,
                axis: DVec3::Z,
                across: DVec3::X,
                section,
                depth_mm: 6.0,
            };
            let found = gap_to_cavity(&strand(1, 2, vec![from.into(), to.into()]), &cavity).unwrap();
            assert!((found.value - gap_mm).abs() < 1e-9, "{found:?} instead of {gap_mm}");
        };
        let board = Section::Rectangle { width_mm: 20.0, length_mm: 30.0 };
        check(board, [14.0, -9.0, 4.0], [14.0, 9.0, 4.0], 4.0 - 1.875);
        check(board, [-30.0, 0.0, 9.0], [30.0, 0.0, 9.0], 3.0 - 1.875);
        check(board, [13.0, 19.0, 4.0], [13.0, 19.0, 5.0], 5.0 - 1.875);
        check(board, [-30.0, 0.0, 2.0], [30.0, 0.0, 3.0], -1.875);
        check(Section::Circle { diameter_mm: 20.0 }, [13.0, 0.0, 0.0], [13.0, 0.0, 9.0], 3.0 - 1.875);
    }
}
