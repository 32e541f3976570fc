//! What the tracker knows of an object: its markers, and which of them a pose could show.

use crate::camera::Camera;
use crate::pose::Pose;
use fibar_core::artefact::constellation::{Constellation, Marker};
use fibar_core::id::PatternId;
use glam::DVec2;

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
    cos_emission: f64,
}

impl Model {
    /// The constellation's markers, which light up to `emission_rad` from their normals.
    pub fn new(constellation: &Constellation, emission_rad: f64) -> Model {
        let markers = constellation.markers.clone();
        let blinking = |p: PatternId| (0..markers.len()).filter(|&k| markers[k].pattern == p).collect();
        let by_pattern = constellation.patterns.iter().map(|p| (p.id, blinking(p.id))).collect();
        Model { by_pattern, cos_emission: libm::cos(emission_rad), markers }
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

    /// Where a marker would be seen, px, if the object hid none of it; `None` when it faces away or lies outside.
    pub fn project(&self, camera: &Camera, pose: &Pose, marker: usize) -> Option<DVec2> {
        let Marker { position, normal, .. } = &self.markers[marker];
        let z = pose.apply(*position);
        let toward_camera = -(pose.rotation * *normal).dot(z);
        let faces = z.z > 0.0 && toward_camera > 0.0;
        let lit = faces
            && toward_camera * toward_camera > self.cos_emission * self.cos_emission * z.length_squared();
        lit.then(|| camera.project(z)).filter(|pixel| camera.sees(*pixel))
    }

    /// Names blobs by a pose: of all pairs of one pattern within `gate_px` the nearest first, each blob and marker once.
    pub fn name(&self, camera: &Camera, pose: &Pose, blobs: &[Blob], gate_px: f64) -> Vec<Option<usize>> {
        let places: Vec<Option<DVec2>> =
            (0..self.markers.len()).map(|k| self.project(camera, pose, k)).collect();
        let mut pairs = Vec::new();
        for (blob, seen) in blobs.iter().enumerate() {
            for &marker in self.of_pattern(seen.pattern) {
                let distance = places[marker].map_or(f64::INFINITY, |p| p.distance_squared(seen.at));
                if distance <= gate_px * gate_px {
                    pairs.push((distance, blob, marker));
                }
            }
        }
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        let mut names = vec![None; blobs.len()];
        let mut taken = vec![false; self.markers.len()];
        for (_, blob, marker) in pairs {
            if names[blob].is_none() && !taken[marker] {
                (names[blob], taken[marker]) = (Some(marker), true);
            }
        }
        names
    }
}
