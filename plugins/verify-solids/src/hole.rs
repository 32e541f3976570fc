//! An LED's hole: its volume inside the body, and the part of a line inside of it.

use crate::pierce::pierce;
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_core::artefact::sockets::{Hole, Socket};
use glam::{DMat3, DVec2, DVec3, Vec3Swizzles};
use std::f64::consts::{PI, TAU};

/// Rings and spokes of the lines that measure a hole, all standing for the same area.
const RINGS: usize = 16;
const SPOKES: usize = 48;

/// Volume of the hole inside the body, mm³, by lines along its axis: exact where the body's surface is flat and square to
/// the axis all across the hole's mouth.
pub fn volume_within(body: &TriangleMesh, socket: &Socket, hole: &Hole) -> f64 {
    let across = socket.axis.any_orthonormal_vector();
    let x_from_axis = DMat3::from_cols(socket.axis, across, socket.axis.cross(across)).transpose();
    let turned = |v: &DVec3| x_from_axis * (*v - socket.position);
    let mut near =
        TriangleMesh { vertices: body.vertices.iter().map(turned).collect(), triangles: Vec::new() };
    let radius = 0.5 * hole.diameter_mm;
    let reaches = |t: &&[u32; 3]| {
        let corners = t.map(|v| near.vertices[v as usize].yz());
        let (low, high) =
            (corners[0].min(corners[1]).min(corners[2]), corners[0].max(corners[1]).max(corners[2]));
        low.max_element() <= radius && high.min_element() >= -radius
    };
    near.triangles = body.triangles.iter().filter(reaches).copied().collect();
    let lines = (0..RINGS).flat_map(|ring| (0..SPOKES).map(move |spoke| line(ring, spoke) * radius));
    let length: f64 = lines.map(|line| length_inside(&near, line, hole.depth_mm)).sum();
    length * PI * radius * radius / (RINGS * SPOKES) as f64
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
    use crate::topology::tests::cuboid;
    use fibar_core::{LedId, PatternId};

    #[test]
    fn volume_of_holes_whole_and_cut_short() {
        let body = cuboid(DVec3::splat(-10.0), DVec3::splat(10.0));
        let hole = Hole { diameter_mm: 4.0, depth_mm: 3.0 };
        let check = |position: DVec3, axis: DVec3, length: f64| {
            let socket = Socket { led: LedId(0), pattern: PatternId(1), position, axis };
            let (found, expected) = (volume_within(&body, &socket, &hole), length * PI * 4.0);
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
