//! Light of the paper's whole chain, of its markers with our router, and of ours, on every object.

use super::measured::{Column, Measured, measure, print_heads, print_row, text};
use super::router::Words;
use crate::recipe::Recipe;
use fibar_tests::checkout;

/// Objects with a recipe of ours and one of the paper's stages.
const OBJECTS: [&str; 3] = ["bunny", "wavy-cone", "building"];

/// Our router and the paper's.
const OURS: &str = "route-negotiated";
const PAPERS: &str = "route-fibar";
/// Ours is to leave out what it finds no room for, and to say so; the paper's lets it collide.
const LEAVES_OUT: Words = &[("on_misfit", "drop")];

/// Mean detection distances that the paper reports: initial, optimised, mm.
const REPORTED: [[f64; 2]; 3] = [[843.0, 1543.0], [1618.7, 2028.2], [868.4, 1407.9]];

const COLUMNS: [Column; 16] = [
    ("fibres", "light.fibres", 0),
    ("left out", "route.left_out", 0),
    ("mean d_cam", "light.mean_d_cam_mm", 1),
    ("p10", "light.p10_d_cam_mm", 1),
    ("coupled mean", "light.mean_d_cam_coupled_mm", 1),
    ("coupled p10", "light.p10_d_cam_coupled_mm", 1),
    ("bound_share", "light.bound_share", 3),
    ("certified_share", "light.certified_share", 3),
    ("≥ 700 mm", "light.share_over_700mm", 3),
    ("track range", "light.track_range_mm", 0),
    ("for half the views", "light.track_range_half_mm", 0),
    ("below 20 mm", "light.length_below_20mm_share", 3),
    ("colliding pairs", "clearance.colliding_pairs", 0),
    ("least gap", "clearance.min_gap_mm", 3),
    ("least wall", "clearance.min_wall_mm", 3),
    ("least bend", "clearance.min_bend_radius_mm", 2),
];

/// What is held against the paper's chain: head and metric.
const RATIOS: [Column; 5] = [
    ("mean d_cam", "light.mean_d_cam_mm", 2),
    ("p10", "light.p10_d_cam_mm", 2),
    ("coupled mean", "light.mean_d_cam_coupled_mm", 2),
    ("track range", "light.track_range_mm", 2),
    ("for half the views", "light.track_range_half_mm", 2),
];

/// A chain, what it is called, and how it came out.
struct Chain {
    name: &'static str,
    outcome: Result<Measured, String>,
}

pub fn run() {
    println!(
        "Distances in mm, by verify-light and verify-clearance; bounds at normal effort. Processor seconds of the router alone.\n"
    );
    print_heads(&["chain", "processor s"], &COLUMNS);
    let all: Vec<[Chain; 3]> = OBJECTS.iter().map(|object| measure_chains(object)).collect();
    print_ratios(&all);
    print_reported(&all);
}

/// Builds the three chains of an object and prints their rows.
fn measure_chains(object: &str) -> [Chain; 3] {
    let paper = Recipe::read(&checkout().join(format!("recipes/paper/{object}.toml")));
    let rerouted = paper.clone().map(|recipe| recipe.replaced(PAPERS, OURS));
    let ours = Recipe::read(&checkout().join(format!("recipes/{object}.toml")));
    let chains = [
        ("the paper's chain", "paper", paper),
        ("its markers, our router", "rerouted", rerouted),
        ("ours", "ours", ours),
    ];
    chains.map(|(name, short, recipe)| {
        let outcome = recipe.and_then(|recipe| {
            let words = if recipe.router() == OURS { LEAVES_OUT } else { &[] };
            measure(&format!("{object}-{short}"), recipe, words)
        });
        print_row(&format!("{object}: {name}"), &outcome, &COLUMNS);
        Chain { name, outcome }
    })
}

/// Each chain over the paper's; seconds the other way round.
fn print_ratios(all: &[[Chain; 3]]) {
    println!(
        "\nTimes the paper's chain; for seconds, the paper's over this one's. – where the paper's is 0.\n"
    );
    print_heads(&["chain", "processor s"], &RATIOS);
    for (object, [paper, others @ ..]) in OBJECTS.iter().zip(all) {
        for chain in others {
            let (Ok(paper), Ok(this)) = (&paper.outcome, &chain.outcome) else { continue };
            // Other markers are another task: only on the same ones does the time say anything about the routers.
            let same = chain.name == others[0].name;
            let seconds = if same { ratio(paper.seconds, this.seconds) } else { None };
            let cell =
                |(_, metric, digits): &Column| text(ratio(this.value(metric), paper.value(metric)), *digits);
            let cells: Vec<String> = RATIOS.iter().map(cell).collect();
            println!("| {object}: {} | {} | {} |", chain.name, text(seconds, 1), cells.join(" | "));
        }
    }
}

fn ratio(this: Option<f64>, other: Option<f64>) -> Option<f64> {
    let (this, other) = (this?, other?);
    (other > 0.0).then(|| this / other)
}

/// The paper's own figures beside what the same estimate gives here.
fn print_reported(all: &[[Chain; 3]]) {
    println!(
        "\n| object | reported, initial → optimised | our E_cam, initial → optimised | printed law, exact curve | monotone law |"
    );
    println!("| --- | --- | --- | --- | --- |");
    for ((object, [paper, ..]), [initial, optimised]) in OBJECTS.iter().zip(all).zip(REPORTED) {
        let Ok(measured) = &paper.outcome else { continue };
        let cell = |metric: &str| measured.cell(metric, 1);
        println!(
            "| {object} | {initial} → {optimised} | {} → {} | {} | {} |",
            cell("route.mean_e_cam_initial_mm"),
            cell("route.mean_e_cam_mm"),
            cell("light.mean_d_cam_printed_law_mm"),
            cell("light.mean_d_cam_mm")
        );
    }
}
