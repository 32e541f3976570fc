//! The mesh that is subdivided: welded by exact coordinates, with what each part has of it.

use crate::angles;
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_core::artefact::parts::{Part, Parts};
use fibar_plugin::StageError;
use glam::DVec3;

/// Triangles around a vertex that OpenSubdiv can count.
const MOST_AROUND: u32 = 65_000;

/// Welded triangles in the order of the parts.
pub struct ControlMesh {
    /// Vertices and triangles, none of which has a corner twice.
    pub mesh: TriangleMesh,
    /// The parts, with their places in `mesh`.
    pub parts: Vec<Part>,
}

impl ControlMesh {
    /// Of a mesh and its parts; without parts, all of it is one that has no name.
    pub fn new(mesh: &TriangleMesh, parts: Option<Parts>) -> Result<ControlMesh, StageError> {
        let parts = parts.map_or_else(|| vec![whole(mesh)], |parts| parts.parts);
        if parts.iter().map(|part| part.triangles).sum::<usize>() != mesh.triangles.len() {
            return Err(
                StageError::input("the parts are not those of the mesh").hint("wire both from one stage")
            );
        }
        let (welded, origin) = weld(mesh);
        let mut first = 0;
        let parts = parts.into_iter().filter_map(|part| {
            let ours = part.first_triangle..part.first_triangle + part.triangles;
            let triangles =
                origin.partition_point(|&t| t < ours.end) - origin.partition_point(|&t| t < ours.start);
            let moved = Part { first_triangle: first, triangles, ..part };
            first += triangles;
            (triangles > 0).then_some(moved)
        });
        let control = ControlMesh { parts: parts.collect(), mesh: welded };
        control.check()?;
        Ok(control)
    }

    fn check(&self) -> Result<(), StageError> {
        if self.mesh.triangles.is_empty() {
            return Err(StageError::input("the mesh has no triangles").hint("export the object again"));
        }
        let mut around = vec![0u32; self.mesh.vertices.len()];
        self.mesh.triangles.iter().flatten().for_each(|&v| around[v as usize] += 1);
        match around.iter().position(|&count| count > MOST_AROUND) {
            Some(v) => Err(StageError::input(format!("{} triangles meet at one vertex", around[v]))
                .hint(format!("OpenSubdiv takes {MOST_AROUND}; make the mesh more even"))
                .place_mm(self.mesh.vertices[v].to_array())),
            None => Ok(()),
        }
    }

    /// The parts of a refined mesh of ours, in which every triangle has become `children` ones, one after the other;
    /// `splits` is into how many an edge was.
    pub fn parts_of(&self, refined: &TriangleMesh, children: usize, splits: usize) -> Parts {
        let part = |part: &Part| {
            let (first, triangles) = (part.first_triangle * children, part.triangles * children);
            Part {
                first_triangle: first,
                triangles,
                volume_mm3: refined.volume_of(first..first + triangles),
                open_edges: part.open_edges.map(|open| open * splits),
                ..part.clone()
            }
        };
        Parts::new(self.parts.iter().map(part).collect())
    }

    /// Edges of exactly one triangle.
    pub fn rim_edges(&self) -> usize {
        angles::edges(&self.mesh).iter().filter(|edge| edge.sides.len() == 1).count()
    }
}

fn whole(mesh: &TriangleMesh) -> Part {
    Part {
        label: String::new(),
        colour: None,
        first_triangle: 0,
        triangles: mesh.triangles.len(),
        volume_mm3: mesh.volume_of(0..mesh.triangles.len()),
        open_edges: None,
    }
}

/// The welded mesh, and which triangle each of its triangles was.
fn weld(mesh: &TriangleMesh) -> (TriangleMesh, Vec<usize>) {
    let same = |a: DVec3, b: DVec3| a == b;
    let is_whole = |t: &usize| {
        let [a, b, c] = mesh.corners(*t);
        !(same(a, b) || same(b, c) || same(c, a))
    };
    (mesh.welded(), (0..mesh.triangles.len()).filter(is_whole).collect())
}
