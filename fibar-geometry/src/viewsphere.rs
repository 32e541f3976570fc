//! Geodesic spheres: directions spread evenly over the sphere, for viewpoints.
//!
//! Tone 2020 takes "the vertices of a 4-frequency dodecahedral geodesic sphere". The name is ambiguous; every reading is
//! a polyhedron and a frequency here:
//!
//! | reading | polyhedron, frequency | vertices |
//! | --- | --- | --- |
//! | faces of the pentakis dodecahedron cut in 4 (our default) | `PentakisDodecahedron`, 4 | 482 |
//! | the same, frequency counted along the icosahedron's edges (class II) | `PentakisDodecahedron`, 2 | 122 |
//! | faces of the icosahedron, the dodecahedron's dual, cut in 4 (class I) | `Icosahedron`, 4 | 162 |
//! | corners of the dual of that, pentagons and hexagons (Goldberg) | `Goldberg`, 4 | 320 |
//!
//! +Z is a two-fold axis of all of them. Only +, −, ×, ÷ and √ are used: the same bits on every machine.

use fibar_core::artefact::mesh::TriangleMesh;
use glam::DVec3;
use std::collections::BTreeMap;

/// The solid whose triangles are cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Polyhedron {
    /// 60 triangles on 32 vertices: `30 f² + 2` directions.
    PentakisDodecahedron,
    /// 20 triangles on 12 vertices: `10 f² + 2` directions.
    Icosahedron,
    /// The centres of the icosahedron's cut triangles: `20 f²` directions.
    Goldberg,
}

/// Unit vectors of the geodesic sphere whose triangles have every edge cut in `frequency` (at least 1).
pub fn geodesic_directions(polyhedron: Polyhedron, frequency: u32) -> Vec<DVec3> {
    let mesh = geodesic_mesh(polyhedron, frequency);
    if polyhedron != Polyhedron::Goldberg {
        return mesh.vertices;
    }
    let centre = |t| mesh.corners(t).into_iter().sum::<DVec3>().normalize();
    (0..mesh.triangles.len()).map(centre).collect()
}

/// The triangles of the geodesic sphere of radius 1, outward; those of the icosahedron for [`Polyhedron::Goldberg`].
pub fn geodesic_mesh(polyhedron: Polyhedron, frequency: u32) -> TriangleMesh {
    let base = match polyhedron {
        Polyhedron::PentakisDodecahedron => pentakis_dodecahedron(),
        Polyhedron::Icosahedron | Polyhedron::Goldberg => icosahedron(),
    };
    cut(&base, frequency.max(1))
}

fn icosahedron() -> TriangleMesh {
    let golden = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let signs = [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)];
    let vertices: Vec<DVec3> = signs
        .iter()
        .flat_map(|&(a, b)| {
            let (a, b) = (a, b * golden);
            [DVec3::new(0.0, a, b), DVec3::new(a, b, 0.0), DVec3::new(b, 0.0, a)]
        })
        .collect();
    // Edges have length 2, the next longer distance is 2·golden.
    let touch = |i: usize, j: usize| vertices[i].distance_squared(vertices[j]) < 5.0;
    let mut triangles = Vec::new();
    for i in 0..12 {
        for j in (i + 1..12).filter(|&j| touch(i, j)) {
            triangles.extend((j + 1..12).filter(|&k| touch(i, k) && touch(j, k)).map(|k| [i, j, k]));
        }
    }
    let outward = |t: [usize; 3]| outward([t[0] as u32, t[1] as u32, t[2] as u32], &vertices);
    let triangles = triangles.into_iter().map(outward).collect();
    TriangleMesh { vertices: vertices.iter().map(|v| v.normalize()).collect(), triangles }
}

/// Each edge of the icosahedron, with the centres of its two faces, gives two of the sixty triangles.
fn pentakis_dodecahedron() -> TriangleMesh {
    let base = icosahedron();
    let mut vertices = base.vertices.clone();
    let mut faces_of_edge = BTreeMap::<[u32; 2], Vec<u32>>::new();
    for (face, &[a, b, c]) in base.triangles.iter().enumerate() {
        let centre = vertices.len() as u32;
        vertices.push(base.corners(face).into_iter().sum::<DVec3>().normalize());
        for [i, j] in [[a, b], [b, c], [c, a]] {
            faces_of_edge.entry([i.min(j), i.max(j)]).or_default().push(centre);
        }
    }
    let halves = faces_of_edge.iter().flat_map(|(&[i, j], f)| [[i, f[0], f[1]], [j, f[0], f[1]]]);
    let triangles = halves.map(|t| outward(t, &vertices)).collect();
    TriangleMesh { vertices, triangles }
}

/// The triangle, turned so that it is counter-clockwise seen from outside.
fn outward([a, b, c]: [u32; 3], vertices: &[DVec3]) -> [u32; 3] {
    let [p, q, r] = [a, b, c].map(|v| vertices[v as usize]);
    if (q - p).cross(r - p).dot(p) > 0.0 { [a, b, c] } else { [a, c, b] }
}

/// Cuts every edge in `f` and pushes the new vertices out to the sphere.
fn cut(base: &TriangleMesh, f: u32) -> TriangleMesh {
    let mut grid = Grid { base, frequency: f, index: BTreeMap::new(), vertices: Vec::new() };
    let mut triangles = Vec::new();
    for &corners in &base.triangles {
        for i in 0..f {
            for j in 0..f - i {
                let mut at = |i: u32, j: u32| grid.vertex(corners, [i, j, f - i - j]);
                let [a, b, c] = [at(i + 1, j), at(i, j + 1), at(i, j)];
                triangles.push([a, b, c]);
                if i + j + 1 < f {
                    triangles.push([a, at(i + 1, j + 1), b]);
                }
            }
        }
    }
    TriangleMesh { vertices: grid.vertices, triangles }
}

/// The vertices made so far, found again by their exact place: which corners, with which whole weights.
struct Grid<'a> {
    base: &'a TriangleMesh,
    frequency: u32,
    index: BTreeMap<Vec<(u32, u32)>, u32>,
    vertices: Vec<DVec3>,
}

impl Grid<'_> {
    fn vertex(&mut self, corners: [u32; 3], weights: [u32; 3]) -> u32 {
        let mut place: Vec<(u32, u32)> = std::iter::zip(corners, weights).filter(|(_, w)| *w > 0).collect();
        place.sort_unstable();
        let f = f64::from(self.frequency);
        let weighted = |&(v, w): &(u32, u32)| self.base.vertices[v as usize] * (f64::from(w) / f);
        let point = place.iter().map(weighted).sum::<DVec3>().normalize();
        *self.index.entry(place).or_insert_with(|| {
            self.vertices.push(point);
            self.vertices.len() as u32 - 1
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_reading_has_its_count() {
        let check = |polyhedron, frequency, count| {
            assert_eq!(geodesic_directions(polyhedron, frequency).len(), count, "{polyhedron:?} {frequency}");
        };
        check(Polyhedron::PentakisDodecahedron, 1, 32);
        check(Polyhedron::PentakisDodecahedron, 2, 122);
        check(Polyhedron::PentakisDodecahedron, 4, 482);
        check(Polyhedron::Icosahedron, 1, 12);
        check(Polyhedron::Icosahedron, 4, 162);
        check(Polyhedron::Goldberg, 4, 320);
        check(Polyhedron::Goldberg, 1, 20);
    }

    #[test]
    fn spheres_are_closed_round_and_balanced() {
        for (polyhedron, frequency) in
            [(Polyhedron::PentakisDodecahedron, 4), (Polyhedron::Icosahedron, 5), (Polyhedron::Goldberg, 3)]
        {
            let mesh = geodesic_mesh(polyhedron, frequency);
            let mut edges = BTreeMap::<[u32; 2], i32>::new();
            for &[a, b, c] in &mesh.triangles {
                for [i, j] in [[a, b], [b, c], [c, a]] {
                    *edges.entry([i.min(j), i.max(j)]).or_default() += if i < j { 1 } else { -1 };
                }
            }
            assert!(edges.values().all(|&turns| turns == 0), "closed and oriented");
            assert_eq!(mesh.vertices.len() + mesh.triangles.len(), edges.len() + 2, "Euler");
            let volume: f64 = (0..mesh.triangles.len())
                .map(|t| mesh.corners(t))
                .map(|[p, q, r]| p.dot(q.cross(r)) / 6.0)
                .sum();
            assert!((3.8..4.19).contains(&volume), "{polyhedron:?}: {volume}");
            let directions = geodesic_directions(polyhedron, frequency);
            assert!(directions.iter().all(|d| (d.length() - 1.0).abs() < 1e-12));
            let sum: DVec3 = directions.iter().sum();
            assert!(sum.length() < 1e-9, "{sum}");
        }
    }
}
