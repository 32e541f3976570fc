//! Several shells: beside, in, against and through each other; and shells through themselves.

use super::shapes::{ball, block, cells, inverted, knot, moved, scaled, together, torus};
use super::ways::*;
use super::{Case, simple::plate};
use fibar_core::artefact::mesh::TriangleMesh;
use glam::DVec3;

fn cube(x: f64, y: f64, z: f64) -> TriangleMesh {
    moved(block([0.0; 3], [20.0; 3]), [x, y, z])
}

/// Shells that do not pass through each other.
pub(super) fn shells() -> Vec<Case> {
    let sound = |name, what, parts: &[TriangleMesh]| Case::new(name, what, &together(parts), together(parts));
    let onto = |name, what, sound: &[TriangleMesh], parts: &[TriangleMesh]| {
        Case::new(name, what, &together(sound), together(parts))
    };
    let (outer, inner, core) = (ball(40.0, 16), ball(30.0, 12), ball(15.0, 8));
    let bodies = [ball(20.0, 10), moved(torus(20.0, 6.0, 40, 20), [60.0, 0.0, 0.0]), cube(-10.0, 40.0, 0.0)];
    let row = |size: [i32; 3]| scaled(cells(size, |_| true), 20.0);
    let mut walled = together(&[cube(0.0, 0.0, 0.0), cube(20.0, 0.0, 0.0)]);
    walled.triangles.drain(12..14);
    let in_pieces: Vec<TriangleMesh> = (0..40)
        .map(|k| moved(ball(3.0, 3), [f64::from(k % 8) * 10.0, f64::from(k / 8) * 10.0, f64::from(k % 3)]))
        .collect();
    vec![
        sound("bodies", "three bodies apart", &bodies),
        sound("bodies-forty", "forty small bodies", &in_pieces),
        onto(
            "bodies-turned",
            "three bodies, two inside out",
            &bodies,
            &[bodies[0].clone(), inverted(bodies[1].clone()), inverted(bodies[2].clone())],
        ),
        sound("cavity", "a hollow ball", &[outer.clone(), inverted(inner.clone())]),
        onto(
            "cavity-inverted",
            "a hollow ball inside out",
            &[outer.clone(), inverted(inner.clone())],
            &[inverted(outer.clone()), inner.clone()],
        ),
        sound(
            "nested-three",
            "a ball in a hollow ball",
            &[outer.clone(), inverted(inner.clone()), core.clone()],
        ),
        onto(
            "nested-inverted",
            "the same, the inmost inside out",
            &[outer.clone(), inverted(inner.clone()), core.clone()],
            &[outer.clone(), inverted(inner.clone()), inverted(core.clone())],
        ),
        onto(
            "nested-same",
            "a ball in a ball, both outward",
            std::slice::from_ref(&outer),
            &[outer.clone(), inner],
        ),
        sound(
            "edge-shared",
            "two boxes that touch along an edge",
            &[cube(0.0, 0.0, 0.0), cube(20.0, 20.0, 0.0)],
        ),
        sound(
            "corner-shared",
            "two boxes that touch at a corner",
            &[cube(0.0, 0.0, 0.0), cube(20.0, 20.0, 20.0)],
        ),
        onto(
            "face-shared",
            "two boxes, face to face",
            &[row([2, 1, 1])],
            &[cube(0.0, 0.0, 0.0), cube(20.0, 0.0, 0.0)],
        ),
        Case::new("wall", "a wall between two rooms", &row([2, 1, 1]), walled),
    ]
}

/// A square tube of side 4 along a path, its sides upright, ends closed.
fn duct(path: &[[f64; 3]]) -> TriangleMesh {
    let at = |k: usize| DVec3::from(path[k]);
    let mut mesh = TriangleMesh::default();
    for k in 0..path.len() {
        let before = (at(k) - at(k.saturating_sub(1))).with_z(0.0).normalize_or_zero();
        let after = (at((k + 1).min(path.len() - 1)) - at(k)).with_z(0.0).normalize_or_zero();
        let along = (before + after).normalize();
        // At a corner the section is a diagonal one.
        let turn = along.dot(if k == 0 { after } else { before });
        let side = DVec3::Z.cross(along) * 2.0 / turn;
        mesh.vertices.extend(
            [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
                .map(|[s, u]| at(k) + s * side + u * 2.0 * DVec3::Z),
        );
    }
    let ring = |k: usize, c: usize| (4 * k + c % 4) as u32;
    for (k, c) in (0..path.len() - 1).flat_map(|k| (0..4).map(move |c| (k, c))) {
        let [a, b, d, e] = [ring(k, c), ring(k, c + 1), ring(k + 1, c + 1), ring(k + 1, c)];
        mesh.triangles.extend([[a, b, d], [a, d, e]]);
    }
    let last = path.len() - 1;
    mesh.triangles.extend([[0, 3, 2], [0, 2, 1]].map(|t: [usize; 3]| t.map(|c| ring(0, c))));
    mesh.triangles.extend([[0, 1, 2], [0, 2, 3]].map(|t: [usize; 3]| t.map(|c| ring(last, c))));
    mesh
}

/// Shells that pass through each other or themselves.
pub(super) fn crossing() -> Vec<Case> {
    let at = |mesh: TriangleMesh, x: f64, y: f64, z: f64| moved(mesh, [x, y, z]);
    let two = together(&[ball(20.0, 12), at(ball(20.0, 12), 17.3, 9.1, 3.7)]);
    let chain: Vec<TriangleMesh> = (0..5)
        .map(|k| at(ball(12.0, 8), f64::from(k) * 15.1, f64::from(k % 2) * 4.3, 0.7 * f64::from(k)))
        .collect();
    let row = |size: [i32; 3]| scaled(cells(size, |_| true), 10.0);
    let boxes = together(&[block([0.0; 3], [20.0; 3]), block([10.0, 0.0, 0.0], [30.0, 20.0, 20.0])]);
    let level = [[-20.0, 0.0, 0.0], [40.0, 0.0, 0.0], [40.0, 40.0, 0.9], [0.0, 40.0, 0.9], [0.0, -20.0, 0.9]];
    let flat = level.map(|[x, y, _]| [x, y, 0.0]);
    let whole = ball(40.0, 16);
    let spiked = |to: [f64; 3]| with_spike(whole.clone(), DVec3::Z, DVec3::from(to));
    let rod = at(block([-3.0, -3.0, -60.0], [3.0, 3.0, 60.0]), 1.3, 2.1, 0.7);
    let turned = together(&[inverted(ball(20.0, 12)), at(ball(20.0, 12), 17.3, 9.1, 3.7)]);
    let rings = [torus(20.0, 6.0, 48, 24), at(torus(20.0, 6.0, 48, 24), 27.0, 0.4, 3.3)];
    let cross =
        |name, what, genus, mesh: TriangleMesh| Case::overlapping([name, what], genus, &mesh, mesh.clone());
    vec![
        cross("cross-balls", "two balls in each other", Some(0), two.clone()),
        Case::overlapping(["cross-balls-turned", "the same, one inside out"], Some(0), &two, turned),
        cross("cross-chain", "a chain of five balls", Some(0), together(&chain)),
        Case::new("cross-boxes", "two boxes, four pairs of faces in one plane", &row([3, 2, 2]), boxes),
        cross("cross-rod", "a rod through a ball", Some(0), together(&[ball(30.0, 12), rod])),
        cross("cross-rings", "two rings in each other", Some(3), together(&rings)),
        cross(
            "cross-plates",
            "a plate with holes through another",
            None,
            together(&[plate(), at(plate(), 9.7, 9.1, 3.3)]),
        ),
        cross("self-loop", "a duct through itself", Some(1), duct(&level)),
        cross("self-loop-flat", "a duct through itself, in one plane", Some(1), duct(&flat)),
        cross("self-knot", "a knot too fat for its own bends", None, knot(30.0, 8.0, 7.6, 160, 16)),
        Case::new("self-spike", "a spike through the far wall", &whole, spiked([1.0, 2.0, -60.0])),
        Case::new("self-dent", "a vertex pulled through a side wall", &whole, spiked([55.0, 3.0, 2.0])),
    ]
}
