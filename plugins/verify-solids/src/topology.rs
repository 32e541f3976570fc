//! How a mesh hangs together: open edges, shells, holes through it, enclosed volume.

use fibar_core::artefact::mesh::TriangleMesh;
use glam::DVec3;

/// What can be counted on a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Topology {
    /// Directed edges that occur more than once, or whose opposite does not occur: none on a closed, oriented manifold.
    pub bad_edges: usize,
    /// The middle of one of them, mm.
    pub bad_place: Option<DVec3>,
    /// Connected shells that enclose material: the pieces that the solid falls into.
    pub components: usize,
    /// Connected shells that enclose a hollow.
    pub cavities: usize,
    /// Sum of the genus of all shells: holes through the solid and its hollows.
    pub genus: i64,
    /// Volume of the smallest component, mm³.
    pub smallest_mm3: f64,
    /// Enclosed volume by the divergence theorem, mm³.
    pub volume_mm3: f64,
}

impl Topology {
    /// Counts.
    pub fn of(mesh: &TriangleMesh) -> Topology {
        let (bad_edges, bad_place) = bad_edges(mesh);
        let shells = shell_volumes(mesh);
        let edges = mesh.triangles.len() as i64 * 3 / 2;
        let euler = used_vertices(mesh) as i64 - edges + mesh.triangles.len() as i64;
        let components = shells.iter().filter(|v| **v > 0.0);
        Topology {
            bad_edges,
            bad_place,
            components: components.clone().count(),
            cavities: shells.iter().filter(|v| **v < 0.0).count(),
            genus: shells.len() as i64 - euler / 2,
            smallest_mm3: components.copied().fold(f64::INFINITY, f64::min),
            volume_mm3: shells.iter().sum(),
        }
    }
}

/// Enclosed volume, mm³ (divergence theorem, about the mesh's first vertex).
pub fn volume(mesh: &TriangleMesh) -> f64 {
    (0..mesh.triangles.len()).map(|t| cone(mesh, t)).sum()
}

fn cone(mesh: &TriangleMesh, triangle: usize) -> f64 {
    let apex = mesh.vertices[0];
    let [a, b, c] = mesh.corners(triangle).map(|v| v - apex);
    a.dot(b.cross(c)) / 6.0
}

fn bad_edges(mesh: &TriangleMesh) -> (usize, Option<DVec3>) {
    let edges = mesh.triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
    let mut forward: Vec<(u32, u32)> = edges.collect();
    let mut backward: Vec<(u32, u32)> = forward.iter().map(|&(a, b)| (b, a)).collect();
    forward.sort_unstable();
    backward.sort_unstable();
    let repeated = forward.windows(2).filter(|pair| pair[0] == pair[1]).map(|pair| pair[0]);
    let unmatched = forward.iter().filter(|edge| backward.binary_search(edge).is_err()).copied();
    let bad: Vec<(u32, u32)> = repeated.chain(unmatched).collect();
    let middle = |&(a, b): &(u32, u32)| mesh.vertices[a as usize].midpoint(mesh.vertices[b as usize]);
    (bad.len(), bad.first().map(middle))
}

/// Signed volume of every connected shell, in the order of their first vertices.
fn shell_volumes(mesh: &TriangleMesh) -> Vec<f64> {
    let mut parents: Vec<u32> = (0..mesh.vertices.len() as u32).collect();
    for &[a, b, c] in &mesh.triangles {
        join(&mut parents, a, b);
        join(&mut parents, b, c);
    }
    let mut volumes = vec![None; mesh.vertices.len()];
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        let shell = root(&mut parents, triangle[0]) as usize;
        *volumes[shell].get_or_insert(0.0) += cone(mesh, t);
    }
    volumes.into_iter().flatten().collect()
}

fn join(parents: &mut [u32], a: u32, b: u32) {
    let (a, b) = (root(parents, a), root(parents, b));
    parents[a.max(b) as usize] = a.min(b);
}

fn root(parents: &mut [u32], mut v: u32) -> u32 {
    while parents[v as usize] != v {
        parents[v as usize] = parents[parents[v as usize] as usize];
        v = parents[v as usize];
    }
    v
}

fn used_vertices(mesh: &TriangleMesh) -> usize {
    let mut used = vec![false; mesh.vertices.len()];
    mesh.triangles.iter().flatten().for_each(|v| used[*v as usize] = true);
    used.into_iter().filter(|used| *used).count()
}

#[cfg(test)]
pub mod tests {
    //! Boxes to check.

    use super::*;

    /// The box between two corners.
    pub fn cuboid(low: DVec3, high: DVec3) -> TriangleMesh {
        let corner = |k: u32| {
            let [x, y, z] = [k & 1, k >> 1 & 1, k >> 2].map(f64::from);
            low + (high - low) * DVec3::new(x, y, z)
        };
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let halves = |[a, b, c, d]: [u32; 4]| [[a, b, c], [a, c, d]];
        TriangleMesh {
            vertices: (0..8).map(corner).collect(),
            triangles: quads.into_iter().flat_map(halves).collect(),
        }
    }

    /// Several meshes as one; the second one turned inside out makes a hollow.
    pub fn together(meshes: &[TriangleMesh]) -> TriangleMesh {
        let mut whole = TriangleMesh::default();
        for mesh in meshes {
            let start = whole.vertices.len() as u32;
            whole.vertices.extend(&mesh.vertices);
            whole.triangles.extend(mesh.triangles.iter().map(|t| t.map(|v| v + start)));
        }
        whole
    }

    /// The same surface seen from the other side.
    pub fn inside_out(mut mesh: TriangleMesh) -> TriangleMesh {
        mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        mesh
    }

    fn cube(size: f64) -> TriangleMesh {
        cuboid(DVec3::splat(-size), DVec3::splat(size))
    }

    #[track_caller]
    fn check(mesh: &TriangleMesh, components: usize, cavities: usize, genus: i64, volume_mm3: f64) {
        let found = Topology::of(mesh);
        assert_eq!((found.components, found.cavities, found.genus), (components, cavities, genus));
        assert!((found.volume_mm3 - volume_mm3).abs() < 1e-9);
        assert_eq!(found.bad_edges, 0);
    }

    #[test]
    fn boxes_and_hollow_boxes() {
        check(&cube(1.0), 1, 0, 0, 8.0);
        check(&together(&[cube(2.0), inside_out(cube(1.0))]), 1, 1, 0, 56.0);
        let far = cuboid(DVec3::splat(5.0), DVec3::splat(6.0));
        check(&together(&[cube(1.0), far]), 2, 0, 0, 9.0);
    }

    #[test]
    fn broken_boxes() {
        let mut open = cube(1.0);
        open.triangles.pop();
        assert_eq!(Topology::of(&open).bad_edges, 3);
        let mut flipped = cube(1.0);
        flipped.triangles[0].swap(0, 1);
        assert_eq!(Topology::of(&flipped).bad_edges, 9);
        let mut doubled = cube(1.0);
        doubled.triangles.push(doubled.triangles[0]);
        assert_eq!(Topology::of(&doubled).bad_edges, 3);
    }
}
