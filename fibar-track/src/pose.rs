//! A rigid motion from one frame to another: `camera_from_object`, say.

use glam::{DMat3, DVec3};

/// `x ↦ rotation · x + translation`, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// A proper rotation.
    pub rotation: DMat3,
    /// Where the origin goes, mm.
    pub translation: DVec3,
}

impl Pose {
    /// The pose of a camera at `eye` that looks at `target`, its picture turned by `roll_rad` clockwise from upright (+Z up;
    /// straight down or up, +Y is up).
    pub fn looking(eye: DVec3, target: DVec3, roll_rad: f64) -> Pose {
        let forward = (target - eye).normalize();
        let up = if forward.cross(DVec3::Z).length() > 1e-9 { DVec3::Z } else { DVec3::Y };
        let level = forward.cross(up).normalize();
        let (sin, cos) = (libm::sin(roll_rad), libm::cos(roll_rad));
        let right = level * cos + forward.cross(level) * sin;
        let rotation = DMat3::from_cols(right, forward.cross(right), forward).transpose();
        Pose { rotation, translation: -(rotation * eye) }
    }

    /// A point of the first frame in the second, mm.
    pub fn apply(&self, point: DVec3) -> DVec3 {
        self.rotation * point + self.translation
    }

    /// Origin of the second frame in the first, mm: the camera's place on the object.
    pub fn centre(&self) -> DVec3 {
        -(self.rotation.transpose() * self.translation)
    }

    /// Angle between two poses' rotations, rad.
    pub fn angle_to(&self, other: &Pose) -> f64 {
        let turn = self.rotation * other.rotation.transpose();
        let axis = DVec3::new(
            turn.y_axis.z - turn.z_axis.y,
            turn.z_axis.x - turn.x_axis.z,
            turn.x_axis.y - turn.y_axis.x,
        );
        let trace = turn.x_axis.x + turn.y_axis.y + turn.z_axis.z;
        libm::atan2(axis.length(), trace - 1.0)
    }
}

/// Rotation by the length of `vector`, rad, about its direction (Rodrigues).
pub fn rotation_by(vector: DVec3) -> DMat3 {
    let angle = vector.length();
    let cross = DMat3::from_cols(
        DVec3::new(0.0, vector.z, -vector.y),
        DVec3::new(-vector.z, 0.0, vector.x),
        DVec3::new(vector.y, -vector.x, 0.0),
    );
    let (first, second) = if angle < 1e-8 {
        (1.0, 0.5)
    } else {
        (libm::sin(angle) / angle, (1.0 - libm::cos(angle)) / (angle * angle))
    };
    DMat3::IDENTITY + cross * first + cross * cross * second
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    #[test]
    fn a_camera_looks_where_it_is_told() {
        let check = |eye: DVec3, target: DVec3, roll: f64, up: DVec3, image_of_up: DVec3| {
            let pose = Pose::looking(eye, target, roll);
            assert!((pose.centre() - eye).length() < 1e-9);
            assert!((pose.rotation.determinant() - 1.0).abs() < 1e-12);
            assert!((pose.apply(target) - DVec3::Z * eye.distance(target)).length() < 1e-9);
            assert!((pose.rotation * up - image_of_up).length() < 1e-9, "{eye} {roll}");
        };
        check(DVec3::X * 900.0, DVec3::ZERO, 0.0, DVec3::Z, DVec3::NEG_Y);
        check(DVec3::X * 900.0, DVec3::ZERO, FRAC_PI_2, DVec3::Z, DVec3::NEG_X);
        check(DVec3::Z * 900.0, DVec3::ZERO, 0.0, DVec3::Y, DVec3::NEG_Y);
        check(DVec3::new(3.0, 4.0, 5.0), DVec3::ONE, PI, DVec3::ZERO, DVec3::ZERO);
    }

    #[test]
    fn angles_are_those_of_the_turn() {
        let check = |turn: DVec3| {
            let start = Pose::looking(DVec3::new(30.0, -400.0, 50.0), DVec3::ZERO, 0.3);
            let turned = Pose { rotation: rotation_by(turn) * start.rotation, ..start };
            assert!((turned.angle_to(&start) - turn.length()).abs() < 1e-12, "{turn}");
        };
        check(DVec3::ZERO);
        check(DVec3::new(1e-9, 0.0, 0.0));
        check(DVec3::new(0.1, -0.2, 0.3));
        check(DVec3::new(0.0, 3.1, 0.0));
    }
}
