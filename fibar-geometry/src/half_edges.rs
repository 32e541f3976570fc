//! Half-edges: side `k` of triangle `t`, which runs from its corner `k` to its next, is number `3·t + k`.

use fibar_core::artefact::mesh::TriangleMesh;

/// No twin.
pub const OPEN: u32 = u32::MAX;

/// The half-edge that runs the other way along the same edge, for each; [`OPEN`] if there is none. Where there are several, each is the
/// twin of one at most.
pub fn twins(mesh: &TriangleMesh) -> Vec<u32> {
    let mut waiting = Waiting::of(mesh);
    for (triangle, &[a, b, c]) in (0..).zip(&mesh.triangles) {
        waiting.meet(3 * triangle, [a, b]);
        waiting.meet(3 * triangle + 1, [b, c]);
        waiting.meet(3 * triangle + 2, [c, a]);
    }
    waiting.end()
}

/// The next half-edge around the same triangle.
pub fn next(half_edge: u32) -> u32 {
    if half_edge % 3 == 2 { half_edge - 2 } else { half_edge + 1 }
}

/// Half-edges that have not met their twins yet, in lists by a number that both of them know.
struct Waiting<'a> {
    triangles: &'a [[u32; 3]],
    /// The first of each list.
    heads: Vec<u32>,
    /// Of those who wait the next in the list, of the others their twin.
    links: Vec<u32>,
}

impl Waiting<'_> {
    fn of(mesh: &TriangleMesh) -> Waiting<'_> {
        let lists = (2 * mesh.vertices.len()).next_power_of_two();
        Waiting {
            triangles: &mesh.triangles,
            heads: vec![OPEN; lists],
            links: vec![OPEN; 3 * mesh.triangles.len()],
        }
    }

    /// Near edges have near lists; yet neither the edges around a vertex nor those of a zigzag have the same.
    fn list(&self, [from, to]: [u32; 2]) -> usize {
        (from.min(to) as usize + 3 * from.max(to) as usize) & (self.heads.len() - 1)
    }

    fn ends(&self, half_edge: u32) -> [u32; 2] {
        let triangle = self.triangles[half_edge as usize / 3];
        let k = half_edge as usize % 3;
        [triangle[k], triangle[if k == 2 { 0 } else { k + 1 }]]
    }

    fn meet(&mut self, half_edge: u32, [from, to]: [u32; 2]) {
        let list = self.list([from, to]);
        let (mut before, mut at) = (OPEN, self.heads[list]);
        while at != OPEN {
            let next = self.links[at as usize];
            if self.ends(at) == [to, from] {
                match before {
                    OPEN => self.heads[list] = next,
                    before => self.links[before as usize] = next,
                }
                self.links[at as usize] = half_edge;
                self.links[half_edge as usize] = at;
                return;
            }
            (before, at) = (at, next);
        }
        self.links[half_edge as usize] = self.heads[list];
        self.heads[list] = half_edge;
    }

    /// Who still waits has none.
    fn end(mut self) -> Vec<u32> {
        for head in self.heads {
            let mut at = head;
            while at != OPEN {
                at = std::mem::replace(&mut self.links[at as usize], OPEN);
            }
        }
        self.links
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn check(triangles: &[[u32; 3]], expected: &[(u32, u32)]) {
        let mesh = TriangleMesh { vertices: vec![DVec3::ZERO; 9], triangles: triangles.to_vec() };
        let mut twins = twins(&mesh).into_iter().zip(0u32..).filter(|(twin, _)| *twin != OPEN);
        let found: Vec<(u32, u32)> =
            twins.by_ref().filter(|(twin, own)| twin > own).map(|(t, o)| (o, t)).collect();
        assert_eq!(found, expected, "{triangles:?}");
    }

    #[test]
    fn twins_run_the_other_way_and_are_alone() {
        check(&[], &[]);
        check(&[[0, 1, 2]], &[]);
        check(&[[0, 1, 2], [2, 1, 3]], &[(1, 3)]);
        check(&[[0, 1, 2], [1, 2, 3]], &[]);
        check(&[[0, 1, 2], [2, 1, 3], [2, 1, 4]], &[(1, 3)]);
        check(&[[0, 1, 2], [1, 2, 3], [2, 1, 4]], &[(3, 6)]);
        check(&[[0, 1, 2], [2, 1, 0]], &[(0, 4), (1, 3), (2, 5)]);
        check(&[[0, 0, 1]], &[(1, 2)]);
    }
}
