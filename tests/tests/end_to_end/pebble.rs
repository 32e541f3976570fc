//! The pebble: what a store by content spares.

use fibar_tests::{Workshop, checkout};

#[test]
fn only_what_a_change_touches_runs_again() {
    let workshop = Workshop::default();
    let pebble = workshop.opened("pebble");
    let check = |arguments: &[&str], expected: usize| {
        workshop.build("recipes/pebble.toml", arguments).expect(0);
        assert_eq!(pebble.executed(), expected, "{arguments:?}");
    };
    check(&[], 11);
    check(&[], 0);
    // The GLB, the 3MF and the verifiers hang on the routes, the routes on the markers.
    check(&["--set", "sweep-solids.skin_mm=0.5"], 3);
    check(&["--set", "verify-light.allow=[]"], 0);
    check(&[], 0);
}

#[test]
fn unchanged_bytes_stop_the_rebuild() {
    let workshop = Workshop::default();
    let recipe = std::fs::read_to_string(checkout().join("recipes/pebble.toml")).unwrap();
    let object = std::fs::read_to_string(checkout().join("recipes/objects/pebble.obj")).unwrap();
    workshop.link_profiles();
    workshop.write("objects/pebble.obj", &object);
    let path = workshop.write("pebble.toml", &recipe);
    let build = || workshop.run(&["build", path.to_str().unwrap()]).expect(0);
    build();
    assert_eq!(workshop.opened("pebble").executed(), 11);
    workshop.write("objects/pebble.obj", format!("# another comment\n{object}"));
    build();
    assert_eq!(workshop.opened("pebble").executed(), 1, "the file is read again, its mesh is the same");
}
