//! What must hold of every reader whatever bytes it is given: no panic, and what is accepted keeps its promises.
//!
//! `tests/fuzz` looks for bytes that break them; `tests/tests/corpus.rs` replays those that are kept.

use fibar_core::artefact::Document;
use fibar_core::artefact::constellation::Constellation;
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_core::artefact::routes::Routes;
use fibar_core::artefact::sites::Sites;
use fibar_core::artefact::sockets::Sockets;
use fibar_core::artefact::solids::Solids;
use fibar_core::artefact::verdict::Verdict;
use fibar_core::protocol::{HostMessage, PluginMessage};
use fibar_engine::recipe::{Matrix, Recipe};

/// Every target: its name, which is that of its corpus, and what it does with bytes.
pub const TARGETS: [(&str, fn(&[u8])); 7] = [
    ("stl", |bytes| mesh_file(bytes, "stl")),
    ("obj", |bytes| mesh_file(bytes, "obj")),
    ("ply", |bytes| mesh_file(bytes, "ply")),
    ("artefact-mesh", artefact_mesh),
    ("artefact-json", artefact_json),
    ("protocol", protocol),
    ("recipe", recipe),
];

/// Runs the target of this name.
pub fn run(target: &str, bytes: &[u8]) {
    let (_, check) = TARGETS.iter().find(|(name, _)| *name == target).expect("targets are in the table");
    check(bytes);
}

/// A file of somebody else's, in the format of an extension.
fn mesh_file(bytes: &[u8], extension: &str) {
    let Ok(mesh) = fibar_formats::read_mesh(bytes, extension) else { return };
    let count = mesh.vertices.len();
    assert!(mesh.vertices.iter().all(|v| v.is_finite()), "a vertex is not finite");
    assert!(mesh.triangles.iter().flatten().all(|&v| (v as usize) < count), "a triangle has unknown corners");
    assert!(!mesh.triangles.is_empty(), "a mesh without triangles was accepted");
}

/// The exchange form between stages: what is read is written back to the same bytes.
fn artefact_mesh(bytes: &[u8]) {
    if let Ok(mesh) = TriangleMesh::from_ply(bytes) {
        assert_eq!(mesh.to_ply(), bytes);
    }
}

/// Documents: what is read keeps its promises when written and read again.
fn artefact_json(bytes: &[u8]) {
    fn check<T: Document>(bytes: &[u8]) {
        let Ok(document) = T::from_json(bytes) else { return };
        let written = document.to_json();
        let again = T::from_json(&written).expect("what was accepted is accepted again");
        assert_eq!(again.to_json(), written);
    }
    check::<Constellation>(bytes);
    check::<Routes>(bytes);
    check::<Sites>(bytes);
    check::<Sockets>(bytes);
    check::<Solids>(bytes);
    check::<Verdict>(bytes);
}

/// Messages of either side.
fn protocol(bytes: &[u8]) {
    fn check<T: serde::Serialize + serde::de::DeserializeOwned>(bytes: &[u8]) {
        let Ok(message) = serde_json::from_slice::<T>(bytes) else { return };
        let written = serde_json::to_vec(&message).expect("messages hold no map with non-string keys");
        serde_json::from_slice::<T>(&written).expect("what was accepted is accepted again");
    }
    check::<HostMessage>(bytes);
    check::<PluginMessage>(bytes);
}

/// A recipe with its variants: whatever is wrong is a finding, and every finding can be shown.
fn recipe(bytes: &[u8]) {
    let folder = tempfile::tempdir().expect("a temporary folder can be made");
    let path = folder.path().join("recipe.toml");
    std::fs::write(&path, bytes).expect("the folder can be written");
    let findings = match Recipe::read(&path, &[], Matrix::Expand) {
        Ok(reading) => reading.findings,
        Err(error) => error.findings,
    };
    findings.iter().for_each(|finding| assert!(!finding.render().is_empty()));
}
