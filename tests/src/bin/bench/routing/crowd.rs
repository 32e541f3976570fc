//! The bunny with ever more markers, until their fibres no longer fit.

use super::measured::{Column, measure, print_heads, print_row};
use crate::recipe::Recipe;
use fibar_tests::checkout;

const MARKERS: [u32; 6] = [43, 65, 90, 120, 160, 200];

/// Markers of the recipe, and between two of them, mm: more stand closer, in proportion to the root of what each has of the surface.
const OF_RECIPE: (f64, f64) = (65.0, 10.0);

/// Moves of the search for places, if not the stage's own.
const PLACE_MOVES: Option<u32> = None;

const COLUMNS: [Column; 9] = [
    ("fibres", "light.fibres", 0),
    ("mean d_cam", "light.mean_d_cam_mm", 0),
    ("coupled mean", "light.mean_d_cam_coupled_mm", 0),
    ("p10", "light.p10_d_cam_mm", 0),
    ("track range", "light.track_range_mm", 0),
    ("for half the views", "light.track_range_half_mm", 0),
    ("bound_share", "light.bound_share", 3),
    ("colliding pairs", "clearance.colliding_pairs", 0),
    ("least gap", "clearance.min_gap_mm", 3),
];

pub fn run() {
    let moves = PLACE_MOVES.map_or(String::new(), |moves| format!(", place_moves {moves}"));
    println!(
        "\nrecipes/bunny.toml with other numbers of markers{moves}. mm; processor seconds of the router alone.\n"
    );
    print_heads(&["markers, apart", "processor s"], &COLUMNS);
    for markers in MARKERS {
        let spacing = spacing_mm(markers);
        let recipe = Recipe::read(&checkout().join("recipes/bunny.toml"))
            .map(|recipe| crowded(recipe, markers, spacing));
        let outcome = recipe.and_then(|recipe| measure(&format!("bunny-{markers}"), recipe, &[]));
        print_row(&format!("{markers}, {spacing:.1}"), &outcome, &COLUMNS);
    }
}

fn spacing_mm(markers: u32) -> f64 {
    let (usual, spacing) = OF_RECIPE;
    (spacing * (usual / f64::from(markers)).sqrt().min(1.0) * 10.0).floor() / 10.0
}

fn crowded(recipe: Recipe, markers: u32, spacing_mm: f64) -> Recipe {
    let recipe = recipe.set("assign-covering", "markers", &markers.to_string());
    let recipe = recipe.set("assign-covering", "spacing_mm", &format!("{spacing_mm:.1}"));
    match PLACE_MOVES {
        Some(moves) => recipe.set("assign-covering", "place_moves", &moves.to_string()),
        None => recipe,
    }
}
