//! Names of CAD parts, from a STEP file to the 3MF, read back by build123d's Mesher. Slow: only with `--full`.

use fibar_formats::Limits;
use fibar_tests::{Outcome, Workshop, checkout};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A house in STEP with a few fibres: what the paper's router does not promise is waived.
const RECIPE: &str = r#"
fibar = 1
[object]
name = "house"
[[stage]]
use = "source-build123d"
path = "house.step"
[[stage]]
use = "repair-manifold"
[[stage]]
use = "socket-led"
count = 7
pitch_mm = 9.0
[[stage]]
use = "place-visibility"
spacing_mm = 16.0
seed = 1
[[stage]]
use = "assign-genetic"
seed = 7
[[stage]]
use = "route-fibar"
[[stage]]
use = "sweep-solids"
[[stage]]
use = "export-3mf"
[[stage]]
use = "verify-solids"
allow = ["solids.min_wall", "solids.fibre_gap"]
"#;

/// An interpreter that has build123d: that of the stage's own environment, which the store keeps.
fn python(store: &Path) -> PathBuf {
    let environments = std::fs::read_dir(store.join("environments")).unwrap().flatten();
    let mut found = environments.map(|e| e.path().join("bin/python")).filter(|python| {
        Command::new(python).args(["-c", "import build123d"]).output().is_ok_and(|out| out.status.success())
    });
    found.next().expect("the build has set up an environment with build123d")
}

/// Runs a script of `tests/peers` and gives what it printed.
fn run(python: &Path, script: &str, file: &Path) -> String {
    let script = checkout().join("tests/peers").join(script);
    Outcome::of(Command::new(python).arg(script).arg(file)).expect(0).stdout
}

#[test]
fn labels_of_a_step_file_are_on_the_objects_of_the_3mf() {
    if !fibar_tests::is_full() {
        return;
    }
    let workshop = Workshop::default();
    let store = checkout().join("target/store");
    let build = |recipe: &Path| {
        let recipe = recipe.to_str().unwrap();
        Outcome::of(workshop.program(&["build", recipe]).env("FIBAR_STORE", &store))
    };
    // Something to set up the environment with, which then writes the STEP file.
    workshop.write("first.py", "from build123d import Box\nresult = Box(30, 30, 30)\n");
    let first =
        "fibar = 1\n[object]\nname = \"first\"\n[[stage]]\nuse = \"source-build123d\"\npath = \"first.py\"\n";
    build(&workshop.write("first.toml", first)).expect(0);
    let python = python(&store);
    let step = workshop.path().join("house.step");
    run(&python, "labelled_house.py", &step);
    build(&workshop.write("house.toml", RECIPE)).expect(0);
    let path = workshop.opened("house").path("object.3mf");

    let file = fibar_formats::read(std::fs::File::open(&path).unwrap(), "3mf", &Limits::default()).unwrap();
    let volume = |part: &fibar_formats::Part| file.mesh.volume_of(part.triangles.clone());
    let ours: BTreeMap<&str, f64> =
        file.parts.iter().map(|part| (part.name.as_str(), volume(part))).collect();
    for name in
        ["tower & walls / skin", "tower & walls / filler", "roof / skin", "roof / filler", "core-led0"]
    {
        assert!(ours.contains_key(name), "{name:?} is not among {:?}", ours.keys());
    }
    let colour = |name: &str| file.parts.iter().find(|part| part.name == name).unwrap().colour.unwrap();
    assert_ne!(colour("roof / skin"), colour("tower & walls / skin"));

    let text = run(&python, "read_by_mesher.py", &path);
    let theirs: BTreeMap<&str, f64> = text
        .lines()
        .map(|line| line.split_once('\t').unwrap())
        .map(|(n, v)| (n, v.parse().unwrap()))
        .collect();
    assert_eq!(theirs.keys().collect::<Vec<_>>(), ours.keys().collect::<Vec<_>>());
    for (name, volume) in &theirs {
        // Its kernel sews triangles within a tolerance of its own: slivers go.
        assert!((volume / ours[name] - 1.0).abs() < 1e-5, "{name}: {volume} mm³, not {}", ours[name]);
    }
    let total: f64 = ours.values().sum();
    println!("{} objects, {total:.1} mm³", ours.len());
}
