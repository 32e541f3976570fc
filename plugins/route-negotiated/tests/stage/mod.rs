//! The stage as a process, run by hand on inputs made up by a test.

#![allow(dead_code)] // not every test needs all of it

use fibar_core::artefact::Document;
use fibar_core::artefact::constellation::{Constellation, Marker, Pattern};
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_core::artefact::routes::{Fibre, Routes};
use fibar_core::artefact::sockets::{Hole, Socket, Sockets};
use fibar_core::{LedId, MarkerId, PatternId};
use glam::DVec3;
use serde_json::{Value, json};
use std::process::Command;

/// A marker on the top, and what it blinks.
pub type Place = (f64, f64, u32);

/// A tower on z = 0 around the z axis: squares of these heights and widths, one above the other.
pub fn tower(storeys: &[(f64, f64)]) -> TriangleMesh {
    let square = |&(z, width): &(f64, f64)| {
        [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)]
            .map(|(x, y): (f64, f64)| DVec3::new(x * width, y * width, z))
    };
    let top = 4 * (storeys.len() as u32 - 1);
    let mut triangles = vec![[0, 2, 1], [0, 3, 2], [top, top + 1, top + 2], [top, top + 2, top + 3]];
    for storey in (0..top).step_by(4) {
        for k in 0..4 {
            let [a, b] = [storey + k, storey + (k + 1) % 4];
            triangles.extend([[a, b, b + 4], [a, b + 4, a + 4]]);
        }
    }
    TriangleMesh { vertices: storeys.iter().flat_map(square).collect(), triangles }
}

/// LEDs in a row, 12 mm apart, of patterns 1, 2, 3, …
pub fn sockets(count: u32) -> Sockets {
    let first = -6.0 * f64::from(count - 1);
    let socket = |led: u32| Socket {
        led: LedId(led),
        pattern: PatternId(led + 1),
        position: DVec3::new(first + 12.0 * f64::from(led), 0.0, 8.6),
        axis: DVec3::Z,
    };
    Sockets::new(Hole { diameter_mm: 5.2, depth_mm: 8.6 }, (0..count).map(socket).collect())
}

/// Markers on a flat top of this height.
pub fn constellation(places: &[Place], height: f64) -> Constellation {
    let pattern = |id| Pattern { id: PatternId(id), bits: vec![true, false] };
    let marker = |(id, &(x, y, pattern)): (u32, &Place)| Marker {
        id: MarkerId(id),
        position: DVec3::new(x, y, height),
        normal: DVec3::Z,
        pattern: PatternId(pattern),
        neighbours: vec![],
    };
    let markers = (1..).zip(places).map(marker).collect();
    let patterns = places.iter().map(|place| place.2).max().unwrap_or(1);
    Constellation::new(350.0, (1..=patterns).map(pattern).collect(), markers)
}

/// What a run said and wrote.
pub struct Run {
    pub messages: Vec<Value>,
    pub bytes: Vec<u8>,
}

impl Run {
    /// With quick effort; `warm` are earlier routes.
    pub fn of(
        (body, sockets, constellation): (&TriangleMesh, &Sockets, &Constellation),
        warm: Option<&[u8]>,
        params: Value,
        threads: u32,
    ) -> Run {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).unwrap();
        write("body.ply", &body.to_ply());
        write("sockets.json", &sockets.to_json());
        write("constellation.json", &constellation.to_json());
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

    pub fn metric(&self, name: &str) -> Option<f64> {
        self.messages.iter().find(|m| m["name"] == name).and_then(|m| m["value"].as_f64())
    }

    pub fn says(&self, words: &str) -> bool {
        self.messages.iter().any(|m| m.to_string().contains(words))
    }

    pub fn fibres(&self) -> Vec<Fibre> {
        assert!(!self.bytes.is_empty(), "{:?}", self.messages.last());
        Routes::from_json(&self.bytes).unwrap().fibres
    }
}

/// Least distance of axes of two patterns, mm, by points on both.
pub fn least_distance(fibres: &[Fibre]) -> f64 {
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
