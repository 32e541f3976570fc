//! Samples sorted into cubic cells, for finding those near a point straight through space.

use fibar_geometry::sampling::SurfaceSample;
use glam::{DVec3, IVec3};
use std::collections::BTreeMap;

/// Samples by cubic cell.
pub struct Cells {
    size: f64,
    members: BTreeMap<[i32; 3], Vec<usize>>,
}

impl Cells {
    /// Sorts samples into cells of a size, mm.
    pub fn new(samples: &[SurfaceSample], size: f64) -> Cells {
        let mut members = BTreeMap::<[i32; 3], Vec<usize>>::new();
        for (k, sample) in samples.iter().enumerate() {
            members.entry(cell_of(sample.position, size).to_array()).or_default().push(k);
        }
        Cells { size, members }
    }

    /// Other samples nearer than `distance`, which is no more than the size of a cell.
    pub fn within(&self, samples: &[SurfaceSample], here: usize, distance: f64) -> Vec<usize> {
        let place = samples[here].position;
        let home = cell_of(place, self.size);
        let around = (0..27).map(|k| home + IVec3::new(k / 9 - 1, k / 3 % 3 - 1, k % 3 - 1));
        let members = around.filter_map(|cell| self.members.get(&cell.to_array())).flatten();
        let near = |&&k: &&usize| k != here && samples[k].position.distance(place) < distance;
        members.filter(near).copied().collect()
    }
}

fn cell_of(place: DVec3, size: f64) -> IVec3 {
    (place / size).floor().as_ivec3()
}
