//! A pebble with markers, for the tests: small, lumpy, without symmetry.

use fibar_core::artefact::constellation::{Constellation, Marker, Pattern};
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_core::code::design_codes;
use fibar_core::id::{MarkerId, PatternId};
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// A closed surface of about 2 · `rings`² triangles, 80 to 120 mm wide.
pub fn pebble(rings: usize) -> TriangleMesh {
    let columns = 2 * rings;
    let vertex = |k: usize| {
        let (ring, column) = (k / columns, k % columns);
        surface(PI * (ring as f64 + 0.5) / rings as f64, TAU * column as f64 / columns as f64)
    };
    let mut vertices: Vec<DVec3> = (0..rings * columns).map(vertex).collect();
    let (north, south) = (vertices.len() as u32, vertices.len() as u32 + 1);
    vertices.extend([surface(0.0, 0.0), surface(PI, 0.0)]);
    let at = |ring: usize, column: usize| (ring * columns + column % columns) as u32;
    let mut triangles = Vec::new();
    for column in 0..columns {
        triangles.push([north, at(0, column), at(0, column + 1)]);
        triangles.push([south, at(rings - 1, column + 1), at(rings - 1, column)]);
        for ring in 0..rings - 1 {
            let [a, b] = [at(ring, column), at(ring, column + 1)];
            let [c, d] = [at(ring + 1, column), at(ring + 1, column + 1)];
            triangles.extend([[a, c, d], [a, d, b]]);
        }
    }
    TriangleMesh { vertices, triangles }
}

/// Markers on the pebble, evenly spread, patterns in a fixed disorder; neighbours are left out.
pub fn markers(count: usize) -> Constellation {
    let codes = design_codes(4, 3, 6).expect("the paper's codes");
    let patterns = codes.into_iter().map(|c| Pattern { id: c.pattern, bits: c.bits }).collect();
    let golden = PI * (3.0 - 5.0_f64.sqrt());
    let marker = |k: usize| {
        let height = 1.0 - 2.0 * (k as f64 + 0.5) / count as f64;
        let (polar, azimuth) = (libm::acos(height), golden * k as f64);
        let step = 1e-5;
        let along = surface(polar + step, azimuth) - surface(polar - step, azimuth);
        let around = surface(polar, azimuth + step) - surface(polar, azimuth - step);
        Marker {
            id: MarkerId(k as u32 + 1),
            position: surface(polar, azimuth),
            normal: along.cross(around).normalize(),
            pattern: PatternId((k * k * 5 + k * 3) as u32 % 11 % 7 + 1),
            neighbours: vec![vec![]],
        }
    };
    Constellation::new(350.0, patterns, (0..count).map(marker).collect())
}

fn surface(polar: f64, azimuth: f64) -> DVec3 {
    let direction = DVec3::new(
        libm::sin(polar) * libm::cos(azimuth),
        libm::sin(polar) * libm::sin(azimuth),
        libm::cos(polar),
    );
    let lumps = 6.0 * libm::sin(3.0 * direction.x + 1.0)
        + 5.0 * libm::sin(4.0 * direction.y * direction.z + direction.x);
    direction * DVec3::new(55.0, 45.0, 40.0) * (1.0 + lumps / 60.0)
}
