//! What a ray tracer says of the law of light.

use fibar_core::light::{LedBeam, LightLaw};
use fibar_core::material::{LayerRadii, Role};
use fibar_tests::{Peer, Workshop};
use serde_json::json;

/// A minute of ray tracing: only with `cargo xtask test --full`.
#[test]
fn mitsuba_finds_the_slope_of_straight_rods_and_the_trend_of_bent_ones() {
    if std::env::var_os("FIBAR_TEST_FULL").is_none() {
        println!("skipped: a slow test; cargo xtask test --full runs it");
        return;
    }
    let LightLaw { c1_per_mm, c2_per_mm, c3_per_mm, .. } = LightLaw::TONE_2020;
    let index = |role: Role| role.material().refractive_index;
    let rods = json!({
        "law": {"c1_per_mm": c1_per_mm, "c2_per_mm": c2_per_mm, "c3_per_mm": c3_per_mm},
        "core": {"radius_mm": LayerRadii::TONE_2020.core, "index": index(Role::Core)},
        "cladding_index": index(Role::Cladding),
        "half_angle_deg": LedBeam::TONE_2020.half_angle_deg,
        "lengths_mm": [40, 60],
        "radii_mm": [20, 30, 50, 70],
        "rays": 1500,
    });
    let workshop = Workshop::default();
    let file = workshop.write("rods.json", rods.to_string());
    if let Some(outcome) = Peer::Optics("check_optics.py").run(&[&file]) {
        outcome.expect(0);
    }
}
