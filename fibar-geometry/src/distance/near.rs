//! Signed distances near a surface at many points of a lattice: every triangle goes over the points that it may be near, instead of
//! every point looking for its triangle.

use super::{Lattice, Surface, distance_to_triangle};
use glam::DVec3;
use rayon::prelude::*;

/// A triangle, made ready.
struct Facet {
    corners: [DVec3; 3],
    /// Unit normal, outward; zero if it has no area.
    normal: DVec3,
    low: DVec3,
    high: DVec3,
}

impl Facet {
    fn of(corners: [DVec3; 3]) -> Facet {
        let [a, b, c] = corners;
        Facet {
            corners,
            normal: (b - a).cross(c - a).normalize_or_zero(),
            low: a.min(b).min(c),
            high: a.max(b).max(c),
        }
    }
}

/// What is known of a point: the square of the distance, mm², and the facet.
#[derive(Clone, Copy)]
struct Found {
    square: f64,
    facet: u32,
}

const NOTHING: u32 = u32::MAX;
/// Of distances, relative and in mm.
const ROUNDING: f64 = 1e-9;

/// How far from a surface, mm.
#[derive(Clone, Copy)]
pub struct Bands {
    /// Up to here every triangle is looked at; no less than the spacing.
    pub exact: f64,
    /// From there up to here only the nearest triangles of the neighbours; beyond, the distance is stored as this.
    pub all: f64,
}

/// Samples a surface at all points of a lattice whose border lies outside. On all threads of the current pool.
pub fn sample(surface: &Surface, lattice: &Lattice, bands: Bands) -> Vec<f64> {
    let facets: Vec<Facet> = (0..surface.triangle_count()).map(|k| Facet::of(surface.corners(k))).collect();
    let [nx, ny, nz] = lattice.counts;
    let mut of_planes: Vec<Vec<u32>> = vec![vec![]; nz];
    for (number, facet) in (0..).zip(&facets) {
        let (from, to) = range(lattice, 2, facet.low.z - bands.exact, facet.high.z + bands.exact);
        of_planes[from..to].iter_mut().for_each(|plane| plane.push(number));
    }
    let nothing = Found { square: bands.exact * bands.exact, facet: NOTHING };
    let mut found = vec![nothing; lattice.len()];
    let mut samples = vec![0.0; lattice.len()];
    let planes = samples.par_chunks_mut(nx * ny).zip(found.par_chunks_mut(nx * ny)).enumerate();
    planes.for_each(|(k, (samples, found))| {
        for &number in &of_planes[k] {
            go_over(&facets[number as usize], number, lattice, (k, bands.exact), found);
        }
        for (j, (samples, found)) in samples.chunks_mut(nx).zip(found.chunks(nx)).enumerate() {
            sign_row(surface, &facets, lattice, (k * ny + j, bands.exact), found, samples);
        }
    });
    spread(&facets, lattice, bands.all, &mut found);
    samples
        .iter_mut()
        .zip(&found)
        .for_each(|(sample, found)| *sample = found.square.sqrt().copysign(*sample));
    samples
}

/// Goes outwards and inwards from what is known, a step at a time: a point takes the nearest of the facets of those before it. What
/// it finds is no less than the true distance, and nearly always that.
fn spread(facets: &[Facet], lattice: &Lattice, band: f64, found: &mut [Found]) {
    let [nx, ny, nz] = lattice.counts;
    let mut front: Vec<usize> = (0..found.len()).filter(|&n| found[n].facet != NOTHING).collect();
    let mut round = vec![0u8; found.len()];
    front.iter().for_each(|&n| round[n] = 1);
    found.iter_mut().filter(|found| found.facet == NOTHING).for_each(|found| found.square = band * band);
    for now in 2..u8::MAX {
        let mut next = vec![];
        for &here in &front {
            let Found { facet, .. } = found[here];
            let (i, j, k) = (here % nx, here / nx % ny, here / (nx * ny));
            let steps = [
                (i > 0, here.wrapping_sub(1)),
                (i + 1 < nx, here + 1),
                (j > 0, here.wrapping_sub(nx)),
                (j + 1 < ny, here + nx),
                (k > 0, here.wrapping_sub(nx * ny)),
                (k + 1 < nz, here + nx * ny),
            ];
            for (_, there) in steps.into_iter().filter(|(within, _)| *within) {
                if round[there] != 0 && round[there] != now || found[there].facet == facet {
                    continue;
                }
                let distance = distance_to_triangle(lattice.place(there), facets[facet as usize].corners);
                if distance * distance < found[there].square {
                    found[there] = Found { square: distance * distance, facet };
                    if round[there] == 0 {
                        next.push(there);
                        round[there] = now;
                    }
                }
            }
        }
        if next.is_empty() {
            return;
        }
        front = next;
    }
}

/// Places along an axis between two coordinates, as a range of numbers.
fn range(lattice: &Lattice, axis: usize, low: f64, high: f64) -> (usize, usize) {
    let at = |coordinate: f64| (coordinate - lattice.origin[axis]) / lattice.spacing;
    let last = lattice.counts[axis] as f64;
    let from = at(low).ceil().clamp(0.0, last) as usize;
    (from, ((at(high) + 1.0).floor().clamp(0.0, last) as usize).max(from))
}

/// Notes a facet at the points of a plane that it is nearer to than all before it.
fn go_over(facet: &Facet, number: u32, lattice: &Lattice, (plane, band): (usize, f64), found: &mut [Found]) {
    let beside = |at: f64, axis: usize| (facet.low[axis] - at).max(at - facet.high[axis]).max(0.0);
    let z = lattice.origin.z + lattice.spacing * plane as f64;
    let left = band * band - beside(z, 2) * beside(z, 2);
    if left < 0.0 {
        return;
    }
    let reach = left.sqrt();
    let (from, to) = range(lattice, 1, facet.low.y - reach, facet.high.y + reach);
    for j in from..to {
        let y = lattice.origin.y + lattice.spacing * j as f64;
        let reach = (left - beside(y, 1) * beside(y, 1)).max(0.0).sqrt();
        let (from, to) = range(lattice, 0, facet.low.x - reach, facet.high.x + reach);
        for (i, found) in (from..).zip(&mut found[j * lattice.counts[0]..][from..to]) {
            let place = DVec3::new(lattice.origin.x + lattice.spacing * i as f64, y, z);
            let height = facet.normal.dot(place - facet.corners[0]);
            if height * height < found.square {
                let distance = distance_to_triangle(place, facet.corners);
                if distance * distance < found.square {
                    *found = Found { square: distance * distance, facet: number };
                }
            }
        }
    }
}

/// One row along x, which starts outside. No surface lies between two points that are together further from it than from each
/// other: then the sign is the same.
fn sign_row(
    surface: &Surface,
    facets: &[Facet],
    lattice: &Lattice,
    (row, band): (usize, f64),
    found: &[Found],
    samples: &mut [f64],
) {
    let mut last = band;
    for (k, (sample, found)) in samples.iter_mut().zip(found).enumerate() {
        let distance = found.square.sqrt();
        *sample = if distance + last.abs() > lattice.spacing * (1.0 + ROUNDING) {
            distance.copysign(last)
        } else {
            let place = lattice.place(row * lattice.counts[0] + k);
            distance.copysign(side(surface, facets, place, *found, distance))
        };
        last = *sample;
    }
}

/// A number whose sign says on which side a point lies: by its facet where that is seen from straight above, else by the surface.
fn side(surface: &Surface, facets: &[Facet], place: DVec3, found: Found, distance: f64) -> f64 {
    // Nothing may be near a point whose neighbour lies on the surface.
    let Some(facet) = facets.get(found.facet as usize) else { return surface.signed_distance(place) };
    let height = facet.normal.dot(place - facet.corners[0]);
    if distance - height.abs() < ROUNDING * distance {
        return height;
    }
    surface.closest_within(place, distance + ROUNDING).map_or(1.0, |closest| closest.signed_distance)
}
