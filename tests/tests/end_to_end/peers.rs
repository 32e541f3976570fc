//! What other people's readers say of the exports.

use crate::bunny::bunny;
use fibar_tests::{Peer, checkout};

#[test]
fn lib3mf_reads_the_spec_profile_without_a_warning() {
    if let Some(outcome) = Peer::Python("check_lib3mf.py").run(&[&bunny().path("object.3mf")]) {
        outcome.expect(0);
    }
}

#[test]
fn prusa_slicer_uses_all_five_tools_for_the_right_volumes() {
    let printer = checkout().join("profiles/printers/five-tools-prusa.ini");
    let build = bunny();
    let files = [build.path("object-prusa.3mf"), printer, build.path("object.3mf")];
    if let Some(outcome) = Peer::Python("check_prusa.py").run(&files.each_ref().map(|f| f.as_path())) {
        outcome.expect(0);
    }
}

#[test]
fn gltf_validator_finds_no_error() {
    if let Some(outcome) = Peer::Node("check_gltf.mjs").run(&[&bunny().path("object.glb")]) {
        outcome.expect(0);
    }
}
