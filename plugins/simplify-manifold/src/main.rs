//! `simplify-manifold`: fewer triangles for the same body, within a chord error that is kept.
//!
//! Edges are collapsed, cheapest first (Garland & Heckbert 1997), as long as the surface stays near where it was; then both
//! surfaces are measured against each other with a bound, and where that exceeds the chord error it starts again with less
//! room. The surface stays closed and oriented, with the same handles and shells; base and box stay as they are.

mod base;
mod collapse;
mod quadric;
mod simplify;
#[cfg(test)]
mod tests;
mod web;
mod witnesses;

use fibar_core::artefact::mesh::TriangleMesh;
use fibar_plugin::{Description, Job, Stage, StageError, serve};
use simplify::{Wish, simplify};

fn main() -> std::process::ExitCode {
    serve::<SimplifyManifold>()
}

struct SimplifyManifold;

#[derive(serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
struct Params {
    /// How far any point of either surface, before and after, may lie from the other.
    #[schemars(range(min = 1e-6, max = 10.0), extend("unit" = "mm"))]
    chord_error_mm: f64,
    /// Triangles that are few enough: no more edges are collapsed then. 0 goes as far as the chord error allows.
    #[schemars(range(min = 0, max = 200_000_000))]
    enough_triangles: u64,
}

impl Default for Params {
    fn default() -> Params {
        Params { chord_error_mm: 0.02, enough_triangles: 0 }
    }
}

impl Stage for SimplifyManifold {
    type Params = Params;

    fn describe() -> Description {
        Description::new(
            "simplify-manifold",
            "Fewer triangles for the same body, within a chord error that is kept.",
        )
        .version(env!("CARGO_PKG_VERSION"))
        .input("body", "body", "The closed body, mm.")
        .published(
            "body",
            "body",
            "simplified.ply",
            "The same with fewer triangles; base and box are the same, mm.",
        )
    }

    fn run(params: Params, job: &mut Job) -> Result<(), StageError> {
        let body = TriangleMesh::from_ply(&job.read("body")?)?;
        check(&body)?;
        let wish = Wish { chord_error: params.chord_error_mm, triangles: params.enough_triangles as usize };
        let all = body.triangles.len() as f64;
        let mut tick = |left: usize| job.progress(1.0 - left as f64 / all, "collapsing");
        let done = simplify(&body, &wish, &mut tick)?;
        if done.mesh.triangles.len() == body.triangles.len() {
            job.log("warn", "no edge could be collapsed within the chord error: the body is as it was");
        } else if done.mesh.triangles.len() > wish.triangles && wish.triangles > 0 {
            let left = done.mesh.triangles.len();
            job.log(
                "warn",
                &format!("within the chord error {left} triangles are needed, not {}", wish.triangles),
            );
        }
        report(&body, &done, job);
        job.write("body", "simplified.ply", &done.mesh.to_ply())
    }
}

/// A body is closed; what is not is no body.
fn check(body: &TriangleMesh) -> Result<(), StageError> {
    let mut edges: Vec<[u32; 2]> =
        body.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
    edges.sort_unstable();
    let doubled = edges.windows(2).any(|pair| pair[0] == pair[1]);
    if body.triangles.is_empty()
        || doubled
        || edges.iter().any(|&[a, b]| edges.binary_search(&[b, a]).is_err())
    {
        return Err(
            StageError::input("the body is not closed").hint("put `repair-manifold` before this stage")
        );
    }
    Ok(())
}

fn report(body: &TriangleMesh, done: &simplify::Simplified, job: &mut Job) {
    let volume = |mesh: &TriangleMesh| mesh.volume_of(0..mesh.triangles.len());
    job.metric("simplify.triangles_before", body.triangles.len() as f64, "1");
    job.metric("simplify.triangles", done.mesh.triangles.len() as f64, "1");
    job.metric_at("simplify.deviation_mm", done.deviation.at_most, "mm", done.deviation.place.to_array());
    job.metric("simplify.volume_change_mm3", volume(&done.mesh) - volume(body), "mm3");
    job.metric("simplify.rounds", done.rounds as f64, "1");
}
