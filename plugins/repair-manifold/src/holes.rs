//! Holes: closed rims of half-edges without a twin, and the caps that close them.

use crate::cap::cap;
use crate::edges::{next, origin};
use crate::sheets::{OPEN, Sheets};
use fibar_core::artefact::mesh::TriangleMesh;
use glam::DVec3;

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

    /// Closes it; returns the area of the cap, mm².
    pub fn close(&self, mesh: &mut TriangleMesh) -> f64 {
        let places: Vec<DVec3> = self.rim.iter().map(|&v| mesh.vertices[v as usize]).collect();
        let first = mesh.triangles.len();
        mesh.triangles.extend(cap(&places).into_iter().map(|t| t.map(|k| self.rim[k])));
        let area = |t: usize| {
            let [a, b, c] = mesh.corners(t);
            (b - a).cross(c - a).length() / 2.0
        };
        (first..mesh.triangles.len()).map(area).sum()
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
        holes.iter().for_each(|hole| {
            hole.close(&mut mesh);
        });
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
