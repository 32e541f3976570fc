//! `cargo xtask bench [NAME]`: ratios to peers, measured in one run on one machine. Nothing here fails on a slow one.
//! `repair/hole` is the bench `repair` on the meshes whose names begin with `hole`.

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
    if names.is_empty() || names.iter().any(|n| n == "repair" || n.starts_with("repair/")) {
        let prefix = names.iter().find_map(|n| n.strip_prefix("repair/")).unwrap_or_default();
        repair::run(prefix);
    }
    if wanted("routing") {
        routing::run();
    }
}
