//! A fibre made ready to be measured.

use crate::CURVE_TOLERANCE_MM;
use fibar_core::artefact::routes::Fibre;
use fibar_core::{LedId, MarkerId, PatternId};
use fibar_plugin::StageError;
use fibar_ruler::capsules::CapsuleTree;
use fibar_ruler::curve::Curve;

/// One fibre: who it is, its exact axis, and the axis in capsules.
pub struct Strand {
    /// Its number.
    pub id: u32,
    /// Where it ends.
    pub marker: MarkerId,
    /// The LED that feeds it.
    pub led: LedId,
    /// What it carries.
    pub pattern: PatternId,
    /// Radius of its outer surface, mm.
    pub radius: f64,
    /// Its axis.
    pub curve: Curve,
    /// The axis in capsules.
    pub capsules: CapsuleTree,
}

impl Strand {
    /// Cuts the fibre's NURBS curve into Bézier pieces and encloses them.
    pub fn of(fibre: &Fibre) -> Result<Strand, StageError> {
        let curve = Curve::of_fibre(fibre).map_err(StageError::input)?;
        Ok(Strand {
            id: fibre.id,
            marker: fibre.marker,
            led: fibre.led,
            pattern: fibre.pattern,
            radius: fibre.radii_mm.black,
            capsules: enclose(&curve),
            curve,
        })
    }
}

/// Capsules fine enough for [`CURVE_TOLERANCE_MM`]: a bound falls short of the exact distance by at most twice the slack.
pub fn enclose(curve: &Curve) -> CapsuleTree {
    CapsuleTree::enclose(curve, CURVE_TOLERANCE_MM / 2.0)
}

#[cfg(test)]
pub mod tests {
    //! Things to measure.

    use super::*;
    use fibar_core::artefact::mesh::TriangleMesh;
    use fibar_core::artefact::sockets::Socket;
    use fibar_core::material::LayerRadii;
    use glam::DVec3;

    /// A broken line through the points, fed by LED `pattern` − 1.
    pub fn strand(id: u32, pattern: u32, points: Vec<DVec3>) -> Strand {
        let inner = (1..points.len() - 1).map(|k| k as f64);
        let last = (points.len() - 1) as f64;
        let knots = [0.0, 0.0].into_iter().chain(inner).chain([last, last]).collect();
        let fibre = Fibre {
            id,
            marker: MarkerId(id),
            led: LedId(pattern - 1),
            pattern: PatternId(pattern),
            degree: 1,
            knots,
            weights: vec![1.0; points.len()],
            points,
            radii_mm: LayerRadii::TONE_2020,
        };
        Strand::of(&fibre).unwrap()
    }

    /// An LED that looks up and blinks pattern `led` + 1.
    pub fn socket(led: u32, position: DVec3) -> Socket {
        Socket { led: LedId(led), pattern: PatternId(led + 1), position, axis: DVec3::Z }
    }

    /// A cube with its base on z = 0, centred on the z axis.
    pub fn cube(size: f64) -> TriangleMesh {
        let corner = |k: u32| {
            let [x, y, z] = [k & 1, k >> 1 & 1, k >> 2].map(f64::from);
            DVec3::new(x - 0.5, y - 0.5, z) * size
        };
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let halves = |[a, b, c, d]: [u32; 4]| [[a, b, c], [a, c, d]];
        TriangleMesh {
            vertices: (0..8).map(corner).collect(),
            triangles: quads.into_iter().flat_map(halves).collect(),
        }
    }
}
