//! The folder that all tools work in: meshes in, results out.

use super::Patient;
use super::outcome::Said;
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_formats::Limits;
use fibar_tests::broken::{cases, large_cases};
use fibar_tests::{Peer, checkout, executables};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

/// `target/bench/repair`; it stays, so that one may look.
pub struct Workbench {
    folder: PathBuf,
}

/// What every tool said of every mesh.
#[derive(serde::Deserialize)]
pub struct Results {
    #[serde(rename = "starts")]
    _starts: BTreeMap<String, f64>,
    #[serde(flatten)]
    said: BTreeMap<String, BTreeMap<String, Said>>,
}

impl Results {
    /// A tool's word on a mesh.
    pub fn of(&self, mesh: &str, tool: &str) -> Option<&Said> {
        self.said.get(mesh)?.get(tool)
    }
}

#[derive(serde::Deserialize)]
struct Real {
    name: String,
    what: String,
}

impl Workbench {
    /// An empty folder.
    pub fn set_up() -> Result<Workbench, String> {
        let folder = checkout().join("target/bench/repair");
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
        Ok(Workbench { folder })
    }

    /// Meshes whose names begin with a word, written for the tools: ours, then those of packages.
    pub fn patients(&self, prefix: &str) -> Result<Vec<Patient>, String> {
        let mut patients = Vec::new();
        for case in cases().into_iter().chain(large_cases()).filter(|case| case.name.starts_with(prefix)) {
            write_stl(&self.path(case.name, "stl"), &case.mesh).map_err(|e| e.to_string())?;
            let (name, what) = (case.name.to_owned(), case.what.to_owned());
            patients.push(Patient { name, what, mesh: case.mesh, truth: Some(case.truth) });
        }
        for Real { name, what } in self.real()? {
            if name.starts_with(prefix) {
                let mesh = read(&self.path(&name, "stl"))?;
                patients.push(Patient { name, what, mesh, truth: None });
            } else {
                let _ = std::fs::remove_file(self.path(&name, "stl"));
            }
        }
        for patient in &patients {
            let soup = read(&self.path(&patient.name, "stl"))?;
            std::fs::write(self.path(&patient.name, "ply"), soup.to_ply()).map_err(|e| e.to_string())?;
        }
        Ok(patients)
    }

    fn real(&self) -> Result<Vec<Real>, String> {
        let npm = checkout().join("target/peers/meshes/node_modules");
        let said = run(Peer::Repair("repair_meshes.py"), &[&self.folder, &npm])?;
        said.lines().map(|line| serde_json::from_str(line).map_err(|e| format!("{line}: {e}"))).collect()
    }

    /// Lets every tool mend every mesh.
    pub fn mend(&self) -> Result<Results, String> {
        run(Peer::Repair("repair_tools.py"), &[&self.folder, &executables().join("repair-manifold")])?;
        let path = self.path("repaired", "json");
        let text = std::fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
        serde_json::from_str(&text).map_err(|e| format!("{}: {e}", path.display()))
    }

    /// What a tool made of a mesh.
    pub fn result(&self, name: &str, tool: &str) -> Option<TriangleMesh> {
        let bytes = std::fs::read(self.path(&format!("{name}.{tool}"), "ply")).ok()?;
        TriangleMesh::from_ply(&bytes).ok()
    }

    fn path(&self, name: &str, extension: &str) -> PathBuf {
        self.folder.join(format!("{name}.{extension}"))
    }
}

fn run(peer: Peer, arguments: &[&Path]) -> Result<String, String> {
    let outcome = peer.run(arguments).ok_or("the tools of other people are not set up")?;
    if outcome.code == 0 { Ok(outcome.stdout) } else { Err(outcome.stderr) }
}

fn read(path: &Path) -> Result<TriangleMesh, String> {
    let file = File::open(path).map_err(|e| format!("{}: {e}", path.display()))?;
    Ok(fibar_formats::read(file, "stl", &Limits::default()).map_err(|e| e.to_string())?.mesh)
}

fn write_stl(path: &Path, mesh: &TriangleMesh) -> std::io::Result<()> {
    let mut file = BufWriter::new(File::create(path)?);
    file.write_all(&[b' '; 80])?;
    file.write_all(&(mesh.triangles.len() as u32).to_le_bytes())?;
    for t in 0..mesh.triangles.len() {
        file.write_all(&[0; 12])?;
        for x in mesh.corners(t).iter().flat_map(|corner| corner.to_array()) {
            file.write_all(&(x as f32).to_le_bytes())?;
        }
        file.write_all(&[0; 2])?;
    }
    file.flush()
}
