//! The bunny: built once for all tests here, and once more with another thread count.

use fibar_core::artefact::Document;
use fibar_core::artefact::constellation::Constellation;
use fibar_core::artefact::routes::Routes;
use fibar_core::artefact::sockets::Sockets;
use fibar_tests::{Build, Workshop};
use std::sync::LazyLock;

static WORKSHOP: LazyLock<Workshop> = LazyLock::new(|| {
    let workshop = Workshop::default();
    workshop.build("recipes/bunny.toml", &[]).expect(0);
    workshop
});

/// The bunny, built.
pub fn bunny() -> Build {
    WORKSHOP.opened("bunny")
}

/// Files whose bytes a recipe determines.
const FILES: [&str; 8] = [
    "body.ply",
    "constellation.json",
    "metrics.json",
    "object-prusa.3mf",
    "object.3mf",
    "object.glb",
    "routes.json",
    "sockets.json",
];

#[test]
fn everything_is_there() {
    let files = bunny().files();
    for name in FILES.iter().chain(&["timings.json", "cutaway.png", "routes.png"]) {
        assert!(files.iter().any(|f| f == name), "{name} is missing among {files:?}");
    }
}

#[test]
fn metrics_hold_what_the_recipe_promises() {
    let check = |name: &str, range: std::ops::RangeInclusive<f64>| {
        let value = bunny().metric(name);
        assert!(range.contains(&value), "{name} is {value}, expected {range:?}");
    };
    // Four triangles of each of 3,674; as long as before, and inside the box.
    check("subdivide.triangles", 14696.0..=14696.0);
    check("subdivide.growth_y_mm", -1e-9..=1e-9);
    check("subdivide.growth_x_mm", -1.0..=1e-9);
    check("subdivide.growth_z_mm", -1.0..=1e-9);
    check("subdivide.displacement_mm", 0.5..=3.0);
    check("place.markers", 55.0..=75.0);
    check("assign.blind_directions", 0.0..=0.0);
    check("light.bound_share", 0.95..=1.0);
    check("light.certified_share", 0.5..=1.0);
    check("light.mean_d_cam_mm", 1500.0..=4000.0);
    check("light.share_over_700mm", 0.95..=1.0);
    check("light.track_range_mm", 1000.0..=2000.0);
    check("light.length_below_20mm_share", 0.0..=0.05);
    check("clearance.min_gap_mm", 0.1..=100.0);
    check("clearance.colliding_pairs", 0.0..=0.0);
    check("clearance.min_wall_mm", 0.0..=100.0);
    check("clearance.min_bend_radius_mm", 12.0..=1000.0);
    check("recognise.views_mseq_share", 1.0..=1.0);
    check("recognise.views_6_share", 0.99..=1.0);
    check("recognise.ours_rate_missing_00", 0.999..=1.0);
    check("recognise.ours_rate_missing_30", 0.995..=1.0);
    check("solids.overlap_mm3", 0.0..=0.1);
    check("solids.min_skin_mm", 0.4..=0.5);
    check("solids.volume_error_ratio", 0.0..=1e-3);
    check("solids.components", 23.0..=400.0);
}

#[test]
fn every_marker_has_its_fibre() {
    let routes = Routes::from_json(&bunny().read("routes.json")).unwrap();
    let sockets = Sockets::from_json(&bunny().read("sockets.json")).unwrap();
    let constellation = Constellation::from_json(&bunny().read("constellation.json")).unwrap();
    assert_eq!(sockets.sockets.len(), 7);
    assert_eq!(routes.fibres.len(), constellation.markers.len());
    for fibre in &routes.fibres {
        let marker = constellation.markers.iter().find(|m| m.id == fibre.marker).unwrap();
        let socket = sockets.sockets.iter().find(|s| s.led == fibre.led).unwrap();
        assert_eq!((fibre.pattern, fibre.pattern), (marker.pattern, socket.pattern));
        // A core's mouth lies under the LED's dome: within 2.5 mm less its radius.
        assert!(fibre.points[0].distance(socket.position) <= 1.625 + 1e-9);
        assert!(fibre.points[fibre.points.len() - 1].distance(marker.position) < 1e-9);
    }
}

#[test]
fn second_build_executes_nothing() {
    bunny();
    WORKSHOP.build("recipes/bunny.toml", &[]).expect(0);
    assert_eq!(bunny().executed(), 0);
}

#[test]
fn builds_are_equal_to_the_byte() {
    let other = Workshop::default();
    other.build("recipes/bunny.toml", &["-j", "1"]).expect(0);
    for name in FILES {
        assert!(bunny().read(name) == other.opened("bunny").read(name), "{name} differs");
    }
}
