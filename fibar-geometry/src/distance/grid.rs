//! Signed distance sampled on a lattice: a query in tens of nanoseconds instead of microseconds.

use super::near::{self, Bands};
use super::{Lattice, Surface};
use glam::DVec3;
use rayon::prelude::*;

/// How to sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridOptions {
    /// Between samples, mm.
    pub spacing: f64,
    /// Room around the surface's box, mm.
    pub margin: f64,
    /// Distances beyond this are stored as this; building time grows with it. At least `spacing`; infinite for all.
    pub band: f64,
    /// Distances beyond this, at least `spacing`, may come out a little too large where the nearest triangle changes: much quicker for
    /// fine meshes. All are exact if it is no less than `band`.
    pub exact: f64,
}

/// Signed distance by linear interpolation of samples.
///
/// Distance changes by no more than 1 mm per mm, so a value is off by at most `√3/2·spacing`, the half diagonal of a
/// cell; by about `spacing²/8` times the surface's curvature where the closest point is unique; by nothing before a
/// plane. Directions are off most where the closest point jumps, on the medial axis.
pub struct DistanceGrid {
    lattice: Lattice,
    samples: Vec<f64>,
}

impl DistanceGrid {
    /// Samples a surface, on all threads of the current pool.
    pub fn sample(surface: &Surface, options: GridOptions) -> DistanceGrid {
        let lattice =
            Lattice::around(surface.bounds(), options.margin + 2.0 * options.spacing, options.spacing);
        let band = options.band.max(options.spacing);
        if options.exact < band {
            let bands = Bands { exact: options.exact.max(options.spacing), all: band };
            return DistanceGrid { lattice, samples: near::sample(surface, &lattice, bands) };
        }
        let mut samples = vec![0.0; lattice.len()];
        let row = lattice.counts[0];
        let blocks = Blocks::of(surface, &lattice, band);
        let rows = samples.par_chunks_mut(row).enumerate();
        rows.for_each(|(k, samples)| sample_row(surface, &lattice, &blocks, (k, band), samples));
        DistanceGrid { lattice, samples }
    }

    /// Distance, mm, negative inside.
    pub fn distance(&self, place: DVec3) -> f64 {
        self.lattice.interpolate_linear(&self.samples, place).0
    }

    /// Distance and its gradient, which points away from the surface outside and towards it inside.
    pub fn distance_with_gradient(&self, place: DVec3) -> (f64, DVec3) {
        self.lattice.interpolate_linear(&self.samples, place)
    }

    /// About where on the surface the closest point is, to the error of the distance and its direction.
    pub fn closest(&self, place: DVec3) -> DVec3 {
        let (distance, gradient) = self.distance_with_gradient(place);
        place - distance * gradient.normalize_or_zero()
    }

    /// Where the samples are.
    pub fn lattice(&self) -> &Lattice {
        &self.lattice
    }

    /// Distance at the samples, in the lattice's order.
    pub fn samples(&self) -> &[f64] {
        &self.samples
    }
}

/// Cubes of samples, and which of them may have the surface within the band.
struct Blocks {
    counts: [usize; 3],
    near: Vec<bool>,
}

/// Samples along a block's side.
const SIDE: usize = 4;

impl Blocks {
    fn of(surface: &Surface, lattice: &Lattice, band: f64) -> Blocks {
        let counts = lattice.counts.map(|n| n.div_ceil(SIDE));
        let half = 0.5 * (SIDE - 1) as f64;
        let reach = (band + half * 3f64.sqrt() * lattice.spacing) * (1.0 + 1e-12);
        let is_near = |block: usize| {
            let at = [block % counts[0], block / counts[0] % counts[1], block / (counts[0] * counts[1])];
            let middle = DVec3::from(at.map(|k| (k * SIDE) as f64 + half));
            surface.closest_within(lattice.origin + lattice.spacing * middle, reach).is_some()
        };
        let near = (0..counts.iter().product()).into_par_iter().map(is_near).collect();
        Blocks { counts, near }
    }

    /// The first block of the row of samples with this number.
    fn row(&self, number: usize, lattice: &Lattice) -> &[bool] {
        let (j, k) = (number % lattice.counts[1] / SIDE, number / lattice.counts[1] / SIDE);
        &self.near[(k * self.counts[1] + j) * self.counts[0]..][..self.counts[0]]
    }
}

/// One row along x. It starts outside. A neighbour's distance plus the spacing bounds the search; where nothing is within
/// the band the sign is the neighbour's, since a surface between the two would be within half a spacing of one of them.
fn sample_row(
    surface: &Surface,
    lattice: &Lattice,
    blocks: &Blocks,
    (row, band): (usize, f64),
    samples: &mut [f64],
) {
    let first = row * lattice.counts[0];
    let near = blocks.row(row, lattice);
    let mut last = f64::INFINITY;
    for (k, sample) in samples.iter_mut().enumerate() {
        let reach = (last.abs() + lattice.spacing).min(band) * (1.0 + 1e-12);
        let look = || surface.closest_within(lattice.place(first + k), reach);
        let found = if near[k / SIDE] { look() } else { None };
        *sample = found.map_or(band.copysign(last), |c| c.signed_distance);
        last = *sample;
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{cube, distance_to_cube};
    use super::*;

    fn check(options: GridOptions) {
        let surface = Surface::new(&cube(10.0)).expect("a cube");
        let grid = DistanceGrid::sample(&surface, options);
        for k in 0..400 {
            let t = f64::from(k);
            let p = DVec3::new((t * 0.731).sin(), (t * 1.137).sin(), (t * 0.317).cos()) * 11.5;
            let exact = distance_to_cube(10.0, p).clamp(-options.band, options.band);
            let (value, gradient) = grid.distance_with_gradient(p);
            let bound = 3f64.sqrt() / 2.0 * options.spacing;
            assert!((value - exact).abs() <= bound, "{p}: {value} is not {exact}");
            assert!(gradient.abs().max_element() < 1.0 + 1e-9, "{p}: {gradient}");
        }
        for (n, sample) in grid.samples().iter().enumerate() {
            let exact = distance_to_cube(10.0, grid.lattice().place(n)).clamp(-options.band, options.band);
            assert!((sample - exact).abs() < 1e-9, "sample {n}: {sample} is not {exact}");
        }
    }

    #[test]
    fn samples_are_exact_and_between_them_the_error_is_bounded() {
        check(GridOptions { spacing: 1.0, margin: 1.0, band: f64::INFINITY, exact: f64::INFINITY });
        check(GridOptions { spacing: 0.7, margin: 2.0, band: 3.0, exact: f64::INFINITY });
        check(GridOptions { spacing: 2.5, margin: 0.0, band: 2.5, exact: f64::INFINITY });
        // Triangle by triangle near the surface, also where samples lie on it; from neighbour to neighbour beyond.
        check(GridOptions { spacing: 1.0, margin: 1.0, band: 6.0, exact: 1.0 });
        check(GridOptions { spacing: 0.7, margin: 2.0, band: 5.0, exact: 1.4 });
        check(GridOptions { spacing: 2.5, margin: 0.0, band: 6.0, exact: 0.0 });
    }

    #[test]
    fn the_closest_point_lies_on_the_surface() {
        let surface = Surface::new(&cube(10.0)).expect("a cube");
        let options = GridOptions { spacing: 1.0, margin: 3.0, band: f64::INFINITY, exact: f64::INFINITY };
        let grid = DistanceGrid::sample(&surface, options);
        for p in [DVec3::new(8.3, 1.2, -2.0), DVec3::new(11.7, 3.0, 4.0), DVec3::new(0.4, -7.9, 0.2)] {
            assert!(grid.closest(p).distance(surface.closest(p).point) < 1e-9, "{p}");
        }
    }
}
