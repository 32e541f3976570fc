//! Which triangles use each edge.
//!
//! A half-edge is numbered `3·triangle + k` and runs from the triangle's corner `k` to its next.

use fibar_core::artefact::mesh::TriangleMesh;

/// All edges of a mesh, in the order of their ends.
pub struct Edges {
    /// Where the uses of edges with this lower end begin.
    starts: Vec<u32>,
    uses: Vec<Use>,
}

/// A half-edge that runs along an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Use {
    upper: u32,
    /// Its number.
    pub half_edge: u32,
    /// Whether it runs from the lower to the upper vertex.
    pub forward: bool,
}

impl Edges {
    /// Collects the edges of a mesh.
    pub fn of(mesh: &TriangleMesh) -> Edges {
        let mut starts = vec![0; mesh.vertices.len() + 2];
        for [from, to] in half_edges(mesh) {
            starts[from.min(to) as usize + 2] += 1;
        }
        (2..starts.len()).for_each(|k| starts[k] += starts[k - 1]);
        let blank = Use { upper: 0, half_edge: 0, forward: true };
        let mut uses = vec![blank; 3 * mesh.triangles.len()];
        for (half_edge, [from, to]) in half_edges(mesh).enumerate() {
            let next = &mut starts[from.min(to) as usize + 1];
            uses[*next as usize] =
                Use { upper: from.max(to), half_edge: half_edge as u32, forward: from < to };
            *next += 1;
        }
        starts.windows(2).for_each(|range| uses[range[0] as usize..range[1] as usize].sort_unstable());
        Edges { starts, uses }
    }

    /// Whether each edge has one triangle on either side, which agree on what is outside.
    pub fn are_all_shared_by_two(&self) -> bool {
        self.iter().all(|(_, uses)| matches!(uses, [one, other] if one.forward != other.forward))
    }

    /// Lower and upper vertex of each edge, and the half-edges along it.
    pub fn iter(&self) -> impl Iterator<Item = ([u32; 2], &[Use])> {
        let ranges = self.starts.windows(2).enumerate();
        ranges.flat_map(|(lower, range)| {
            let uses = &self.uses[range[0] as usize..range[1] as usize];
            uses.chunk_by(|a, b| a.upper == b.upper).map(move |along| ([lower as u32, along[0].upper], along))
        })
    }
}

/// Both ends of every half-edge, by number.
pub fn half_edges(mesh: &TriangleMesh) -> impl Iterator<Item = [u32; 2]> {
    mesh.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
}

/// The vertex that a half-edge starts from.
pub fn origin(mesh: &TriangleMesh, half_edge: u32) -> u32 {
    mesh.triangles[half_edge as usize / 3][half_edge as usize % 3]
}

#[cfg(test)]
mod tests {
    use super::*;
    use fibar_geometry::half_edges::next;
    use glam::DVec3;

    #[test]
    fn every_half_edge_lies_along_its_edge() {
        let triangles = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3], [3, 2, 0]];
        let mesh = TriangleMesh { vertices: vec![DVec3::ZERO; 5], triangles };
        let edges = Edges::of(&mesh);
        let found: Vec<([u32; 2], usize)> = edges.iter().map(|(ends, uses)| (ends, uses.len())).collect();
        assert_eq!(found, [([0, 1], 2), ([0, 2], 3), ([0, 3], 3), ([1, 2], 2), ([1, 3], 2), ([2, 3], 3)]);
        for (ends, uses) in edges.iter() {
            for along in uses {
                let (from, to) = (origin(&mesh, along.half_edge), origin(&mesh, next(along.half_edge)));
                assert_eq!(if along.forward { [from, to] } else { [to, from] }, ends);
            }
        }
    }
}
