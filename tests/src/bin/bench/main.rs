//! `cargo xtask bench [NAME]`: ratios to peers, measured in one run on one machine. Nothing here fails on a slow one.
//! `repair/hole` is the bench `repair` on the meshes whose names begin with `hole`; `routing/hourglass`, `routing/crowd` and
//! `routing/chains` are parts of the bench `routing`.

mod cpu;
mod engine;
mod markers;
mod meshes;
mod peers;
mod recipe;
mod repair;
mod routing;
mod stopwatch;

fn main() {
    let names: Vec<String> = std::env::args().skip(1).collect();
    let wanted = |name: &str| names.is_empty() || names.iter().any(|n| n == name);
    if wanted("engine") {
        engine::run();
    }
    if wanted("markers") {
        markers::run();
    }
    if wanted("meshes") {
        meshes::run();
    }
    if let Some(prefix) = part_of("repair", &names) {
        repair::run(prefix);
    }
    if let Some(prefix) = part_of("routing", &names) {
        routing::run(prefix);
    }
}

/// What follows `bench/` in the names, nothing if the whole bench is wanted; none if it is not.
fn part_of<'a>(bench: &str, names: &'a [String]) -> Option<&'a str> {
    if names.is_empty() || names.iter().any(|name| name == bench) {
        return Some("");
    }
    names.iter().find_map(|name| name.strip_prefix(bench)?.strip_prefix('/'))
}
