//! Coordinates that every file format keeps: multiples of a power of two that f32 represents exactly.

use crate::{Solid, SolidError};
use glam::DVec3;

/// A grid of places. Rounding to it moves a vertex by less than 0.87 of its step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    step: f64,
}

impl Grid {
    /// The finest grid whose coordinates up to `extent` mm fit the 24 bits of an f32: 2⁻¹⁶ mm (15 nm) up to 256 mm.
    pub fn exact_in_f32(extent: f64) -> Grid {
        let mut step = 2f64.powi(-16);
        while extent > step * f64::from(1u32 << 24) && step < 1.0 {
            step *= 2.0;
        }
        Grid { step }
    }

    /// Distance between neighbouring coordinates, mm.
    pub fn step(self) -> f64 {
        self.step
    }

    /// The nearest place of the grid.
    pub fn snap(self, place: DVec3) -> DVec3 {
        // Adding 0 turns −0 into 0.
        (place / self.step).round() * self.step + 0.0
    }

    /// A solid with all vertices on the grid, and edges that became points collapsed, so that readers which weld equal
    /// places find the same surface. Flat detail below four steps goes, too.
    pub fn snap_solid(self, solid: &Solid) -> Result<Solid, SolidError> {
        let mut mesh = solid.simplify(4.0 * self.step)?.to_mesh()?;
        mesh.vertices.iter_mut().for_each(|v| *v = self.snap(*v));
        // Vertices of a collapsed edge keep one of its ends: all stay on the grid.
        Solid::from_mesh(&mesh)?.simplify(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn snapped_coordinates_survive_f32() {
        for extent in [1.0, 100.0, 256.0, 257.0, 3000.0] {
            let grid = Grid::exact_in_f32(extent);
            for share in [1.0, 0.999_999_9, 0.123_456_789, -0.777_777_7, 1e-9] {
                let x = grid.snap(DVec3::splat(share * extent)).x;
                assert_eq!(f64::from(x as f32), x, "{share} of {extent}");
                assert!((x - share * extent).abs() <= grid.step() / 2.0);
            }
        }
        assert_eq!(Grid::exact_in_f32(256.0).step(), 2f64.powi(-16));
        assert_eq!(Grid::exact_in_f32(257.0).step(), 2f64.powi(-15));
    }
}
