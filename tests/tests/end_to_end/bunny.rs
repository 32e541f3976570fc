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
fn metrics_are_within_what_the_paper_leads_to_expect() {
    let check = |name: &str, range: std::ops::RangeInclusive<f64>| {
        let value = bunny().metric(name);
        assert!(range.contains(&value), "{name} is {value}, expected {range:?}");
    };
    check("place.markers", 55.0..=75.0);
    check("assign.objective", 1.0..=1e9);
    check("assign.iterations", 1000.0..=1e6);
    check("route.mean_e_cam_initial_mm", 300.0..=2000.0);
    check("route.mean_e_cam_mm", bunny().metric("route.mean_e_cam_initial_mm")..=4000.0);
    check("light.worst_d_cam_mm", 0.0..=bunny().metric("light.p10_d_cam_mm"));
    check("light.p10_d_cam_mm", 0.0..=bunny().metric("light.mean_d_cam_mm"));
    check("light.length_below_20mm_share", 0.0..=1.0);
    check("clearance.min_gap_mm", -3.75..=100.0);
    check("clearance.colliding_pairs", 0.0..=1000.0);
    check("clearance.min_wall_mm", -10.0..=100.0);
    check("clearance.min_bend_radius_mm", 0.0..=1000.0);
    check("solids.overlap_mm3", 0.0..=0.5);
    check("solids.volume_error_ratio", 0.0..=1e-3);
    check("solids.components", 23.0..=400.0);
    check("solids.min_wall_mm", 0.0..=0.51);
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
        assert!(fibre.points[0].distance(socket.position) < 1e-9);
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
