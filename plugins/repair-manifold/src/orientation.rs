//! Neighbours that agree on what is outside.
//!
//! Triangles are joined over edges that exactly two of them share. A shell that agrees with itself keeps its orientation,
//! cavities included; one that does not is turned so that it encloses a positive volume. A body that is inside out as a
//! whole is turned over.

use fibar_core::artefact::mesh::TriangleMesh;
use std::collections::BTreeMap;

/// Turns triangles so that neighbours agree; returns how many were turned.
pub fn orient(mesh: &mut TriangleMesh) -> usize {
    let before = mesh.triangles.clone();
    for shell in shells(mesh) {
        turn_shell(mesh, &shell);
    }
    if signed_volume(mesh, 0..mesh.triangles.len()) < 0.0 {
        mesh.triangles.iter_mut().for_each(turn);
    }
    before.iter().zip(&mesh.triangles).filter(|(a, b)| a != b).count()
}

/// Volume enclosed by some triangles, mm³, negative when they are inside out; meaningful for closed sets.
pub fn signed_volume(mesh: &TriangleMesh, triangles: impl IntoIterator<Item = usize>) -> f64 {
    let tetrahedron = |t| {
        let [a, b, c] = mesh.corners(t);
        a.dot(b.cross(c)) / 6.0
    };
    triangles.into_iter().map(tetrahedron).sum()
}

/// Triangles joined with each other, each with whether it must turn to agree with the first of its shell.
type Shell = Vec<(usize, bool)>;

fn turn_shell(mesh: &mut TriangleMesh, shell: &Shell) {
    let disagreeing = shell.iter().filter(|(_, turned)| *turned).count();
    if disagreeing == 0 {
        return;
    }
    shell.iter().filter(|(_, turned)| *turned).for_each(|&(t, _)| turn(&mut mesh.triangles[t]));
    if signed_volume(mesh, shell.iter().map(|&(t, _)| t)) < 0.0 {
        shell.iter().for_each(|&(t, _)| turn(&mut mesh.triangles[t]));
    }
}

fn turn(triangle: &mut [u32; 3]) {
    triangle.swap(1, 2);
}

fn shells(mesh: &TriangleMesh) -> Vec<Shell> {
    let neighbours = neighbours(mesh);
    let mut seen = vec![false; mesh.triangles.len()];
    let mut shells = Vec::new();
    for first in 0..mesh.triangles.len() {
        if !seen[first] {
            seen[first] = true;
            let mut shell = vec![(first, false)];
            let mut next = 0;
            while let Some(&(triangle, turned)) = shell.get(next) {
                next += 1;
                for &(other, disagrees) in &neighbours[triangle] {
                    if !seen[other] {
                        seen[other] = true;
                        shell.push((other, turned != disagrees));
                    }
                }
            }
            shells.push(shell);
        }
    }
    shells
}

/// For each triangle those that share an edge with it alone, and whether the two run along it in the same direction.
fn neighbours(mesh: &TriangleMesh) -> Vec<Vec<(usize, bool)>> {
    let mut edges: BTreeMap<[u32; 2], Vec<(usize, bool)>> = BTreeMap::new();
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (triangle[k], triangle[(k + 1) % 3]);
            edges.entry([a.min(b), a.max(b)]).or_default().push((t, a < b));
        }
    }
    let mut neighbours = vec![Vec::new(); mesh.triangles.len()];
    for users in edges.values() {
        if let [(one, forward), (other, also_forward)] = users[..] {
            let disagree = forward == also_forward;
            neighbours[one].push((other, disagree));
            neighbours[other].push((one, disagree));
        }
    }
    neighbours
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn tetrahedron(scale: f64) -> TriangleMesh {
        TriangleMesh {
            vertices: [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z].map(|v| v * scale).to_vec(),
            triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
        }
    }

    #[test]
    fn any_set_of_turned_triangles_is_found() {
        for mask in 0..16usize {
            let mut mesh = tetrahedron(1.0);
            (0..4).filter(|k| mask >> k & 1 == 1).for_each(|k| turn(&mut mesh.triangles[k]));
            let flipped = orient(&mut mesh);
            assert_eq!(flipped, mask.count_ones() as usize, "mask {mask}");
            assert_eq!(mesh, tetrahedron(1.0), "mask {mask}");
        }
    }

    #[test]
    fn a_cavity_stays_a_cavity() {
        let mut mesh = tetrahedron(3.0);
        let mut inner = tetrahedron(-1.0);
        inner.vertices.iter_mut().for_each(|v| *v += DVec3::splat(0.7));
        mesh.vertices.extend(inner.vertices);
        mesh.triangles.extend(inner.triangles.iter().map(|t| t.map(|v| v + 4)));
        let expected = mesh.clone();
        assert_eq!(orient(&mut mesh), 0);
        mesh.triangles.iter_mut().for_each(turn);
        assert_eq!(orient(&mut mesh), 8, "inside out as a whole");
        assert_eq!(mesh, expected);
    }
}
