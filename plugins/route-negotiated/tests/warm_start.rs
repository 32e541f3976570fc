//! The whole stage as a process: a routing that starts from an earlier one.

#![allow(clippy::unwrap_used)]

mod stage;

use fibar_core::artefact::Document;
use fibar_core::artefact::routes::Fibre;
use serde_json::{Value, json};
use stage::{Place, constellation, least_distance, sockets, tower};

const HEIGHT: f64 = 70.0;

/// Nine markers, so that fibres have to cross.
const PLACES: [Place; 9] = [
    (-24.0, -20.0, 1),
    (0.0, -20.0, 3),
    (24.0, -20.0, 2),
    (-24.0, 0.0, 2),
    (0.0, 0.0, 1),
    (24.0, 0.0, 3),
    (-24.0, 20.0, 3),
    (0.0, 20.0, 2),
    (24.0, 20.0, 1),
];

/// A run on a block with three LEDs.
struct Run;

impl Run {
    fn of(places: &[Place], warm: Option<&[u8]>, params: Value, threads: u32) -> stage::Run {
        let block = tower(&[(0.0, 80.0), (HEIGHT, 80.0)]);
        stage::Run::of((&block, &sockets(3), &constellation(places, HEIGHT)), warm, params, threads)
    }
}

fn cold() -> stage::Run {
    Run::of(&PLACES, None, json!({}), 2)
}

/// Routes with a start from the earlier routes of [`PLACES`]; `kept` fibres must be the very same, and no more.
#[track_caller]
fn check(places: &[Place], kept: std::ops::RangeInclusive<usize>) {
    let earlier = cold();
    let run = Run::of(places, Some(&earlier.bytes), json!({}), 2);
    let (before, after) = (earlier.fibres(), run.fibres());
    let is_same =
        |fibre: &&Fibre| before.iter().any(|b| b.points == fibre.points && b.pattern == fibre.pattern);
    let same = after.iter().filter(is_same).count();
    assert!(kept.contains(&same), "{same} of {} are the same, not {kept:?}", after.len());
    assert_eq!(run.metric("route.kept"), Some(same as f64));
    assert_eq!(run.metric("route.rerouted"), Some((places.len() - same) as f64));
    assert_eq!(after.len(), places.len());
    assert!(least_distance(&after) >= 3.85 - 1e-9, "{}", least_distance(&after));
    let alone = Run::of(places, Some(&earlier.bytes), json!({}), 1);
    assert_eq!(alone.bytes, run.bytes, "threads must not change a byte");
}

#[test]
fn nothing_changed_gives_the_same_bytes() {
    let earlier = cold();
    let again = Run::of(&PLACES, Some(&earlier.bytes), json!({}), 2);
    assert_eq!(again.bytes, earlier.bytes);
    assert!(again.says("9 of 9 fibres are those of the earlier routes"));
    assert!(earlier.metric("route.kept").is_none(), "a cold start says nothing of it");
}

#[test]
fn a_changed_marker_leaves_the_others_as_they_are() {
    let with = |k: usize, place: Place| {
        let mut places = PLACES;
        places[k] = place;
        places
    };
    check(&with(4, (6.0, 8.0, 1)), 8..=8);
    check(&with(2, (27.0, -28.0, 2)), 8..=8);
    check(&with(0, (-24.0, -20.0, 3)), 5..=8); // another LED
}

#[test]
fn markers_may_come_go_and_be_numbered_anew() {
    check(&PLACES[..6], 6..=6);
    let mut more = PLACES.to_vec();
    more.reverse();
    more.push((12.0, 10.0, 3));
    check(&more, 6..=9);
}

#[test]
fn fibres_that_are_in_the_way_give_way() {
    // The middle now belongs to the LED furthest off, and so do its neighbours.
    let mut places = PLACES;
    for (k, pattern) in [(3, 3), (4, 3), (5, 1)] {
        places[k].2 = pattern;
    }
    check(&places, 0..=6);
}

#[test]
fn what_no_longer_fits_is_routed_anew() {
    let earlier = cold();
    let thinner = json!({"black_radius_mm": 1.8});
    let run = Run::of(&PLACES, Some(&earlier.bytes), thinner.clone(), 2);
    assert!(run.says("their 9 fibres have other radii"), "{:?}", run.messages);
    assert_eq!(run.metric("route.kept"), Some(0.0));
    assert_eq!(run.bytes, Run::of(&PLACES, None, thinner, 2).bytes);

    let elsewhere = PLACES.map(|(x, y, pattern)| (x + 1.0, y, pattern));
    let run = Run::of(&elsewhere, Some(&earlier.bytes), json!({}), 2);
    assert!(run.says("none of their 9 fibres leads from an LED to a marker"), "{:?}", run.messages);
    assert_eq!(run.bytes, Run::of(&elsewhere, None, json!({}), 2).bytes);

    // More room between them than they have.
    let run = Run::of(&PLACES, Some(&earlier.bytes), json!({"clearance_mm": 1.0}), 2);
    assert!(least_distance(&run.fibres()) >= 4.75 - 1e-9);
}

#[test]
fn another_file_is_refused() {
    for (bytes, says) in [
        (&b"not json"[..], "these are no earlier routes"),
        (br#"{"format": "fibar.sockets/1"}"#, "these are no earlier routes"),
        (&sockets(3).to_json(), "fibar.routes/1"),
    ] {
        let run = Run::of(&PLACES, Some(bytes), json!({}), 1);
        assert!(run.says(says) && run.says("/warm_start"), "{:?}", run.messages.last());
        assert!(run.bytes.is_empty());
    }
}
