//! Broken meshes, known and real, mended by `repair-manifold` and by the tools of other people, judged by one judge.

mod outcome;
mod table;
mod workbench;

use fibar_core::artefact::mesh::TriangleMesh;
use fibar_tests::broken::Truth;
use outcome::{Outcome, Said};
use workbench::Workbench;

/// Tools in the order of their columns; a peer with two settings counts with its better one.
const TOOLS: [(&str, &[&str]); 5] = [
    ("repair-manifold", &["repair-manifold"]),
    ("pymeshfix", &["pymeshfix", "pymeshfix-largest"]),
    ("admesh", &["admesh"]),
    ("trimesh", &["trimesh"]),
    ("Manifold import", &["manifold"]),
];

/// A mesh to mend; of real ones the truth is unknown.
struct Patient {
    name: String,
    what: String,
    mesh: TriangleMesh,
    truth: Option<Truth>,
}

/// A mesh, and what each tool made of it, in the order of [`TOOLS`].
struct Row {
    patient: Patient,
    outcomes: Vec<Outcome>,
}

/// Runs it for the meshes whose names begin with a word.
pub fn run(prefix: &str) {
    match rows(prefix) {
        Ok(rows) => table::print(&rows),
        Err(reason) => println!("repair: skipped, {reason}"),
    }
}

fn rows(prefix: &str) -> Result<Vec<Row>, String> {
    let bench = Workbench::set_up()?;
    let patients = bench.patients(prefix)?;
    let said = bench.mend()?;
    patients.into_iter().map(|patient| row(&bench, patient, &said)).collect()
}

fn row(bench: &Workbench, patient: Patient, said: &workbench::Results) -> Result<Row, String> {
    let of = |tool: &&str| -> Result<Outcome, String> {
        let said: &Said =
            said.of(&patient.name, tool).ok_or_else(|| format!("{tool} said nothing of {}", patient.name))?;
        Ok(Outcome::judge(&patient, said, bench.result(&patient.name, tool)))
    };
    let best = |settings: &[&str]| -> Result<Outcome, String> {
        let outcomes = settings.iter().map(of).collect::<Result<Vec<_>, _>>()?;
        Ok(outcomes.into_iter().min_by(Outcome::compare).expect("a tool has a setting"))
    };
    let outcomes = TOOLS.iter().map(|(_, settings)| best(settings)).collect::<Result<_, _>>()?;
    Ok(Row { patient, outcomes })
}
