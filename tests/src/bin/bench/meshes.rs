//! A big mesh: reading it, beside reading, repairing and storing it. Processor time, which other work on the machine blurs least.

use super::cpu::{children_seconds, own_seconds};
use fibar_formats::Limits;
use fibar_tests::{Peer, checkout, executables};
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;
use std::process::Command;

/// Rows of a ball from pole to pole, and columns around it: 2 · 708 · (708 − 1) = 1,001,112 triangles.
const ROWS: usize = 708;
/// Readings together, as processor time is told in hundredths of a second.
const READINGS: usize = 15;
const BUILDS: usize = 5;

pub fn run() {
    println!(
        "| a rippled ball of {} triangles, binary STL | processor time | to merely parsing it | peak memory |",
        triangles()
    );
    println!("| --- | --- | --- | --- |");
    if let Err(reason) = measure() {
        println!("| skipped: {reason} | | | |");
    }
}

fn triangles() -> usize {
    2 * ROWS * (ROWS - 1)
}

fn measure() -> Result<(), String> {
    let folder = tempfile::tempdir_in(checkout().join("target")).map_err(|e| e.to_string())?;
    let path = folder.path().join("ball.stl");
    write_ball(&path).map_err(|e| e.to_string())?;
    let parsing = seconds_to_read(&path, &Limits::default())?;
    let print = |what: &str, seconds: f64, memory: &str| {
        println!("| {what} | {seconds:.3} s | {:.1} | {memory} |", seconds / parsing);
    };
    print("merely parsing it: `fibar_formats::read`, triangles with corners of their own", parsing, "");
    let sharing = Limits { shares_corners: true, ..Limits::default() };
    print("the same, equal corners shared", seconds_to_read(&path, &sharing)?, "");
    for (what, seconds) in peers(&path)? {
        print(&what, seconds, "");
    }
    let source = "[[stage]]\nuse = \"source-mesh\"\npath = \"ball.stl\"\n";
    let repair = "[[stage]]\nuse = \"repair-manifold\"\n";
    for (what, stages) in [
        ("`fibar build`: `source-mesh`, stored", source.to_string()),
        ("`fibar build`: `source-mesh` and `repair-manifold`, stored", format!("{source}{repair}")),
    ] {
        let recipe = format!("fibar = 1\n[object]\nname = \"ball\"\n{stages}");
        std::fs::write(folder.path().join("ball.toml"), recipe).map_err(|e| e.to_string())?;
        let mut usages = (0..BUILDS).map(|_| build(folder.path())).collect::<Result<Vec<_>, _>>()?;
        usages.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
        let Usage { seconds, megabytes } = &usages[BUILDS / 2];
        print(what, *seconds, &megabytes.map_or("not measured".into(), |m| format!("{m:.0} MB")));
    }
    Ok(())
}

fn seconds_to_read(path: &Path, limits: &Limits) -> Result<f64, String> {
    let now = || own_seconds().ok_or("no processor time is told here");
    let started = now()?;
    for _ in 0..READINGS {
        let file = File::open(path).map_err(|e| e.to_string())?;
        let read = fibar_formats::read(file, "stl", limits).map_err(|e| e.to_string())?;
        if read.mesh.triangles.len() != triangles() {
            return Err("triangles are missing".into());
        }
    }
    Ok((now()? - started) / READINGS as f64)
}

/// What readers of other people say that they take; none if they are not set up.
fn peers(path: &Path) -> Result<BTreeMap<String, f64>, String> {
    match Peer::Repair("read_stl.py").run(&[path]) {
        Some(outcome) => {
            serde_json::from_str(&outcome.stdout).map_err(|e| format!("{e}: {}", outcome.stderr))
        }
        None => Ok(BTreeMap::new()),
    }
}

/// What the processes of a build used: seconds of all together, and the greatest memory of any.
struct Usage {
    seconds: f64,
    megabytes: Option<f64>,
}

/// A build into an empty store.
fn build(folder: &Path) -> Result<Usage, String> {
    let store = folder.join("store");
    let _ = std::fs::remove_dir_all(&store);
    let mut command = match Path::new("/usr/bin/time").exists() {
        true => Command::new("/usr/bin/time"),
        false => Command::new("env"),
    };
    if command.get_program() == "/usr/bin/time" {
        command.args(["-f", "%M", "-o", "memory"]);
    }
    command.arg(executables().join("fibar")).args(["build", "ball.toml"]);
    let now = || children_seconds().ok_or("no processor time is told here");
    let started = now()?;
    super::stopwatch::once(command.current_dir(folder).env("FIBAR_STORE", &store))?;
    let seconds = now()? - started;
    let kilobytes = std::fs::read_to_string(folder.join("memory")).unwrap_or_default();
    Ok(Usage { seconds, megabytes: kilobytes.trim().parse::<f64>().ok().map(|k| k / 1e3) })
}

/// A ball of 50 mm with ripples of 1 mm.
fn write_ball(path: &Path) -> std::io::Result<()> {
    let mut file = BufWriter::new(File::create(path)?);
    file.write_all(&[b' '; 80])?;
    file.write_all(&(triangles() as u32).to_le_bytes())?;
    let corner = |row: usize, column: usize| {
        let (polar, around) = (PI * row as f64 / ROWS as f64, TAU * (column % ROWS) as f64 / ROWS as f64);
        let radius = 50.0 + (12.0 * polar).sin() * (9.0 * around).sin() * polar.sin();
        let (flat, up) = if row == 0 || row == ROWS {
            (0.0, if row == 0 { 1.0 } else { -1.0 })
        } else {
            (polar.sin(), polar.cos())
        };
        [radius * flat * around.cos(), radius * flat * around.sin(), radius * up].map(|x| x as f32)
    };
    for (row, column) in (0..ROWS).flat_map(|row| (0..ROWS).map(move |column| (row, column))) {
        let [a, b] = [corner(row, column), corner(row, column + 1)];
        let [c, d] = [corner(row + 1, column), corner(row + 1, column + 1)];
        if row > 0 {
            write_triangle(&mut file, [a, d, b])?;
        }
        if row + 1 < ROWS {
            write_triangle(&mut file, [a, c, d])?;
        }
    }
    file.flush()
}

fn write_triangle(file: &mut impl Write, corners: [[f32; 3]; 3]) -> std::io::Result<()> {
    file.write_all(&[0; 12])?;
    for x in corners.iter().flatten() {
        file.write_all(&x.to_le_bytes())?;
    }
    file.write_all(&[0; 2])
}
