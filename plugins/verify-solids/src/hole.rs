//! What is cut out of the base, an LED's hole or a cavity: its volume inside the body, and the part of a line inside of it.

use crate::pierce::pierce;
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_core::artefact::sockets::{Cavity, Section, Sockets};
use glam::{DMat3, DVec2, DVec3, Vec3Swizzles};
use std::f64::consts::{PI, TAU};

/// Rings and spokes of the lines that measure what is round, all standing for the same area.
const RINGS: usize = 16;
const SPOKES: usize = 48;
/// Lines along either side of a rectangle.
const ROWS: usize = 28;

/// All that is cut out, the LEDs' holes as cavities.
pub fn all(sockets: &Sockets) -> Vec<Cavity> {
    let hole = |socket: &fibar_core::artefact::sockets::Socket| Cavity {
        name: format!("hole of LED {}", socket.led),
        position: socket.position,
        axis: socket.axis,
        across: socket.axis.any_orthonormal_vector(),
        section: Section::Circle { diameter_mm: sockets.hole.diameter_mm },
        depth_mm: sockets.hole.depth_mm,
    };
    sockets.sockets.iter().map(hole).chain(sockets.cavities.iter().cloned()).collect()
}

/// The same, larger by an allowance all around and at the ceiling, mm.
pub fn widened(cavity: &Cavity, allowance: f64) -> Cavity {
    let section = match cavity.section {
        Section::Circle { diameter_mm } => Section::Circle { diameter_mm: diameter_mm + 2.0 * allowance },
        Section::Rectangle { width_mm, length_mm } => Section::Rectangle {
            width_mm: width_mm + 2.0 * allowance,
            length_mm: length_mm + 2.0 * allowance,
        },
    };
    Cavity { section, depth_mm: cavity.depth_mm + allowance, ..cavity.clone() }
}

/// Volume of the cavity inside the body, mm³, by lines along its axis: exact where the body's surface is flat and square to
/// the axis all across the cavity's mouth.
pub fn volume_within(body: &TriangleMesh, cavity: &Cavity) -> f64 {
    let side = cavity.axis.cross(cavity.across);
    let x_from_axis = DMat3::from_cols(cavity.axis, cavity.across, side).transpose();
    let turned = |v: &DVec3| x_from_axis * (*v - cavity.position);
    let mut near =
        TriangleMesh { vertices: body.vertices.iter().map(turned).collect(), triangles: Vec::new() };
    let half = DVec2::from(cavity.section.half_size());
    let reaches = |t: &&[u32; 3]| {
        let corners = t.map(|v| near.vertices[v as usize].yz());
        let (low, high) =
            (corners[0].min(corners[1]).min(corners[2]), corners[0].max(corners[1]).max(corners[2]));
        low.cmple(half).all() && high.cmpge(-half).all()
    };
    near.triangles = body.triangles.iter().filter(reaches).copied().collect();
    let (lines, area) = lines(cavity.section);
    let length: f64 = lines.iter().map(|line| length_inside(&near, *line, cavity.depth_mm)).sum();
    length * area / lines.len() as f64
}

/// Places across a section that stand for equal areas, mm, and its whole area, mm².
fn lines(section: Section) -> (Vec<DVec2>, f64) {
    let grid = |rows: usize, columns: usize| (0..rows).flat_map(move |i| (0..columns).map(move |j| (i, j)));
    match section {
        Section::Circle { diameter_mm } => {
            let radius = 0.5 * diameter_mm;
            let lines = grid(RINGS, SPOKES).map(|(ring, spoke)| line(ring, spoke) * radius);
            (lines.collect(), PI * radius * radius)
        }
        Section::Rectangle { width_mm, length_mm } => {
            let share = |k: usize| (k as f64 + 0.5) / ROWS as f64 - 0.5;
            let place = |(i, j)| DVec2::new(share(i) * width_mm, share(j) * length_mm);
            (grid(ROWS, ROWS).map(place).collect(), width_mm * length_mm)
        }
    }
}

/// A place in the unit disc.
fn line(ring: usize, spoke: usize) -> DVec2 {
    let radius = ((ring as f64 + 0.5) / RINGS as f64).sqrt();
    let (sine, cosine) = libm::sincos((spoke as f64 + 0.381_966) * TAU / SPOKES as f64);
    DVec2::new(cosine, sine) * radius
}

/// How much of the line from x = −depth to 0 lies inside the mesh, mm.
fn length_inside(mesh: &TriangleMesh, line: DVec2, depth: f64) -> f64 {
    let hits = (0..mesh.triangles.len() as u32).filter_map(|t| pierce(mesh, t, line));
    let signed = |(x, enters): (f64, bool)| {
        let covered = -x.clamp(-depth, 0.0);
        if enters { covered } else { -covered }
    };
    hits.map(signed).sum()
}

/// The stretch of the line through `point` along +X that lies inside the cavity, from and to, as x.
pub fn stretch(point: DVec3, cavity: &Cavity) -> Option<(f64, f64)> {
    let from_ceiling = point - cavity.position;
    let (rise, height) = (cavity.axis.x, from_ceiling.dot(cavity.axis));
    let mut within = between(rise, height, -cavity.depth_mm, 0.0)?;
    let mut narrow = |(from, to): (f64, f64)| within = (within.0.max(from), within.1.min(to));
    match cavity.section {
        Section::Circle { diameter_mm } => {
            let across = DVec3::X - cavity.axis * rise;
            narrow(near(across, from_ceiling - cavity.axis * height, 0.5 * diameter_mm)?);
        }
        Section::Rectangle { width_mm, length_mm } => {
            let sides = [(cavity.across, width_mm), (cavity.axis.cross(cavity.across), length_mm)];
            for (side, size) in sides {
                narrow(between(side.x, from_ceiling.dot(side), -0.5 * size, 0.5 * size)?);
            }
        }
    }
    (within.0 < within.1).then_some((point.x + within.0, point.x + within.1))
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
    use crate::topology::tests::cuboid;

    fn round(position: DVec3, axis: DVec3, diameter_mm: f64, depth_mm: f64) -> Cavity {
        let section = Section::Circle { diameter_mm };
        let across = axis.any_orthonormal_vector();
        Cavity { name: "hole".into(), position, axis, across, section, depth_mm }
    }

    #[test]
    fn volume_of_holes_whole_and_cut_short() {
        let body = cuboid(DVec3::splat(-10.0), DVec3::splat(10.0));
        let check = |position: DVec3, axis: DVec3, length: f64| {
            let hole = round(position, axis, 4.0, 3.0);
            let (found, expected) = (volume_within(&body, &hole), length * PI * 4.0);
            assert!((found - expected).abs() < 1e-9, "{found} instead of {expected}");
            let section = Section::Rectangle { width_mm: 2.0, length_mm: 3.0 };
            let (found, expected) = (volume_within(&body, &Cavity { section, ..hole }), length * 6.0);
            assert!((found - expected).abs() < 1e-9, "{found} instead of {expected}");
        };
        check(DVec3::new(1.0, 2.0, -7.0), DVec3::Z, 3.0);
        check(DVec3::new(1.0, 2.0, -9.0), DVec3::Z, 1.0);
        check(DVec3::new(1.0, 2.0, 3.0), DVec3::Z, 3.0);
        check(DVec3::new(8.5, 2.0, 3.0), DVec3::NEG_X, 1.5);
        check(DVec3::new(30.0, 2.0, 3.0), DVec3::NEG_X, 0.0);
    }

    #[track_caller]
    fn check(axis: DVec3, y: f64, z: f64, expected: Option<(f64, f64)>) {
        let found = stretch(DVec3::new(0.0, y, z), &round(DVec3::new(1.0, 0.0, 8.0), axis, 5.0, 8.0));
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

    #[test]
    fn lines_across_a_board() {
        let section = Section::Rectangle { width_mm: 6.0, length_mm: 20.0 };
        let upright =
            Cavity { section, across: DVec3::X, ..round(DVec3::new(1.0, 0.0, 8.0), DVec3::Z, 1.0, 8.0) };
        let at = |cavity: &Cavity, y: f64, z: f64| stretch(DVec3::new(0.0, y, z), cavity);
        assert_eq!(at(&upright, 9.9, 4.0), Some((-2.0, 4.0)));
        assert_eq!(at(&upright, 10.1, 4.0), None);
        assert_eq!(at(&upright, 0.0, 8.1), None);
        let wider = widened(&upright, 0.25);
        assert_eq!((at(&wider, 10.1, 4.0), at(&wider, 0.0, 8.1)), (Some((-2.25, 4.25)), None));
        let turned = Cavity { across: DVec3::Y, ..upright };
        assert_eq!(at(&turned, 2.9, 4.0), Some((-9.0, 11.0)));
    }
}
