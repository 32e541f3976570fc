//! The whole stage as a process: a routing that starts from an earlier one.

#![allow(clippy::unwrap_used)]

use fibar_core::artefact::Document;
use fibar_core::artefact::constellation::{Constellation, Marker, Pattern};
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_core::artefact::routes::{Fibre, Routes};
use fibar_core::artefact::sockets::{Hole, Socket, Sockets};
use fibar_core::{LedId, MarkerId, PatternId};
use glam::DVec3;
use serde_json::{Value, json};
use std::process::Command;

const SIDE: f64 = 80.0;
const HEIGHT: f64 = 70.0;

/// A block on z = 0 around the z axis.
fn block() -> TriangleMesh {
    let corner = |k: u32| {
        let [x, y, z] = [k & 1, k >> 1 & 1, k >> 2].map(f64::from);
        DVec3::new((x - 0.5) * SIDE, (y - 0.5) * SIDE, z * HEIGHT)
    };
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let halves = |[a, b, c, d]: [u32; 4]| [[a, b, c], [a, c, d]];
    TriangleMesh {
        vertices: (0..8).map(corner).collect(),
        triangles: quads.into_iter().flat_map(halves).collect(),
    }
}

/// Three LEDs of patterns 1, 2, 3.
fn sockets() -> Sockets {
    let socket = |led: u32| Socket {
        led: LedId(led),
        pattern: PatternId(led + 1),
        position: DVec3::new(12.0 * f64::from(led) - 12.0, 0.0, 8.6),
        axis: DVec3::Z,
    };
    Sockets::new(Hole { diameter_mm: 5.2, depth_mm: 8.6 }, (0..3).map(socket).collect())
}

/// A marker on the top, and what it blinks.
type Place = (f64, f64, u32);

/// Nine of them, so that fibres have to cross.
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

fn constellation(places: &[Place]) -> Constellation {
    let pattern = |id| Pattern { id: PatternId(id), bits: vec![true, false] };
    let marker = |(id, &(x, y, pattern)): (u32, &Place)| Marker {
        id: MarkerId(id),
        position: DVec3::new(x, y, HEIGHT),
        normal: DVec3::Z,
        pattern: PatternId(pattern),
        neighbours: vec![],
    };
    let markers = (1..).zip(places).map(marker).collect();
    Constellation::new(350.0, vec![pattern(1), pattern(2), pattern(3)], markers)
}

/// What a run said and wrote.
struct Run {
    messages: Vec<Value>,
    bytes: Vec<u8>,
}

impl Run {
    fn of(places: &[Place], warm: Option<&[u8]>, params: Value, threads: u32) -> Run {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).unwrap();
        write("body.ply", &block().to_ply());
        write("sockets.json", &sockets().to_json());
        write("constellation.json", &constellation(places).to_json());
        let mut all = json!({"effort": "quick"});
        all.as_object_mut().unwrap().extend(params.as_object().unwrap().clone());
        if let Some(earlier) = warm {
            write("earlier.json", earlier);
            all["warm_start"] = json!("earlier.json");
        }
        let input = |name: &str| json!([{"path": name, "digest": "0"}]);
        let inputs = json!({
            "body": input("body.ply"), "sockets": input("sockets.json"), "constellation": input("constellation.json"),
        });
        std::fs::create_dir(folder.path().join("out")).unwrap();
        let request =
            json!({"inputs": inputs, "params": all, "out_dir": "out", "threads": threads, "seed": 1});
        write("request.json", request.to_string().as_bytes());
        let stage = env!("CARGO_BIN_EXE_route-negotiated");
        let output =
            Command::new(stage).args(["--request", "request.json"]).current_dir(folder.path()).output();
        let text = String::from_utf8(output.unwrap().stdout).unwrap();
        let messages = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
        Run { messages, bytes: std::fs::read(folder.path().join("out/routes.json")).unwrap_or_default() }
    }

    fn metric(&self, name: &str) -> Option<f64> {
        self.messages.iter().find(|m| m["name"] == name).and_then(|m| m["value"].as_f64())
    }

    fn says(&self, words: &str) -> bool {
        self.messages.iter().any(|m| m.to_string().contains(words))
    }

    fn fibres(&self) -> Vec<Fibre> {
        assert!(!self.bytes.is_empty(), "{:?}", self.messages.last());
        Routes::from_json(&self.bytes).unwrap().fibres
    }
}

fn cold() -> Run {
    Run::of(&PLACES, None, json!({}), 2)
}

/// Least distance of axes of two patterns, mm, by points on both.
fn least_distance(fibres: &[Fibre]) -> f64 {
    let curve = |fibre: &Fibre| {
        let curve = fibar_geometry::curve::Curve::clamped_uniform(3, &fibre.points).unwrap();
        (0..=400).map(|k| curve.point(f64::from(k) / 400.0)).collect::<Vec<DVec3>>()
    };
    let curves: Vec<(u32, Vec<DVec3>)> = fibres.iter().map(|f| (f.pattern.0, curve(f))).collect();
    let mut least = f64::INFINITY;
    for (k, (pattern, one)) in curves.iter().enumerate() {
        for (_, other) in curves[..k].iter().filter(|(p, _)| p != pattern) {
            let all = one.iter().flat_map(|p| other.iter().map(|q| p.distance(*q)));
            least = all.fold(least, f64::min);
        }
    }
    least
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
        (&sockets().to_json(), "fibar.routes/1"),
    ] {
        let run = Run::of(&PLACES, Some(bytes), json!({}), 1);
        assert!(run.says(says) && run.says("/warm_start"), "{:?}", run.messages.last());
        assert!(run.bytes.is_empty());
    }
}
