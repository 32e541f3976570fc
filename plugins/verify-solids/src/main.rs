//! The finished solids: closed, disjoint, adding up to the object, with walls as thick as asked.
//!
//! Everything is measured on the meshes as readers of the exports will have them, rounded to single precision, and by
//! means that share nothing with the stage that made them: no booleans, but edges counted, divergence theorem, lines
//! through the object, and shortest distances between surfaces. docs/verification.md states the errors.

mod hole;
mod layers;
mod part;
mod pierce;
mod scan;
mod sum;
mod sweep;
mod topology;
mod verdict;
mod wall;

use fibar_core::artefact::Document;
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_core::artefact::routes::Routes;
use fibar_core::artefact::sockets::Sockets;
use fibar_core::artefact::verdict::Verdict;
use fibar_plugin::{Description, Job, Stage, StageError, serve};
use part::Object;
use topology::Topology;

#[derive(Clone, Debug, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
struct Params {
    /// Distance between the lines that look for overlaps and gaps; what is narrower than this may slip between them.
    #[schemars(range(min = 0.05, max = 5.0), extend("unit" = "mm"))]
    line_spacing_mm: f64,
    /// Largest share by which the solids' volumes may miss the object's.
    #[schemars(range(min = 0.0, max = 1.0))]
    max_volume_error_ratio: f64,
    /// Largest volume that may belong to two solids.
    #[schemars(range(min = 0.0, max = 1000000.0), extend("unit" = "mm3"))]
    max_overlap_mm3: f64,
    /// Largest volume of the object that may belong to none, or of the solids that may lie outside the object.
    #[schemars(range(min = 0.0, max = 1000000.0), extend("unit" = "mm3"))]
    max_gap_mm3: f64,
    /// Least thickness of cladding and black.
    #[schemars(range(min = 0.0, max = 10.0), extend("unit" = "mm"))]
    min_layer_mm: f64,
    /// Least distance between the outer surfaces of fibres of two LEDs; 0 judges nothing.
    #[schemars(range(min = 0.0, max = 20.0), extend("unit" = "mm"))]
    min_fibre_gap_mm: f64,
    /// How much any wall may fall short of what is asked.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "mm"))]
    wall_tolerance_mm: f64,
    /// Cladding and black are not judged this near to either end of a fibre, where they stop: the straight leg of 2.5 mm, the
    /// outer radius and the skin, as in verify-clearance.
    #[schemars(range(min = 0.0, max = 50.0), extend("unit" = "mm"))]
    end_zone_mm: f64,
}

impl Default for Params {
    fn default() -> Params {
        Params {
            line_spacing_mm: 0.25,
            max_volume_error_ratio: 1e-4,
            max_overlap_mm3: 0.1,
            max_gap_mm3: 0.1,
            min_layer_mm: 0.5,
            min_fibre_gap_mm: 0.0,
            wall_tolerance_mm: 0.01,
            end_zone_mm: 4.8,
        }
    }
}

struct VerifySolids;

impl Stage for VerifySolids {
    type Params = Params;

    fn describe() -> Description {
        Description::new(
            "verify-solids",
            "Checks that the solids are closed, disjoint, complete and thick enough.",
        )
        .version(env!("CARGO_PKG_VERSION"))
        .input("body", "body", "The object.")
        .input("sockets", "sockets", "The holes for the LEDs.")
        .input("routes", "routes", "Where fibres start and end.")
        .input("solids", "solids", "The solids that are checked.")
        .published("verdict", "verdict", "verdict-verify-solids.json", "Every rule with its worst places.")
        .memory_mb(2048)
    }

    fn run(params: Params, job: &mut Job) -> Result<(), StageError> {
        let object = read(job)?;
        job.progress(0.1, "edges")?;
        let topologies: Vec<Topology> = object.parts.iter().map(|part| Topology::of(&part.mesh)).collect();
        job.progress(0.3, "lines")?;
        let scanned = scan::scan(&object, params.line_spacing_mm);
        job.progress(0.6, "walls")?;
        let walls = layers::measure(&object, params.end_zone_mm);
        let mut judged = verdict::judge(&params, &object, &topologies, &scanned, &walls);
        job.progress(0.9, "gaps between fibres")?;
        verdict::judge_fibre_gaps(&params, &layers::bridges(&object), &mut judged);
        judged.report(job);
        let verdict = Verdict::new("verify-solids", judged.findings);
        job.write("verdict", "verdict-verify-solids.json", &verdict.to_json())
    }
}

fn read(job: &Job) -> Result<Object, StageError> {
    let body = TriangleMesh::from_ply(&job.read("body")?)?;
    let sockets = Sockets::from_json(&job.read("sockets")?)?;
    let routes = Routes::from_json(&job.read("routes")?)?;
    Object::read(body, sockets, &routes, &job.input_path("solids")?)
}

fn main() -> std::process::ExitCode {
    serve::<VerifySolids>()
}
