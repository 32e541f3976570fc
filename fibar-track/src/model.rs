//! What the tracker knows of an object: its markers, and which of them a pose could show.

use crate::camera::Camera;
use crate::pose::Pose;
use fibar_core::artefact::constellation::{Constellation, Marker};
use fibar_core::id::PatternId;
use glam::{DVec2, DVec3};

/// A blob in the image whose pattern has been decoded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blob {
    /// Its centre, px.
    pub at: DVec2,
    /// What it blinks.
    pub pattern: PatternId,
}

/// The markers of an object, by index in their constellation and by pattern.
#[derive(Clone, Debug)]
pub struct Model {
    markers: Vec<Marker>,
    by_pattern: Vec<(PatternId, Vec<usize>)>,
    near: Vec<Vec<usize>>,
    emission: Emission,
}

/// Cosines of the angles from the normal within which a marker surely shows, and beyond which it surely does not.
#[derive(Clone, Copy, Debug)]
struct Emission {
    cos_sure: f64,
    cos_possible: f64,
}

/// How far a marker may be off its limit of emission before that counts, rad: poses are a little off, normals too.
const EMISSION_SLACK: f64 = 0.14;
/// How many neighbours of a marker are taken to be near it: about two rings.
const NEAR: usize = 20;

impl Model {
    /// The constellation's markers, which light up to `emission_rad` from their normals.
    pub fn new(constellation: &Constellation, emission_rad: f64) -> Model {
        let markers = constellation.markers.clone();
        let blinking = |p: PatternId| (0..markers.len()).filter(|&k| markers[k].pattern == p).collect();
        let by_pattern = constellation.patterns.iter().map(|p| (p.id, blinking(p.id))).collect();
        let limit = |angle: f64| libm::cos(angle.clamp(0.0, std::f64::consts::FRAC_PI_2));
        let emission = Emission {
            cos_sure: limit(emission_rad - EMISSION_SLACK),
            cos_possible: limit(emission_rad + EMISSION_SLACK),
        };
        Model { by_pattern, emission, near: find_near(&markers), markers }
    }

    /// The markers.
    pub fn markers(&self) -> &[Marker] {
        &self.markers
    }

    /// How many patterns there are.
    pub fn patterns(&self) -> usize {
        self.by_pattern.len()
    }

    /// Indices of the markers of a pattern, rising.
    pub fn of_pattern(&self, pattern: PatternId) -> &[usize] {
        let found = self.by_pattern.iter().find(|(p, _)| *p == pattern);
        found.map_or(&[], |(_, markers)| markers)
    }

    /// The markers nearest to a marker among those that can be seen along with it, the nearest first.
    pub fn near(&self, marker: usize) -> &[usize] {
        &self.near[marker]
    }

    /// Where a marker would be seen, px, if the object hid none of it; `None` when it faces away or lies outside.
    pub fn project(&self, camera: &Camera, pose: &Pose, marker: usize) -> Option<DVec2> {
        let z = pose.apply(self.markers[marker].position);
        let lit = z.z > 0.0 && self.emits(pose, marker, z, self.emission.cos_possible);
        lit.then(|| camera.project(z)).filter(|pixel| camera.sees(*pixel))
    }

    /// Whether a marker is turned to the camera well within its limit of emission and lies in the image.
    pub fn surely_lit(&self, camera: &Camera, pose: &Pose, marker: usize) -> bool {
        let z = pose.apply(self.markers[marker].position);
        z.z > 0.0 && self.emits(pose, marker, z, self.emission.cos_sure) && camera.sees(camera.project(z))
    }

    /// Whether light leaves a marker, at `z` in the camera's frame, towards the camera.
    fn emits(&self, pose: &Pose, marker: usize, z: DVec3, cos_limit: f64) -> bool {
        let toward_camera = -(pose.rotation * self.markers[marker].normal).dot(z);
        toward_camera > 0.0 && toward_camera * toward_camera > cos_limit * cos_limit * z.length_squared()
    }

    /// Names blobs by a pose: of all pairs of one pattern within `gate_px` the nearest first, each blob and marker once.
    pub fn name(&self, camera: &Camera, pose: &Pose, blobs: &[Blob], gate_px: f64) -> Vec<Option<usize>> {
        let mut names = vec![None; blobs.len()];
        self.pair_up(camera, pose, blobs, gate_px, &mut names, |blob, marker| blob.pattern == marker.pattern);
        names
    }

    /// Names what [`name`](Self::name) left over by place alone: blobs whose bits were misread (Tone 2020, "Pose estimation of
    /// projection object from markers": names are corrected by the pose).
    pub fn name_misread(
        &self,
        camera: &Camera,
        pose: &Pose,
        blobs: &[Blob],
        gate_px: f64,
        names: &mut [Option<usize>],
    ) {
        self.pair_up(camera, pose, blobs, gate_px, names, |_, _| true);
    }

    fn pair_up(
        &self,
        camera: &Camera,
        pose: &Pose,
        blobs: &[Blob],
        gate_px: f64,
        names: &mut [Option<usize>],
        may_be: impl Fn(&Blob, &Marker) -> bool,
    ) {
        let mut pairs = Vec::new();
        for (marker, known) in self.markers.iter().enumerate().filter(|(k, _)| !names.contains(&Some(*k))) {
            let Some(place) = self.project(camera, pose, marker) else { continue };
            for (blob, seen) in blobs.iter().enumerate().filter(|(k, _)| names[*k].is_none()) {
                let distance = place.distance_squared(seen.at);
                if distance <= gate_px * gate_px && may_be(seen, known) {
                    pairs.push((distance, blob, marker));
                }
            }
        }
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        for (_, blob, marker) in pairs {
            if names[blob].is_none() && !names.contains(&Some(marker)) {
                names[blob] = Some(marker);
            }
        }
    }
}

fn find_near(markers: &[Marker]) -> Vec<Vec<usize>> {
    let near = |k: usize| {
        let apart = |&other: &usize| markers[other].position.distance_squared(markers[k].position);
        let meets = |other: &usize| *other != k && markers[*other].normal.dot(markers[k].normal) > 0.0;
        let mut others: Vec<usize> = (0..markers.len()).filter(meets).collect();
        others.sort_by(|a, b| apart(a).total_cmp(&apart(b)).then(a.cmp(b)));
        others.truncate(NEAR);
        others
    };
    (0..markers.len()).map(near).collect()
}
