//! Which three blobs to begin with: a good triangle, few markers they could be, and other blobs each time.

use crate::model::{Blob, Model};
use fibar_core::adjacency::clockwise_neighbours;
use glam::DVec2;

/// Three blobs, by index.
pub type Triple = [usize; 3];

/// Triples out of which the most promising is drawn next.
pub struct Triples {
    rated: Vec<(f64, Triple)>,
    weights: Vec<f64>,
}

impl Triples {
    /// A blob and two of its neighbours in the image: their markers are probably neighbours too. What is promising is a triangle far
    /// from a line.
    pub fn near(model: &Model, blobs: &[Blob]) -> Triples {
        let places: Vec<DVec2> = blobs.iter().map(|b| b.at).collect();
        let mut rated = Vec::new();
        for (a, neighbours) in clockwise_neighbours(&places).iter().enumerate() {
            let choices = model.of_pattern(blobs[a].pattern).len() as f64;
            for (k, &b) in neighbours.iter().enumerate() {
                for &c in &neighbours[..k] {
                    let (area, longest) = triangle(&places, [a, b, c]);
                    rated.push((area / (longest * longest * choices), [a, b, c]));
                }
            }
        }
        Triples::of(rated, blobs.len())
    }

    /// Any three blobs. What is promising is a wide triangle of few markers.
    pub fn wide(model: &Model, blobs: &[Blob]) -> Triples {
        let places: Vec<DVec2> = blobs.iter().map(|b| b.at).collect();
        let choices: Vec<f64> = blobs.iter().map(|b| model.of_pattern(b.pattern).len() as f64).collect();
        let mut rated = Vec::new();
        for c in 2..blobs.len() {
            for b in 1..c {
                let scale = 1.0 / (choices[b] * choices[c]);
                rated
                    .extend((0..b).map(|a| (triangle(&places, [a, b, c]).0 * scale / choices[a], [a, b, c])));
            }
        }
        Triples::of(rated, blobs.len())
    }

    fn of(mut rated: Vec<(f64, Triple)>, blobs: usize) -> Triples {
        rated.retain(|(rating, _)| *rating > 0.0 && rating.is_finite());
        Triples { rated, weights: vec![1.0; blobs] }
    }
}

impl Iterator for Triples {
    type Item = Triple;

    /// The best rated; then its blobs count for half, so that one that was decoded wrongly does not spoil them all.
    fn next(&mut self) -> Option<Triple> {
        let worth = |(rating, triple): &(f64, Triple)| {
            triple.iter().fold(*rating, |worth, &k| worth * self.weights[k])
        };
        let mut best = (0, 0.0);
        for (k, entry) in self.rated.iter().enumerate() {
            let worth = worth(entry);
            if worth > best.1 {
                best = (k, worth);
            }
        }
        let (_, triple) = (best.1 > 0.0).then(|| self.rated.swap_remove(best.0))?;
        triple.iter().for_each(|&k| self.weights[k] *= 0.5);
        Some(triple)
    }
}

/// Twice the area, px², and the longest side, px.
fn triangle(places: &[DVec2], triple: Triple) -> (f64, f64) {
    let [a, b, c] = triple.map(|k| places[k]);
    let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
    ((b - a).perp_dot(c - a).abs(), longest.sqrt())
}
