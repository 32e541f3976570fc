//! The mirror twin of a pose: the other orientation that points near a plane allow from afar.
//!
//! From far away a camera sees little of depth: a flat object tilted towards it looks nearly like the same object tilted away, and
//! the reprojection error has a second minimum there (Schweighofer & Pinz, PAMI 2006, "Robust Pose Estimation from a Planar
//! Target"; Collins & Bartoli, IJCV 2014). A solver that starts in the wrong valley stays in it.

use crate::camera::Camera;
use crate::pose::Pose;
use crate::refinement::{Correspondence, Fit, refine};
use glam::{DMat3, DVec3};

/// Where the second minimum would be: `(1 − 2 v vᵀ) R (1 − 2 n nᵀ)`, `v` the sight to the points' mean, `n` the normal of the
/// plane nearest to them. The mean stays where it is.
pub fn twin(pose: &Pose, seen: &[Correspondence]) -> Pose {
    let mean = seen.iter().map(|s| s.point).sum::<DVec3>() / seen.len().max(1) as f64;
    let (centre, normal) = (pose.apply(mean), flattest_direction(seen, mean));
    let rotation = mirror(centre.normalize()) * pose.rotation * mirror(normal);
    Pose { rotation, translation: centre - rotation * mean }
}

/// The better of a fit and its twin, and how many times the square error of the better one the other has.
pub fn better_of_twins(camera: &Camera, fit: Fit, seen: &[Correspondence], steps: usize) -> (Fit, f64) {
    let Some(other) = refine(camera, &twin(&fit.pose, seen), seen, steps) else {
        return (fit, f64::INFINITY);
    };
    let same = other.pose.angle_to(&fit.pose) < 0.02;
    let (better, worse) = if other.error_px2 < fit.error_px2 { (other, fit) } else { (fit, other) };
    (better, if same { f64::INFINITY } else { worse.error_px2 / better.error_px2.max(1e-12) })
}

fn mirror(unit: DVec3) -> DMat3 {
    DMat3::IDENTITY - DMat3::from_cols(unit * unit.x, unit * unit.y, unit * unit.z) * 2.0
}

/// Direction in which the points spread least, by inverse iteration on their scatter.
fn flattest_direction(seen: &[Correspondence], mean: DVec3) -> DVec3 {
    let mut scatter = DMat3::ZERO;
    for arm in seen.iter().map(|s| s.point - mean) {
        scatter += DMat3::from_cols(arm * arm.x, arm * arm.y, arm * arm.z);
    }
    let size = scatter.x_axis.x + scatter.y_axis.y + scatter.z_axis.z;
    let inverse = (scatter + DMat3::from_diagonal(DVec3::splat(1e-9 * size + f64::MIN_POSITIVE))).inverse();
    let start = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| inverse * axis);
    let longest = start.into_iter().max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
    let mut direction = longest.unwrap_or(DVec3::Z).normalize_or(DVec3::Z);
    for _ in 0..8 {
        direction = (inverse * direction).normalize_or(DVec3::Z);
    }
    direction
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::{Random, random_pose};

    const CAMERA: Camera = Camera {
        focal_px: 1100.0,
        centre_px: glam::DVec2::new(360.0, 270.0),
        size_px: glam::DVec2::new(720.0, 540.0),
    };

    fn see(pose: &Pose, points: &[DVec3], random: &mut Random, noise_px: f64) -> Vec<Correspondence> {
        let pixel = |p: DVec3, random: &mut Random| CAMERA.project(pose.apply(p)) + random.noise(noise_px);
        points.iter().map(|&point| Correspondence { point, pixel: pixel(point, random) }).collect()
    }

    #[test]
    fn a_flat_object_keeps_its_outline_in_the_twin() {
        let mut random = Random::new(2);
        for _ in 0..200 {
            let points: Vec<DVec3> =
                (0..8).map(|_| random.in_ball(50.0) * DVec3::new(1.0, 1.0, 0.0)).collect();
            let pose = random_pose(&mut random, 3000.0..5000.0);
            let other = twin(&pose, &see(&pose, &points, &mut random, 0.0));
            assert!((other.rotation.determinant() - 1.0).abs() < 1e-9);
            for point in points {
                let off = CAMERA.project(other.apply(point)).distance(CAMERA.project(pose.apply(point)));
                assert!(off < 1.0, "{off} px from 3 m and more");
            }
        }
    }

    #[test]
    fn the_right_valley_is_found_from_the_wrong_one() {
        let mut random = Random::new(3);
        for _ in 0..300 {
            let points: Vec<DVec3> =
                (0..10).map(|_| random.in_ball(60.0) * DVec3::new(1.0, 1.0, 0.3)).collect();
            let pose = random_pose(&mut random, 400.0..900.0);
            let seen = see(&pose, &points, &mut random, 0.1);
            let start = twin(&pose, &seen);
            let Some(fit) = refine(&CAMERA, &start, &seen, 30) else { continue };
            let (best, _) = better_of_twins(&CAMERA, fit, &seen, 30);
            assert!(best.pose.angle_to(&pose) < 0.03, "off by {} rad", best.pose.angle_to(&pose));
        }
    }
}
