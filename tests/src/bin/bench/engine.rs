//! The engine's own time: nothing to do, many variants, many small stages; and peers on the same chain.

use super::peers::{PEERS, Peer};
use super::stopwatch::{once, several, text};
use fibar_tests::{checkout, executables};
use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

const STAGES: usize = 20;
const WORK: Duration = Duration::from_millis(100);

pub fn run() {
    println!("| engine | target | measured |\n| --- | --- | --- |");
    for (what, target, result) in [
        ("no-op build of recipes/bunny.toml, whole process", "≤ 50 ms", noop()),
        ("plan of 1,000 variants of the bunny, whole process", "< 1 s", variants()),
    ] {
        println!("| {what} | {target} | {} |", result.unwrap_or_else(|e| format!("skipped: {e}")));
    }
    println!("\n| chain of {STAGES} stages of 0.1 s | first build | overhead per stage | nothing to do |");
    println!("| --- | --- | --- | --- |");
    for sandbox in ["auto", "off"] {
        row(&format!("fibar, sandbox {sandbox}"), fibar(sandbox));
    }
    for peer in &PEERS {
        row(peer.name, (peer.install)().and_then(|()| measure_peer(peer)));
    }
}

fn row(name: &str, times: Result<[Duration; 2], String>) {
    match times {
        Ok([first, again]) => {
            let overhead = first.saturating_sub(WORK * STAGES as u32) / STAGES as u32;
            println!("| {name} | {} | {} | {} |", text(first), text(overhead), text(again));
        }
        Err(reason) => println!("| {name} | skipped: {} | | |", reason.lines().last().unwrap_or_default()),
    }
}

/// The program with a store of its own.
fn program(folder: &Path) -> Command {
    let mut command = Command::new(executables().join("fibar"));
    command.current_dir(folder).env("FIBAR_STORE", folder.join("store"));
    command
}

fn folder() -> tempfile::TempDir {
    tempfile::tempdir_in(checkout().join("target")).expect("target can be written")
}

/// The bunny from the checkout's own store, built first if need be.
fn noop() -> Result<String, String> {
    let folder = folder();
    let build = || {
        let mut command = program(folder.path());
        command.env("FIBAR_STORE", checkout().join("target/store"));
        command.arg("build").arg(checkout().join("recipes/bunny.toml"));
        command
    };
    once(&mut build())?;
    let [best, median] = several(21, || once(&mut build()))?;
    Ok(format!("{} (best {})", text(median), text(best)))
}

fn variants() -> Result<String, String> {
    let folder = folder();
    let numbers = |n: u32| (0..n).map(|i| (10 + i).to_string()).collect::<Vec<_>>().join(", ");
    let recipe = std::fs::read_to_string(checkout().join("recipes/bunny.toml")).map_err(|e| e.to_string())?;
    let matrix = format!(
        "\n[matrix]\n\"place-visibility.spacing_mm\" = [{}]\n\"assign-genetic.seed\" = [{}]\n",
        numbers(100),
        numbers(10)
    );
    std::fs::write(folder.path().join("many.toml"), recipe + &matrix).map_err(|e| e.to_string())?;
    let object = checkout().join("recipes/objects/stanford-bunny.obj");
    let plan = || {
        let mut command = program(folder.path());
        command
            .args(["plan", "many.toml", "--matrix", "--set"])
            .arg(format!("source-mesh.path={}", object.display()));
        command
    };
    once(&mut plan())?;
    let [best, median] = several(5, || once(&mut plan()))?;
    Ok(format!("{} (best {})", text(median), text(best)))
}

/// First build and nothing to do, of the chain.
fn fibar(sandbox: &str) -> Result<[Duration; 2], String> {
    let folder = folder();
    let plugins = folder.path().join("plugins");
    std::fs::create_dir(&plugins).map_err(|e| e.to_string())?;
    for name in ["make-text", "pass-text"] {
        std::fs::copy(executables().join("examples/demo-stages"), plugins.join(name))
            .map_err(|e| e.to_string())?;
    }
    let mut recipe = "fibar = 1\n[object]\nname = \"chain\"\n[[stage]]\nuse = \"make-text\"\n".to_owned();
    for i in 0..STAGES {
        let _ = write!(recipe, "[[stage]]\nuse = \"pass-text\"\nseconds = 0.1\nword = \"{i}\"\n");
    }
    std::fs::write(folder.path().join("chain.toml"), recipe).map_err(|e| e.to_string())?;
    let build = || {
        let mut command = program(folder.path());
        command.args(["build", "chain.toml", "--plugin-path", "plugins", "--sandbox", sandbox]);
        command
    };
    let first = several(3, || {
        let _ = std::fs::remove_dir_all(folder.path().join("store"));
        once(&mut build())
    })?;
    Ok([first[1], several(5, || once(&mut build()))?[1]])
}

fn measure_peer(peer: &Peer) -> Result<[Duration; 2], String> {
    let mut firsts = Vec::new();
    let mut again = Duration::ZERO;
    for _ in 0..3 {
        let folder = folder();
        (peer.prepare)(folder.path(), STAGES);
        firsts.push(once(&mut (peer.command)(folder.path()))?);
        again = once(&mut (peer.command)(folder.path()))?;
    }
    firsts.sort();
    Ok([firsts[1], again])
}
