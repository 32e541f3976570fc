//! `subdivide-opensubdiv`: makes a mesh smooth by Loop or Catmull–Clark subdivision.
//!
//! OpenSubdiv says which faces there will be and with which weights (`refinement`); positions are ours, in f64 (`stencils`). What
//! stays sharp is told by angle (`angles`). It mends nothing: `repair-manifold` comes after it.

mod angles;
mod control;
mod fitting;
mod limit;
#[cfg(test)]
mod reference;
mod refinement;
mod smooth;
mod stencils;
#[cfg(test)]
mod tests;

use fibar_core::artefact::Document;
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_core::artefact::parts::Parts;
use fibar_plugin::{Description, Job, Stage, StageError, serve};
use smooth::{Smooth, smooth};

fn main() -> std::process::ExitCode {
    serve::<SubdivideOpenSubdiv>()
}

struct SubdivideOpenSubdiv;

#[derive(Clone, Debug, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
struct Params {
    /// `loop`, made for triangles, or `catmull-clark`, which divides each into three quads.
    scheme: Scheme,
    /// How often each edge is halved.
    #[schemars(range(min = 1, max = 8))]
    levels: u32,
    /// An edge stays sharp where its triangles' normals differ by more than this; 180 keeps none.
    #[schemars(range(min = 0.0, max = 180.0), extend("unit" = "deg"))]
    crease_deg: f64,
    /// A vertex of a crease or rim stays where it is if that turns by more than this; 180 holds none.
    #[schemars(range(min = 0.0, max = 180.0), extend("unit" = "deg"))]
    corner_deg: f64,
    /// What the rims of an open mesh become: `smooth` curves, or such as hold the `corners` of single triangles.
    rims: Rims,
    /// Weights of `catmull-clark` at triangles: those of 1978 (`plain`), or OpenSubdiv's, which wrinkle less (`even`).
    triangles: TriangleWeights,
    /// Whether vertices are moved on to the surface that further subdivision tends to.
    limit: bool,
    /// What is kept, for round shapes shrink: `nothing`; the `size`, by scaling evenly until the mesh's box is touched from inside
    /// again; or the places of its `vertices`, which then lie on the smooth mesh, at the price of bumps between them.
    keep: Keep,
    /// Most triangles to make; a million take about 0.8 GB of memory.
    #[schemars(range(min = 1, max = 20_000_000))]
    max_triangles: u64,
}

#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
enum Scheme {
    Loop,
    CatmullClark,
}

#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
enum Rims {
    Smooth,
    Corners,
}

#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
enum TriangleWeights {
    Plain,
    Even,
}

#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
enum Keep {
    Nothing,
    Size,
    Vertices,
}

impl Default for Params {
    fn default() -> Params {
        Params {
            scheme: Scheme::Loop,
            levels: 1,
            crease_deg: 60.0,
            corner_deg: 60.0,
            rims: Rims::Smooth,
            triangles: TriangleWeights::Even,
            limit: true,
            keep: Keep::Nothing,
            max_triangles: 1_000_000,
        }
    }
}

impl Params {
    /// How many triangles one becomes.
    fn children(&self) -> u64 {
        let of_quads = 4u64.pow(self.levels);
        match self.scheme {
            Scheme::Loop => of_quads,
            // Three quads at the first level, four of each at every further one, two triangles of each in the end.
            Scheme::CatmullClark => of_quads / 4 * 6,
        }
    }
}

impl Stage for SubdivideOpenSubdiv {
    type Params = Params;

    fn describe() -> Description {
        Description::new("subdivide-opensubdiv", "Makes a mesh smooth by Loop or Catmull-Clark subdivision.")
            .version(env!("CARGO_PKG_VERSION"))
            .input("mesh", "mesh", "Any triangle mesh, mm.")
            .optional_input("parts", "parts", "Which of its triangles belong to which object.")
            .output("mesh", "mesh", "The smooth mesh, mm; closed if the one before is closed.")
            .output("parts", "parts", "The same objects, with their triangles in the smooth mesh.")
    }

    fn run(params: Params, job: &mut Job) -> Result<(), StageError> {
        let mesh = TriangleMesh::from_ply(&job.read("mesh")?)?;
        let parts = job.read_optional("parts")?.map(|bytes| Parts::from_json(&bytes)).transpose()?;
        job.progress(0.1, "refining")?;
        let smooth = smooth(&mesh, parts, &params)?;
        job.progress(0.9, "writing")?;
        report(&smooth, job);
        job.write("mesh", "mesh.ply", &smooth.mesh.to_ply())?;
        job.write("parts", "parts.json", &smooth.parts.to_json())
    }
}

fn report(smooth: &Smooth, job: &mut Job) {
    let Smooth { mesh, fate, .. } = smooth;
    job.metric("subdivide.triangles", mesh.triangles.len() as f64, "1");
    job.metric("subdivide.creases", fate.creases as f64, "1");
    job.metric("subdivide.corners", fate.corners as f64, "1");
    job.metric("subdivide.volume_before_mm3", fate.volume_before_mm3, "mm3");
    job.metric("subdivide.volume_after_mm3", fate.volume_after_mm3, "mm3");
    job.metric("subdivide.displacement_mm", fate.displacement_mm, "mm");
    job.metric("subdivide.kept_within_mm", fate.kept_within_mm, "mm");
    for (axis, side) in ["x", "y", "z"].iter().zip(fate.growth_mm.to_array()) {
        job.metric(&format!("subdivide.growth_{axis}_mm"), side, "mm");
    }
    if fate.rim_edges > 0 {
        let rims = fate.rim_edges;
        job.log(
            "warn",
            &format!("the mesh is open: {rims} edges have one triangle only; its rims became curves"),
        );
    }
    if fate.unlimited > 0 {
        let count = fate.unlimited;
        job.log("warn", &format!("{count} vertices whose ring meets itself stay short of the limit surface"));
    }
}
