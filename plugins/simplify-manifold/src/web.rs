//! A closed surface whose edges can be collapsed one by one.

use fibar_core::artefact::mesh::TriangleMesh;
use glam::DVec3;

/// Triangles and what lies around each vertex. Numbers stay; what has gone is empty.
pub struct Web {
    /// Where the vertices are, mm.
    pub places: Vec<DVec3>,
    /// Corners; meaningless once a triangle has gone.
    pub triangles: Vec<[u32; 3]>,
    /// The triangles around each vertex; none around one that has gone.
    fans: Vec<Vec<u32>>,
    left: usize,
}

/// What a collapse would change.
#[derive(Debug, Default)]
pub struct Ring {
    /// The two triangles at the edge, which go.
    pub gone: Vec<u32>,
    /// The others around its ends, which stay and change.
    pub kept: Vec<u32>,
}

impl Web {
    /// A closed mesh, as it is.
    pub fn of(mesh: &TriangleMesh) -> Web {
        let mut fans = vec![Vec::new(); mesh.vertices.len()];
        for (t, triangle) in mesh.triangles.iter().enumerate() {
            triangle.iter().for_each(|&v| fans[v as usize].push(t as u32));
        }
        let left = mesh.triangles.len();
        Web { places: mesh.vertices.clone(), triangles: mesh.triangles.clone(), fans, left }
    }

    /// Triangles left.
    pub fn left(&self) -> usize {
        self.left
    }

    /// The triangles around a vertex.
    pub fn fan(&self, vertex: u32) -> &[u32] {
        &self.fans[vertex as usize]
    }

    /// The corners of a triangle, mm.
    pub fn corners(&self, triangle: u32) -> [DVec3; 3] {
        self.triangles[triangle as usize].map(|v| self.places[v as usize])
    }

    /// The vertices next to a vertex, ascending.
    pub fn neighbours(&self, vertex: u32) -> Vec<u32> {
        let corners = self.fan(vertex).iter().flat_map(|&t| self.triangles[t as usize]);
        let mut found: Vec<u32> = corners.filter(|&v| v != vertex).collect();
        found.sort_unstable();
        found.dedup();
        found
    }

    /// All edges, ascending.
    pub fn edges(&self) -> Vec<[u32; 2]> {
        let live = (0..self.fans.len() as u32).filter(|&v| !self.fan(v).is_empty());
        live.flat_map(|v| self.neighbours(v).into_iter().filter(move |&w| w > v).map(move |w| [v, w]))
            .collect()
    }

    /// What the collapse of an edge would change; `None` if the surface would pinch or fold onto itself: only the two triangles'
    /// other corners may be next to both ends (Dey et al. 1999).
    pub fn ring(&self, [u, v]: [u32; 2]) -> Option<Ring> {
        let mut ring = Ring::default();
        for &t in self.fan(u) {
            let side = if self.triangles[t as usize].contains(&v) { &mut ring.gone } else { &mut ring.kept };
            side.push(t);
        }
        ring.kept.extend(self.fan(v).iter().filter(|t| !ring.gone.contains(t)));
        let (near_u, near_v) = (self.neighbours(u), self.neighbours(v));
        let common = near_u.iter().filter(|w| near_v.binary_search(w).is_ok());
        let mut count = 0;
        let thin = common.inspect(|_| count += 1).any(|&w| self.fan(w).len() <= 3);
        (!thin && count == 2 && ring.gone.len() == 2 && ring.kept.len() >= 3).then_some(ring)
    }

    /// Corners of a triangle once the ends of an edge lie at one place.
    pub fn corners_after(&self, triangle: u32, edge: [u32; 2], place: DVec3) -> [DVec3; 3] {
        self.triangles[triangle as usize]
            .map(|v| if edge.contains(&v) { place } else { self.places[v as usize] })
    }

    /// Collapses an edge: its second end goes, the first one moves.
    pub fn collapse(&mut self, [keep, lose]: [u32; 2], ring: &Ring, place: DVec3) {
        for &t in &ring.gone {
            for v in self.triangles[t as usize] {
                self.fans[v as usize].retain(|&other| other != t);
            }
        }
        for t in std::mem::take(&mut self.fans[lose as usize]) {
            let corners = self.triangles[t as usize].map(|v| if v == lose { keep } else { v });
            self.triangles[t as usize] = corners;
            self.fans[keep as usize].push(t);
        }
        self.places[keep as usize] = place;
        self.left -= ring.gone.len();
    }

    /// What is left, numbered anew in the old order.
    pub fn mesh(&self) -> TriangleMesh {
        let mut numbers = vec![u32::MAX; self.places.len()];
        let mut mesh = TriangleMesh::default();
        for v in (0..self.places.len()).filter(|&v| !self.fans[v].is_empty()) {
            numbers[v] = mesh.vertices.len() as u32;
            mesh.vertices.push(self.places[v]);
        }
        let stands = |t: &usize| self.fan(self.triangles[*t][0]).contains(&(*t as u32));
        let live = (0..self.triangles.len()).filter(stands);
        mesh.triangles = live.map(|t| self.triangles[t].map(|v| numbers[v as usize])).collect();
        mesh
    }
}
