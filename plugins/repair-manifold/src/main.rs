//! `repair-manifold`: makes a closed, oriented body of a mesh, or says why it cannot.
//!
//! Welded by exact coordinates; duplicates dropped; rims sewn where they almost meet; neighbours turned to agree; inner walls and
//! flaps taken away; triangles paired around crowded edges; holes capped; shells nested and turned; what passes through itself
//! parted or cut away; overlapping bodies united. No body is dropped, and everything that changed is counted.

mod base;
mod bulge;
mod cap;
mod census;
mod closing;
mod distance;
mod drawing;
mod edges;
mod families;
mod fate;
#[cfg(test)]
mod fixture;
mod heads;
mod holes;
mod nesting;
mod orientation;
mod relief;
mod scuffs;
mod seams;
mod sheets;
mod sight;
mod sound;
mod strands;
mod tangles;
#[cfg(test)]
mod tests;
mod volume;
mod walls;
mod weld;

use closing::{Limits, Obstacle, close};
use fate::Fate;
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_plugin::{Description, Job, Stage, StageError, serve};

fn main() -> std::process::ExitCode {
    serve::<RepairManifold>()
}

struct RepairManifold;

#[derive(serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
struct Params {
    /// Rims that are this near are sewn together; far below what a printer resolves.
    #[schemars(range(min = 0.0, max = 10.0), extend("unit" = "mm"))]
    seam_mm: f64,
    /// A hole that reaches farther than this from its middle is not closed, and the mesh is refused.
    #[schemars(range(min = 0.0, max = 10000.0), extend("unit" = "mm"))]
    largest_hole_mm: f64,
    /// Height cut off the bottom by a horizontal plane, to make a flat base; 0 cuts nothing.
    #[schemars(range(min = 0.0, max = 1000.0), extend("unit" = "mm"))]
    flatten_base_mm: f64,
}

impl Default for Params {
    fn default() -> Params {
        Params { seam_mm: 0.005, largest_hole_mm: 10000.0, flatten_base_mm: 0.0 }
    }
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
        let limits = Limits { seam_mm: params.seam_mm, largest_hole_mm: params.largest_hole_mm };
        let mut fate = Fate::default();
        let closed = close(&mesh, limits, &mut fate);
        fate.metrics().into_iter().for_each(|(name, value, unit)| job.metric(name, value, unit));
        fate.changes().iter().for_each(|change| job.log("info", change));
        let closed = closed.map_err(refuse)?;
        job.progress(0.6, "cutting the base")?;
        let (body, moved) = base::seat(closed, params.flatten_base_mm)?;
        let axes = ["repair.moved_x_mm", "repair.moved_y_mm", "repair.moved_z_mm"];
        axes.into_iter().zip(moved.to_array()).for_each(|(name, by)| job.metric(name, by, "mm"));
        job.metric("repair.volume_after_mm3", volume::signed_volume(&body), "mm3");
        job.metric("repair.triangles", body.triangles.len() as f64, "1");
        job.write("body", "body.ply", &body.to_ply())
    }
}

/// What keeps the mesh from being a solid, where, and what to try.
fn refuse(obstacle: Obstacle) -> StageError {
    let (message, hint, place) = match obstacle {
        Obstacle::Edges(census) => (
            format!("the mesh cannot be closed: {census}"),
            "unite its parts (\"union\", \"make manifold\") in a modelling program and export again",
            census.place(),
        ),
        Obstacle::Hole { count, middle, radius } => (
            format!("the mesh has open holes ({count}), the widest {:.2} mm across", 2.0 * radius),
            "close them in a modelling program, or allow it by a larger `largest_hole_mm`",
            Some(middle),
        ),
        Obstacle::Crossings(left) => (
            format!("the surface passes through itself, still {} times after repair", left.len()),
            "mend the self-intersections in a modelling program and export again",
            left.first().map(|crossing| crossing.place),
        ),
        Obstacle::Nothing => {
            ("the mesh encloses no volume".into(), "export the object as a closed solid", None)
        }
        Obstacle::Solid(error) => (error.to_string(), "export the object as a closed solid", None),
    };
    let error = StageError::input(message).hint(hint);
    match place {
        Some(place) => error.place_mm(place.to_array()),
        None => error,
    }
}
