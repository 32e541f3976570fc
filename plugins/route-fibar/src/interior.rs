//! The inside of the body: how deep a place lies, and the way back in.

use crate::params::Params;
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_geometry::distance::{DistanceGrid, GridOptions, Lattice, Surface};
use fibar_plugin::StageError;
use glam::DVec3;

/// Most samples that the fields may have: 8 bytes each, twice.
const MOST_SAMPLES: f64 = 4e7;

/// Distance to the body's surface, sampled for the inner loops.
pub struct Interior {
    surface: Surface,
    grid: DistanceGrid,
    least_depth: f64,
}

impl Interior {
    /// Samples the distance everywhere in the body's box.
    pub fn of(body: &TriangleMesh, params: &Params) -> Result<Interior, StageError> {
        let surface = Surface::new(body).map_err(|e| StageError::input(format!("body: {e}")))?;
        check_size(&surface, params.grid_mm)?;
        let options =
            GridOptions { spacing: params.grid_mm, margin: 2.0, band: f64::INFINITY, exact: f64::INFINITY };
        let grid = DistanceGrid::sample(&surface, options);
        Ok(Interior { surface, grid, least_depth: params.least_depth_mm })
    }

    /// Distance to the surface without sampling, mm, negative inside.
    pub fn exact_distance(&self, place: DVec3) -> f64 {
        self.surface.signed_distance(place)
    }

    /// Depth below the surface, mm, and the unit direction inwards; zero where all directions are alike.
    pub fn depth(&self, place: DVec3) -> (f64, DVec3) {
        let (distance, gradient) = self.grid.distance_with_gradient(place);
        (-distance, -gradient.normalize_or_zero())
    }

    /// The guard: a place too shallow or outside is put back to the least depth, straight inwards; the paper keeps points
    /// inside by soft terms alone, which pull outwards once a point is out.
    pub fn keep_inside(&self, place: DVec3) -> DVec3 {
        const TRIES: u32 = 4;
        let mut place = place;
        for _ in 0..TRIES {
            let (depth, inwards) = self.depth(place);
            if depth >= self.least_depth {
                break;
            }
            place += (self.least_depth - depth) * inwards;
        }
        place
    }

    /// Where distances are sampled.
    pub fn lattice(&self) -> &Lattice {
        self.grid.lattice()
    }

    /// Signed distance at a sample, mm.
    pub fn sample(&self, number: usize) -> f64 {
        self.grid.samples()[number]
    }
}

fn check_size(surface: &Surface, spacing: f64) -> Result<(), StageError> {
    let (low, high) = surface.bounds();
    let samples = ((high - low) / spacing + 6.0).element_product();
    if samples <= MOST_SAMPLES {
        return Ok(());
    }
    let needed = spacing * libm::cbrt(samples / MOST_SAMPLES);
    Err(StageError::user(format!("a body of {} mm has too many samples {spacing} mm apart", high - low))
        .hint(format!("sample about every {:.1} mm", needed + 0.05))
        .param("/grid_mm"))
}

#[cfg(test)]
pub mod tests {
    use super::*;

    /// A box from −`half` to `half`, closed, outward.
    pub fn cuboid(half: DVec3) -> TriangleMesh {
        let corner =
            |k: usize| DVec3::from([0, 1, 2].map(|bit| if k >> bit & 1 == 1 { 1.0 } else { -1.0 })) * half;
        let quads: [[u32; 4]; 6] =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        TriangleMesh { vertices: (0..8).map(corner).collect(), triangles }
    }

    #[test]
    fn the_guard_moves_nothing_inside_and_everything_else_in() {
        let params = Params { least_depth_mm: 2.0, ..Params::default() };
        let interior = Interior::of(&cuboid(DVec3::splat(20.0)), &params).unwrap();
        let check = |x, y, z| {
            let place = DVec3::new(x, y, z);
            let kept = interior.keep_inside(place);
            if interior.exact_distance(place) < -2.5 {
                assert_eq!(kept, place);
            }
            assert!(interior.exact_distance(kept) < -1.5, "{place} stays at {kept}");
        };
        check(0.0, 0.0, 0.0);
        check(17.0, 3.0, 4.0);
        check(19.0, 3.0, 4.0);
        check(23.0, 3.0, 4.0);
        check(21.0, -21.5, 22.0);
    }

    #[test]
    fn a_body_too_large_for_the_grid_says_what_to_set() {
        let error = Interior::of(&cuboid(DVec3::splat(500.0)), &Params::default()).err().unwrap();
        assert!(error.to_string().contains("too many samples"), "{error}");
    }
}
