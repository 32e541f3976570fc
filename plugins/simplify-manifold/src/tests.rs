//! The promises, measured by rulers that no stage makes things with.

use crate::simplify::{Simplified, Wish, simplify};
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_ruler::bvh::Bvh;
use fibar_solid::Solid;
use glam::DVec3;
use rand::RngExt;
use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};
use std::f64::consts::{PI, TAU};

/// A ball of rows from pole to pole, whose radius depends on the angles from the pole and around.
fn ball(rows: u32, radius: impl Fn(f64, f64) -> f64) -> TriangleMesh {
    let columns = 2 * rows;
    let place = |row: u32, column: u32| {
        let (polar, around) =
            (PI * f64::from(row) / f64::from(rows), TAU * f64::from(column) / f64::from(columns));
        let sine = if row == 0 || row == rows { 0.0 } else { polar.sin() };
        radius(polar, around) * DVec3::new(sine * around.cos(), sine * around.sin(), polar.cos())
    };
    let mut mesh = TriangleMesh { vertices: vec![place(0, 0), place(rows, 0)], triangles: Vec::new() };
    mesh.vertices.extend(
        (1..rows).flat_map(|row| (0..columns).map(move |column| (row, column))).map(|(r, c)| place(r, c)),
    );
    let number = |row: u32, column: u32| match row {
        0 => 0,
        _ if row == rows => 1,
        _ => 2 + (row - 1) * columns + column % columns,
    };
    for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
        let [a, b] = [number(row, column), number(row, column + 1)];
        let [c, d] = [number(row + 1, column), number(row + 1, column + 1)];
        mesh.triangles
            .extend([[a, d, b], [a, c, d]].into_iter().filter(|[p, q, r]| p != q && q != r && r != p));
    }
    mesh
}

/// A block of `n` squares a side, bent by `bend`.
fn block(size: [f64; 3], n: u32, bend: impl Fn(DVec3) -> DVec3) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    for (axis, side) in (0..3).flat_map(|axis| [(axis, 0.0), (axis, 1.0)]) {
        let at = |i: u32, j: u32| {
            let mut place = DVec3::ZERO;
            place[axis] = side;
            place[(axis + 1) % 3] = f64::from(i) / f64::from(n);
            place[(axis + 2) % 3] = f64::from(j) / f64::from(n);
            place * DVec3::from(size)
        };
        for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
            let first = mesh.vertices.len() as u32;
            mesh.vertices.extend([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
            let turn = |[a, b, c]: [u32; 3]| if side > 0.5 { [a, b, c] } else { [a, c, b] };
            mesh.triangles.extend([[0, 1, 2], [0, 2, 3]].map(|t| turn(t.map(|k| first + k))));
        }
    }
    let mut mesh = mesh.welded();
    mesh.vertices.iter_mut().for_each(|v| *v = bend(*v));
    mesh
}

/// A ring of `n` squares around and across; its genus is 1.
fn ring(n: u32) -> TriangleMesh {
    let place = |i: u32, j: u32| {
        let [u, v] = [i, j].map(|k| TAU * f64::from(k % n) / f64::from(n));
        let out = 30.0 + 8.0 * v.cos();
        DVec3::new(out * u.cos(), out * u.sin(), 8.0 * v.sin())
    };
    let number = |i: u32, j: u32| (i % n) * n + j % n;
    let cells = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
    let cell = |(i, j): (u32, u32)| {
        let [a, b, c, d] = [number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)];
        [[a, b, c], [a, c, d]]
    };
    TriangleMesh {
        vertices: (0..n).flat_map(|i| (0..n).map(move |j| place(i, j))).collect(),
        triangles: cells.flat_map(cell).collect(),
    }
}

fn together(one: &TriangleMesh, other: &TriangleMesh) -> TriangleMesh {
    let first = one.vertices.len() as u32;
    let moved = other.triangles.iter().map(|t| t.map(|v| v + first));
    TriangleMesh {
        vertices: one.vertices.iter().chain(&other.vertices).copied().collect(),
        triangles: one.triangles.iter().copied().chain(moved).collect(),
    }
}

fn run(mesh: &TriangleMesh, chord_error: f64) -> Simplified {
    simplify(mesh, &Wish { chord_error, triangles: 0 }, &mut |_| Ok(())).unwrap()
}

/// Greatest distance of many points of one surface from another, by the ruler.
fn farthest(from: &TriangleMesh, to: &TriangleMesh) -> f64 {
    let tree = Bvh::of(&(0..to.triangles.len()).map(|t| to.corners(t)).collect::<Vec<_>>());
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let per_triangle = (200_000 / from.triangles.len()).clamp(2, 400);
    let inside = (0..from.triangles.len()).flat_map(|t| (0..per_triangle).map(move |_| t)).map(|t| {
        let [a, b, c] = from.corners(t);
        let (u, v): (f64, f64) = (rng.random(), rng.random());
        let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
        a + (b - a) * u + (c - a) * v
    });
    let places: Vec<DVec3> = from.vertices.iter().copied().chain(inside).collect();
    places.iter().map(|p| tree.nearest(p, f64::INFINITY).unwrap().distance).fold(0.0, f64::max)
}

fn base_area(mesh: &TriangleMesh) -> f64 {
    let low = mesh.bounds().unwrap().0.z;
    let corners = (0..mesh.triangles.len()).map(|t| mesh.corners(t));
    let base = corners.filter(|c| c.iter().all(|p| p.z == low));
    base.map(|[a, b, c]| (b - a).cross(c - a).length() / 2.0).sum()
}

/// All promises at a chord error; the triangles that are left are `most` or fewer.
fn check(what: &str, mesh: &TriangleMesh, chord_error: f64, most: usize) {
    let done = run(mesh, chord_error);
    let count = done.mesh.triangles.len();
    assert!(count <= most, "{what}: {count} of {} triangles are left, not {most}", mesh.triangles.len());
    let measured = farthest(mesh, &done.mesh).max(farthest(&done.mesh, mesh));
    assert!(measured <= done.deviation.at_most + 1e-9, "{what}: {measured} mm, said {:?}", done.deviation);
    assert!(done.deviation.at_most <= chord_error, "{what}: {:?}", done.deviation);
    assert!(
        measured >= 0.9 * done.deviation.at_least - 1e-9 && measured > 0.0 || chord_error < 1e-3,
        "{what}: {measured}"
    );
    let [before, after] = [mesh, &done.mesh].map(|mesh| Solid::from_mesh(mesh).unwrap());
    assert_eq!(before.genus(), after.genus(), "{what}");
    assert_eq!(before.components().unwrap().len(), after.components().unwrap().len(), "{what}");
    assert!((before.volume() - after.volume()).abs() <= chord_error * before.surface_area(), "{what}");
    assert_eq!(mesh.bounds(), done.mesh.bounds(), "{what}: its box is as it was");
    assert!((base_area(mesh) - base_area(&done.mesh)).abs() <= 0.01 * base_area(mesh), "{what}: its base");
}

#[test]
fn promises_are_kept() {
    let round = ball(60, |_, _| 50.0);
    check("a ball", &round, 0.05, 9000);
    check("a ball", &round, 0.5, 1000);
    let rippled = ball(90, |polar, around| 50.0 + (12.0 * polar).sin() * (9.0 * around).sin() * polar.sin());
    check("a rippled ball", &rippled, 0.05, 16_000);
    check("a ring", &ring(80), 0.05, 7000);
    let inner = ball(30, |_, _| 20.0);
    let cavity =
        TriangleMesh { triangles: inner.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect(), ..inner };
    check("a hollow ball", &together(&round, &cavity), 0.1, 8000);
}

#[test]
fn flat_faces_fall_to_their_corners() {
    let flat = run(&block([40.0, 30.0, 20.0], 30, |v| v), 0.001);
    assert_eq!(flat.mesh.triangles.len(), 12);
    assert!(flat.deviation.at_most < 1e-8);
    // Upright walls are bent, the base keeps its plane.
    let bent = block([40.0, 30.0, 20.0], 40, |v| DVec3::new(v.x + 3.0 * (v.z / 8.0).sin(), v.y, v.z));
    check("a bent block", &bent, 0.02, 600);
    // A vertex hovers above the rim, nearer than the chord error.
    let low = block([40.0, 30.0, 20.0], 20, |v| if v.z > 0.5 && v.z < 1.5 { v.with_z(0.004) } else { v });
    check("a block with a low row", &low, 0.02, 200);
    // A plate thinner than the chord error may not pass through itself.
    check("a thin plate", &block([40.0, 30.0, 0.03], 20, |v| v), 0.1, 2000);
    check("a thin shell", &thin_shell(), 0.2, 4_500);
}

/// Two balls, one in the other, nearer than a chord of either leaves room for.
fn thin_shell() -> TriangleMesh {
    let (outer, inner) = (ball(24, |_, _| 30.0), ball(24, |_, _| 29.9));
    let cavity =
        TriangleMesh { triangles: inner.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect(), ..inner };
    let shell = together(&outer, &cavity);
    assert!(fibar_geometry::crossings::crossings(&shell).is_empty());
    shell
}

#[test]
fn enough_is_enough() {
    let round = ball(40, |_, _| 50.0);
    let done = simplify(&round, &Wish { chord_error: 1.0, triangles: 2000 }, &mut |_| Ok(())).unwrap();
    assert_eq!(done.mesh.triangles.len(), 2000);
    let fewer = run(&round, 1.0);
    assert!(fewer.mesh.triangles.len() < 2000 && fewer.deviation.at_least > done.deviation.at_most);
}

#[test]
fn the_same_bytes_with_any_number_of_threads() {
    let mesh = ball(40, |polar, around| 50.0 + (6.0 * polar).sin() * around.sin() * polar.sin());
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| run(&mesh, 0.03).mesh.to_ply())
    };
    assert_eq!(with(1), with(3));
}

#[test]
fn open_meshes_are_no_bodies() {
    let mut open = block([1.0, 1.0, 1.0], 2, |v| v);
    assert!(crate::check(&open).is_ok());
    open.triangles.pop();
    assert!(crate::check(&open).is_err() && crate::check(&TriangleMesh::default()).is_err());
}
