//! The solids as they go into the file.

use crate::precision::SingleMesh;
use fibar_core::artefact::Document;
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_core::artefact::solids::{INDEX_FILE, Solid, Solids};
use fibar_core::material::Role;
use fibar_plugin::StageError;
use rayon::prelude::*;
use std::path::Path;

/// One solid with its mesh in single precision.
pub struct Part {
    /// `core-led0`, `skin`, `tower / skin`, …
    pub name: String,
    /// Decides material and extruder.
    pub role: Role,
    /// The user's part that it is a piece of.
    pub label: Option<String>,
    /// Colour of that part: red, green, blue (sRGB) and opacity from 0 to 1.
    pub colour: Option<[f64; 4]>,
    /// The mesh.
    pub mesh: SingleMesh,
}

/// Reads a tree of solids, in the order of its index; solids without triangles are left out.
pub fn read_all(tree: &Path) -> Result<Vec<Part>, StageError> {
    let index = Solids::from_json(&std::fs::read(tree.join(INDEX_FILE))?)?;
    let parts: Result<Vec<Part>, StageError> = index.solids.par_iter().map(|s| read(tree, s)).collect();
    let mut parts = parts?;
    parts.retain(|part| !part.mesh.triangles.is_empty());
    if parts.is_empty() {
        return Err(StageError::input("there is no solid to write"));
    }
    Ok(parts)
}

fn read(tree: &Path, solid: &Solid) -> Result<Part, StageError> {
    let mesh = TriangleMesh::from_ply(&std::fs::read(tree.join(&solid.file))?)?;
    Ok(Part {
        name: solid.name(),
        role: solid.role,
        label: solid.part.clone(),
        colour: solid.colour,
        mesh: SingleMesh::of(&mesh),
    })
}

impl Part {
    /// Place of the role among all.
    pub fn role_index(&self) -> usize {
        Role::ALL.iter().position(|role| *role == self.role).expect("ALL holds every role")
    }
}

#[cfg(test)]
pub mod tests {
    //! Parts to write.

    use super::*;
    use glam::DVec3;

    /// A tetrahedron of a role.
    pub fn tetrahedron(role: Role) -> Part {
        let vertices = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::new(0.1, 0.25, 1.5)];
        let triangles = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let mesh = SingleMesh::of(&TriangleMesh { vertices, triangles });
        Part { name: role.name().into(), role, label: None, colour: None, mesh }
    }
}
