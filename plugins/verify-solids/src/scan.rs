//! Lines along x through the object: where no solid is, where two are.
//!
//! Along a line everything is exact: it enters and leaves each closed solid where it pierces the triangles, and whether it
//! pierces one is decided edge by edge, the same way for both triangles of an edge. Across, the lines stand on a square
//! grid, so volumes are sums of lengths times the area of a cell.

use crate::hole;
use crate::part::Object;
use crate::pierce::pierce;
use crate::sum::Sums;
use crate::sweep::{Event, Owner, sweep};
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_core::artefact::sockets::{Cavity, Sockets};
use glam::{DVec2, DVec3, Vec3Swizzles};
use rayon::prelude::*;

/// A hole or cavity is widened by this much where a gap inside of it is forgiven: its wall is a polygon, mm.
const HOLE_ALLOWANCE_MM: f64 = 0.05;

/// What the lines found, in mm³ where it is a volume.
pub fn scan(object: &Object, spacing_mm: f64) -> Sums {
    let meshes = object.parts.iter().map(|part| &part.mesh);
    let grid = Grid::over(meshes.clone().chain([&object.body]), spacing_mm);
    let owners = (0..object.parts.len()).map(|k| Owner::Part(k as u16));
    let sorted: Vec<Rows> = owners
        .zip(meshes)
        .chain([(Owner::Body, &object.body)])
        .map(|(owner, mesh)| Rows::of(owner, mesh, &grid))
        .collect();
    let rows = (0..grid.rows).into_par_iter().map(|row| {
        let mut events: Vec<Event> = sorted.iter().flat_map(|rows| rows.events(row, &grid)).collect();
        add_holes(&mut events, &object.sockets, row, &grid);
        events.sort_unstable_by(Event::order);
        sweep(&events, object.parts.len(), |column| grid.place(row, column))
    });
    let rows: Vec<Sums> = rows.collect();
    rows.into_iter().fold(Sums::default(), Sums::and).times(spacing_mm * spacing_mm)
}

/// The lines: rows along z of columns along y.
pub struct Grid {
    origin: DVec2,
    spacing: f64,
    rows: usize,
    columns: usize,
}

impl Grid {
    fn over<'a>(meshes: impl Iterator<Item = &'a TriangleMesh>, spacing: f64) -> Grid {
        let empty = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let join = |a: (DVec3, DVec3), b: (DVec3, DVec3)| (a.0.min(b.0), a.1.max(b.1));
        let (low, high) = meshes.filter_map(TriangleMesh::bounds).fold(empty, join);
        // An odd share of a cell, so that lines keep away from coordinates that people choose.
        let origin = low.yz() + DVec2::splat(spacing * 0.381_966_011_250_105);
        let count = |length: f64| (length / spacing).ceil().max(1.0) as usize;
        Grid { origin, spacing, rows: count(high.z - low.z), columns: count(high.y - low.y) }
    }

    fn place(&self, row: usize, column: u32) -> DVec2 {
        self.origin + DVec2::new(f64::from(column), row as f64) * self.spacing
    }

    /// Indices of the grid lines from `low` to `high` (relative to the origin's coordinate), one to spare either side.
    fn span(&self, low: f64, high: f64, count: usize) -> std::ops::Range<usize> {
        let from = (low / self.spacing).floor().max(0.0) as usize;
        let to = ((high / self.spacing).ceil() + 1.0).clamp(0.0, count as f64) as usize;
        from.min(to)..to
    }
}

/// A mesh with its triangles sorted into the rows that they reach.
struct Rows<'a> {
    owner: Owner,
    mesh: &'a TriangleMesh,
    starts: Vec<u32>,
    triangles: Vec<u32>,
}

impl<'a> Rows<'a> {
    fn of(owner: Owner, mesh: &'a TriangleMesh, grid: &Grid) -> Rows<'a> {
        let reach = |t: usize| {
            let z = mesh.corners(t).map(|v| v.z - grid.origin.y);
            grid.span(z[0].min(z[1]).min(z[2]), z[0].max(z[1]).max(z[2]), grid.rows)
        };
        let mut starts = vec![0u32; grid.rows + 1];
        (0..mesh.triangles.len()).flat_map(reach).for_each(|row| starts[row + 1] += 1);
        (0..grid.rows).for_each(|row| starts[row + 1] += starts[row]);
        let mut next = starts.clone();
        let mut triangles = vec![0; starts[grid.rows] as usize];
        for t in 0..mesh.triangles.len() {
            for row in reach(t) {
                triangles[next[row] as usize] = t as u32;
                next[row] += 1;
            }
        }
        Rows { owner, mesh, starts, triangles }
    }

    /// Where the lines of a row enter and leave the mesh, in no particular order.
    fn events(&self, row: usize, grid: &Grid) -> Vec<Event> {
        let mut events = Vec::new();
        let here = self.starts[row] as usize..self.starts[row + 1] as usize;
        for &t in &self.triangles[here] {
            let corners = self.mesh.corners(t as usize);
            let y = corners.map(|v| v.y - grid.origin.x);
            let reach = grid.span(y[0].min(y[1]).min(y[2]), y[0].max(y[1]).max(y[2]), grid.columns);
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero();
            for column in reach {
                let column = column as u32;
                if let Some((x, enters)) = pierce(self.mesh, t, grid.place(row, column)) {
                    events.push(Event { column, x, enters, owner: self.owner, slope: normal.x.abs() as f32 });
                }
            }
        }
        events
    }
}

fn add_holes(events: &mut Vec<Event>, sockets: &Sockets, row: usize, grid: &Grid) {
    let wide: Vec<Cavity> =
        hole::all(sockets).iter().map(|cavity| hole::widened(cavity, HOLE_ALLOWANCE_MM)).collect();
    for column in 0..grid.columns as u32 {
        let line = grid.place(row, column);
        let point = DVec3::new(0.0, line.x, line.y);
        for (from, to) in wide.iter().filter_map(|cavity| hole::stretch(point, cavity)) {
            let event = |x, enters| Event { column, x, enters, owner: Owner::Hole, slope: 1.0 };
            events.extend([event(from, true), event(to, false)]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::part::tests::object;
    use crate::topology::tests::cuboid;

    /// A body of 10 mm cubed and two parts that fill it from below up to `low` and from above down to `high`.
    #[track_caller]
    fn check(low: f64, high: f64, [overlap, gap, outside]: [f64; 3]) {
        let corners = [DVec3::ZERO, DVec3::splat(10.0)];
        let parts =
            [cuboid(corners[0], DVec3::new(10.0, 10.0, low)), cuboid(DVec3::new(0.0, 0.0, high), corners[1])];
        let found = scan(&object(cuboid(corners[0], corners[1]), &parts), 0.25);
        let volumes = [found.overlap.length, found.gap.length, found.outside.length];
        for (found, expected) in volumes.into_iter().zip([overlap, gap, outside]) {
            assert!((found - expected).abs() < 1e-6, "{volumes:?}");
        }
        assert_eq!(found.skipped_lines, 0);
    }

    #[test]
    fn volumes_of_overlaps_and_gaps() {
        check(5.0, 5.0, [0.0, 0.0, 0.0]);
        check(6.0, 5.0, [100.0, 0.0, 0.0]);
        check(5.0, 7.0, [0.0, 200.0, 0.0]);
        check(12.0, 10.0, [0.0, 0.0, 200.0]);
    }
}
