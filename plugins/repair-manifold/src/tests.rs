//! Sound meshes broken in every known way, and what must come out.

use crate::closing::{Limits, Obstacle, close};
use crate::fate::Fate;
use crate::fixture::{ball, block, inverted, moved, octahedron, together};
use crate::orientation::turn;
use crate::sheets::Sheets;
use crate::volume::signed_volume;
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_geometry::crossings::crossings;
use fibar_solid::Solid;
use glam::DVec3;

const LIMITS: Limits = Limits { seam_mm: 0.005, largest_hole_mm: 1e4 };

fn repair(mesh: &TriangleMesh) -> (Result<Solid, Obstacle>, Fate) {
    let mut fate = Fate::default();
    let closed = close(mesh, LIMITS, &mut fate);
    (closed.and_then(|closed| Ok(Solid::from_mesh(&closed)?)), fate)
}

/// The repaired mesh is closed, crosses nothing, has so many shells and this volume, within a share.
#[track_caller]
fn check(mesh: &TriangleMesh, shells: usize, volume: f64, share: f64) -> Fate {
    let (repaired, fate) = repair(mesh);
    let solid = repaired.expect("it can be repaired");
    let surface = solid.to_mesh().unwrap();
    assert!(Sheets::of(&surface).is_closed() && crossings(&surface).is_empty());
    assert_eq!(solid.components().unwrap().len(), shells);
    let off = (solid.volume() - volume).abs();
    assert!(off <= share * volume, "{} mm³, not {volume}: {fate:?}", solid.volume());
    fate
}

fn cube(x: f64, y: f64, z: f64) -> TriangleMesh {
    moved(block([0.0; 3], [10.0; 3]), [x, y, z])
}

/// Every triangle with corners of its own, as in an STL file.
fn soup(mesh: &TriangleMesh) -> TriangleMesh {
    let vertices = (0..mesh.triangles.len()).flat_map(|t| mesh.corners(t)).collect();
    let triangles = (0..mesh.triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    TriangleMesh { vertices, triangles }
}

#[test]
fn sound_meshes_pass_untouched() {
    for mesh in [octahedron(5.0), ball(10.0, 10), cube(0.0, 0.0, 0.0)] {
        let volume = signed_volume(&mesh);
        let fate = check(&mesh, 1, volume, 1e-12);
        assert_eq!(
            fate,
            Fate {
                shells: 1,
                bodies: 1,
                bodies_left: 1,
                volume_before: fate.volume_before,
                ..Fate::default()
            }
        );
        let welded = check(&soup(&mesh), 1, volume, 1e-12);
        assert!(welded.vertices_welded > 0 && welded.changes().is_empty());
    }
}

#[test]
fn orientation_is_restored() {
    let volume = signed_volume(&ball(10.0, 8));
    for step in [2, 3, 7] {
        let mut mesh = ball(10.0, 8);
        mesh.triangles.iter_mut().step_by(step).for_each(turn);
        let fate = check(&mesh, 1, volume, 1e-12);
        assert!(fate.triangles_turned > 0);
    }
    assert_eq!(check(&inverted(ball(10.0, 8)), 1, volume, 1e-12).shells_turned, 1);
}

#[test]
fn duplicate_and_degenerate_triangles_go() {
    let mut mesh = ball(10.0, 8);
    let volume = signed_volume(&mesh);
    let copies: Vec<[u32; 3]> = mesh.triangles.iter().step_by(5).copied().collect();
    mesh.triangles.extend(&copies);
    mesh.triangles.extend([[3, 3, 9], [7, 8, 7]]);
    let fate = check(&mesh, 1, volume, 1e-12);
    assert_eq!((fate.degenerate_removed, fate.duplicates_removed), (2, copies.len()));
}

#[test]
fn holes_are_capped() {
    let whole = signed_volume(&ball(10.0, 16));
    for missing in [1, 2, 40] {
        let mut mesh = ball(10.0, 16);
        mesh.triangles.drain(200..200 + missing);
        let fate = check(&mesh, 1, whole, 0.005);
        assert!(fate.holes_closed >= 1 && fate.cap_area > 0.0);
    }
    let mut open_box = cube(0.0, 0.0, 0.0);
    open_box.triangles.drain(4..6);
    check(&open_box, 1, 1000.0, 1e-12);
    let mut sieve = ball(10.0, 16);
    let mut number = 0;
    sieve.triangles.retain(|_| {
        number += 1;
        number % 50 != 0
    });
    check(&sieve, 1, whole, 0.005);
}

#[test]
fn a_hole_wider_than_allowed_is_refused() {
    let mut open_box = cube(0.0, 0.0, 0.0);
    open_box.triangles.drain(4..6);
    let limits = Limits { largest_hole_mm: 5.0, ..LIMITS };
    let refused = close(&open_box, limits, &mut Fate::default());
    assert!(
        matches!(refused, Err(Obstacle::Hole { count: 1, radius, .. }) if (radius - 50_f64.sqrt()).abs() < 1e-9)
    );
}

#[test]
fn near_rims_are_sewn() {
    let mut mesh = soup(&ball(10.0, 8));
    for (k, vertex) in mesh.vertices.iter_mut().enumerate() {
        *vertex += DVec3::new(1e-4, -2e-4, 1e-4) * (k % 3) as f64;
    }
    let fate = check(&mesh, 1, signed_volume(&ball(10.0, 8)), 1e-3);
    assert!(fate.vertices_sewn > 0 && fate.displacement <= LIMITS.seam_mm);
}

#[test]
fn crowded_edges_and_corners_come_apart_or_join() {
    check(&together(&[cube(0.0, 0.0, 0.0), cube(10.0, 10.0, 0.0)]), 2, 2000.0, 1e-9);
    check(&together(&[cube(0.0, 0.0, 0.0), cube(10.0, 10.0, 10.0)]), 2, 2000.0, 1e-9);
    check(&together(&[cube(0.0, 0.0, 0.0), cube(10.0, 0.0, 0.0)]), 1, 2000.0, 1e-9);
    let mut walled = together(&[cube(0.0, 0.0, 0.0), cube(10.0, 0.0, 0.0)]);
    walled.triangles.drain(12..14);
    assert_eq!(check(&walled, 1, 2000.0, 1e-9).walls_removed, 2);
    let mut flapped = cube(0.0, 0.0, 0.0);
    flapped.vertices.push(DVec3::new(-3.0, -3.0, 5.0));
    flapped.triangles.push([0, 4, 8]);
    assert_eq!(check(&flapped, 1, 1000.0, 1e-9).walls_removed, 1);
}

#[test]
fn bodies_are_united_and_none_is_lost() {
    check(&together(&[cube(0.0, 0.0, 0.0), cube(20.0, 0.0, 0.0), cube(0.0, 30.0, 0.0)]), 3, 3000.0, 1e-9);
    check(&together(&[cube(0.0, 0.0, 0.0), cube(5.0, 0.0, 0.0)]), 1, 1500.0, 1e-9);
    check(&together(&[cube(0.0, 0.0, 0.0), cube(5.0, 3.0, 4.0)]), 1, 2000.0 - 5.0 * 7.0 * 6.0, 1e-9);
    check(&together(&[cube(0.0, 0.0, 0.0), inverted(cube(5.0, 3.0, 4.0))]), 1, 2000.0 - 210.0, 1e-9);
    let inner = block([2.0; 3], [8.0; 3]);
    check(&together(&[cube(0.0, 0.0, 0.0), inverted(inner.clone())]), 2, 1000.0 - 216.0, 1e-9);
    check(&together(&[cube(0.0, 0.0, 0.0), inner]), 1, 1000.0, 1e-9);
}

#[test]
fn what_encloses_nothing_is_refused() {
    let sheet = TriangleMesh { vertices: vec![DVec3::ZERO, DVec3::X, DVec3::Y], triangles: vec![[0, 1, 2]] };
    assert!(matches!(repair(&sheet).0, Err(Obstacle::Nothing)));
    assert!(matches!(repair(&TriangleMesh::default()).0, Err(Obstacle::Nothing)));
}
