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
use fibar_formats::Limits;
use std::io::{Cursor, Write};
use zip::write::{SimpleFileOptions, ZipWriter};

/// A target's name and what it does with bytes.
pub type Target = (&'static str, fn(&[u8]));

/// Every target: its name, which is that of its corpus, and what it does with bytes.
pub const TARGETS: [Target; 11] = [
    ("stl", |bytes| mesh_file(bytes, "stl")),
    ("obj", |bytes| mesh_file(bytes, "obj")),
    ("ply", |bytes| mesh_file(bytes, "ply")),
    ("off", |bytes| mesh_file(bytes, "off")),
    ("3mf", |bytes| mesh_file(bytes, "3mf")),
    ("3mf-model", model_3mf),
    ("gltf", |bytes| mesh_file(bytes, "gltf")),
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
    let limits =
        Limits { triangles: 100_000, mends_3mf: bytes.len() % 2 == 1, shares_corners: bytes.len() % 4 > 1 };
    let Ok(file) = fibar_formats::read(Cursor::new(bytes), extension, &limits) else { return };
    let mesh = &file.mesh;
    let count = mesh.vertices.len();
    assert!(mesh.vertices.iter().all(|v| v.is_finite()), "a vertex is not finite");
    assert!(mesh.triangles.iter().flatten().all(|&v| (v as usize) < count), "a triangle has unknown corners");
    let triangles = mesh.triangles.len();
    assert!((1..=100_000).contains(&triangles), "{triangles} triangles were accepted");
    assert!(file.parts.iter().all(|p| p.triangles.start <= p.triangles.end && p.triangles.end <= triangles));
}

/// The model part of a 3MF document that is sound otherwise: what a check sum would keep from being looked at.
fn model_3mf(bytes: &[u8]) {
    let types = r#"<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types"><Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/><Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>"#;
    let relationships = r#"<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship Target="/3D/3dmodel.model" Id="a" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>"#;
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let stored = SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
    let files = [
        ("[Content_Types].xml", types.as_bytes()),
        ("_rels/.rels", relationships.as_bytes()),
        ("3D/3dmodel.model", bytes),
    ];
    for (name, content) in files {
        zip.start_file(name, stored).expect("the archive is in memory");
        zip.write_all(content).expect("the archive is in memory");
    }
    mesh_file(zip.finish().expect("the archive is in memory").get_ref(), "3mf");
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
