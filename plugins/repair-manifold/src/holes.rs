//! Holes: closed rims of half-edges without a twin, and the caps that close them.
//!
//! Rims in one plane, one within the other and running the other way, are closed together by what lies between them; a rim that the
//! surface runs smoothly into gets a bulge; any other its cap of least area.

use crate::bulge::{Stars, bulge};
use crate::cap::cap;
use crate::drawing::{Plane, fill, is_inside};
use crate::edges::origin;
use crate::sheets::Sheets;
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_geometry::half_edges::{OPEN, next};
use glam::{DVec2, DVec3};

/// A hole in a sheet.
#[derive(Clone, Debug, PartialEq)]
pub struct Hole {
    /// Vertices around it, in the direction in which its cap runs along the rim.
    pub rim: Vec<u32>,
    /// The middle of its rim, mm.
    pub middle: DVec3,
    /// Greatest distance of the rim from its middle, mm.
    pub radius: f64,
}

/// The holes of a mesh, in the order of their first half-edges.
pub fn holes(sheets: &Sheets) -> Vec<Hole> {
    let mut seen = vec![false; sheets.twins.len()];
    let open = (0..sheets.twins.len() as u32).filter(|&h| sheets.twins[h as usize] == OPEN);
    let mut holes = Vec::new();
    for first in open {
        if !seen[first as usize] {
            holes.push(Hole::along(first, sheets, &mut seen));
        }
    }
    holes
}

/// Closes holes; returns the area of all caps, mm².
pub fn close_all(holes: &[Hole], mesh: &mut TriangleMesh) -> f64 {
    let first = mesh.triangles.len();
    let within = within(holes, mesh);
    let stars = if holes.iter().any(|hole| hole.rim.len() > 3) {
        Stars::of(mesh)
    } else {
        Stars::of(&TriangleMesh::default())
    };
    let sound = mesh.clone();
    for (number, hole) in holes.iter().enumerate().filter(|(number, _)| within[*number].is_none()) {
        let inner: Vec<&Hole> =
            (0..holes.len()).filter(|&k| within[k] == Some(number)).map(|k| &holes[k]).collect();
        if !inner.is_empty() && hole.close_between(&inner, mesh) {
            continue;
        }
        inner.iter().for_each(|hole| hole.close(mesh));
        if hole.rim.len() <= 3 || !hole.close_smoothly(&sound, &stars, mesh) {
            hole.close(mesh);
        }
    }
    let area = |t: usize| {
        let [a, b, c] = mesh.corners(t);
        (b - a).cross(c - a).length() / 2.0
    };
    (first..mesh.triangles.len()).map(area).sum()
}

/// For each hole the smallest one around it in the same plane, that runs the other way.
fn within(holes: &[Hole], mesh: &TriangleMesh) -> Vec<Option<usize>> {
    const FLAT: f64 = 1e-4;
    let places = |hole: &Hole| hole.rim.iter().map(|&v| mesh.vertices[v as usize]).collect::<Vec<DVec3>>();
    let is_flat = |plane: &Plane, hole: &Hole, reach: f64| {
        hole.rim.iter().all(|&v| plane.draw(mesh.vertices[v as usize]).1.abs() <= FLAT * reach)
    };
    let planes: Vec<Option<(Plane, f64)>> = holes
        .iter()
        .map(|hole| Plane::of(&places(hole)).filter(|(plane, _)| is_flat(plane, hole, hole.radius)))
        .collect();
    let rings: Vec<Vec<DVec2>> = holes
        .iter()
        .zip(&planes)
        .map(|(hole, plane)| {
            plane.map_or_else(Vec::new, |(plane, _)| places(hole).iter().map(|&p| plane.draw(p).0).collect())
        })
        .collect();
    let is_around = |outer: usize, inner: usize| {
        let (Some((plane, area)), Some((other, small))) = (planes[outer], planes[inner]) else {
            return false;
        };
        area > small
            && plane.normal.dot(other.normal) < -0.999
            && is_flat(&plane, &holes[inner], holes[outer].radius)
            && is_inside(&rings[outer], plane.draw(mesh.vertices[holes[inner].rim[0] as usize]).0)
    };
    let area = |k: usize| planes[k].map_or(0.0, |(_, area)| area);
    let smallest = |inner: usize| {
        let around = (0..holes.len()).filter(|&outer| outer != inner && is_around(outer, inner));
        around.min_by(|&a, &b| area(a).total_cmp(&area(b)))
    };
    let flat: Vec<bool> = planes.iter().map(Option::is_some).collect();
    (0..holes.len()).map(|inner| if flat[inner] { smallest(inner) } else { None }).collect()
}

impl Hole {
    fn along(first: u32, sheets: &Sheets, seen: &mut [bool]) -> Hole {
        let mut rim = Vec::new();
        let mut at = first;
        while !std::mem::replace(&mut seen[at as usize], true) {
            rim.push(origin(&sheets.mesh, at));
            at = next_open(at, &sheets.twins);
        }
        // The cap lies on the other side of the rim's edges.
        rim.reverse();
        let places = || rim.iter().map(|&v| sheets.mesh.vertices[v as usize]);
        let middle = places().sum::<DVec3>() / rim.len() as f64;
        let radius = places().map(|place| place.distance(middle)).fold(0.0, f64::max);
        Hole { rim, middle, radius }
    }

    /// Closes it by the cap of least area.
    fn close(&self, mesh: &mut TriangleMesh) {
        let places: Vec<DVec3> = self.rim.iter().map(|&v| mesh.vertices[v as usize]).collect();
        mesh.triangles.extend(cap(&places).into_iter().map(|t| t.map(|k| self.rim[k])));
    }

    /// Closes it and holes in it by what lies between them in one plane; false if that cannot be drawn.
    fn close_between(&self, inner: &[&Hole], mesh: &mut TriangleMesh) -> bool {
        let rims: Vec<&Vec<u32>> =
            std::iter::once(&self.rim).chain(inner.iter().map(|hole| &hole.rim)).collect();
        let places = |rim: &[u32]| rim.iter().map(|&v| mesh.vertices[v as usize]).collect::<Vec<DVec3>>();
        let Some((plane, _)) = Plane::of(&places(&self.rim)) else { return false };
        let rings: Vec<Vec<DVec2>> = rims
            .iter()
            .map(|rim| places(rim).into_iter().map(|place| plane.draw(place).0).collect())
            .collect();
        let Some(triangles) = fill(&rings, &[]) else { return false };
        let all: Vec<u32> = rims.into_iter().flatten().copied().collect();
        mesh.triangles.extend(triangles.into_iter().map(|t| t.map(|k| all[k])));
        true
    }

    /// Closes it by a bulge, if the surface runs into it.
    fn close_smoothly(&self, sound: &TriangleMesh, stars: &Stars, mesh: &mut TriangleMesh) -> bool {
        let Some((vertices, triangles)) = bulge(sound, &self.rim, stars) else { return false };
        let first = mesh.vertices.len();
        mesh.vertices.extend(vertices);
        let number =
            |k: usize| if k < self.rim.len() { self.rim[k] } else { (first + k - self.rim.len()) as u32 };
        mesh.triangles.extend(triangles.into_iter().map(|t| t.map(number)));
        true
    }
}

/// The open half-edge that starts where another ends, around the same fan.
fn next_open(half_edge: u32, twins: &[u32]) -> u32 {
    let mut at = next(half_edge);
    while twins[at as usize] != OPEN {
        at = next(twins[at as usize]);
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::octahedron;
    use crate::volume::signed_volume;

    /// Lengths of the rims of an octahedron without some faces; closed, it has this volume.
    fn check(missing: &[usize], rims: &[usize], volume: f64) {
        let mut mesh = octahedron(1.0);
        let keep = (0..8).filter(|k| !missing.contains(k));
        mesh.triangles = keep.map(|k| octahedron(1.0).triangles[k]).collect();
        let sheets = Sheets::of(&mesh);
        let holes = holes(&sheets);
        assert_eq!(holes.iter().map(|hole| hole.rim.len()).collect::<Vec<_>>(), rims);
        let mut mesh = sheets.mesh;
        close_all(&holes, &mut mesh);
        assert!(Sheets::of(&mesh).is_closed());
        assert!((signed_volume(&mesh) - volume).abs() < 1e-12, "{missing:?}");
    }

    #[test]
    fn holes_are_found_and_closed() {
        check(&[], &[], 4.0 / 3.0);
        check(&[3], &[3], 4.0 / 3.0);
        check(&[0, 1], &[4], 4.0 / 3.0);
        check(&[0, 6], &[3, 3], 4.0 / 3.0);
        check(&[0, 1, 2, 3], &[4], 2.0 / 3.0);
    }
}
