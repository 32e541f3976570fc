//! Which edges keep a mesh from being a solid.

use fibar_core::artefact::mesh::TriangleMesh;
use glam::DVec3;
use std::collections::BTreeMap;
use std::fmt;

/// The edges that are not shared by exactly two triangles in opposite directions, by their middles, mm.
#[derive(Debug)]
pub struct Census {
    /// Edges of one triangle only: the rims of holes.
    pub open: Vec<DVec3>,
    /// Edges of three and more triangles.
    pub crowded: Vec<DVec3>,
    /// Edges whose two triangles disagree on what is outside.
    pub twisted: Vec<DVec3>,
}

impl Census {
    /// Takes the census of a mesh.
    pub fn of(mesh: &TriangleMesh) -> Census {
        let mut census = Census { open: Vec::new(), crowded: Vec::new(), twisted: Vec::new() };
        for ([a, b], (forward, backward)) in count_uses(mesh) {
            let middle = (mesh.vertices[a as usize] + mesh.vertices[b as usize]) * 0.5;
            match (forward, backward) {
                (1, 1) => {}
                (1, 0) | (0, 1) => census.open.push(middle),
                (2, 0) | (0, 2) => census.twisted.push(middle),
                _ => census.crowded.push(middle),
            }
        }
        census
    }

    /// One offending place, mm.
    pub fn place(&self) -> Option<DVec3> {
        self.kinds().into_iter().find_map(|(places, _)| places.first().copied())
    }

    fn kinds(&self) -> [(&[DVec3], &'static str); 3] {
        [
            (&self.open, "open (one triangle)"),
            (&self.crowded, "non-manifold (three or more triangles)"),
            (&self.twisted, "twisted (its triangles disagree on what is outside)"),
        ]
    }
}

impl fmt::Display for Census {
    /// `12 edges are open (one triangle), the first at (1.0, 2.0, 3.0) mm; …`
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut parts = Vec::new();
        for (places, what) in self.kinds() {
            if let Some(p) = places.first() {
                let count = places.len();
                let edges = if count == 1 { "edge is" } else { "edges are" };
                parts.push(format!(
                    "{count} {edges} {what}, the first at ({:.2}, {:.2}, {:.2}) mm",
                    p.x, p.y, p.z
                ));
            }
        }
        f.write_str(&parts.join("; "))
    }
}

/// How often each edge is run along from its lower to its higher vertex, and back.
fn count_uses(mesh: &TriangleMesh) -> BTreeMap<[u32; 2], (u32, u32)> {
    let mut uses: BTreeMap<[u32; 2], (u32, u32)> = BTreeMap::new();
    for triangle in &mesh.triangles {
        for k in 0..3 {
            let (a, b) = (triangle[k], triangle[(k + 1) % 3]);
            let (forward, backward) = uses.entry([a.min(b), a.max(b)]).or_default();
            *(if a < b { forward } else { backward }) += 1;
        }
    }
    uses
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_of_edge_is_counted_where_it_is() {
        let vertices = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z, -DVec3::Z];
        let check = |triangles: &[[u32; 3]], counts: [usize; 3], says: &str| {
            let census =
                Census::of(&TriangleMesh { vertices: vertices.clone(), triangles: triangles.to_vec() });
            assert_eq!(
                [census.open.len(), census.crowded.len(), census.twisted.len()],
                counts,
                "{triangles:?}"
            );
            assert!(census.to_string().contains(says), "{census}");
        };
        check(&[[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]], [0, 0, 0], "");
        check(
            &[[0, 2, 1], [0, 1, 3], [1, 2, 3]],
            [3, 0, 0],
            "3 edges are open (one triangle), the first at (0.00, 0.50",
        );
        check(&[[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 2, 3]], [0, 0, 3], "3 edges are twisted");
        check(&[[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3], [0, 1, 4]], [2, 1, 0], "1 edge is non-manifold");
    }
}
