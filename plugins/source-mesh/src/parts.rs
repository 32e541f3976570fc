//! The objects of a file as the artefact that travels on.

use fibar_core::artefact::parts::{Part, Parts};
use fibar_formats::MeshFile;

/// The parts of a file; one without a name where its format knows none. Volumes in mm³ follow once the mesh is placed.
pub fn of(file: &MeshFile) -> Parts {
    let all =
        fibar_formats::Part { name: String::new(), colour: None, triangles: 0..file.mesh.triangles.len() };
    let parts = if file.parts.is_empty() { std::slice::from_ref(&all) } else { &file.parts };
    let part = |part: &fibar_formats::Part| Part {
        label: part.name.clone(),
        colour: part.colour,
        first_triangle: part.triangles.start,
        triangles: part.triangles.len(),
        volume_mm3: 0.0,
        open_edges: None,
    };
    Parts::new(parts.iter().map(part).collect())
}

/// Fills in the volumes, from the mesh in mm.
pub fn measure(parts: &mut Parts, mesh: &fibar_core::artefact::mesh::TriangleMesh) {
    for part in &mut parts.parts {
        part.volume_mm3 = mesh.volume_of(part.first_triangle..part.first_triangle + part.triangles);
    }
}
