//! Which shell lies inside which, and so which are bodies and which cavities.
//!
//! A shell that lies in no other encloses material. Deeper ones keep the side they came with, cavity or body, unless the
//! outermost was inside out: then all that alternated with it are turned with it.

use crate::orientation::turn;
use crate::sheets::Sheets;
use crate::volume::{area_of, signed_volume_of};
use fibar_core::artefact::mesh::TriangleMesh;
use glam::DVec3;

/// A closed part of the surface.
#[derive(Clone, Debug)]
pub struct Shell {
    /// Its triangles.
    pub triangles: Vec<u32>,
    /// Volume it encloses, mm³; negative for a cavity.
    pub volume: f64,
    /// Number of the smallest shell around it.
    pub parent: Option<usize>,
    bounds: [DVec3; 2],
}

/// The shells of a mesh, after turning those that were inside out.
pub struct Nesting {
    /// In the order of their first triangles.
    pub shells: Vec<Shell>,
    /// Shells that were turned.
    pub turned: usize,
    /// Shells that enclosed nothing, as they were folded flat, and were taken away.
    pub flat: usize,
}

impl Nesting {
    /// Nests the shells of closed sheets; turns and removes triangles of the mesh accordingly.
    pub fn of(sheets: &Sheets, mesh: &mut TriangleMesh) -> Nesting {
        let mut shells: Vec<Shell> = sheets.shells().into_iter().map(|t| Shell::of(mesh, t)).collect();
        let all = shells.len();
        let flat = remove_flat(&mut shells, mesh);
        nest(&mut shells, mesh);
        let turned = turn_shells(&mut shells, mesh);
        debug_assert_eq!(all, shells.len() + flat);
        Nesting { shells, turned, flat }
    }
}

impl Shell {
    fn of(mesh: &TriangleMesh, triangles: Vec<u32>) -> Shell {
        let volume = signed_volume_of(mesh, triangles.iter().copied());
        let corners = triangles.iter().flat_map(|&t| mesh.corners(t as usize));
        let ends = corners.fold(None, |ends: Option<[DVec3; 2]>, v| {
            let [low, high] = ends.unwrap_or([v; 2]);
            Some([low.min(v), high.max(v)])
        });
        Shell { triangles, volume, parent: None, bounds: ends.unwrap_or_default() }
    }

    /// Whether its box and another's have a point in common.
    pub fn may_touch(&self, other: &Shell) -> bool {
        self.bounds[0].cmple(other.bounds[1]).all() && other.bounds[0].cmple(self.bounds[1]).all()
    }

    fn size(&self) -> f64 {
        self.bounds[0].distance(self.bounds[1])
    }

    /// Whether a point lies inside, by the solid angle that the shell fills (van Oosterom & Strackee 1983).
    fn encloses(&self, point: DVec3, mesh: &TriangleMesh) -> bool {
        let within = point.cmpge(self.bounds[0]).all() && point.cmple(self.bounds[1]).all();
        let angle = |t: &u32| {
            let [a, b, c] = mesh.corners(*t as usize).map(|corner| corner - point);
            let (la, lb, lc) = (a.length(), b.length(), c.length());
            let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
            2.0 * libm::atan2(a.dot(b.cross(c)), below)
        };
        within && self.triangles.iter().map(angle).sum::<f64>().abs() > 2.0 * std::f64::consts::PI
    }
}

/// Takes away shells whose volume is rounding compared with their area.
fn remove_flat(shells: &mut Vec<Shell>, mesh: &mut TriangleMesh) -> usize {
    const ROUNDING: f64 = 1e-9;
    let is_flat = |shell: &Shell, mesh: &TriangleMesh| {
        shell.volume.abs() <= ROUNDING * area_of(mesh, shell.triangles.iter().copied()) * shell.size()
    };
    let (flat, kept): (Vec<Shell>, Vec<Shell>) =
        std::mem::take(shells).into_iter().partition(|shell| is_flat(shell, mesh));
    if flat.is_empty() {
        *shells = kept;
        return 0;
    }
    let mut numbers: Vec<u32> = Vec::new();
    for shell in kept {
        let first = numbers.len() as u32;
        numbers.extend(&shell.triangles);
        shells.push(Shell { triangles: (first..numbers.len() as u32).collect(), ..shell });
    }
    mesh.triangles = numbers.into_iter().map(|t| mesh.triangles[t as usize]).collect();
    flat.len()
}

fn nest(shells: &mut [Shell], mesh: &TriangleMesh) {
    for k in 0..shells.len() {
        let sample = mesh.corners(shells[k].triangles[0] as usize)[0];
        let around = (0..shells.len()).filter(|&other| {
            other != k
                && shells[other].volume.abs() > shells[k].volume.abs()
                && shells[other].encloses(sample, mesh)
        });
        let smallest = around.min_by(|&a, &b| shells[a].volume.abs().total_cmp(&shells[b].volume.abs()));
        shells[k].parent = smallest;
    }
}

/// Turns what is inside out; returns how many shells.
fn turn_shells(shells: &mut [Shell], mesh: &mut TriangleMesh) -> usize {
    // Larger ones first: a parent is judged before its children.
    let mut order: Vec<usize> = (0..shells.len()).collect();
    order.sort_by(|&a, &b| shells[b].volume.abs().total_cmp(&shells[a].volume.abs()).then(a.cmp(&b)));
    let came: Vec<bool> = shells.iter().map(|shell| shell.volume > 0.0).collect();
    let mut turned = vec![false; shells.len()];
    for k in order {
        turned[k] = match shells[k].parent {
            None => !came[k],
            Some(parent) if turned[parent] => came[k] != came[parent],
            // A cavity within a cavity bounds nothing: it must be a body.
            Some(parent) => !came[k] && shells[parent].volume < 0.0,
        };
        if turned[k] {
            shells[k].triangles.iter().for_each(|&t| turn(&mut mesh.triangles[t as usize]));
            shells[k].volume = -shells[k].volume;
        }
    }
    turned.into_iter().filter(|&turned| turned).count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{ball, block, inverted, moved, octahedron, together};
    use crate::volume::signed_volume;

    /// Shells turned, shells left, and the volume they enclose together.
    fn check(parts: &[TriangleMesh], [turned, left]: [usize; 2], volume: f64) {
        let mut mesh = together(parts);
        let nesting = Nesting::of(&Sheets::of(&mesh), &mut mesh);
        assert_eq!([nesting.turned, nesting.shells.len()], [turned, left]);
        assert!((signed_volume(&mesh) - volume).abs() < 1e-9 * volume, "{}", signed_volume(&mesh));
        assert!((nesting.shells.iter().map(|s| s.volume).sum::<f64>() - volume).abs() < 1e-9 * volume);
    }

    #[test]
    fn outermost_shells_enclose_material() {
        let cube = |half: f64| block([-half; 3], [half; 3]);
        check(&[cube(1.0)], [0, 1], 8.0);
        check(&[inverted(cube(1.0))], [1, 1], 8.0);
        check(&[moved(cube(1.0), [5.0, 0.0, 0.0]), inverted(cube(1.0))], [1, 2], 16.0);
        let hollow = [cube(2.0), inverted(cube(1.0))];
        check(&hollow, [0, 2], 56.0);
        check(&hollow.clone().map(inverted), [2, 2], 56.0);
        check(&[inverted(cube(2.0)), inverted(cube(1.0))], [1, 2], 56.0);
        check(&[cube(3.0), inverted(cube(2.0)), cube(1.0)], [0, 3], 216.0 - 64.0 + 8.0);
        check(&[cube(3.0), inverted(cube(2.0)), inverted(cube(1.0))], [1, 3], 216.0 - 64.0 + 8.0);
        check(&[inverted(cube(3.0)), cube(2.0), inverted(cube(1.0))], [3, 3], 216.0 - 64.0 + 8.0);
        check(
            &[octahedron(1.0), inverted(moved(ball(0.1, 3), [5.0, 0.0, 0.0]))],
            [1, 2],
            4.0 / 3.0 + signed_volume(&ball(0.1, 3)),
        );
    }

    #[test]
    fn what_is_folded_flat_goes() {
        let mut flat = octahedron(1.0);
        flat.vertices.iter_mut().for_each(|v| v.z = 0.0);
        check(&[flat, octahedron(1.0)], [0, 1], 4.0 / 3.0);
    }
}
