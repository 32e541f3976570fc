//! Hourglasses with ever narrower necks: what is routed and certified, and what is said of the rest.

use super::measured::{Column, measure, print_heads, print_row};
use crate::recipe::Recipe;
use fibar_tests::checkout;

const NECKS_MM: [f64; 7] = [24.0, 18.0, 15.0, 14.0, 13.0, 12.0, 11.0];

const COLUMNS: [Column; 9] = [
    ("fibres", "light.fibres", 0),
    ("colliding pairs", "clearance.colliding_pairs", 0),
    ("least gap", "clearance.min_gap_mm", 3),
    ("least wall", "clearance.min_wall_mm", 3),
    ("least bend", "clearance.min_bend_radius_mm", 2),
    ("mean d_cam", "light.mean_d_cam_mm", 0),
    ("coupled mean", "light.mean_d_cam_coupled_mm", 0),
    ("p10", "light.p10_d_cam_mm", 0),
    ("bound_share", "light.bound_share", 3),
];

pub fn run() {
    println!(
        "\nrecipes/hourglass.toml with other necks: 7 LEDs, 46 markers. mm; processor seconds of the router alone.\n"
    );
    print_heads(&["neck", "processor s"], &COLUMNS);
    for neck in NECKS_MM {
        let recipe = Recipe::read(&checkout().join("recipes/hourglass.toml"));
        let parameters = format!("{{ neck_mm = {neck:.1} }}");
        let recipe = recipe.map(|recipe| recipe.set("source-build123d", "parameters", &parameters));
        let outcome = recipe.and_then(|recipe| measure(&format!("hourglass-{neck}"), recipe, &[]));
        print_row(&format!("{neck}"), &outcome, &COLUMNS);
    }
}
