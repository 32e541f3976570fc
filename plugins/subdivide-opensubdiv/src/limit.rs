//! Where a vertex goes if one subdivides for ever.
//!
//! A vertex and the ring around it make, at the next level, a smaller ring of the same kind by a matrix M whose rows are
//! OpenSubdiv's own stencils; the limit is v∞ = lim (first row of Mᵏ) · ring, so the left eigenvector of M for 1 (Halstead, Kass,
//! DeRose 1993, §4). Iterating finds it for smooth vertices, darts, creases, corners and rims alike, with no table of masks.

use crate::stencils::Stencils;

/// A vertex, first, and those around it.
pub struct Ring {
    /// Vertices of a level.
    pub vertices: Vec<u32>,
    /// For each the vertex of the next level that takes its place in the smaller ring.
    pub children: Vec<usize>,
}

/// Change of a weight in one step below which the mask is done; f64 has 2e-16.
const STILL: f64 = 1e-15;
/// The second eigenvalue is at most about 0.9, for rings of hundreds of vertices.
const MOST_STEPS: usize = 1000;

/// Weights of the ring's vertices; `None` if a vertex is in the ring twice, or the matrix leaves it.
pub fn mask(ring: &Ring, next: &Stencils) -> Option<Vec<(u32, f64)>> {
    let matrix = matrix(ring, next)?;
    let mut weights = vec![0.0; matrix.len()];
    weights[0] = 1.0;
    for _ in 0..MOST_STEPS {
        let mut moved = vec![0.0; weights.len()];
        for (row, weight) in matrix.iter().zip(&weights) {
            row.iter().for_each(|&(column, share)| moved[column] += weight * share);
        }
        let change = moved.iter().zip(&weights).map(|(new, old)| (new - old).abs()).fold(0.0, f64::max);
        weights = moved;
        if change < STILL {
            break;
        }
    }
    Some(ring.vertices.iter().copied().zip(weights).collect())
}

/// Rows over places in the ring.
fn matrix(ring: &Ring, next: &Stencils) -> Option<Vec<Vec<(usize, f64)>>> {
    let mut places: Vec<(u32, usize)> = ring.vertices.iter().copied().zip(0..).collect();
    places.sort_unstable();
    if places.windows(2).any(|pair| pair[0].0 == pair[1].0) {
        return None;
    }
    let place = |vertex: u32| {
        let found = places.binary_search_by_key(&vertex, |&(other, _)| other).ok()?;
        Some(places[found].1)
    };
    let row = |&child: &usize| next.row(child).map(|(v, weight)| Some((place(v)?, weight))).collect();
    ring.children.iter().map(row).collect()
}
