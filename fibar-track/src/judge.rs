//! How well a pose explains an image of decoded blobs.

use crate::camera::Camera;
use crate::model::{Blob, Model};
use crate::pose::Pose;
use glam::DVec2;

/// Log likelihood that a blob within the gate gains over one that came from nowhere, and that a marker which should be seen and
/// is not costs: with half of all facing markers hidden or missing, as measured on real views.
const GAIN: f64 = 6.0;
const LOSS: f64 = 0.6;

/// An image and the object that may be in it.
pub struct Judge<'a> {
    pub model: &'a Model,
    pub camera: &'a Camera,
    pub blobs: &'a [Blob],
    /// Area that the blobs spread over, px².
    area_px2: f64,
}

/// What speaks for a pose.
#[derive(Clone, Copy, Debug)]
pub struct Judgement {
    /// Blobs within the gate of a marker of their pattern.
    pub explained: usize,
    /// Markers that could be seen.
    pub possible: usize,
    /// Log likelihood, up to a constant of the image.
    pub merit: f64,
}

impl<'a> Judge<'a> {
    /// A judge of one image.
    pub fn new(model: &'a Model, camera: &'a Camera, blobs: &'a [Blob]) -> Judge<'a> {
        let (lo, hi) = blobs
            .iter()
            .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(lo, hi), b| (lo.min(b.at), hi.max(b.at)));
        let size = (hi - lo).max(DVec2::splat(40.0));
        Judge { model, camera, blobs, area_px2: size.x * size.y }
    }

    /// Whether at least `wanted` blobs lie within the gate; says no as soon as too few are left.
    pub fn explains(&self, pose: &Pose, gate_px: f64, wanted: usize) -> bool {
        let (mut found, mut missed) = (0, 0);
        for blob in self.blobs {
            match self.offset_px2(pose, blob) <= gate_px * gate_px {
                true => found += 1,
                false => missed += 1,
            }
            if found >= wanted {
                return true;
            }
            if missed + wanted > self.blobs.len() {
                return false;
            }
        }
        false
    }

    /// The full judgement.
    pub fn judge(&self, pose: &Pose, gate_px: f64) -> Judgement {
        let names = self.model.name(self.camera, pose, self.blobs, gate_px);
        let mut judgement = Judgement { explained: 0, possible: 0, merit: 0.0 };
        for (blob, name) in self.blobs.iter().zip(&names) {
            let place = name.and_then(|marker| self.model.project(self.camera, pose, marker));
            if let Some(place) = place {
                judgement.explained += 1;
                judgement.merit += GAIN - 2.0 * place.distance_squared(blob.at) / (gate_px * gate_px);
            }
        }
        for marker in (0..self.model.markers().len()).filter(|k| !names.contains(&Some(*k))) {
            judgement.possible += usize::from(self.model.project(self.camera, pose, marker).is_some());
            judgement.merit -= if self.model.surely_lit(self.camera, pose, marker) { LOSS } else { 0.0 };
        }
        judgement.possible += judgement.explained;
        judgement
    }

    /// Expected number of poses, among `tried`, that explain as many blobs beyond their own three by chance.
    pub fn false_alarms(&self, judgement: &Judgement, tried: usize, gate_px: f64) -> f64 {
        let per_pattern = judgement.possible as f64 / self.model.patterns().max(1) as f64;
        let chance = (per_pattern * std::f64::consts::PI * gate_px * gate_px / self.area_px2).min(1.0);
        let others = self.blobs.len().saturating_sub(3);
        let agreeing = judgement.explained.saturating_sub(3);
        let ways = (0..agreeing).fold(1.0, |ways, k| ways * (others - k) as f64 / (k + 1) as f64);
        tried as f64 * ways * libm::pow(chance, agreeing as f64)
    }

    /// Squared distance to the nearest marker of the blob's pattern, px².
    fn offset_px2(&self, pose: &Pose, blob: &Blob) -> f64 {
        let places = self
            .model
            .of_pattern(blob.pattern)
            .iter()
            .filter_map(|&k| self.model.project(self.camera, pose, k));
        places.map(|place| place.distance_squared(blob.at)).fold(f64::INFINITY, f64::min)
    }
}
