//! From the file's coordinates to mm with +Z up: units, axis, turn, size.

use fibar_core::artefact::mesh::TriangleMesh;
use fibar_plugin::Direction;
use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};

/// How a mesh is brought into the frame of the object.
pub struct Placement {
    /// Millimetres of a 1 in the file.
    pub mm_per_unit: f64,
    /// Axis of the file that becomes +Z.
    pub up: Direction,
    /// Turn about +Z, degrees, counter-clockwise from above.
    pub turn_deg: f64,
    /// Box to touch from inside, mm.
    pub fit_mm: Option<DVec3>,
}

/// Length of a 1 in the file; an inch is 25.4 mm.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Unit {
    Mm,
    Cm,
    M,
    Inch,
}

impl Placement {
    /// Rotates, then scales; the error says what is wrong with the mesh's size.
    pub fn apply(&self, mut mesh: TriangleMesh) -> Result<TriangleMesh, String> {
        let z_up_from_file = DMat3::from_cols_array_2d(&self.up.turn_to_z()).transpose();
        let object_from_file = turn(self.turn_deg) * z_up_from_file * self.mm_per_unit;
        mesh.vertices.iter_mut().for_each(|v| *v = object_from_file * *v);
        let (low, high) = mesh.bounds().ok_or("the file holds no vertex")?;
        let size = high - low;
        if !(size.is_finite() && size.min_element() > 0.0) {
            return Err(format!("the mesh is flat or too large: {} × {} × {} mm", size.x, size.y, size.z));
        }
        if let Some(fit) = self.fit_mm {
            let factor = (fit / size).min_element();
            mesh.vertices.iter_mut().for_each(|v| *v *= factor);
        }
        Ok(mesh)
    }
}

impl Unit {
    /// Its length, mm.
    pub fn mm(self) -> f64 {
        match self {
            Unit::Mm => 1.0,
            Unit::Cm => 10.0,
            Unit::M => 1000.0,
            Unit::Inch => 25.4,
        }
    }
}

/// Rotation about +Z, exact for multiples of 90°.
fn turn(degrees: f64) -> DMat3 {
    let quarter = (degrees / 90.0).round();
    let (sine, cosine) = libm::sincos((degrees - quarter * 90.0).to_radians());
    let small = DMat3::from_cols(DVec3::new(cosine, sine, 0.0), DVec3::new(-sine, cosine, 0.0), DVec3::Z);
    let right_angle = DMat3::from_cols(DVec3::Y, -DVec3::X, DVec3::Z);
    (0..quarter.rem_euclid(4.0) as u32).fold(small, |turned, _| right_angle * turned)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh(vertices: &[[f64; 3]]) -> TriangleMesh {
        TriangleMesh { vertices: vertices.iter().map(|&v| v.into()).collect(), triangles: vec![] }
    }

    /// Where the corners 0 and (1, 2, 3) of the file end up.
    #[test]
    fn axes_turn_into_place() {
        let check = |up, turn_deg, expected: [f64; 3]| {
            let placement = Placement { mm_per_unit: 10.0, up, turn_deg, fit_mm: None };
            let placed = placement.apply(mesh(&[[0.0; 3], [1.0, 2.0, 3.0]])).unwrap();
            assert_eq!(placed.vertices[1], DVec3::from(expected), "{up:?} {turn_deg}");
        };
        check(Direction::PlusZ, 0.0, [10.0, 20.0, 30.0]);
        check(Direction::MinusZ, 0.0, [10.0, -20.0, -30.0]);
        check(Direction::PlusY, 0.0, [10.0, -30.0, 20.0]);
        check(Direction::MinusY, 0.0, [10.0, 30.0, -20.0]);
        check(Direction::PlusX, 0.0, [-30.0, 20.0, 10.0]);
        check(Direction::MinusX, 0.0, [30.0, 20.0, -10.0]);
        check(Direction::PlusZ, 90.0, [-20.0, 10.0, 30.0]);
        check(Direction::PlusZ, -90.0, [20.0, -10.0, 30.0]);
        check(Direction::PlusZ, 360.0, [10.0, 20.0, 30.0]);
    }

    #[test]
    fn turns_are_rotations() {
        assert!((turn(37.0).determinant() - 1.0).abs() < 1e-15);
    }

    #[test]
    fn fitting_touches_the_box_evenly() {
        let fit = Placement {
            mm_per_unit: 1.0,
            up: Direction::PlusZ,
            turn_deg: 0.0,
            fit_mm: Some(DVec3::new(10.0, 100.0, 6.0)),
        };
        let placed = fit.apply(mesh(&[[0.0; 3], [1.0, 2.0, 3.0]])).unwrap();
        assert_eq!(placed.vertices[1], DVec3::new(2.0, 4.0, 6.0));
        assert!(fit.apply(mesh(&[[0.0; 3], [1.0, 0.0, 3.0]])).unwrap_err().contains("flat"));
        assert!(fit.apply(mesh(&[])).is_err());
    }
}
