//! How the fibres of one LED share its light.
//!
//! At the tip, each place of the beam is dealt among the mouths over it. Along the way, cores that overlap at the same distance
//! from the LED form one section: it mixes their light, holds no more per area than the calibration's core, and deals
//! it to its members by the area that each would have if every place were dealt among the cores over it. What a fibre
//! has at last, over what a centred core of the calibration takes, is its κ; it is seen from `d_cam·√κ`.

use crate::beam::Beam;
use crate::discs::{Disc, deal};
use fibar_core::artefact::sockets::Socket;
use fibar_core::material::LayerRadii;
use fibar_ruler::curve::Curve;
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// Distance between the places at which cores are compared, mm.
const STATION_MM: f64 = 0.2;

/// One fibre of an LED.
pub struct Member {
    places: Vec<DVec3>,
    core_radius: f64,
    power: f64,
}

impl Member {
    /// The fibre with its axis as far as light is concerned.
    pub fn of(curve: &Curve, core_radius: f64) -> Member {
        Member { places: curve.stations(STATION_MM), core_radius, power: 0.0 }
    }
}

/// κ of every fibre of one LED.
pub fn couplings(beam: &Beam, socket: &Socket, mut members: Vec<Member>) -> Vec<f64> {
    enter(beam, socket, &mut members);
    let longest = members.iter().map(|m| m.places.len()).max().unwrap_or(0);
    for station in 1..longest {
        for section in sections(&members, station) {
            mix(&mut members, &section, station);
        }
    }
    members.iter().map(|member| member.power).collect()
}

/// Gives every member what its mouth takes of the beam.
fn enter(beam: &Beam, socket: &Socket, members: &mut [Member]) {
    let (across, up) = plane_of(socket.axis);
    let mouth = |m: &Member| {
        let arm = m.places[0] - socket.position;
        Disc { centre: DVec2::new(arm.dot(across), arm.dot(up)), radius: m.core_radius }
    };
    let mouths: Vec<Disc> = members.iter().map(mouth).collect();
    let centred = Disc { centre: DVec2::ZERO, radius: LayerRadii::TONE_2020.core };
    let light = |place: DVec2| beam.at(place.length());
    let calibrated = deal(&[centred], &light)[0];
    let taken = deal(&mouths, &light);
    members.iter_mut().zip(taken).for_each(|(member, light)| member.power = light / calibrated);
}

/// Lists of two and more members whose cores overlap at a station, one through the other.
fn sections(members: &[Member], station: usize) -> Vec<Vec<usize>> {
    let mut label: Vec<usize> = (0..members.len()).collect();
    for k in 0..members.len() {
        for j in 0..k {
            if overlap(&members[k], &members[j], station) {
                let (keep, drop) = (label[j].min(label[k]), label[j].max(label[k]));
                label.iter_mut().filter(|l| **l == drop).for_each(|l| *l = keep);
            }
        }
    }
    let with = |wanted: usize| (0..members.len()).filter(|&k| label[k] == wanted).collect::<Vec<usize>>();
    (0..members.len()).map(with).filter(|section| section.len() > 1).collect()
}

fn overlap(a: &Member, b: &Member, station: usize) -> bool {
    let places = a.places.get(station).zip(b.places.get(station));
    places.is_some_and(|(p, q)| p.distance(*q) < a.core_radius + b.core_radius)
}

fn mix(members: &mut [Member], section: &[usize], station: usize) {
    let step = |&k: &usize| members[k].places[station] - members[k].places[station - 1];
    let (across, up) = plane_of(section.iter().map(step).sum());
    let disc = |&k: &usize| {
        let place = members[k].places[station];
        Disc { centre: DVec2::new(place.dot(across), place.dot(up)), radius: members[k].core_radius }
    };
    let discs: Vec<Disc> = section.iter().map(disc).collect();
    let areas = deal(&discs, &|_| 1.0);
    let whole: f64 = areas.iter().sum();
    let calibrated_area = PI * LayerRadii::TONE_2020.core * LayerRadii::TONE_2020.core;
    let light: f64 = section.iter().map(|&k| members[k].power).sum();
    let held = light.min(whole / calibrated_area);
    section.iter().zip(areas).for_each(|(&k, area)| members[k].power = held * area / whole);
}

/// Two unit vectors square to a direction and to each other.
fn plane_of(direction: DVec3) -> (DVec3, DVec3) {
    let least = direction.abs().min_position();
    let across = direction.cross(DVec3::AXES[least]).normalize_or(DVec3::X);
    (across, direction.cross(across).normalize_or(DVec3::Y))
}

#[cfg(test)]
mod tests {
    use super::*;
    use fibar_core::light::LedBeam;
    use fibar_core::{LedId, PatternId};
    use fibar_ruler::bezier::Bezier;

    /// κ of broken lines from a socket at the origin, looking up, in a frame turned at will.
    #[track_caller]
    fn check(lines: &[&[[f64; 3]]], expected: &[f64]) {
        let turn = glam::DMat3::from_euler(glam::EulerRot::XYZ, 0.3, -0.8, 1.1);
        let member = |line: &&[[f64; 3]]| {
            let points: Vec<DVec3> = line.iter().map(|p| turn * DVec3::from_array(*p)).collect();
            Member::of(&Curve { pieces: points.windows(2).map(Bezier::polynomial).collect() }, 0.875)
        };
        let (led, pattern) = (LedId(0), PatternId(1));
        let socket = Socket { led, pattern, position: DVec3::ZERO, axis: turn * DVec3::Z };
        let found = couplings(&Beam::of(&LedBeam::TONE_2020), &socket, lines.iter().map(member).collect());
        assert!(found.iter().zip(expected).all(|(f, e)| (f - e).abs() < 0.01), "{found:?}, not {expected:?}");
    }

    fn fan(x: f64, y: f64) -> [[f64; 3]; 3] {
        [[0.0; 3], [0.0, 0.0, 2.5], [x, y, 40.0]]
    }

    #[test]
    fn one_centred_core_is_the_calibration_s() {
        check(&[&fan(0.0, 0.0)], &[1.0]);
        check(&[&fan(20.0, 0.0)], &[1.0]);
    }

    #[test]
    fn mouths_take_their_part_of_the_beam() {
        let up = |x: f64| [[x, 0.0, 0.0], [x, 0.0, 30.0]];
        check(&[&up(0.9), &up(-0.9)], &[0.912, 0.912]);
        check(&[&up(1.625)], &[0.748]);
        check(&[&up(5.0)], &[0.0]);
    }

    #[test]
    fn fibres_of_one_mouth_share_evenly() {
        check(&[&fan(20.0, 0.0), &fan(-10.0, 17.3), &fan(-10.0, -17.3)], &[1.0 / 3.0; 3]);
    }

    #[test]
    fn branches_take_half_whatever_they_carry() {
        let single = [[0.0; 3], [0.0, 0.0, 5.0], [30.0, 0.0, 20.0]];
        let pair = |y: f64| [[0.0; 3], [0.0, 0.0, 5.0], [-20.0, 0.0, 20.0], [-30.0, y, 30.0]];
        check(&[&single, &pair(10.0), &pair(-10.0)], &[0.5, 0.25, 0.25]);
    }

    #[test]
    fn a_section_is_no_brighter_than_the_led() {
        let merging = |x: f64| [[x, 0.0, 0.0], [0.0, 0.0, 10.0], [0.0, 0.0, 20.0], [20.0 * x, 0.0, 40.0]];
        check(&[&merging(-1.0), &merging(1.0)], &[0.5, 0.5]);
    }
}
