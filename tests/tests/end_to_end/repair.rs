//! Meshes broken in known ways, mended by `repair-manifold`, and what it says of it.

use fibar_core::artefact::mesh::TriangleMesh;
use fibar_tests::broken::{Case, cases, large_cases, shapes, ways};
use fibar_tests::judge::{Judgement, farthest, placed};
use fibar_tests::{Outcome, Workshop, executables, is_full};
use serde_json::json;
use std::path::Path;
use std::process::Command;

/// Cases that `repair-manifold` does not get right, and in what: docs/repair-manifold.md says why.
const KNOWN: [(&str, &str); 0] = [];

/// What is wrong with a case's repair, and how far it moved anything, mm.
fn repair(case: &Case, folder: &Path) -> (Option<String>, f64) {
    let (mesh, request) = (folder.join("mesh.ply"), folder.join("request.json"));
    let out = folder.join("out");
    let _ = std::fs::remove_dir_all(&out);
    std::fs::write(&mesh, ways::soup(&case.mesh).to_ply()).unwrap();
    let asked = json!({ "params": {}, "inputs": { "mesh": [{ "path": mesh }] }, "out_dir": out });
    std::fs::write(&request, asked.to_string()).unwrap();
    let program = executables().join("repair-manifold");
    let outcome = Outcome::of(Command::new(program).arg("--request").arg(&request));
    if outcome.code != 0 {
        return (Some(format!("refused: {}", outcome.stdout)), 0.0);
    }
    let body = TriangleMesh::from_ply(&std::fs::read(out.join("body.ply")).unwrap()).unwrap();
    let body = placed(body, case.truth.sound.as_ref().unwrap_or(&case.mesh));
    let moved =
        case.truth.sound.as_ref().map_or(0.0, |sound| farthest(&body, sound).max(farthest(sound, &body)));
    let seen = Judgement::of(&body);
    let folded = (!seen.is_manifold).then(|| "not manifold".into());
    (folded.or_else(|| seen.differs_from(&case.truth)), moved)
}

#[test]
fn every_known_fault_is_mended() {
    let folder = tempfile::tempdir().unwrap();
    let large = if is_full() { large_cases() } else { Vec::new() };
    let mut unexpected = Vec::new();
    for case in cases().iter().chain(&large) {
        let (wrong, moved) = repair(case, folder.path());
        let known = KNOWN.iter().find(|(name, _)| *name == case.name).map(|(_, why)| (*why).to_owned());
        if wrong != known {
            unexpected.push(format!("{} ({}): {wrong:?}, {moved:.4} mm", case.name, case.what));
        }
    }
    assert!(unexpected.is_empty(), "{}", unexpected.join("\n"));
}

/// Takes several minutes: every real mesh is mended by every tool, and judged.
#[test]
fn what_any_peer_mends_of_real_meshes_is_mended() {
    if !is_full() {
        return;
    }
    let bench = Command::new(env!("CARGO_BIN_EXE_bench")).arg("repair/real").output().unwrap();
    let table = String::from_utf8(bench.stdout).unwrap();
    if table.contains("repair: skipped") {
        println!("{table}");
        return assert!(std::env::var_os("CI").is_none(), "the peers are not set up");
    }
    let lost: Vec<&str> = table.lines().filter(|line| line.starts_with("- lost")).collect();
    assert!(lost.is_empty(), "{}", lost.join("\n"));
    assert_eq!(table.lines().filter(|line| line.starts_with("| real-")).count(), 16, "{table}");
}

#[test]
fn a_build_says_what_was_repaired_and_where_it_could_not() {
    let workshop = Workshop::default();
    let recipe = |limit: &str| {
        format!(
            "fibar = 1\n[object]\nname = \"ring\"\n[[stage]]\nuse = \"source-mesh\"\npath = \"ring.off\"\nunits = \"mm\"\n[[stage]]\nuse = \"repair-manifold\"\n{limit}"
        )
    };
    let ring = ways::flipped(ways::sieved(shapes::torus(30.0, 12.0, 48, 24), 0.02, 1), 0.2, 2);
    workshop.write("ring.off", off(&ring));
    workshop.write("ring.toml", recipe(""));
    workshop.run(&["build", "ring.toml"]).expect(0);
    let build = workshop.opened("ring");
    for name in ["holes_closed", "triangles_turned", "cap_area_mm2", "bodies", "bodies_left"] {
        assert!(build.metric(&format!("repair.{name}")) > 0.0, "{name}");
    }
    assert_eq!(build.metric("repair.displacement_mm"), 0.0);
    let [before, after] = ["before", "after"].map(|when| build.metric(&format!("repair.volume_{when}_mm3")));
    assert!((before / after - 1.0).abs() < 1e-9);
    workshop.write("ring.toml", recipe("largest_hole_mm = 0.5\n"));
    workshop.run(&["build", "ring.toml"]).expect(3).says(&["open holes", "mm across", "largest_hole_mm"]);
}

/// A mesh as an OFF file.
fn off(mesh: &TriangleMesh) -> String {
    let vertices = mesh.vertices.iter().map(|v| format!("{} {} {}\n", v.x, v.y, v.z));
    let triangles = mesh.triangles.iter().map(|[a, b, c]| format!("3 {a} {b} {c}\n"));
    let counts = format!("OFF\n{} {} 0\n", mesh.vertices.len(), mesh.triangles.len());
    std::iter::once(counts).chain(vertices).chain(triangles).collect()
}
