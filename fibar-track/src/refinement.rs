//! The pose that fits its points best, and how sure it is: Levenberg–Marquardt on the reprojection error (Hartley & Zisserman,
//! "Multiple View Geometry", 2nd ed., A6.2), covariance by linear propagation (5.2 there).
//!
//! Notation: `c` the pivot, the mean of the points; `x` a point, `z = R (x − c) + s` the same in the camera's frame; unknowns are a
//! turn `ω` and a shift `δ` of the camera's frame, `z ↦ exp(ω) R (x − c) + s + δ`. A pivot amid the points keeps turn and
//! shift apart.

use crate::camera::Camera;
use crate::matrix6::{Cholesky, Matrix6};
use crate::pose::{Pose, rotation_by};
use glam::{DVec2, DVec3};

/// A point of the object and where the camera saw it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Correspondence {
    /// On the object, mm.
    pub point: DVec3,
    /// In the image, px.
    pub pixel: DVec2,
}

/// A pose at a minimum of the reprojection error.
#[derive(Clone, Copy, Debug)]
pub struct Fit {
    /// Camera from object.
    pub pose: Pose,
    /// Sum of squared reprojection errors, px².
    pub error_px2: f64,
    /// How sure the pose is.
    pub uncertainty: Uncertainty,
}

/// Covariance of a pose for blobs that are off by 1 px in each direction (standard deviation); multiply by your camera's.
#[derive(Clone, Copy, Debug)]
pub struct Uncertainty {
    /// Of turn (rad, camera's frame, first three) and shift (mm, last three), per px².
    pub covariance: Matrix6,
    /// Unit vector from the camera to the pivot.
    pub sight: DVec3,
}

impl Uncertainty {
    /// Standard deviation of the object's distance, mm per px.
    pub fn along_sight_mm(&self) -> f64 {
        let variance = |i: usize, j: usize| self.covariance[3 + i][3 + j] * self.sight[i] * self.sight[j];
        (0..9).map(|k| variance(k / 3, k % 3)).sum::<f64>().max(0.0).sqrt()
    }

    /// Standard deviation of its place across the sight, mm per px and direction.
    pub fn across_sight_mm(&self) -> f64 {
        let all: f64 = (3..6).map(|k| self.covariance[k][k]).sum();
        let along = self.along_sight_mm();
        ((all - along * along) / 2.0).max(0.0).sqrt()
    }

    /// Standard deviation of the angle by which the orientation is off, rad per px.
    pub fn turn_rad(&self) -> f64 {
        (0..3).map(|k| self.covariance[k][k]).sum::<f64>().sqrt()
    }
}

/// Walks from `start` to the nearest minimum in at most `steps` steps. `None` when points lie behind the camera or do not fix a
/// pose.
pub fn refine(camera: &Camera, start: &Pose, seen: &[Correspondence], steps: usize) -> Option<Fit> {
    let pivot = seen.iter().map(|s| s.point).sum::<DVec3>() / seen.len().max(1) as f64;
    let mut at = Pose { translation: start.apply(pivot), ..*start };
    let mut equations = Equations::at(camera, &at, pivot, seen)?;
    let mut damping = 1e-4;
    for _ in 0..steps {
        let Some((turn, shift)) = equations.step(damping) else { break };
        let next = Pose { rotation: rotation_by(turn) * at.rotation, translation: at.translation + shift };
        match Equations::at(camera, &next, pivot, seen).filter(|e| e.error_px2 <= equations.error_px2) {
            Some(better) => {
                let settled = equations.error_px2 - better.error_px2 <= 1e-10 * equations.error_px2;
                (at, equations, damping) = (next, better, damping * 0.1);
                if settled {
                    break;
                }
            }
            None => damping *= 20.0,
        }
    }
    let covariance = Cholesky::of(&equations.normal)?.inverse();
    let pose = Pose { rotation: orthonormal(at.rotation), translation: at.translation };
    let pose = Pose { translation: pose.translation - pose.rotation * pivot, ..pose };
    let uncertainty = Uncertainty { covariance, sight: at.translation.normalize() };
    Some(Fit { pose, error_px2: equations.error_px2, uncertainty })
}

/// `JᵀJ`, `Jᵀr` and `rᵀr` of the reprojection errors.
struct Equations {
    normal: Matrix6,
    gradient: [f64; 6],
    error_px2: f64,
}

impl Equations {
    fn at(camera: &Camera, pose: &Pose, pivot: DVec3, seen: &[Correspondence]) -> Option<Equations> {
        let mut equations = Equations { normal: [[0.0; 6]; 6], gradient: [0.0; 6], error_px2: 0.0 };
        for Correspondence { point, pixel } in seen {
            let arm = pose.rotation * (*point - pivot);
            let z = arm + pose.translation;
            if z.z.is_nan() || z.z <= 1e-6 {
                return None;
            }
            let off = camera.project(z) - *pixel;
            let scale = camera.focal_px / z.z;
            equations.add(arm, DVec3::new(scale, 0.0, -scale * z.x / z.z), off.x);
            equations.add(arm, DVec3::new(0.0, scale, -scale * z.y / z.z), off.y);
        }
        Some(equations)
    }

    /// Adds one error whose derivative by `z` is `slope`; by `ω` it is `arm × slope`.
    fn add(&mut self, arm: DVec3, slope: DVec3, off: f64) {
        let turn = arm.cross(slope);
        let row = [turn.x, turn.y, turn.z, slope.x, slope.y, slope.z];
        for i in 0..6 {
            for j in 0..=i {
                self.normal[i][j] += row[i] * row[j];
            }
            self.gradient[i] += row[i] * off;
        }
        self.error_px2 += off * off;
    }

    fn step(&self, damping: f64) -> Option<(DVec3, DVec3)> {
        let mut damped = self.normal;
        (0..6).for_each(|k| damped[k][k] *= 1.0 + damping);
        let step = Cholesky::of(&damped)?.solve(self.gradient);
        Some((-DVec3::new(step[0], step[1], step[2]), -DVec3::new(step[3], step[4], step[5])))
    }
}

/// The rotation near a product of rotations: its axes made unit and square again.
fn orthonormal(matrix: glam::DMat3) -> glam::DMat3 {
    let x = matrix.x_axis.normalize();
    let z = x.cross(matrix.y_axis).normalize();
    glam::DMat3::from_cols(x, z.cross(x), z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::{Random, disturbed, random_pose};

    const CAMERA: Camera =
        Camera { focal_px: 1100.0, centre_px: DVec2::new(360.0, 270.0), size_px: DVec2::new(720.0, 540.0) };

    fn see(pose: &Pose, points: &[DVec3], random: &mut Random, noise_px: f64) -> Vec<Correspondence> {
        let pixel = |p: DVec3, random: &mut Random| CAMERA.project(pose.apply(p)) + random.noise(noise_px);
        points.iter().map(|&point| Correspondence { point, pixel: pixel(point, random) }).collect()
    }

    #[test]
    fn clean_points_give_the_pose_back() {
        let mut random = Random::new(6);
        for _ in 0..500 {
            let points: Vec<DVec3> = (0..8).map(|_| random.in_ball(70.0)).collect();
            let pose = random_pose(&mut random, 400.0..1500.0);
            let seen = see(&pose, &points, &mut random, 0.0);
            let fit = refine(&CAMERA, &disturbed(&pose, &mut random, 0.05, 10.0), &seen, 30).unwrap();
            assert!(fit.pose.angle_to(&pose) < 1e-6 && fit.error_px2 < 1e-9, "{fit:?}");
            assert!((fit.pose.rotation.determinant() - 1.0).abs() < 1e-12);
        }
    }

    /// Over many noisy views the squared errors, in units of their predicted variance, average to 1.
    #[test]
    fn errors_are_as_large_as_predicted() {
        let mut random = Random::new(7);
        let points: Vec<DVec3> = (0..12).map(|_| random.in_ball(70.0)).collect();
        let pose = random_pose(&mut random, 700.0..800.0);
        let pivot = points.iter().sum::<DVec3>() / points.len() as f64;
        let (noise_px, runs) = (0.3, 4000);
        let [mut turn, mut along, mut across] = [0.0; 3];
        for _ in 0..runs {
            let fit = refine(&CAMERA, &pose, &see(&pose, &points, &mut random, noise_px), 20).unwrap();
            let off = fit.pose.apply(pivot) - pose.apply(pivot);
            let depth = off.dot(fit.uncertainty.sight);
            let unit = |error: f64, deviation: f64| (error / (deviation * noise_px)).powi(2) / runs as f64;
            turn += unit(fit.pose.angle_to(&pose), fit.uncertainty.turn_rad());
            along += unit(depth, fit.uncertainty.along_sight_mm());
            across +=
                unit((off - fit.uncertainty.sight * depth).length(), fit.uncertainty.across_sight_mm()) / 2.0;
        }
        for ratio in [turn, along, across] {
            assert!((ratio - 1.0).abs() < 0.08, "turn {turn}, along {along}, across {across}");
        }
    }

    #[test]
    fn what_fixes_no_pose_has_none() {
        let pose = Pose::looking(DVec3::X * 500.0, DVec3::ZERO, 0.0);
        let check = |points: &[DVec3]| {
            let seen = see(&pose, points, &mut Random::new(8), 0.0);
            assert!(refine(&CAMERA, &pose, &seen, 10).is_none(), "{points:?}");
        };
        check(&[]);
        check(&[DVec3::Z, DVec3::Y]);
        check(&[DVec3::Z, DVec3::Z * 2.0, DVec3::Z * 3.0, DVec3::Z * 4.0]);
        check(&[DVec3::ZERO, DVec3::Y, DVec3::Z, DVec3::X * 600.0]);
    }
}
