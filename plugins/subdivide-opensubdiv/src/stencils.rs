//! Rows of weights that make points of other points; how OpenSubdiv says where refined vertices lie.
//!
//! OpenSubdiv's weights are f32. Those of regular vertices are dyadic and so exact; others are off by 6e-8. Rows are brought to
//! a sum of 1 and applied in f64 to differences, so that what is flat along an axis stays so to the bit.

use glam::DVec3;

/// A sparse matrix whose rows sum to 1.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stencils {
    ends: Vec<usize>,
    indices: Vec<u32>,
    weights: Vec<f64>,
}

impl Stencils {
    /// Adds a row; weights are scaled to a sum of 1.
    pub fn push(&mut self, row: impl Iterator<Item = (u32, f64)> + Clone) {
        let sum: f64 = row.clone().map(|(_, weight)| weight).sum();
        for (index, weight) in row.filter(|(_, weight)| *weight != 0.0) {
            self.indices.push(index);
            self.weights.push(weight / sum);
        }
        self.ends.push(self.indices.len());
    }

    /// Number of rows: of points that come out.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Indices and weights of a row.
    pub fn row(&self, row: usize) -> impl Iterator<Item = (u32, f64)> + Clone + '_ {
        let start = if row == 0 { 0 } else { self.ends[row - 1] };
        let range = start..self.ends[row];
        self.indices[range.clone()].iter().copied().zip(self.weights[range].iter().copied())
    }

    /// The points that the rows make, in the unit of `points`.
    pub fn apply(&self, points: &[DVec3]) -> Vec<DVec3> {
        (0..self.len()).map(|row| self.point(row, points)).collect()
    }

    fn point(&self, row: usize, points: &[DVec3]) -> DVec3 {
        let Some((first, _)) = self.row(row).next() else { return DVec3::ZERO };
        let origin = points[first as usize];
        let moved = self.row(row).map(|(index, weight)| (points[index as usize] - origin) * weight);
        origin + moved.sum::<DVec3>()
    }
}
