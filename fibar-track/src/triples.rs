//! Which three blobs to begin with: few markers they could be, a wide triangle, and other blobs each time.

use crate::model::{Blob, Model};

/// Three blobs, by index.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triple {
    /// The blobs.
    pub blobs: [usize; 3],
}

/// At most `count` triples, the most promising first. What is promising: area over the number of choices of markers, halved each
/// time a blob was used before, so that one wrongly decoded blob does not spoil them all.
pub fn choose_triples(model: &Model, blobs: &[Blob], count: usize) -> Vec<Triple> {
    let mut rated = rate_triples(model, blobs);
    let mut uses = vec![0; blobs.len()];
    let mut chosen = Vec::new();
    while chosen.len() < count && !rated.is_empty() {
        let worth = |(rating, triple): &(f64, Triple)| {
            rating * triple.blobs.iter().map(|&k| 0.5_f64.powi(uses[k])).product::<f64>()
        };
        let best =
            (0..rated.len()).fold(0, |best, k| if worth(&rated[k]) > worth(&rated[best]) { k } else { best });
        let (_, triple) = rated.swap_remove(best);
        triple.blobs.iter().for_each(|&k| uses[k] += 1);
        chosen.push(triple);
    }
    chosen
}

fn rate_triples(model: &Model, blobs: &[Blob]) -> Vec<(f64, Triple)> {
    let choices: Vec<f64> = blobs.iter().map(|b| model.of_pattern(b.pattern).len() as f64).collect();
    let mut rated = Vec::new();
    for c in 2..blobs.len() {
        for b in 1..c {
            for a in 0..b {
                let area = (blobs[b].at - blobs[a].at).perp_dot(blobs[c].at - blobs[a].at).abs();
                let rating = area / (choices[a] * choices[b] * choices[c]);
                if rating > 0.0 && rating.is_finite() {
                    rated.push((rating, Triple { blobs: [a, b, c] }));
                }
            }
        }
    }
    rated
}
