//! Who is near whom on the surface: distances along it, over a graph of its samples.
//!
//! Samples up to a few grains apart (a grain is the side of the square that a sample stands for) are linked, and the
//! shortest way over links stands for the shortest way on the surface, a few per cent too long. Samples that face each other across a thin wall are not
//! linked. Mesh edges would do worse: their lengths depend on the triangulation.

use crate::cells::Cells;
use crate::params::Along;
use fibar_geometry::sampling::SurfaceSample;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Length of the longest links in grains.
const LINK: f64 = 3.0;
/// Cosine between normals below which two samples lie on opposite sides of something thin; a cube's edge (0) links.
const OPPOSITE: f64 = -0.5;

/// Finds the samples within a distance of one of them.
pub struct Neighbourhood<'a> {
    samples: &'a [SurfaceSample],
    spacing: f64,
    kind: Kind,
}

enum Kind {
    Straight(Cells),
    Surface { links: Links, ways: Ways },
}

impl<'a> Neighbourhood<'a> {
    /// Prepares for queries of one distance, mm, among samples of the given grain, mm.
    pub fn new(samples: &'a [SurfaceSample], grain: f64, spacing: f64, along: Along) -> Neighbourhood<'a> {
        let kind = match along {
            Along::Straight => Kind::Straight(Cells::new(samples, spacing)),
            Along::Surface => {
                Kind::Surface { links: Links::new(samples, LINK * grain), ways: Ways::new(samples.len()) }
            }
        };
        Neighbourhood { samples, spacing, kind }
    }

    /// Every other sample nearer than the spacing, in no promised but a repeatable order.
    pub fn around(&mut self, here: usize) -> Vec<usize> {
        match &mut self.kind {
            Kind::Straight(cells) => cells.within(self.samples, here, self.spacing),
            Kind::Surface { links, ways } => ways.within(links, here, self.spacing),
        }
    }
}

/// The graph: for every sample, the linked ones and their distances, mm.
struct Links(Vec<Vec<(usize, f64)>>);

impl Links {
    fn new(samples: &[SurfaceSample], reach: f64) -> Links {
        let cells = Cells::new(samples, reach);
        let faces = |a: usize, b: usize| samples[a].normal.dot(samples[b].normal) > OPPOSITE;
        let length = |a: usize, b: usize| samples[a].position.distance(samples[b].position);
        let links = |a: usize| {
            let near = cells.within(samples, a, reach).into_iter();
            near.filter(|&b| faces(a, b)).map(|b| (b, length(a, b))).collect()
        };
        Links((0..samples.len()).map(links).collect())
    }
}

/// Scratch for shortest ways, kept between queries.
struct Ways {
    length: Vec<f64>,
}

impl Ways {
    fn new(count: usize) -> Ways {
        Ways { length: vec![f64::INFINITY; count] }
    }

    /// Dijkstra's walk from one sample, no further than `distance`.
    fn within(&mut self, links: &Links, here: usize, distance: f64) -> Vec<usize> {
        let mut reached = vec![here];
        let mut front = BinaryHeap::from([Reverse((Length(0.0), here))]);
        self.length[here] = 0.0;
        while let Some(Reverse((Length(length), at))) = front.pop() {
            if length > self.length[at] {
                continue;
            }
            for &(next, step) in &links.0[at] {
                let longer = length + step;
                if longer < distance && longer < self.length[next] {
                    if self.length[next] == f64::INFINITY {
                        reached.push(next);
                    }
                    self.length[next] = longer;
                    front.push(Reverse((Length(longer), next)));
                }
            }
        }
        reached.iter().for_each(|&k| self.length[k] = f64::INFINITY);
        reached.split_off(1)
    }
}

/// A length that can be ordered.
#[derive(Clone, Copy, PartialEq)]
struct Length(f64);

impl Eq for Length {}

impl PartialOrd for Length {
    fn partial_cmp(&self, other: &Length) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Length {
    fn cmp(&self, other: &Length) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::{box_mesh, samples_of};
    use fibar_geometry::sampling::surface_area;
    use glam::DVec3;

    /// How many of 5000 samples of a box are within `spacing` of the one nearest to `at`, times the area each stands for.
    fn area_around(size: DVec3, at: DVec3, spacing: f64, along: Along) -> f64 {
        let mesh = box_mesh(size);
        let samples = samples_of(&mesh, 5000);
        let cell = surface_area(&mesh) / 5000.0;
        let gap = |k: &usize| samples[*k].position.distance(at);
        let here = (0..5000).min_by(|a, b| gap(a).total_cmp(&gap(b))).unwrap();
        let found = Neighbourhood::new(&samples, cell.sqrt(), spacing, along).around(here);
        assert!(!found.contains(&here));
        found.len() as f64 * cell
    }

    #[test]
    fn thin_walls_separate_along_the_surface_only() {
        let disc = std::f64::consts::PI * 64.0;
        let check = |size: [f64; 3], at: [f64; 3], along: Along, expected: f64| {
            let area = area_around(size.into(), at.into(), 8.0, along);
            assert!(
                (0.93..1.03).contains(&(area / expected)),
                "{along:?} {size:?} {at:?}: {area} not {expected}"
            );
        };
        let plate = [40.0, 40.0, 1.0];
        check(plate, [20.0, 20.0, 1.0], Along::Surface, disc);
        check(plate, [20.0, 20.0, 1.0], Along::Straight, 2.0 * disc);
        let cube = [40.0, 40.0, 40.0];
        check(cube, [20.0, 20.0, 40.0], Along::Surface, disc);
        check(cube, [20.0, 0.0, 40.0], Along::Surface, disc);
        check(cube, [20.0, 0.0, 40.0], Along::Straight, disc);
    }
}
