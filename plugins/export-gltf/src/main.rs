//! The solids as one binary glTF for viewers: metres, +Y up, a named mesh per solid.
//!
//! For looking, not for printing: vertices are split where normals break. docs/export.md shows the frame.

mod glb;
mod material;
mod shaded;

use fibar_core::artefact::Document;
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_core::artefact::solids::{INDEX_FILE, Solid, Solids};
use fibar_plugin::{Description, Job, Stage, StageError, serve};
use glb::Part;
use rayon::prelude::*;
use shaded::ShadedMesh;
use std::path::Path;

#[derive(serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
struct Params {
    /// Triangles whose normals differ by more than this meet in a sharp edge.
    #[schemars(range(min = 0.0, max = 180.0), extend("unit" = "deg"))]
    crease_deg: f64,
}

impl Default for Params {
    fn default() -> Params {
        Params { crease_deg: 40.0 }
    }
}

struct ExportGltf;

impl Stage for ExportGltf {
    type Params = Params;

    fn describe() -> Description {
        Description::new("export-gltf", "Writes the solids as one GLB file for viewers.")
            .version(env!("CARGO_PKG_VERSION"))
            .input("solids", "solids", "The closed solids.")
            .published("glb", "glb", "object.glb", "Metres, +Y up; one named mesh per solid.")
            .memory_mb(1024)
    }

    fn run(params: Params, job: &mut Job) -> Result<(), StageError> {
        let tree = job.input_path("solids")?;
        let index = Solids::from_json(&std::fs::read(tree.join(INDEX_FILE))?)?;
        job.progress(0.1, "normals")?;
        let crease = libm::cos(params.crease_deg.to_radians());
        let parts: Result<Vec<Part>, StageError> =
            index.solids.par_iter().map(|s| read(&tree, s, crease)).collect();
        let mut parts = parts?;
        parts.retain(|part| !part.mesh.triangles.is_empty());
        if parts.is_empty() {
            return Err(StageError::input("there is no solid to write"));
        }
        job.progress(0.8, "packing")?;
        job.write("glb", "object.glb", &glb::pack(&parts)?)
    }
}

fn read(tree: &Path, solid: &Solid, crease_cosine: f64) -> Result<Part, StageError> {
    let mesh = TriangleMesh::from_ply(&std::fs::read(tree.join(&solid.file))?)?;
    Ok(Part { name: solid.name(), role: solid.role, mesh: ShadedMesh::of(&mesh, crease_cosine) })
}

fn main() -> std::process::ExitCode {
    serve::<ExportGltf>()
}
