//! Sound shapes: closed, outward, crossing nothing. mm.

use fibar_core::artefact::mesh::TriangleMesh;
use glam::{DVec2, DVec3};
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

/// A box between two corners.
pub fn block(low: [f64; 3], high: [f64; 3]) -> TriangleMesh {
    let corner = |k: usize| DVec3::from_array(std::array::from_fn(|axis| [low, high][k >> axis & 1][axis]));
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = quads.into_iter().flat_map(halves).collect();
    TriangleMesh { vertices: (0..8).map(corner).collect(), triangles }
}

/// A ball around the origin: a cube's grid blown up; `steps` cells along each of its sides, 12 · steps² triangles.
pub fn ball(radius: f64, steps: i32) -> TriangleMesh {
    let at = |k: i32| (f64::from(k) / f64::from(steps) * PI / 2.0 - PI / 4.0).tan();
    let mut cube = cells([steps; 3], |_| true);
    for vertex in &mut cube.vertices {
        *vertex = DVec3::from_array(vertex.to_array().map(|x| at(x as i32))).normalize() * radius;
    }
    cube
}

/// The surface of a set of unit cells of a grid.
pub fn cells(counts: [i32; 3], is_solid: impl Fn([i32; 3]) -> bool) -> TriangleMesh {
    let filled =
        |cell: [i32; 3]| cell.iter().zip(counts).all(|(&k, count)| (0..count).contains(&k)) && is_solid(cell);
    let mut numbers: BTreeMap<[i32; 3], u32> = BTreeMap::new();
    let mut mesh = TriangleMesh::default();
    let all =
        (0..counts[2]).flat_map(|z| (0..counts[1]).flat_map(move |y| (0..counts[0]).map(move |x| [x, y, z])));
    for cell in all.filter(|&cell| filled(cell)) {
        for (axis, side) in (0..3).flat_map(|axis| [(axis, 0), (axis, 1)]) {
            let mut next = cell;
            next[axis] += 2 * side - 1;
            if !filled(next) {
                let quad = face(cell, axis, side).map(|place| {
                    *numbers.entry(place).or_insert_with(|| {
                        mesh.vertices.push(DVec3::from_array(place.map(f64::from)));
                        mesh.vertices.len() as u32 - 1
                    })
                });
                mesh.triangles.extend(halves(quad));
            }
        }
    }
    mesh
}

/// Corners of a cell's face, counter-clockwise from outside.
fn face(cell: [i32; 3], axis: usize, side: i32) -> [[i32; 3]; 4] {
    let (right, up) = ((axis + 1) % 3, (axis + 2) % 3);
    let corner = |i: i32, j: i32| {
        let mut place = cell;
        place[axis] += side;
        place[right] += i;
        place[up] += j;
        place
    };
    let ring = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
    if side == 1 { ring } else { [ring[0], ring[3], ring[2], ring[1]] }
}

/// A surface that closes in both directions; corners by their row and column.
fn closed_grid(rows: usize, columns: usize, place: impl Fn(usize, usize) -> DVec3) -> TriangleMesh {
    let number = |row: usize, column: usize| (row % rows * columns + column % columns) as u32;
    let pairs = || (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column)));
    let quad = |(r, c)| halves([number(r, c), number(r, c + 1), number(r + 1, c + 1), number(r + 1, c)]);
    TriangleMesh {
        vertices: pairs().map(|(row, column)| place(row, column)).collect(),
        triangles: pairs().flat_map(quad).collect(),
    }
}

/// A ring around the z axis.
pub fn torus(major: f64, minor: f64, rows: usize, columns: usize) -> TriangleMesh {
    closed_grid(rows, columns, |row, column| {
        let (around, about) = (TAU * row as f64 / rows as f64, TAU * column as f64 / columns as f64);
        let out = major + minor * about.cos();
        DVec3::new(out * around.cos(), out * around.sin(), -minor * about.sin())
    })
}

/// A tube along a trefoil knot that winds around a torus; with `minor` too small for it, the tube passes through itself.
pub fn knot(major: f64, minor: f64, tube: f64, rows: usize, columns: usize) -> TriangleMesh {
    let at = |t: f64| {
        let out = major + minor * (3.0 * t).cos();
        DVec3::new(out * (2.0 * t).cos(), out * (2.0 * t).sin(), minor * (3.0 * t).sin())
    };
    closed_grid(rows, columns, |row, column| {
        let (t, about) = (TAU * row as f64 / rows as f64, TAU * column as f64 / columns as f64);
        let along = (at(t + 1e-4) - at(t - 1e-4)).normalize();
        let core = DVec3::new((2.0 * t).cos(), (2.0 * t).sin(), 0.0) * major;
        let side = (at(t) - core).reject_from(along).normalize();
        at(t) + (side * about.cos() + along.cross(side) * about.sin()) * tube
    })
}

/// A ball with ripples: `rows` from pole to pole, 2 · rows · (rows − 1) triangles.
pub fn rippled_ball(radius: f64, rows: usize) -> TriangleMesh {
    let place = |row: usize, column: usize| {
        let (polar, around) = (PI * row as f64 / rows as f64, TAU * column as f64 / rows as f64);
        let out = radius * (1.0 + 0.04 * (12.0 * polar).sin() * (9.0 * around).sin() * polar.sin());
        DVec3::new(polar.sin() * around.cos(), polar.sin() * around.sin(), polar.cos()) * out
    };
    let number = |row: usize, column: usize| match row {
        0 => 0,
        row if row == rows => 1,
        row => (2 + (row - 1) * rows + column % rows) as u32,
    };
    let mut mesh =
        TriangleMesh { vertices: vec![DVec3::Z * radius, DVec3::NEG_Z * radius], triangles: vec![] };
    mesh.vertices.extend(
        (1..rows).flat_map(|row| (0..rows).map(move |column| (row, column))).map(|(r, c)| place(r, c)),
    );
    for (row, column) in (0..rows).flat_map(|row| (0..rows).map(move |column| (row, column))) {
        let quad = [[row, column], [row + 1, column], [row + 1, column + 1], [row, column + 1]];
        let quad = quad.map(|[r, c]| number(r, c));
        mesh.triangles.extend(halves(quad).into_iter().filter(|[a, b, c]| a != b && b != c && c != a));
    }
    mesh
}

/// What stands between two horizontal polygons of the same angles around the z axis: a prism, or with an inner one a pipe.
pub fn prism(outer: &[DVec2], inner: Option<&[DVec2]>, height: f64) -> TriangleMesh {
    let count = outer.len();
    let ring = |points: &[DVec2], z: f64| points.iter().map(move |p| p.extend(z)).collect::<Vec<_>>();
    let mut vertices = [ring(outer, 0.0), ring(outer, height)].concat();
    match inner {
        Some(inner) => vertices.extend([ring(inner, 0.0), ring(inner, height)].concat()),
        None => vertices.extend([DVec3::ZERO, DVec3::Z * height]),
    }
    let number = |ring: usize, k: usize| (ring * count + k % count) as u32;
    let (low, high) = (2 * count as u32, 2 * count as u32 + 1);
    let mut triangles = Vec::new();
    for k in 0..count {
        let (near, far) = (|ring| number(ring, k), |ring| number(ring, k + 1));
        triangles.extend(halves([near(0), far(0), far(1), near(1)]));
        match inner {
            Some(_) => {
                triangles.extend(halves([near(3), far(3), far(2), near(2)]));
                triangles.extend(halves([near(2), far(2), far(0), near(0)]));
                triangles.extend(halves([near(1), far(1), far(3), near(3)]));
            }
            None => triangles.extend([[near(0), low, far(0)], [near(1), far(1), high]]),
        }
    }
    TriangleMesh { vertices, triangles }
}

/// Points around the origin, counter-clockwise.
pub fn polygon(count: usize, radius: impl Fn(usize) -> f64) -> Vec<DVec2> {
    (0..count).map(|k| DVec2::from_angle(TAU * k as f64 / count as f64) * radius(k)).collect()
}

/// Both triangles of a quadrangle.
fn halves([a, b, c, d]: [u32; 4]) -> [[u32; 3]; 2] {
    [[a, b, c], [a, c, d]]
}

/// Several meshes as one, sharing no vertex.
pub fn together(meshes: &[TriangleMesh]) -> TriangleMesh {
    let mut all = TriangleMesh::default();
    for mesh in meshes {
        let first = all.vertices.len() as u32;
        all.vertices.extend(&mesh.vertices);
        all.triangles.extend(mesh.triangles.iter().map(|t| t.map(|v| v + first)));
    }
    all
}

/// The same mesh moved, mm.
pub fn moved(mut mesh: TriangleMesh, by: [f64; 3]) -> TriangleMesh {
    mesh.vertices.iter_mut().for_each(|v| *v += DVec3::from(by));
    mesh
}

/// The same mesh scaled about the origin.
pub fn scaled(mut mesh: TriangleMesh, by: f64) -> TriangleMesh {
    mesh.vertices.iter_mut().for_each(|v| *v *= by);
    mesh
}

/// The same mesh inside out.
pub fn inverted(mut mesh: TriangleMesh) -> TriangleMesh {
    mesh.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    mesh
}
