//! How far away a camera still sees each fibre: the monotone law of light on the exact curve.
//!
//! Independent of every router: the curve comes from `routes.json` alone and is evaluated by `fibar-ruler`. What is not
//! modelled: how an LED's light is shared among the fibres under it (the law was calibrated with one fibre per LED).

mod attenuation;
mod law;
mod summary;

use attenuation::Attenuation;
use fibar_core::artefact::Document;
use fibar_core::artefact::routes::{Fibre, Routes};
use fibar_core::light::LightLaw;
use fibar_plugin::{Description, Job, Stage, StageError, Violation, serve};
use fibar_ruler::curve::Curve;
use law::MonotoneLaw;
use summary::{Sight, Summary};

#[derive(serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
struct Params {
    /// A fibre seen from less far than this breaks the rule `light.reach`; 0 judges nothing.
    #[schemars(range(min = 0.0, max = 100000.0), extend("unit" = "mm"))]
    min_d_cam_mm: f64,
    /// Absorption of a straight fibre.
    #[schemars(range(min = 0.0, max = 10.0), extend("unit" = "1/mm"))]
    c1_per_mm: f64,
    /// Further absorption of a bend as its radius goes to 0.
    #[schemars(range(min = 0.0, max = 100.0), extend("unit" = "1/mm"))]
    c2_per_mm: f64,
    /// Decay of the bend's part with its radius.
    #[schemars(range(min = 0.0001, max = 10.0), extend("unit" = "1/mm"))]
    c3_per_mm: f64,
    /// Distance at which camera and LED would still see a lossless fibre.
    #[schemars(range(min = 1.0, max = 1000000.0), extend("unit" = "mm"))]
    c5_mm: f64,
}

impl Default for Params {
    fn default() -> Params {
        let LightLaw { c1_per_mm, c2_per_mm, c3_per_mm, c5_mm } = LightLaw::TONE_2020;
        Params { min_d_cam_mm: 0.0, c1_per_mm, c2_per_mm, c3_per_mm, c5_mm }
    }
}

impl Params {
    fn law(&self) -> LightLaw {
        let Params { c1_per_mm, c2_per_mm, c3_per_mm, c5_mm, .. } = *self;
        LightLaw { c1_per_mm, c2_per_mm, c3_per_mm, c5_mm }
    }
}

struct VerifyLight;

impl Stage for VerifyLight {
    type Params = Params;

    fn describe() -> Description {
        Description::new(
            "verify-light",
            "Measures from how far a camera sees each fibre (monotone law, exact curve).",
        )
        .version(env!("CARGO_PKG_VERSION"))
        .input("routes", "routes", "The fibres.")
        .published(
            "verdict",
            "verdict",
            "verdict-verify-light.json",
            "Every fibre's reach, the weakest first.",
        )
        .max_cores(1)
    }

    fn run(params: Params, job: &mut Job) -> Result<(), StageError> {
        let routes = Routes::from_json(&job.read("routes")?)?;
        if routes.fibres.is_empty() {
            return Err(StageError::input("there is no fibre to measure"));
        }
        let law = MonotoneLaw::of(params.law());
        let sights: Result<Vec<Sight>, StageError> = routes.fibres.iter().map(|f| look_at(f, &law)).collect();
        let summary = Summary::of(sights?);
        report_metrics(&summary, job);
        if summary.worst().d_cam_mm < params.min_d_cam_mm {
            job.violation(too_dark(&summary, params.min_d_cam_mm));
        }
        job.write(
            "verdict",
            "verdict-verify-light.json",
            &summary.verdict(&law, params.min_d_cam_mm).to_json(),
        )
    }
}

fn look_at(fibre: &Fibre, law: &MonotoneLaw) -> Result<Sight, StageError> {
    let curve = Curve::of_fibre(fibre).map_err(StageError::input)?;
    let attenuation = Attenuation::along(&curve, law);
    Ok(Sight {
        fibre: fibre.id,
        led: fibre.led,
        marker: fibre.marker,
        end: curve.end(),
        d_cam_mm: law.detection_distance(attenuation.monotone.value),
        printed_d_cam_mm: law.detection_distance(attenuation.printed),
        attenuation,
    })
}

fn report_metrics(summary: &Summary, job: &mut Job) {
    let worst = summary.worst();
    job.metric("light.mean_d_cam_mm", summary.mean(|s| s.d_cam_mm), "mm");
    job.metric("light.p10_d_cam_mm", summary.tenth_percentile_mm(), "mm");
    job.metric_at("light.worst_d_cam_mm", worst.d_cam_mm, "mm", worst.end.to_array());
    job.metric("light.mean_d_cam_printed_law_mm", summary.mean(|s| s.printed_d_cam_mm), "mm");
    job.metric("light.length_below_20mm_share", summary.tight_share(), "1");
    job.metric("light.mean_length_mm", summary.mean(|s| s.attenuation.length_mm), "mm");
}

fn too_dark(summary: &Summary, bound_mm: f64) -> Violation {
    let worst = summary.worst();
    let count = summary.darker_than(bound_mm);
    let message = format!(
        "{count} of {} fibres are seen from less than {bound_mm} mm; the weakest is fibre {} with {:.0} mm",
        summary.sights.len(),
        worst.fibre,
        worst.d_cam_mm
    );
    Violation { rule: "light.reach".into(), message, place_mm: Some(worst.end.to_array()) }
}

fn main() -> std::process::ExitCode {
    serve::<VerifyLight>()
}
