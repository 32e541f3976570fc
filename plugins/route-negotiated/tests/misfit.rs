//! Fibres that do not fit: what is said of them, and what is done instead.

#![allow(clippy::unwrap_used)]

mod stage;

use fibar_core::artefact::constellation::Constellation;
use fibar_core::artefact::mesh::TriangleMesh;
use glam::DVec3;
use serde_json::{Value, json};
use stage::{Place, Run, constellation, least_distance, sockets, tower};

const HEIGHT: f64 = 100.0;

/// Four LEDs and four markers; all fibres pass a square neck of this width, of which they can use all but 0.9 mm and their Ø.
fn neck(width: f64) -> TriangleMesh {
    tower(&[(0.0, 70.0), (25.0, 70.0), (50.0, width), (56.0, width), (80.0, 60.0), (HEIGHT, 60.0)])
}

const FOUR: [Place; 4] = [(-15.0, -15.0, 1), (-15.0, 15.0, 2), (15.0, -15.0, 3), (15.0, 15.0, 4)];

fn run(body: &TriangleMesh, places: &[Place], params: Value) -> Run {
    Run::of((body, &sockets(4), &constellation(places, HEIGHT)), None, params, 2)
}

#[track_caller]
fn refused(body: &TriangleMesh, places: &[Place], params: Value, says: &[&str]) {
    let run = run(body, places, params);
    let last = run.messages.last().unwrap();
    assert_eq!(last["type"], "error", "{last}");
    let missing: Vec<&&str> = says.iter().filter(|words| !last.to_string().contains(**words)).collect();
    assert!(missing.is_empty(), "{last} does not say {missing:?}");
    assert!(run.bytes.is_empty());
}

/// Outer diameter and number of fibres that are routed.
#[track_caller]
fn routed(
    body: &TriangleMesh,
    places: &[Place],
    params: Value,
    diameter: std::ops::RangeInclusive<f64>,
    count: usize,
) {
    let run = run(body, places, params.clone());
    let fibres = run.fibres();
    assert_eq!(fibres.len(), count);
    let radii = fibres[0].radii_mm;
    assert!(diameter.contains(&(2.0 * radii.black)), "Ø {}", 2.0 * radii.black);
    for fibre in &fibres {
        assert_eq!(fibre.radii_mm, radii, "all are as thick");
        // Walls stay as thick as they are.
        assert!(
            (radii.black - radii.cladding - 0.5).abs() < 1e-9
                && (radii.cladding - radii.core - 0.5).abs() < 1e-9
        );
    }
    assert!(least_distance(&fibres) >= 2.0 * radii.black + 0.1 - 1e-9);
    assert_eq!(run.metric("route.diameter_mm"), Some(2.0 * radii.black));
    assert_eq!(run.metric("route.left_out"), Some((places.len() - count) as f64));
    let alone = Run::of((body, &sockets(4), &constellation(places, HEIGHT)), None, params, 1);
    assert_eq!(alone.bytes, run.bytes, "threads must not change a byte");
}

#[test]
fn what_does_not_fit_through_a_neck_is_refused_with_what_would() {
    refused(
        &neck(8.2),
        &FOUR,
        json!({}),
        &[
            "through the neck at (",
            "4 fibres of 4 patterns want to pass",
            "tried: fibres of 3.",
            "the others fit",
        ],
    );
    refused(
        &neck(5.0),
        &FOUR,
        json!({"least_core_radius_mm": 0.8}),
        &["fibres of 3.60 mm do not fit either"],
    );
    refused(
        &neck(5.0),
        &FOUR,
        json!({"least_core_radius_mm": 0.8, "on_misfit": "thin"}),
        &["fibres of 3.60 mm do not fit either"],
    );
}

#[test]
fn fibres_are_made_as_thin_as_needed() {
    let thin = json!({"on_misfit": "thin"});
    routed(&neck(9.5), &FOUR, thin.clone(), 3.75..=3.75, 4);
    // Two side by side take 0.9 mm + 2 Ø + 0.1 mm.
    routed(&neck(8.2), &FOUR, thin, 3.3..=3.61, 4);
}

#[test]
fn markers_are_left_out_as_far_as_needed() {
    routed(&neck(8.2), &FOUR, json!({"on_misfit": "drop"}), 3.75..=3.75, 2);
}

#[test]
fn ends_closer_than_a_fibre_take_thinner_ones() {
    let mut places = FOUR;
    places[1] = (-15.0, -11.5, 2);
    let block = tower(&[(0.0, 70.0), (HEIGHT, 70.0)]);
    refused(
        &block,
        &places,
        json!({}),
        &["markers 1 and 2 of patterns 1 and 2 are 3.50 mm apart", "tried: fibres of 3.3", "do fit"],
    );
    routed(&block, &places, json!({"on_misfit": "thin"}), 3.36..=3.4, 4);
    // Not a matter of thickness.
    places[1] = (-15.0, 15.0, 9);
    refused(&block, &places, json!({"on_misfit": "thin"}), &["marker 2 blinks pattern 9, which no LED does"]);
}

/// Two markers below the top of a pyramid, whose fibres would have to cross, and one that is in nobody's way.
fn crossing() -> (TriangleMesh, Constellation) {
    let pyramid = tower(&[(0.0, 70.0), (60.0, 70.0), (94.5, 1.0)]);
    let mut markers = constellation(&[(2.5, 0.0, 1), (-2.5, 0.0, 4), (0.0, 20.0, 2)], 0.0);
    for marker in &mut markers.markers {
        let side = marker.position.normalize();
        marker.position.z = 95.0 - marker.position.length();
        marker.normal = (side + DVec3::Z).normalize();
    }
    (pyramid, markers)
}

#[test]
fn a_jam_is_told_by_its_place_and_markers() {
    let (pyramid, markers) = crossing();
    let run = Run::of((&pyramid, &sockets(4), &markers), None, json!({}), 2);
    let last = run.messages.last().unwrap();
    let says = [
        "the fibres of Ø 3.75 mm do not fit: 1 pair of different patterns stays too close: around (",
        "of markers 1, 2 (closest ",
        "tried: fibres of 2.",
        "do fit",
        "without marker ",
        "\"place_mm\":[",
    ];
    let missing: Vec<&&str> = says.iter().filter(|words| !last.to_string().contains(**words)).collect();
    assert!(missing.is_empty(), "{last} does not say {missing:?}");
    let run = Run::of((&pyramid, &sockets(4), &markers), None, json!({"on_misfit": "drop"}), 2);
    assert_eq!(run.fibres().len(), 2);
    assert!(run.fibres().iter().any(|fibre| fibre.marker.0 == 3), "the third is in nobody's way");
}
