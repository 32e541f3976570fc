//! `repair-manifold`: makes a closed, oriented body of a mesh, or says why it cannot.
//!
//! It welds equal vertices, drops triangles without area, makes neighbours agree on what is outside, and imports the
//! result into Manifold. It deliberately closes no hole and removes no part: what is missing is reported, not guessed.

mod base;
mod census;
mod orientation;
mod weld;

use census::Census;
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_plugin::{Description, Job, Stage, StageError, serve};
use fibar_solid::{Solid, SolidError};

fn main() -> std::process::ExitCode {
    serve::<RepairManifold>()
}

struct RepairManifold;

#[derive(Default, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
struct Params {
    /// Height cut off the bottom by a horizontal plane, to make a flat base; 0 cuts nothing.
    #[schemars(range(min = 0.0, max = 1000.0), extend("unit" = "mm"))]
    flatten_base_mm: f64,
}

impl Stage for RepairManifold {
    type Params = Params;

    fn describe() -> Description {
        Description::new("repair-manifold", "Makes a closed, oriented body of a mesh, or says why it cannot.")
            .version(env!("CARGO_PKG_VERSION"))
            .input("mesh", "mesh", "Any triangle mesh, mm.")
            .published(
                "body",
                "body",
                "body.ply",
                "Closed and oriented, base at z = 0, centred in x and y, mm.",
            )
    }

    fn run(params: Params, job: &mut Job) -> Result<(), StageError> {
        let mesh = TriangleMesh::from_ply(&job.read("mesh")?)?;
        job.progress(0.1, "welding")?;
        let solid = close(mesh, job)?;
        job.progress(0.6, "cutting the base")?;
        let body = base::seat(&solid, params.flatten_base_mm)?;
        let volume =
            Solid::from_mesh(&body).map_err(|error| StageError::internal(error.to_string()))?.volume();
        job.metric("repair.volume_after_mm3", volume, "mm3");
        job.metric("repair.triangles", body.triangles.len() as f64, "1");
        job.write("body", "body.ply", &body.to_ply())
    }
}

/// Welds, orients and imports; reports what it did.
fn close(mesh: TriangleMesh, job: &mut Job) -> Result<Solid, StageError> {
    let vertices_before = mesh.vertices.len();
    let welded = weld::weld(mesh);
    job.metric("repair.vertices_welded", (vertices_before - welded.mesh.vertices.len()) as f64, "1");
    job.metric("repair.triangles_dropped", welded.degenerate as f64, "1");
    let mut mesh = welded.mesh;
    let flipped = orientation::orient(&mut mesh);
    job.metric("repair.triangles_flipped", flipped as f64, "1");
    job.metric("repair.volume_before_mm3", orientation::signed_volume(&mesh, 0..mesh.triangles.len()), "mm3");
    import(&mesh)
}

fn import(mesh: &TriangleMesh) -> Result<Solid, StageError> {
    match Solid::from_mesh(mesh) {
        Ok(solid) if solid.volume() > 0.0 => Ok(solid),
        Ok(_) => {
            Err(StageError::input("the mesh encloses no volume").hint("export the object as a closed solid"))
        }
        Err(SolidError::NotManifold) => Err(refuse(&Census::of(mesh))),
        Err(error) => Err(StageError::input(error.to_string())),
    }
}

/// What keeps the mesh from being a solid, where, and what to try.
fn refuse(census: &Census) -> StageError {
    let error = StageError::input(format!("the mesh is not closed: {census}"));
    let hint = match census.open.is_empty() {
        false => "close the holes in a modelling program (\"fill holes\", \"make solid\") and export again",
        true => {
            "unite parts that touch or overlap (\"union\", \"make manifold\") in a modelling program and export again"
        }
    };
    match census.place() {
        Some(place) => error.hint(hint).place_mm(place.to_array()),
        None => error.hint(hint),
    }
}
