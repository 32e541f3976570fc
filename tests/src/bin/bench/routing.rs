//! Light of the paper's whole chain, of its markers with our router, and of ours, on every object.
//!
//! Each recipe is cut down to what routing needs, bounds are added before the route, and `verify-light` and
//! `verify-clearance` say what came out; no figure is the router's own but the time that the engine took.

use super::recipe::Recipe;
use fibar_tests::{checkout, executables};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Objects with a recipe of ours and one of the paper's stages; further ones named `hourglass…` are found.
const OBJECTS: [&str; 3] = ["bunny", "wavy-cone", "building"];

/// Our router and the paper's.
const OURS: &str = "route-negotiated";
const PAPERS: &str = "route-fibar";

/// Mean detection distances that the paper reports: initial, optimised, mm.
const REPORTED: [[f64; 2]; 3] = [[843.0, 1543.0], [1618.7, 2028.2], [868.4, 1407.9]];

/// Columns: head, metric, digits after the point.
const COLUMNS: [(&str, &str, usize); 15] = [
    ("fibres", "light.fibres", 0),
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

/// Metrics, and the seconds of the route.
struct Measured {
    metrics: Value,
    route_s: f64,
}

pub fn run() {
    let folder = checkout().join("target/bench-routing");
    print_heads();
    for object in OBJECTS {
        let paper = Recipe::read(&checkout().join(format!("recipes/paper/{object}.toml")));
        let rerouted = paper.clone().map(|recipe| recipe.replaced(PAPERS, OURS));
        measure(&folder, object, "the paper's chain", paper);
        measure(&folder, object, "its markers, our router", rerouted);
        measure_ours(&folder, object);
    }
    hourglasses().iter().for_each(|object| measure_ours(&folder, object));
    print_reported(&folder);
}

fn measure_ours(folder: &Path, object: &str) {
    let recipe = Recipe::read(&checkout().join(format!("recipes/{object}.toml")));
    measure(folder, object, "ours", recipe);
}

/// Builds one chain and prints its row.
fn measure(folder: &Path, object: &str, chain: &str, recipe: Result<Recipe, String>) {
    let outcome = recipe.and_then(|recipe| build(folder, object, chain, recipe));
    print_row(&format!("{object}: {chain}"), &outcome);
}

fn hourglasses() -> Vec<String> {
    let files = std::fs::read_dir(checkout().join("recipes")).into_iter().flatten().flatten();
    let names = files.filter_map(|file| Some(file.file_name().to_str()?.strip_suffix(".toml")?.to_owned()));
    let mut names: Vec<String> = names.filter(|name| name.starts_with("hourglass")).collect();
    names.sort();
    names
}

/// Builds what routing and its measures need of a recipe, in the checkout's store: chains share what they
/// have in common, and a second bench runs nothing again.
fn build(folder: &Path, object: &str, chain: &str, recipe: Recipe) -> Result<Measured, String> {
    let name = format!("{object}-{}", chain.replace([' ', '\''], "-").replace(',', ""));
    let recipe = recipe.named(&name).for_routing();
    let path = folder.join(format!("{name}.toml"));
    std::fs::create_dir_all(folder).map_err(|e| e.to_string())?;
    std::fs::write(&path, recipe.text()).map_err(|e| e.to_string())?;
    let mut command = Command::new(executables().join("fibar"));
    command.current_dir(folder).env("FIBAR_STORE", checkout().join("target/store")).arg("build").arg(&path);
    let output = command.output().map_err(|e| e.to_string())?;
    let built = folder.join("build").join(&name);
    // Exit code 1 is a broken rule: measured all the same.
    match output.status.code() {
        Some(0 | 1) => read(&built),
        _ => Err(complaint(&String::from_utf8_lossy(&output.stderr))),
    }
}

/// The first error of a log.
fn complaint(log: &str) -> String {
    let line = log.lines().find(|line| line.starts_with("error")).or(log.lines().last());
    line.unwrap_or("it ended without a word").to_owned()
}

fn read(built: &Path) -> Result<Measured, String> {
    let json = |file: &str| -> Result<Value, String> {
        let path: PathBuf = built.join(file);
        let bytes = std::fs::read(&path).map_err(|e| format!("{}: {e}", path.display()))?;
        serde_json::from_slice(&bytes).map_err(|e| format!("{}: {e}", path.display()))
    };
    let (metrics, timings) = (json("metrics.json")?, json("timings.json")?);
    let stages = timings["stages"].as_array().cloned().unwrap_or_default();
    let route = stages.iter().find(|s| s["use"].as_str().is_some_and(|name| name.starts_with("route-")));
    let route_s = route.and_then(|stage| stage["made_in_s"].as_f64()).unwrap_or(f64::NAN);
    Ok(Measured { metrics, route_s })
}

fn print_heads() {
    println!(
        "Distances in mm, by verify-light and verify-clearance. Time of the route's process when it ran on this machine.\n"
    );
    let heads: Vec<&str> = COLUMNS.iter().map(|(head, _, _)| *head).collect();
    println!("| chain | route | {} |", heads.join(" | "));
    println!("| --- {}|", "| --- ".repeat(COLUMNS.len() + 1));
}

fn print_row(name: &str, outcome: &Result<Measured, String>) {
    match outcome {
        Ok(measured) => {
            let cell = |(_, metric, digits): &(&str, &str, usize)| measured.cell(metric, *digits);
            let cells: Vec<String> = COLUMNS.iter().map(cell).collect();
            println!("| {name} | {:.1} s | {} |", measured.route_s, cells.join(" | "));
        }
        Err(reason) => println!("| {name} | not measured: {reason} |"),
    }
}

impl Measured {
    fn cell(&self, metric: &str, digits: usize) -> String {
        let value = self.metrics[metric]["value"].as_f64();
        value.map_or("–".into(), |value| format!("{value:.digits$}"))
    }
}

/// The paper's own figures beside what the same estimate gives here.
fn print_reported(folder: &Path) {
    println!(
        "\n| object | reported, initial → optimised | our E_cam, initial → optimised | printed law, exact curve | monotone law |"
    );
    println!("| --- | --- | --- | --- | --- |");
    for (object, [initial, optimised]) in OBJECTS.iter().zip(REPORTED) {
        let built = folder.join("build").join(format!("{object}-the-paper-s-chain"));
        let Ok(measured) = read(&built) else { continue };
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
