//! How far one surface strays from another, with a bound.
//!
//! The distance to a triangle is convex, so over another triangle it is greatest at a corner: when all three corners lie near one
//! triangle, so does all between them. Where no single triangle serves, the searched one is divided until the bound is good
//! enough. Taken both ways this is the Hausdorff distance of two surfaces, an interval instead of a sampled maybe.

use crate::distance::{Surface, SurfaceError};
use fibar_core::artefact::mesh::TriangleMesh;
use glam::DVec3;
use rayon::prelude::*;

/// The greatest distance of a surface's points from another surface, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deviation {
    /// It is this great, at `place`.
    pub at_least: f64,
    /// It is not greater than this.
    pub at_most: f64,
    /// Where it was found, mm.
    pub place: DVec3,
}

/// Share of the limit that a bound may be loose by.
const SLACK: f64 = 0.02;
/// Pieces of a triangle are divided at most so often.
const DEEPEST: u32 = 80;
/// A division that leaves this share of a piece whole is none.
const MOSTLY: f64 = 0.8;
/// Pieces narrower than this are left out, mm; every bound has it on top.
const ROUNDING_MM: f64 = 1e-9;

/// A convex, flat piece of a triangle; its corners in turn.
type Piece = Vec<DVec3>;

/// For each triangle of `mesh` how far its points lie from `surface`: bounds to 2 % of `limit`, mm.
pub fn deviations(mesh: &TriangleMesh, surface: &Surface, limit: f64) -> Vec<Deviation> {
    let of = |t: usize| {
        let corners = mesh.corners(t);
        let mut found = Deviation { at_least: 0.0, at_most: 0.0, place: corners[0] };
        search(corners.into(), surface, limit, DEEPEST, &mut found);
        Deviation { at_most: found.at_most + ROUNDING_MM, ..found }
    };
    (0..mesh.triangles.len()).into_par_iter().map(of).collect()
}

/// How far any point of each surface lies from the other, mm: the Hausdorff distance.
pub fn hausdorff(one: &TriangleMesh, other: &TriangleMesh, limit: f64) -> Result<Deviation, SurfaceError> {
    let there = deviations(one, &Surface::unsigned(other)?, limit);
    let back = deviations(other, &Surface::unsigned(one)?, limit);
    let all = there.into_iter().chain(back);
    Ok(all.reduce(Deviation::or_greater).expect("surfaces have triangles"))
}

impl Deviation {
    /// It is as great as that at a place.
    fn note(&mut self, place: DVec3, distance: f64) {
        if distance > self.at_least {
            (self.at_least, self.place) = (distance, place);
        }
    }

    /// Of two parts of a surface.
    pub fn or_greater(self, other: Deviation) -> Deviation {
        let place = if other.at_least > self.at_least { other.place } else { self.place };
        Deviation {
            at_least: self.at_least.max(other.at_least),
            at_most: self.at_most.max(other.at_most),
            place,
        }
    }
}

/// Widens `found` by a piece: a single near triangle bounds it, or it is divided, where that triangle ends, else in the middle.
fn search(piece: Piece, surface: &Surface, limit: f64, depth: u32, found: &mut Deviation) {
    let middle = piece.iter().sum::<DVec3>() / piece.len() as f64;
    let (distance, near) = surface.nearest(middle);
    found.note(middle, distance);
    let far_corner = |piece: &Piece| {
        let to_corners = piece.iter().map(|&corner| (surface.distance_to_triangle(corner, near), corner));
        to_corners.fold((0.0, middle), |most, next| if next.0 > most.0 { next } else { most })
    };
    let (by_triangle, corner) = far_corner(&piece);
    let by_reach = distance + piece.iter().map(|c| c.distance(middle)).fold(0.0, f64::max);
    let most = by_triangle.min(by_reach);
    if most > found.at_least + SLACK * limit {
        found.note(corner, surface.nearest(corner).0);
    }
    if most <= found.at_least + SLACK * limit || depth == 0 {
        found.at_most = found.at_most.max(most);
        return;
    }
    let pieces = divide(&piece, surface.corners(near));
    let largest = pieces.iter().map(double_area).fold(0.0, f64::max);
    // What lies over the triangle need not be nearest to it: then only halves help.
    let pieces = if largest > MOSTLY * double_area(&piece) { halve(&piece) } else { pieces };
    pieces.into_iter().filter_map(wide).for_each(|piece| search(piece, surface, limit, depth - 1, found));
}

/// The part of a piece that lies over a triangle, and the rest, by the walls that stand on the triangle's sides.
fn divide(piece: &Piece, [a, b, c]: [DVec3; 3]) -> Vec<Piece> {
    let normal = (b - a).cross(c - a);
    let (mut within, mut pieces) = (piece.clone(), Vec::new());
    for (from, to) in [(a, b), (b, c), (c, a)] {
        let outwards = (to - from).cross(normal).normalize_or_zero();
        let [inside, outside] = cut(&within, outwards, outwards.dot(from));
        pieces.push(outside);
        within = inside;
    }
    pieces.push(within);
    pieces
}

/// A piece in two, across its longest way.
fn halve(piece: &Piece) -> Vec<Piece> {
    let middle = piece.iter().sum::<DVec3>() / piece.len() as f64;
    let far = piece.iter().max_by(|p, q| p.distance(middle).total_cmp(&q.distance(middle)));
    let along = (far.copied().unwrap_or(middle) - middle).normalize_or_zero();
    cut(piece, along, along.dot(middle)).into()
}

/// The part of a piece with `normal · x ≤ offset`, and the rest.
fn cut(piece: &Piece, normal: DVec3, offset: f64) -> [Piece; 2] {
    let heights: Vec<f64> = piece.iter().map(|corner| normal.dot(*corner) - offset).collect();
    let mut parts = [Piece::new(), Piece::new()];
    for k in 0..piece.len() {
        let next = (k + 1) % piece.len();
        let (here, there) = (heights[k], heights[next]);
        if here <= 0.0 {
            parts[0].push(piece[k]);
        }
        if here >= 0.0 {
            parts[1].push(piece[k]);
        }
        if here < 0.0 && there > 0.0 || here > 0.0 && there < 0.0 {
            let point = piece[k].lerp(piece[next], here / (here - there));
            parts.iter_mut().for_each(|part| part.push(point));
        }
    }
    parts
}

/// Twice its area, mm².
fn double_area(piece: &Piece) -> f64 {
    let Some(&first) = piece.first() else { return 0.0 };
    piece.windows(2).map(|pair| (pair[0] - first).cross(pair[1] - first).length()).sum()
}

/// A piece that is more than rounding.
fn wide(piece: Piece) -> Option<Piece> {
    let &first = piece.first()?;
    let longest = piece.iter().map(|corner| corner.distance(first)).fold(0.0, f64::max);
    (double_area(&piece) > ROUNDING_MM * longest).then_some(piece)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sheet(heights: impl Fn(f64, f64) -> f64, steps: u32) -> TriangleMesh {
        let place = |k: u32| f64::from(k) * 12.0 / f64::from(steps);
        let vertex = |j, i| DVec3::new(place(i), place(j), heights(place(i), place(j)));
        let vertices = (0..=steps).flat_map(|j| (0..=steps).map(move |i| vertex(j, i)).collect::<Vec<_>>());
        let cell = |j: u32, i: u32| {
            let v = j * (steps + 1) + i;
            [[v, v + 1, v + steps + 2], [v, v + steps + 2, v + steps + 1]]
        };
        let triangles = (0..steps).flat_map(|j| (0..steps).flat_map(move |i| cell(j, i)));
        TriangleMesh { vertices: vertices.collect(), triangles: triangles.collect() }
    }

    /// The interval of the Hausdorff distance holds the truth and is tight.
    fn check(one: &TriangleMesh, other: &TriangleMesh, truth: f64) {
        let limit = (1.1 * truth).max(1e-3);
        let found = hausdorff(one, other, limit).unwrap();
        assert!(found.at_least <= truth + 1e-9 && truth <= found.at_most + 1e-9, "{found:?} for {truth}");
        assert!(found.at_most - found.at_least <= 0.02 * limit + 1e-8, "{found:?} for {truth}");
    }

    #[test]
    fn the_interval_holds_the_truth() {
        let flat = |height: f64| sheet(move |_, _| height, 1);
        check(&flat(0.0), &flat(0.25), 0.25);
        check(&flat(0.0), &sheet(|_, _| 0.0, 5), 0.0);
        // A roof over a plane: the farthest point of the plane is near no corner.
        let roof = |x: f64, _: f64| 0.5 - (x - 6.0).abs() / 12.0;
        check(&flat(0.0), &sheet(roof, 2), 0.5);
        check(&sheet(roof, 6), &sheet(roof, 2), 0.0);
        let step = |x: f64, y: f64| if x > 5.0 && y > 5.0 { 1.0 } else { 0.0 };
        check(&sheet(step, 12), &flat(0.0), 1.0);
    }
}
