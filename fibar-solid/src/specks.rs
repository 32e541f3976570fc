//! Shells of a mesh too small to matter: flakes and cavities that rounding leaves where solids nearly touch.

use fibar_core::artefact::mesh::TriangleMesh;

/// The mesh without shells that enclose less than `volume` mm³, or `None` when there are none.
pub fn drop_specks(mesh: &TriangleMesh, volume: f64) -> Option<TriangleMesh> {
    let shell_of = label_shells(mesh);
    let mut volumes = vec![0.0; mesh.vertices.len()];
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        let [a, b, c] = mesh.corners(t);
        volumes[shell_of[triangle[0] as usize]] += a.dot(b.cross(c)) / 6.0;
    }
    let is_speck = |triangle: &&[u32; 3]| volumes[shell_of[triangle[0] as usize]].abs() < volume;
    if !mesh.triangles.iter().any(|triangle| is_speck(&triangle)) {
        return None;
    }
    let triangles = mesh.triangles.iter().filter(|triangle| !is_speck(triangle)).copied().collect();
    Some(drop_unused_vertices(&mesh.vertices, triangles))
}

/// For each vertex the least vertex of its shell.
fn label_shells(mesh: &TriangleMesh) -> Vec<usize> {
    let mut parent: Vec<usize> = (0..mesh.vertices.len()).collect();
    for &[a, b, c] in &mesh.triangles {
        for other in [b, c] {
            let (one, other) = (root(&mut parent, a as usize), root(&mut parent, other as usize));
            parent[one.max(other)] = one.min(other);
        }
    }
    (0..parent.len()).map(|v| root(&mut parent, v)).collect()
}

fn root(parent: &mut [usize], mut vertex: usize) -> usize {
    while parent[vertex] != vertex {
        parent[vertex] = parent[parent[vertex]];
        vertex = parent[vertex];
    }
    vertex
}

fn drop_unused_vertices(vertices: &[glam::DVec3], triangles: Vec<[u32; 3]>) -> TriangleMesh {
    let mut numbers = vec![None; vertices.len()];
    let mut kept = Vec::new();
    let mut number = |v: u32| {
        *numbers[v as usize].get_or_insert_with(|| {
            kept.push(vertices[v as usize]);
            kept.len() as u32 - 1
        })
    };
    let triangles = triangles.into_iter().map(|triangle| triangle.map(&mut number)).collect();
    TriangleMesh { vertices: kept, triangles }
}

#[cfg(test)]
mod tests {
    use crate::Solid;
    use glam::DVec3;

    fn tetrahedron(size: f64, at: DVec3) -> Solid {
        Solid::hull(&[DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z].map(|v| v * size + at)).unwrap()
    }

    #[test]
    fn flakes_and_cavities_go_by_their_volume() {
        let body = tetrahedron(6.0, DVec3::ZERO);
        let (cavity, flake) = (tetrahedron(0.6, DVec3::ONE), tetrahedron(0.3, DVec3::splat(9.0)));
        let solid = Solid::union([&body.subtract([&cavity]).unwrap(), &flake]).unwrap();
        let volumes = [36.0 - 0.036 + 0.0045, 36.0 - 0.036, 36.0];
        let check = |limit: f64, volume: f64, shells: usize| {
            let left = solid.without_specks(limit).unwrap();
            assert!((left.volume() - volume).abs() < 1e-12, "{limit}: {left:?}");
            assert_eq!(left.components().unwrap().len(), shells, "{limit}");
        };
        check(0.004, volumes[0], 3);
        check(0.005, volumes[1], 2);
        check(0.05, volumes[2], 1);
        check(100.0, 0.0, 0);
    }
}
