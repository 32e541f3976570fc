//! OpenSubdiv against the papers, limits against many levels, and shapes whose outcome is known.

use crate::angles::{Sharp, sharp};
use crate::reference::{Cage, catmull_clark_step, loop_step};
use crate::refinement::{Refinement, Rules};
use crate::smooth::{Smooth, smooth};
use crate::{Keep, Params, Rims, Scheme, TriangleWeights};
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_core::artefact::parts::{Part, Parts};
use glam::DVec3;
use opensubdiv_petite::far;
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::{PI, TAU};

fn mesh(vertices: impl IntoIterator<Item = [f64; 3]>, triangles: &[[u32; 3]]) -> TriangleMesh {
    let vertices = vertices.into_iter().map(DVec3::from_array).collect();
    TriangleMesh { vertices, triangles: triangles.to_vec() }
}

fn tetrahedron() -> TriangleMesh {
    mesh(
        [[0.0, 0.0, 0.0], [9.0, 1.0, 0.0], [2.0, 8.0, 1.0], [3.0, 2.0, 7.0]],
        &[[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
    )
}

fn cube() -> TriangleMesh {
    let corner = |k: usize| [0, 1, 2].map(|axis| if k >> axis & 1 == 1 { 10.0 } else { 0.0 });
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles: Vec<[u32; 3]> =
        quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    mesh((0..8).map(corner), &triangles)
}

/// A grid over the unit square, `n` by `m` squares, as a function of u and v; sides meet if it is closed in that direction.
fn grid(n: u32, m: u32, closed: [bool; 2], place: impl Fn(f64, f64) -> [f64; 3]) -> TriangleMesh {
    let (rows, columns) = (n + u32::from(!closed[0]), m + u32::from(!closed[1]));
    let at = |i: u32, j: u32| (i % rows) * columns + j % columns;
    let places = (0..rows * columns)
        .map(|k| place(f64::from(k / columns) / f64::from(n), f64::from(k % columns) / f64::from(m)));
    let cell = |k: u32| {
        let (i, j) = (k / m, k % m);
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        [[a, b, c], [a, c, d]]
    };
    mesh(places, &(0..n * m).flat_map(cell).collect::<Vec<_>>())
}

fn sheet() -> TriangleMesh {
    grid(3, 4, [false; 2], |u, v| [8.0 * u, 9.0 * v, (5.0 * u * v).sin() + u * u])
}

fn torus() -> TriangleMesh {
    grid(7, 5, [true; 2], |u, v| {
        let (a, b) = (TAU * u, TAU * v);
        let reach = 10.0 + 4.0 * b.cos();
        [reach * a.cos(), reach * a.sin(), 4.0 * b.sin()]
    })
}

/// A round can: bottom at z = 0, all its vertices on the rim or in the middle.
fn can(sides: u32) -> TriangleMesh {
    let angle = |k: u32| TAU * f64::from(k) / f64::from(sides);
    let rim = |z: f64| (0..sides).map(move |k| [10.0 * angle(k).cos(), 10.0 * angle(k).sin(), z]);
    let (low, high) = (2 * sides, 2 * sides + 1);
    let wall = (0..sides).flat_map(|k| {
        let next = (k + 1) % sides;
        [
            [k, next, sides + k],
            [next, sides + next, sides + k],
            [next, k, low],
            [sides + k, sides + next, high],
        ]
    });
    mesh(rim(0.0).chain(rim(12.0)).chain([[0.0; 3], [0.0, 0.0, 12.0]]), &wall.collect::<Vec<_>>())
}

fn icosahedron() -> TriangleMesh {
    let golden = (1.0 + 5f64.sqrt()) / 2.0;
    let points = [(-1.0, golden), (1.0, golden), (-1.0, -golden), (1.0, -golden)];
    let triangles = [
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    let vertices = points.map(|(a, b)| [a, b, 0.0]).into_iter();
    let vertices = vertices.chain(points.map(|(a, b)| [0.0, a, b])).chain(points.map(|(a, b)| [b, 0.0, a]));
    mesh(vertices.map(|p| p.map(|x| 10.0 * x)), &triangles)
}

fn rules(scheme: far::Scheme, levels: usize, to_limit: bool) -> Rules {
    let rims = far::BoundaryInterpolation::EdgeOnly;
    Rules { scheme, levels, rims, triangles: far::TriangleSubdivision::CatmullClark, to_limit }
}

fn cage(mesh: &TriangleMesh, sharp: &Sharp) -> Cage {
    Cage {
        vertices: mesh.vertices.clone(),
        faces: mesh.triangles.iter().map(|t| t.map(|v| v as usize).to_vec()).collect(),
        creases: sharp.creases.iter().map(|edge| edge.map(|v| v as usize)).collect(),
        corners: sharp.corners.iter().map(|&v| v as usize).collect(),
    }
}

/// Directed edges between places, rounded to 1e-4 mm.
fn directed_edges(vertices: &[DVec3], faces: impl Iterator<Item = Vec<usize>>) -> BTreeSet<[[i64; 3]; 2]> {
    let place = |v: usize| vertices[v].to_array().map(|x| (x * 1e4 + 0.123).round() as i64);
    let sides = |face: Vec<usize>| (0..face.len()).map(move |k| [face[k], face[(k + 1) % face.len()]]);
    faces.flat_map(sides).map(|side| side.map(place)).collect()
}

#[test]
fn refined_vertices_are_those_of_the_papers() {
    let shapes = [
        ("tetrahedron", tetrahedron()),
        ("cube", cube()),
        ("sheet", sheet()),
        ("torus", torus()),
        ("can", can(7)),
    ];
    for (name, mesh) in &shapes {
        for degrees in [180.0, 60.0, 20.0] {
            let sharp = sharp(mesh, f64::to_radians(degrees), f64::to_radians(75.0));
            let check = |scheme: far::Scheme, step: fn(&Cage) -> Cage, levels: usize| {
                let plain = (0..levels).fold(cage(mesh, &sharp), |cage, _| step(&cage));
                let ours = Refinement::new(mesh, &sharp, rules(scheme, levels, false)).unwrap();
                let places = ours.positions(&mesh.vertices);
                let what = format!("{name}, {scheme:?}, {levels} levels, creases from {degrees}°");
                assert_eq!(places.len(), plain.vertices.len(), "{what}");
                let farthest = plain
                    .vertices
                    .iter()
                    .map(|p| places.iter().map(|q| p.distance(*q)).fold(f64::MAX, f64::min));
                let worst = farthest.fold(0.0, f64::max);
                assert!(worst < 2e-6, "{what}: a vertex is {worst} mm off");
                let plain_edges = directed_edges(&plain.vertices, plain.faces.iter().cloned());
                assert_eq!(plain_edges, directed_edges(&places, ours.face_corners()), "{what}");
            };
            for levels in [1, 2] {
                check(far::Scheme::Loop, loop_step, levels);
                check(far::Scheme::CatmullClark, catmull_clark_step, levels);
            }
        }
    }
}

#[test]
fn limits_are_where_many_levels_lead() {
    let shapes = [("tetrahedron", tetrahedron()), ("cube", cube()), ("sheet", sheet()), ("can", can(5))];
    for (name, mesh) in &shapes {
        for (scheme, degrees) in [far::Scheme::Loop, far::Scheme::CatmullClark].into_iter().zip([80.0, 50.0])
        {
            // With a dart: one crease more, that ends in the open.
            let mut sharp = sharp(mesh, f64::to_radians(degrees), PI);
            sharp.creases.push([mesh.triangles[0][0], mesh.triangles[0][1]]);
            sharp.creases.sort_unstable();
            sharp.creases.dedup();
            let images = |levels: usize, to_limit: bool| {
                let refinement = Refinement::new(mesh, &sharp, rules(scheme, levels, to_limit)).unwrap();
                assert_eq!(refinement.unlimited, 0, "{name}");
                let positions = refinement.positions(&mesh.vertices);
                refinement.of_control(&positions).collect::<Vec<DVec3>>()
            };
            let (soon, late) = (images(1, true), images(7, false));
            let worst = soon.iter().zip(&late).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
            assert!(worst < 2e-3, "{name}, {scheme:?}: {worst} mm");
            let (first, second) = (images(1, true), images(2, true));
            let drift = first.iter().zip(&second).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
            assert!(drift < 3e-6, "{name}, {scheme:?}: limits of two levels differ by {drift} mm");
        }
    }
}

/// Loop: 1/2 and six times 1/12 (his thesis, §3.3). The grid's middle is regular; z alone is not linear.
#[test]
fn a_regular_vertex_has_the_known_limit() {
    let peak =
        grid(6, 6, [false; 2], |u, v| [6.0 * u, 6.0 * v, if (u, v) == (0.5, 0.5) { 12.0 } else { 0.0 }]);
    let refinement = Refinement::new(&peak, &Sharp::default(), rules(far::Scheme::Loop, 1, true)).unwrap();
    let positions = refinement.positions(&peak.vertices);
    let images: Vec<DVec3> = refinement.of_control(&positions).collect();
    assert!((images[24].z - 6.0).abs() < 1e-12, "{}", images[24]);
    for neighbour in [17, 23, 25, 31, 16, 32] {
        assert!((images[neighbour].z - 1.0).abs() < 1e-12, "{neighbour}: {}", images[neighbour]);
    }
}

fn run(mesh: &TriangleMesh, params: Params) -> Smooth {
    smooth(mesh, None, &params).unwrap()
}

const SCHEMES: [Scheme; 2] = [Scheme::Loop, Scheme::CatmullClark];

#[test]
fn a_creased_cube_stays_a_cube() {
    for scheme in SCHEMES {
        let Smooth { mesh, fate, .. } = run(&cube(), Params { scheme, levels: 3, ..Params::default() });
        assert_eq!((fate.creases, fate.corners), (12, 0), "three creases hold a corner by themselves");
        assert!((fate.volume_after_mm3 - 1000.0).abs() < 1e-9, "{fate:?}");
        assert_eq!(fate.growth_mm, DVec3::ZERO);
        let off =
            |p: &DVec3| p.to_array().iter().map(|x| x.abs().min((10.0 - x).abs())).fold(f64::MAX, f64::min);
        assert_eq!(mesh.vertices.iter().map(off).fold(0.0, f64::max), 0.0);
        let round = run(&cube(), Params { scheme, levels: 3, crease_deg: 180.0, ..Params::default() });
        assert!(round.fate.volume_after_mm3 < 700.0 && round.fate.creases == 0, "{:?}", round.fate);
    }
}

#[test]
fn a_flat_base_stays_flat_and_becomes_round() {
    for scheme in SCHEMES {
        for keep in [Keep::Nothing, Keep::Vertices] {
            let Smooth { mesh, fate, .. } =
                run(&can(12), Params { scheme, levels: 3, keep, ..Params::default() });
            assert_eq!(fate.creases, 24, "both rims and nothing else");
            let base: Vec<&DVec3> = mesh.vertices.iter().filter(|p| p.z < 1e-3).collect();
            assert!(base.len() > 50 && base.iter().all(|p| p.z == 0.0), "{scheme:?}");
            assert_eq!(mesh.bounds().unwrap().1.z, 12.0);
            // 12 sides: the polygon has 300 mm² of 314; keeping the vertices fills most of what is missing.
            let area = fate.volume_after_mm3 / 12.0;
            let range = if keep == Keep::Vertices { 310.0..316.0 } else { 280.0..300.0 };
            assert!(range.contains(&area), "{scheme:?}, {keep:?}: {area}");
        }
    }
}

/// Vertices, edges and faces as V − E + F; every edge has two triangles, one in each direction.
fn euler_of_closed(mesh: &TriangleMesh) -> i64 {
    let mut edges: BTreeMap<[u32; 2], i64> = BTreeMap::new();
    for &[a, b, c] in &mesh.triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            assert!(edges.insert([from, to], 1).is_none(), "an edge has two triangles on one side");
        }
    }
    assert!(edges.keys().all(|[a, b]| edges.contains_key(&[*b, *a])), "an edge is open");
    mesh.vertices.len() as i64 - edges.len() as i64 / 2 + mesh.triangles.len() as i64
}

#[test]
fn genus_stays() {
    for scheme in SCHEMES {
        for (mesh, euler) in [(tetrahedron(), 2), (cube(), 2), (torus(), 0), (can(9), 2), (icosahedron(), 2)]
        {
            for levels in [1, 2] {
                let params = Params { scheme, levels, ..Params::default() };
                let children = params.children() as usize;
                let smooth = run(&mesh, params);
                assert_eq!(smooth.mesh.triangles.len(), mesh.triangles.len() * children);
                assert_eq!(euler_of_closed(&smooth.mesh), euler);
                assert_eq!((smooth.fate.rim_edges, smooth.fate.unlimited), (0, 0));
            }
        }
    }
}

#[test]
fn vertices_can_keep_their_places() {
    for scheme in SCHEMES {
        for mesh in [icosahedron(), torus(), tetrahedron()] {
            let params = |keep| Params { scheme, levels: 2, crease_deg: 180.0, keep, ..Params::default() };
            let (free, kept) =
                (run(&mesh, params(Keep::Nothing)).fate, run(&mesh, params(Keep::Vertices)).fate);
            assert!(kept.kept_within_mm < 1e-3 && free.kept_within_mm > 0.5, "{free:?} {kept:?}");
            assert!(free.volume_after_mm3 < free.volume_before_mm3, "{free:?}");
            assert!(kept.volume_after_mm3 > kept.volume_before_mm3, "{kept:?}");
        }
    }
}

#[test]
fn the_size_can_be_kept() {
    for scheme in SCHEMES {
        for mesh in [icosahedron(), torus(), sheet()] {
            let params = Params { scheme, crease_deg: 180.0, keep: Keep::Size, ..Params::default() };
            let grown = run(&mesh, params).fate.growth_mm;
            assert!(grown.max_element().abs() < 1e-9 && grown.min_element() > -3.0, "{grown}");
        }
    }
}

#[test]
fn parts_travel_along() {
    let (mut mesh, mut parts) = (TriangleMesh::default(), Vec::new());
    for (label, shape, x) in [("left", cube(), 0.0), ("right", can(8), 40.0)] {
        let part = Part {
            label: label.into(),
            colour: None,
            first_triangle: mesh.triangles.len(),
            // With one that a weld makes nothing of.
            triangles: shape.triangles.len() + 1,
            volume_mm3: 1.0,
            open_edges: Some(0),
        };
        let first = mesh.vertices.len() as u32;
        mesh.vertices.extend(shape.vertices.iter().map(|v| *v + DVec3::X * x));
        mesh.triangles.push([first, first, first + 1]);
        mesh.triangles.extend(shape.triangles.iter().map(|t| t.map(|v| v + first)));
        parts.push(part);
    }
    for scheme in SCHEMES {
        let params = Params { scheme, levels: 2, ..Params::default() };
        let children = params.children() as usize;
        let smooth = smooth(&mesh, Some(Parts::new(parts.clone())), &params).unwrap();
        let [left, right] = &smooth.parts.parts[..] else { panic!("{:?}", smooth.parts) };
        assert_eq!((left.first_triangle, left.triangles), (0, 12 * children));
        assert_eq!((right.first_triangle, right.triangles), (12 * children, 32 * children));
        assert!((left.volume_mm3 - 1000.0).abs() < 1e-9 && left.label == "left");
        let of_right = &smooth.mesh.triangles[right.first_triangle..];
        assert!(of_right.iter().flatten().all(|&v| smooth.mesh.vertices[v as usize].x > 20.0));
        // Within a part the children of a triangle follow each other: those of the first lie at z = 0.
        let first = smooth.mesh.triangles[..children].iter().flatten();
        assert!(first.clone().all(|&v| smooth.mesh.vertices[v as usize].z == 0.0), "{scheme:?}");
    }
}

#[test]
fn what_cannot_be_is_refused() {
    let check = |mesh: &TriangleMesh, parts: Option<Parts>, params: Params, says: &str| {
        let error = smooth(mesh, parts, &params).unwrap_err();
        assert!(format!("{error:?}").contains(says), "{error:?} does not say {says:?}");
    };
    let deep = Params { levels: 8, max_triangles: 1000, ..Params::default() };
    check(
        &cube(),
        None,
        deep.clone(),
        "12 triangles become 786432 at levels = 8, more than max_triangles = 1000",
    );
    check(&cube(), None, deep, "levels = 3 makes 768");
    let few = Params { max_triangles: 5, ..Params::default() };
    check(&cube(), None, few, "simplify the mesh before");
    check(&TriangleMesh::default(), None, Params::default(), "no triangles");
    let speck = mesh([[1.0; 3], [2.0; 3], [1.0; 3]], &[[0, 1, 2], [2, 1, 0]]);
    check(&speck, None, Params::default(), "no triangles");
    check(&cube(), Some(Parts::new(vec![])), Params::default(), "parts are not those of the mesh");
}

/// Nothing about triangles is promised before `repair-manifold`: crowded edges, both orientations, duplicates, rims.
#[test]
fn any_soup_can_be_subdivided() {
    let mut state = 1u64;
    let mut random = move |below: u64| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) % below
    };
    for round in 0..400 {
        let vertices = 3 + random(9);
        let places: Vec<[f64; 3]> = (0..vertices).map(|_| [0; 3].map(|_| random(6) as f64)).collect();
        let corner = |random: &mut dyn FnMut(u64) -> u64| random(vertices) as u32;
        let triangles: Vec<[u32; 3]> =
            (0..1 + random(20)).map(|_| [0; 3].map(|_| corner(&mut random))).collect();
        let soup = mesh(places, &triangles);
        let params = Params {
            scheme: SCHEMES[round % 2],
            levels: 1 + (round / 2 % 2) as u32,
            crease_deg: [180.0, 30.0][round / 4 % 2],
            rims: [Rims::Smooth, Rims::Corners][round / 8 % 2],
            triangles: [TriangleWeights::Plain, TriangleWeights::Even][round / 16 % 2],
            limit: round % 3 > 0,
            keep: [Keep::Nothing, Keep::Size, Keep::Vertices][round / 32 % 3],
            ..Params::default()
        };
        let whole = soup.welded().triangles.len();
        match smooth(&soup, None, &params) {
            Ok(smooth) => {
                assert_eq!(smooth.mesh.triangles.len(), whole * params.children() as usize);
                assert!(smooth.mesh.vertices.iter().all(|v| v.is_finite()), "{soup:?} {params:?}");
            }
            Err(error) => assert!(whole == 0, "{error:?}: {soup:?} {params:?}"),
        }
    }
}
