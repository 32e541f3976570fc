//! A big mesh: reading it, beside reading, repairing and storing it.

use super::stopwatch::{several, text};
use fibar_formats::Limits;
use fibar_tests::{checkout, executables};
use std::f64::consts::{PI, TAU};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

/// Rows of a ball from pole to pole, and columns around it: 2 · 708 · (708 − 1) = 1,001,112 triangles.
const ROWS: usize = 708;

pub fn run() {
    println!(
        "| a rippled ball of {} triangles, binary STL | time | to merely reading | peak memory |",
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
    let [_, reading] = several(5, || read(&path))?;
    println!("| merely reading it (`fibar_formats::read`) | {} | 1 | |", text(reading));
    let source = "[[stage]]\nuse = \"source-mesh\"\npath = \"ball.stl\"\n";
    let repair = "[[stage]]\nuse = \"repair-manifold\"\n";
    let ratio = |time: Duration| time.as_secs_f64() / reading.as_secs_f64();
    for (what, stages) in [
        ("`source-mesh`, stored", source.to_string()),
        ("`source-mesh` and `repair-manifold`, stored", format!("{source}{repair}")),
    ] {
        let recipe = format!("fibar = 1\n[object]\nname = \"ball\"\n{stages}");
        std::fs::write(folder.path().join("ball.toml"), recipe).map_err(|e| e.to_string())?;
        let mut memory = String::new();
        let [_, building] = several(3, || {
            let (time, peak) = build(folder.path())?;
            memory = peak;
            Ok(time)
        })?;
        println!("| {what} | {} | {:.1} | {memory} |", text(building), ratio(building));
    }
    Ok(())
}

fn read(path: &Path) -> Result<Duration, String> {
    let started = Instant::now();
    let file = File::open(path).map_err(|e| e.to_string())?;
    let read = fibar_formats::read(file, "stl", &Limits::default()).map_err(|e| e.to_string())?;
    let took = started.elapsed();
    if read.mesh.triangles.len() == triangles() { Ok(took) } else { Err("triangles are missing".into()) }
}

/// A build into an empty store; its time, and the greatest memory of any of its processes.
fn build(folder: &Path) -> Result<(Duration, String), String> {
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
    let took = super::stopwatch::once(command.current_dir(folder).env("FIBAR_STORE", &store))?;
    let kilobytes = std::fs::read_to_string(folder.join("memory")).unwrap_or_default();
    let peak =
        kilobytes.trim().parse::<f64>().map_or("not measured".into(), |k| format!("{:.0} MB", k / 1e3));
    Ok((took, peak))
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
