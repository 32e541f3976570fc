//! Bad input ends in an exit code and an error that says what, where and what to try; and leaves nothing half written.

use fibar_tests::{Workshop, checkout};

/// The pebble's recipe with one text replaced, beside an object, built in a folder of its own.
#[track_caller]
fn check(from: &str, to: &str, object: &[u8], code: i32, says: &[&str]) {
    let workshop = Workshop::default();
    let recipe = std::fs::read_to_string(checkout().join("recipes/pebble.toml")).unwrap();
    assert!(from.is_empty() || recipe.contains(from), "{from:?} is not in the recipe");
    workshop.link_profiles();
    workshop.write("objects/pebble.obj", object);
    let path = workshop.write("pebble.toml", recipe.replacen(from, to, 1));
    workshop.run(&["build", path.to_str().unwrap()]).expect(code).says(says);
    let published = workshop.opened("pebble").files();
    let exports: Vec<&String> = published.iter().filter(|f| f.starts_with("object")).collect();
    assert!(exports.is_empty(), "{exports:?}");
}

fn pebble() -> Vec<u8> {
    std::fs::read(checkout().join("recipes/objects/pebble.obj")).unwrap()
}

#[test]
fn recipe_errors_name_line_and_key() {
    let pebble = pebble();
    check("pitch_mm", "pich_mm", &pebble, 2, &["pebble.toml:19", "pich_mm", "pitch_mm"]);
    check("pitch_mm = 9.0", "pitch_mm = -9.0", &pebble, 2, &["pebble.toml:19", "pitch_mm", "1"]);
    check("pitch_mm = 9.0", "pitch_mm = \"wide\"", &pebble, 2, &["pebble.toml:19", "pitch_mm", "number"]);
    check("\"socket-led\"", "\"socket-lead\"", &pebble, 2, &["pebble.toml:17", "socket-lead", "socket-led"]);
    check("fibar = 1", "fibar = 9", &pebble, 2, &["pebble.toml:2", "fibar", "1"]);
    check("[object]", "[object", &pebble, 2, &["pebble.toml:5"]);
}

#[test]
fn files_that_are_no_mesh_are_refused() {
    let pebble = pebble();
    let missing = ["pebble.toml:10", "objects/pebbles.obj", "did you mean \"pebble.obj\""];
    check("objects/pebble.obj", "objects/pebbles.obj", &pebble, 3, &missing);
    check("", "", b"", 3, &["pebble.toml:10", "empty", "export"]);
    check("", "", &pebble[..9_000], 3, &["pebble.toml:10", "line 339", "coordinates"]);
    check("", "", &lines(&pebble, 645), 3, &["pebble.toml:10", "no triangle"]);
    let repair = "use = \"repair-manifold\"";
    let strict = format!("{repair}\nlargest_hole_mm = 2.0");
    check(repair, &strict, &lines(&pebble, 1900), 3, &["open holes (2)", "mm", "largest_hole_mm"]);
}

/// The first lines of a file, whole.
fn lines(bytes: &[u8], count: usize) -> Vec<u8> {
    bytes.split_inclusive(|&byte| byte == b'\n').take(count).flatten().copied().collect()
}

#[test]
fn object_too_small_for_its_sockets_is_named_with_the_place() {
    let small = "path = \"objects/pebble.obj\"\nscale = 0.4";
    check("path = \"objects/pebble.obj\"", small, &pebble(), 3, &["socket", "mm", "pitch"]);
}

#[test]
fn plugin_that_dies_is_a_crash_with_a_way_to_run_it_again() {
    let workshop = Workshop::default();
    let script = "#!/bin/sh\nread hello\necho '{\"type\":\"hello\"'\nexit 3\n";
    let plugin = workshop.write("plugins/source-mesh", script);
    use std::os::unix::fs::PermissionsExt;
    std::fs::set_permissions(&plugin, std::fs::Permissions::from_mode(0o755)).unwrap();
    workshop.build("recipes/pebble.toml", &["--plugin-path", "plugins"]).expect(5).says(&["source-mesh"]);
}
