//! Patterns of LED places in the plane of their face.

use crate::params::{Layout, Params};
use glam::DVec2;
use std::f64::consts::{FRAC_PI_3, PI, TAU};

/// Places of the LEDs relative to the layout's centre, mm, in order of LED.
pub fn offsets(params: &Params) -> Vec<DVec2> {
    let count = params.count as usize;
    let places = match params.layout {
        Layout::Hexagon => hexagon(params.pitch_mm, count),
        Layout::Ring => ring(params.pitch_mm, count),
        Layout::Grid => grid(params.pitch_mm, count),
        Layout::Free => params.places_mm.iter().map(|place| DVec2::from(*place)).collect(),
        // Found by `best`.
        Layout::Best => vec![],
    };
    let (sine, cosine) = libm::sincos(params.rotation_deg.to_radians());
    places.into_iter().map(|place| DVec2::new(cosine, sine).rotate(place)).collect()
}

/// One in the centre, the others on corners counter-clockwise, each as far from its neighbours as from the centre.
fn hexagon(pitch: f64, count: usize) -> Vec<DVec2> {
    let corner = |k: usize| polar(pitch, k as f64 * FRAC_PI_3);
    std::iter::once(DVec2::ZERO).chain((0..6).map(corner)).take(count).collect()
}

/// Evenly round a circle, neighbours a pitch apart.
fn ring(pitch: f64, count: usize) -> Vec<DVec2> {
    let radius = if count > 1 { 0.5 * pitch / libm::sin(PI / count as f64) } else { 0.0 };
    (0..count).map(|k| polar(radius, TAU * k as f64 / count as f64)).collect()
}

/// The places of a square grid that are nearest to its centre, nearest first, the whole moved so that its box is centred.
fn grid(pitch: f64, count: usize) -> Vec<DVec2> {
    let columns = (count as f64).sqrt().ceil() as usize;
    let rows = count.div_ceil(columns.max(1));
    let middle = DVec2::new(columns as f64 - 1.0, rows as f64 - 1.0) / 2.0;
    let cells = (0..rows).flat_map(|j| (0..columns).map(move |i| DVec2::new(i as f64, j as f64)));
    let mut places: Vec<DVec2> = cells.take(count).map(|cell| (cell - middle) * pitch).collect();
    places.sort_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
    places
}

fn polar(radius: f64, angle: f64) -> DVec2 {
    let (sine, cosine) = libm::sincos(angle);
    DVec2::new(cosine, sine) * radius
}

/// The two places nearest to each other, and their distance, mm; none of fewer than two.
pub fn closest_pair(places: &[DVec2]) -> Option<([usize; 2], f64)> {
    let pairs = (0..places.len()).flat_map(|k| (0..k).map(move |j| [j, k]));
    let distances = pairs.map(|[j, k]| ([j, k], places[j].distance(places[k])));
    distances.min_by(|a, b| a.1.total_cmp(&b.1))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Number of places, distance of the nearest two, and of the first and the furthest place from the centre.
    #[track_caller]
    fn check(layout: Layout, count: u32, [nearest, first, furthest]: [f64; 3]) {
        let params = Params { layout, count, pitch_mm: 10.0, rotation_deg: 17.0, ..Params::default() };
        let places = offsets(&params);
        let found = [
            closest_pair(&places).map_or(0.0, |pair| pair.1),
            places[0].length(),
            places.iter().map(|p| p.length()).fold(0.0, f64::max),
        ];
        assert_eq!(places.len(), count as usize);
        let expected = [nearest, first, furthest];
        assert!(found.iter().zip(expected).all(|(f, e)| (f - e).abs() < 1e-9), "{found:?}, not {expected:?}");
    }

    #[test]
    fn neighbours_are_a_pitch_apart() {
        check(Layout::Hexagon, 1, [0.0, 0.0, 0.0]);
        check(Layout::Hexagon, 7, [10.0, 0.0, 10.0]);
        check(Layout::Ring, 1, [0.0, 0.0, 0.0]);
        check(Layout::Ring, 2, [10.0, 5.0, 5.0]);
        check(Layout::Ring, 6, [10.0, 10.0, 10.0]);
        check(Layout::Grid, 9, [10.0, 0.0, 200f64.sqrt()]);
        check(Layout::Grid, 4, [10.0, 50f64.sqrt(), 50f64.sqrt()]);
    }
}
