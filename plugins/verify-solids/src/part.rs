//! What is checked, rounded as the exports round it.

use fibar_core::LedId;
use fibar_core::artefact::Document;
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_core::artefact::routes::Routes;
use fibar_core::artefact::sockets::Sockets;
use fibar_core::artefact::solids::{INDEX_FILE, Solid, Solids};
use fibar_core::material::Role;
use fibar_plugin::StageError;
use glam::DVec3;
use rayon::prelude::*;
use std::path::Path;

/// The object and its solids.
pub struct Object {
    /// The object before anything was cut.
    pub body: TriangleMesh,
    /// The LEDs' holes.
    pub sockets: Sockets,
    /// Where fibres start and end, mm.
    pub fibre_ends: Vec<DVec3>,
    /// Thickness asked of the skin, mm.
    pub skin_mm: f64,
    /// The solids, in the order of their index.
    pub parts: Vec<Part>,
}

/// One solid.
pub struct Part {
    /// `core-led0`, `skin`, …
    pub name: String,
    /// What it is for.
    pub role: Role,
    /// Whose fibres it belongs to.
    pub led: Option<LedId>,
    /// Its mesh, every coordinate a single-precision number.
    pub mesh: TriangleMesh,
    /// Vertices that differed before rounding and fall together after it; `export-3mf` keeps them apart.
    pub merged_vertices: usize,
}

impl Object {
    /// Reads the tree of solids beside the rest.
    pub fn read(
        body: TriangleMesh,
        sockets: Sockets,
        routes: &Routes,
        tree: &Path,
    ) -> Result<Object, StageError> {
        let index = Solids::from_json(&std::fs::read(tree.join(INDEX_FILE))?)?;
        let parts: Result<Vec<Part>, StageError> =
            index.solids.par_iter().map(|s| Part::read(tree, s)).collect();
        let ends = routes.fibres.iter().flat_map(|f| [f.points[0], f.points[f.points.len() - 1]]);
        let object =
            Object { body, sockets, fibre_ends: ends.collect(), skin_mm: index.skin_mm, parts: parts? };
        if object.parts.is_empty() || object.body.triangles.is_empty() {
            return Err(StageError::input("there is no solid, or no body, to check"));
        }
        Ok(object)
    }

    /// The solids of a role.
    pub fn of_role(&self, role: Role) -> impl Iterator<Item = &Part> {
        self.parts.iter().filter(move |part| part.role == role)
    }
}

impl Part {
    fn read(tree: &Path, solid: &Solid) -> Result<Part, StageError> {
        let mut mesh = TriangleMesh::from_ply(&std::fs::read(tree.join(&solid.file))?)?;
        let exact = mesh.vertices.clone();
        mesh.vertices.iter_mut().for_each(|v| *v = v.as_vec3().as_dvec3());
        let merged_vertices = distinct(exact) - distinct(mesh.vertices.clone());
        Ok(Part { name: solid.name(), role: solid.role, led: solid.led, mesh, merged_vertices })
    }
}

fn distinct(mut vertices: Vec<DVec3>) -> usize {
    vertices.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z)));
    vertices.dedup();
    vertices.len()
}

#[cfg(test)]
pub mod tests {
    //! An object to check.

    use super::*;
    use fibar_core::PatternId;
    use fibar_core::artefact::sockets::{Hole, Socket};

    /// A body with one hole, Ø 4 × 3 mm below (0, 0, −7), and solids of LED 0 in the order of the roles.
    pub fn object(body: TriangleMesh, meshes: &[TriangleMesh]) -> Object {
        let part = |(mesh, role): (&TriangleMesh, Role)| Part {
            name: role.name().into(),
            role,
            led: Some(LedId(0)),
            mesh: mesh.clone(),
            merged_vertices: 0,
        };
        let hole = Hole { diameter_mm: 4.0, depth_mm: 3.0 };
        let position = DVec3::new(0.0, 0.0, -7.0);
        let socket = Socket { led: LedId(0), pattern: PatternId(1), position, axis: DVec3::Z };
        Object {
            body,
            sockets: Sockets::new(hole, vec![socket]),
            fibre_ends: Vec::new(),
            skin_mm: 0.4,
            parts: meshes.iter().zip(Role::ALL).map(part).collect(),
        }
    }
}
