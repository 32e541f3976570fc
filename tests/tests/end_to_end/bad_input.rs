//! Bad input ends in an exit code and an error that says what, where and what to try; and leaves nothing half written.

use fibar_tests::{Workshop, checkout};

/// The pebble's recipe with one text replaced, beside an object, built in a folder of its own.
#[track_caller]
fn check(from: &str, to: &str, object: &[u8], code: i32, says: &[&str]) {
    check_all(&[(from, to)], object, code, says);
}

/// The same with several texts replaced.
#[track_caller]
fn check_all(changes: &[(&str, &str)], object: &[u8], code: i32, says: &[&str]) {
    let workshop = Workshop::default();
    let mut recipe = std::fs::read_to_string(checkout().join("recipes/pebble.toml")).unwrap();
    for (from, to) in changes {
        assert!(from.is_empty() || recipe.contains(from), "{from:?} is not in the recipe");
        recipe = recipe.replacen(from, to, 1);
    }
    workshop.link_profiles();
    workshop.write("objects/pebble.obj", object);
    let path = workshop.write("pebble.toml", recipe);
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

/// Boxes one above the other as an OBJ: height, width and depth of each border, mm.
fn tower(borders: &[(f64, f64, f64)]) -> Vec<u8> {
    let mut text = String::new();
    for (z, width, depth) in borders {
        for (x, y) in [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)] {
            text.push_str(&format!("v {} {} {z}\n", x * width, y * depth));
        }
    }
    let top = 4 * (borders.len() - 1);
    text.push_str(&format!("f 1 4 3 2\nf {} {} {} {}\n", top + 1, top + 2, top + 3, top + 4));
    for storey in (0..top).step_by(4) {
        for k in 0..4 {
            let (a, b) = (storey + k + 1, storey + (k + 1) % 4 + 1);
            text.push_str(&format!("f {a} {b} {} {}\n", b + 4, a + 4));
        }
    }
    text.into_bytes()
}

#[test]
fn markers_closer_than_a_fibre_are_named_with_their_distance() {
    let crowded = [
        ("spacing_mm = 6.0", "spacing_mm = 2.5"),
        ("spacing_mm = 14.0", "spacing_mm = 2.5"),
        ("markers = 12", "markers = 150"),
    ];
    let says =
        ["stage `route`: markers ", " mm apart; their fibres need 3.85 mm", "place markers further apart"];
    check_all(&crowded, &pebble(), 3, &says);
}

#[test]
fn a_socket_outside_the_base_is_named_with_the_parameter() {
    let free = "layout = \"free\"\nplaces_mm = [[0, 0], [45, 0]]";
    let says =
        ["pebble.toml:19", "no room for the socket of LED 1", "(45.000, 0.000, 0.000) mm", "move this LED"];
    check_all(&[("count = 7\n", ""), ("pitch_mm = 9.0", free)], &pebble(), 2, &says);
}

#[test]
fn walls_thinner_than_a_fibre_bear_no_marker() {
    let fin = tower(&[(0.0, 60.0, 60.0), (20.0, 60.0, 60.0), (20.5, 60.0, 3.0), (80.0, 60.0, 3.0)]);
    let says =
        ["a fibre can arrive nowhere on the surface", "% is thinner than 8 mm", "make the object larger"];
    check("", "", &fin, 3, &says);
}

#[test]
fn places_that_no_led_reaches_are_told_before_and_in_routing() {
    let bell =
        [(0.0, 60.0, 60.0), (38.0, 60.0, 60.0), (48.0, 3.0, 3.0), (54.0, 3.0, 3.0), (64.0, 50.0, 50.0)];
    let bell = tower(&[&bell[..], &[(88.0, 50.0, 50.0)]].concat());
    let says = [
        "stage `route`: no fibre reaches marker ",
        "bends of 12 mm",
        "do not fit either",
        "others fit (on_misfit = \"drop\")",
    ];
    check("", "", &bell, 3, &says);
    let before =
        "[[stage]]\nuse = \"bound-light\"\neffort = \"quick\"\n\n[[stage]]\nuse = \"assign-covering\"";
    let says = ["no LED reaches ", "candidate places: they are left out"];
    check("[[stage]]\nuse = \"assign-covering\"", before, &bell, 3, &says);
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
