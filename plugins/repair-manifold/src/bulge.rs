//! Bulges: caps that go on as the surface around their rim does, where it runs smoothly into the hole.
//!
//! Over the plane of the rim the surface around is a height at each place. The thin plate that passes through the heights of the rim
//! and of four rows of vertices behind it (Duchon 1977) gives those of the cap.

use crate::drawing::{Plane, fill, is_inside};
use fibar_core::artefact::mesh::TriangleMesh;
use glam::{DVec2, DVec3};
use std::collections::BTreeSet;

/// Heights that the plate passes through, at most: solving takes cubic time.
const KNOTS: usize = 320;
/// Vertices within the cap, at most.
const POINTS: usize = 1500;

/// Which triangles use each vertex.
pub struct Stars {
    starts: Vec<u32>,
    triangles: Vec<u32>,
}

impl Stars {
    /// Collects them.
    pub fn of(mesh: &TriangleMesh) -> Stars {
        let mut starts = vec![0; mesh.vertices.len() + 2];
        mesh.triangles.iter().flatten().for_each(|&v| starts[v as usize + 2] += 1);
        (2..starts.len()).for_each(|k| starts[k] += starts[k - 1]);
        let mut triangles = vec![0; 3 * mesh.triangles.len()];
        for (t, triangle) in (0u32..).zip(&mesh.triangles) {
            for &v in triangle {
                let next = &mut starts[v as usize + 1];
                triangles[*next as usize] = t;
                *next += 1;
            }
        }
        Stars { starts, triangles }
    }

    fn around(&self, vertex: u32) -> &[u32] {
        let vertex = vertex as usize;
        &self.triangles[self.starts[vertex] as usize..self.starts[vertex + 1] as usize]
    }
}

/// New vertices and the triangles of a cap over a rim; those of the rim come first in the triangles' numbers. Nothing where the surface
/// around does not run into the hole.
pub fn bulge(mesh: &TriangleMesh, rim: &[u32], stars: &Stars) -> Option<(Vec<DVec3>, Vec<[usize; 3]>)> {
    const FEWEST: usize = 8;
    let places: Vec<DVec3> = rim.iter().map(|&v| mesh.vertices[v as usize]).collect();
    let (plane, area) = Plane::of(&places).filter(|_| rim.len() >= FEWEST)?;
    if !runs_into(mesh, rim, &plane, stars)? {
        return None;
    }
    let drawn: Vec<DVec2> = places.iter().map(|&place| plane.draw(place).0).collect();
    let sides = places.iter().zip(places.iter().cycle().skip(1));
    let spacing = sides.map(|(a, b)| a.distance(*b)).sum::<f64>() / rim.len() as f64;
    let points = lattice(&drawn, spacing.max(libm::sqrt(area / POINTS as f64)));
    let plate = Plate::through(&knots(mesh, rim, stars, &plane))?;
    let reach = drawn.iter().map(|at| at.length()).fold(0.0, f64::max);
    let heights: Vec<f64> = points.iter().map(|&at| plate.height(at)).collect();
    // A height that is no number is out of reach, too.
    if !heights.iter().all(|height| height.abs() <= reach) {
        return None;
    }
    let triangles = fill(&[drawn], &points)?;
    let lifted = points.iter().zip(heights).map(|(&at, height)| plane.lift(at, height)).collect();
    Some((lifted, triangles))
}

/// Whether the surface runs on over the hole with a slope, neither flat nor steep as at the corner of a box.
fn runs_into(mesh: &TriangleMesh, rim: &[u32], plane: &Plane, stars: &Stars) -> Option<bool> {
    const MEAN: std::ops::Range<f64> = 0.02..0.9; // rad: one to fifty degrees
    const MOST: f64 = 1.2;
    let mut slopes = Vec::new();
    for (k, &from) in rim.iter().enumerate() {
        let to = rim[(k + 1) % rim.len()];
        let beside =
            stars.around(from).iter().map(|&t| mesh.triangles[t as usize]).find(|t| t.contains(&to))?;
        let tip = beside.into_iter().find(|&v| v != from && v != to)?;
        let [from, to, tip] = [from, to, tip].map(|v| mesh.vertices[v as usize]);
        let onward = (from - tip).reject_from_normalized((to - from).try_normalize()?).try_normalize()?;
        slopes.push(libm::asin(onward.dot(plane.normal).clamp(-1.0, 1.0)));
    }
    let mean = slopes.iter().map(|slope| slope.abs()).sum::<f64>() / slopes.len() as f64;
    Some(MEAN.contains(&mean) && slopes.iter().all(|slope| slope.abs() < MOST))
}

/// Points of a triangular grid in a polygon, not too near to its corners and sides.
fn lattice(ring: &[DVec2], spacing: f64) -> Vec<DVec2> {
    let low = ring.iter().fold(DVec2::INFINITY, |low, p| low.min(*p));
    let high = ring.iter().fold(DVec2::NEG_INFINITY, |high, p| high.max(*p));
    let row_height = spacing * 0.75_f64.sqrt();
    let rows = ((high.y - low.y) / row_height) as i32;
    let columns = ((high.x - low.x) / spacing) as i32 + 1;
    let at = |(row, column): (i32, i32)| {
        let shift = if row % 2 == 0 { 0.25 } else { 0.75 };
        low + DVec2::new((f64::from(column) + shift) * spacing, (f64::from(row) + 0.5) * row_height)
    };
    let free = |p: &DVec2| {
        let next = ring.iter().cycle().skip(1);
        is_inside(ring, *p) && ring.iter().zip(next).all(|(&a, &b)| distance(*p, [a, b]) > 0.5 * spacing)
    };
    (0..=rows).flat_map(|row| (0..=columns).map(move |column| (row, column))).map(at).filter(free).collect()
}

fn distance(point: DVec2, [a, b]: [DVec2; 2]) -> f64 {
    let side = b - a;
    let share = ((point - a).dot(side) / side.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    point.distance(a + share * side)
}

/// Places and heights of the rim and of four rows of vertices around it, evenly thinned out.
fn knots(mesh: &TriangleMesh, rim: &[u32], stars: &Stars, plane: &Plane) -> Vec<(DVec2, f64)> {
    let mut known: BTreeSet<u32> = rim.iter().copied().collect();
    let mut rows = vec![rim.to_vec()];
    for k in 0..4 {
        let near = rows[k].iter().flat_map(|&v| stars.around(v)).flat_map(|&t| mesh.triangles[t as usize]);
        rows.push(near.filter(|&v| known.insert(v)).collect());
    }
    let all: Vec<u32> = rows.concat();
    let step = all.len().div_ceil(KNOTS);
    all.iter().step_by(step).map(|&v| plane.draw(mesh.vertices[v as usize])).collect()
}

/// A thin plate: Σ wₖ r² ln r + a + b x + c y.
struct Plate {
    knots: Vec<DVec2>,
    weights: Vec<f64>,
    scale: f64,
}

impl Plate {
    fn through(knots: &[(DVec2, f64)]) -> Option<Plate> {
        let scale = knots.iter().map(|(at, _)| at.length()).fold(0.0, f64::max);
        let places: Vec<DVec2> = knots.iter().map(|(at, _)| *at / scale).collect();
        let count = knots.len();
        let size = count + 3;
        let mut rows = vec![vec![0.0; size + 1]; size];
        for k in 0..count {
            for l in 0..count {
                rows[k][l] = kernel(places[k].distance_squared(places[l]));
            }
            for (l, value) in [1.0, places[k].x, places[k].y].into_iter().enumerate() {
                rows[k][count + l] = value;
                rows[count + l][k] = value;
            }
            rows[k][size] = knots[k].1;
        }
        Some(Plate { knots: places, weights: solve(rows)?, scale })
    }

    fn height(&self, at: DVec2) -> f64 {
        let at = at / self.scale;
        let (bent, flat) = self.weights.split_at(self.knots.len());
        let bent: f64 = self.knots.iter().zip(bent).map(|(k, w)| w * kernel(k.distance_squared(at))).sum();
        bent + flat[0] + flat[1] * at.x + flat[2] * at.y
    }
}

/// r² ln r, from r².
fn kernel(squared: f64) -> f64 {
    if squared > 0.0 { squared * libm::log(squared) / 2.0 } else { 0.0 }
}

/// Gauss's elimination with the largest pivot of a column; nothing for a singular system.
fn solve(mut rows: Vec<Vec<f64>>) -> Option<Vec<f64>> {
    let size = rows.len();
    for k in 0..size {
        let pivot = (k..size).max_by(|&a, &b| rows[a][k].abs().total_cmp(&rows[b][k].abs()))?;
        rows.swap(k, pivot);
        if rows[k][k].abs() < 1e-12 {
            return None;
        }
        let (above, below) = rows.split_at_mut(k + 1);
        for row in below {
            let share = row[k] / above[k][k];
            (k..=size).for_each(|l| row[l] -= share * above[k][l]);
        }
    }
    let mut found = vec![0.0; size];
    for k in (0..size).rev() {
        let known: f64 = (k + 1..size).map(|l| rows[k][l] * found[l]).sum();
        found[k] = (rows[k][size] - known) / rows[k][k];
    }
    Some(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{ball, block};
    use crate::holes::{close_all, holes};
    use crate::sheets::Sheets;
    use crate::volume::signed_volume;

    #[test]
    fn a_ball_is_round_again() {
        let whole = ball(10.0, 20);
        for height in [9.4, 8.5, 7.6] {
            let mut mesh = whole.clone();
            mesh.triangles.retain(|t| t.iter().any(|&v| whole.vertices[v as usize].z < height));
            let sheets = Sheets::of(&mesh);
            let mut mesh = sheets.mesh.clone();
            close_all(&holes(&sheets), &mut mesh);
            assert!(Sheets::of(&mesh).is_closed());
            let off = signed_volume(&mesh) / signed_volume(&whole) - 1.0;
            assert!(off.abs() < 0.005, "open above {height} mm: {off}");
            let off = mesh.vertices.iter().map(|v| (v.length() - 10.0).abs()).fold(0.0, f64::max);
            assert!(off < 0.5, "a vertex {off} mm off, open above {height} mm");
        }
    }

    #[test]
    fn a_box_stays_a_box() {
        let mut open = block([0.0; 3], [1.0; 3]);
        open.triangles.drain(4..6);
        let rim = holes(&Sheets::of(&open)).remove(0).rim;
        assert!(bulge(&open, &rim, &Stars::of(&open)).is_none());
    }
}
