//! How well both routers do: whole chains on every object, hourglasses with narrow necks, ever more markers.
//!
//! Each recipe is cut down to what routing needs, bounds are added before the route, and `verify-light` and
//! `verify-clearance` say what came out; no figure is the router's own but its processor time, taken while it runs alone.

mod chains;
mod crowd;
mod hourglass;
mod measured;
mod router;

/// The parts whose names begin with the prefix.
pub fn run(prefix: &str) {
    let parts: [(&str, fn()); 3] =
        [("chains", chains::run), ("hourglass", hourglass::run), ("crowd", crowd::run)];
    parts.iter().filter(|(name, _)| name.starts_with(prefix)).for_each(|(_, run)| run());
}
