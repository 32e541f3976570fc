//! What a camera sees of the object's markers.

use crate::occlusion::Occluder;
use crate::params::Params;
use crate::views::{Chance, Viewpoint};
use fibar_core::artefact::constellation::Constellation;
use fibar_core::id::PatternId;
use fibar_track::camera::Camera;
use fibar_track::model::Blob;
use fibar_track::pose::Pose;
use glam::{DMat3, DVec2, DVec3};

/// The body with its markers.
pub struct Scene<'a> {
    /// The markers and their codes.
    pub constellation: &'a Constellation,
    /// The body.
    pub occluder: &'a Occluder,
    /// Middle of the body's bounding box, mm.
    pub middle: DVec3,
}

/// A marker that shows in a view, and the luck it has there.
#[derive(Clone, Copy, Debug)]
pub struct Sighting {
    /// Index of the marker.
    pub marker: usize,
    /// How far off its blob is, in standard deviations.
    pub noise: DVec2,
    /// Missing when less than the share that is missing.
    pub luck: f64,
    /// What its bits are read as.
    pub pattern: PatternId,
}

impl Scene<'_> {
    /// The markers that a viewpoint sees: turned towards it, within the limit of emission, in the image both as the camera is held
    /// and upright, nothing in between.
    pub fn look(&self, viewpoint: &Viewpoint, params: &Params, chance: &mut Chance) -> Vec<Sighting> {
        let (camera, poses) = (params.camera(), [viewpoint.pose(), viewpoint.upright_pose()]);
        let cos_limit = libm::cos(params.emission_rad());
        let shows = |marker: usize| {
            let m = &self.constellation.markers[marker];
            let arm = viewpoint.eye - m.position;
            arm.dot(m.normal) > cos_limit * arm.length()
                && poses.iter().all(|pose| in_image(&camera, pose, m.position))
                && self.occluder.is_clear(m.position + m.normal * params.lift_mm, viewpoint.eye)
        };
        let sighting = |marker| Sighting {
            marker,
            noise: chance.normal_pair(),
            luck: chance.within(0.0, 1.0),
            pattern: self.read(marker, params.misread_share, chance),
        };
        (0..self.constellation.markers.len()).filter(|&k| shows(k)).map(sighting).collect()
    }

    /// A marker's pattern, or with a chance of `misread_share` any other one.
    fn read(&self, marker: usize, misread_share: f64, chance: &mut Chance) -> PatternId {
        let pattern = self.constellation.markers[marker].pattern;
        let others = self.constellation.patterns.iter().map(|p| p.id).filter(|p| *p != pattern);
        let misread = chance.within(0.0, 1.0) < misread_share;
        let pick = chance.within(0.0, others.clone().count() as f64) as usize;
        others.clone().nth(pick).filter(|_| misread).unwrap_or(pattern)
    }

    /// The image of the sightings that are not missing.
    pub fn blobs(&self, camera: &Camera, pose: &Pose, sightings: &[Sighting], noise_px: f64) -> Vec<Blob> {
        let blob = |s: &Sighting| {
            let place = self.constellation.markers[s.marker].position;
            Blob { at: camera.project(pose.apply(place)) + s.noise * noise_px, pattern: s.pattern }
        };
        sightings.iter().map(blob).collect()
    }

    /// How many of the sightings blink the m-sequence.
    pub fn m_sequences(&self, sightings: &[Sighting]) -> usize {
        let blinks = |s: &&Sighting| self.constellation.markers[s.marker].pattern == PatternId::M_SEQUENCE;
        sightings.iter().filter(blinks).count()
    }

    /// Root mean square distance of the seen markers from the plane nearest to them, mm.
    pub fn thickness_mm(&self, sightings: &[Sighting]) -> f64 {
        let points = sightings.iter().map(|s| self.constellation.markers[s.marker].position);
        let mean = points.clone().sum::<DVec3>() / sightings.len().max(1) as f64;
        let scatter = points
            .map(|p| p - mean)
            .fold(DMat3::ZERO, |sum, arm| sum + DMat3::from_cols(arm * arm.x, arm * arm.y, arm * arm.z));
        (least_eigenvalue(&scatter).max(0.0) / sightings.len().max(1) as f64).sqrt()
    }
}

fn in_image(camera: &Camera, pose: &Pose, point: DVec3) -> bool {
    let z = pose.apply(point);
    z.z > 0.0 && camera.sees(camera.project(z))
}

/// The least eigenvalue of a symmetric matrix (Smith, CACM 1961: the cubic by cosines).
fn least_eigenvalue(m: &DMat3) -> f64 {
    let mean = (m.x_axis.x + m.y_axis.y + m.z_axis.z) / 3.0;
    let rest = *m - DMat3::from_diagonal(DVec3::splat(mean));
    let size = rest.x_axis.length_squared() + rest.y_axis.length_squared() + rest.z_axis.length_squared();
    let radius = (size / 6.0).sqrt();
    if radius <= 1e-12 * mean.abs() {
        return mean;
    }
    let half = (rest * (1.0 / radius)).determinant() / 2.0;
    mean + 2.0 * radius * libm::cos((libm::acos(half.clamp(-1.0, 1.0)) + std::f64::consts::TAU) / 3.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eigenvalues_are_those_of_known_matrices() {
        let check = |diagonal: [f64; 3], expected: f64| {
            let turn = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7);
            let matrix = turn * DMat3::from_diagonal(diagonal.into()) * turn.transpose();
            assert!((least_eigenvalue(&matrix) - expected).abs() < 1e-9, "{diagonal:?}");
        };
        check([1.0, 2.0, 3.0], 1.0);
        check([5.0, 5.0, 0.0], 0.0);
        check([4.0, 4.0, 4.0], 4.0);
        check([0.0, 0.0, 7.0], 0.0);
    }
}
