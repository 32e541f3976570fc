//! Which triangles have others of another group near them, by a coarse grid; all others need not be held against anything.

use crate::overlaps::LOOSE;
use fibar_core::artefact::mesh::TriangleMesh;
use glam::DVec3;

/// Nobody yet.
const EMPTY: u32 = LOOSE - 1;
/// A triangle reaches over so many cells on average; where it would be more the grid is not worth it.
const MOST_CELLS: usize = 8;

/// The triangles, in order, that share a cell of the grid with one of another group, or with any if one of them is [`LOOSE`]: two
/// triangles of different groups whose boxes overlap are both among them.
pub fn in_company(mesh: &TriangleMesh, groups: &[u32]) -> Vec<u32> {
    let all = 0..mesh.triangles.len() as u32;
    let Some(grid) = Grid::around(mesh) else { return all.collect() };
    let mut owners = vec![EMPTY; grid.cells()];
    let mut left = MOST_CELLS * mesh.triangles.len();
    for (t, &group) in groups.iter().enumerate() {
        let span = grid.span(mesh.corners(t));
        let Some(rest) = left.checked_sub(span.count()) else { return all.collect() };
        left = rest;
        span.any(&grid, |cell| {
            let owner = &mut owners[cell];
            *owner = if *owner == EMPTY || *owner == group { group } else { LOOSE };
            false
        });
    }
    let is_in_company =
        |t: &u32| grid.span(mesh.corners(*t as usize)).any(&grid, |cell| owners[cell] == LOOSE);
    all.filter(is_in_company).collect()
}

/// Cubes, about as many as there are triangles.
struct Grid {
    low: DVec3,
    per_mm: f64,
    counts: [usize; 3],
}

/// First and last cell along each axis.
struct Span([[usize; 2]; 3]);

impl Grid {
    fn around(mesh: &TriangleMesh) -> Option<Grid> {
        const FLAT: f64 = 1e-3;
        let (low, high) = mesh.bounds()?;
        let size = high - low;
        let sides = size.max(DVec3::splat(FLAT * size.max_element()));
        let per_mm = libm::cbrt(mesh.triangles.len() as f64 / sides.element_product());
        let counts = sides.to_array().map(|side| (side * per_mm) as usize + 1);
        (per_mm.is_finite() && per_mm > 0.0).then_some(Grid { low, per_mm, counts })
    }

    fn cells(&self) -> usize {
        self.counts.iter().product()
    }

    fn span(&self, [a, b, c]: [DVec3; 3]) -> Span {
        let [first, last] = [a.min(b).min(c), a.max(b).max(c)].map(|end| (end - self.low) * self.per_mm);
        // The greater a coordinate, the greater its cell: what overlaps shares one, however it is rounded.
        let cell = |x: f64, axis: usize| (x as usize).min(self.counts[axis] - 1);
        Span([0, 1, 2].map(|axis| [cell(first[axis], axis), cell(last[axis], axis)]))
    }
}

impl Span {
    fn count(&self) -> usize {
        self.0.iter().map(|[first, last]| last - first + 1).product()
    }

    /// Whether something holds for any cell; it is asked for each until it does.
    fn any(&self, grid: &Grid, mut holds: impl FnMut(usize) -> bool) -> bool {
        let [x, y, z] = self.0;
        for i in x[0]..x[1] + 1 {
            for j in y[0]..y[1] + 1 {
                for k in z[0]..z[1] + 1 {
                    if holds((i * grid.counts[1] + j) * grid.counts[2] + k) {
                        return true;
                    }
                }
            }
        }
        false
    }
}
