//! Places without markers: too low for a fibre to turn up to, in a named box, too thin, or too narrow for a fibre's end.

use crate::params::Params;
use fibar_core::artefact::sockets::Sockets;
use fibar_geometry::rays::RayScene;
use fibar_geometry::sampling::SurfaceSample;
use fibar_plugin::StageError;
use glam::DVec3;
use rayon::prelude::*;

/// Directions around a fibre's end that are tried for room.
const FEELERS: usize = 12;

/// What makes a place impossible.
pub struct KeepOut<'a> {
    scene: &'a RayScene,
    params: &'a Params,
    floor: f64,
}

/// Why a place is impossible.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Refusal {
    /// Lower than `rise_mm` above the highest LED tip; the base itself, too.
    Low,
    /// In a box of `keep_out`.
    Boxed,
    /// The opposite side is nearer than `thickness_mm`.
    Thin,
    /// A fibre's end piece would touch the skin sideways.
    Narrow,
}

impl<'a> KeepOut<'a> {
    /// The rules of `params` for a body and its LEDs.
    pub fn new(scene: &'a RayScene, sockets: &Sockets, params: &'a Params) -> KeepOut<'a> {
        let tip = sockets.sockets.iter().map(|s| s.position.z).fold(0.0, f64::max);
        KeepOut { scene, params, floor: tip + params.rise_mm }
    }

    /// Indices of the samples where a marker may sit; an error that counts the reasons if there is none.
    pub fn open_samples(&self, samples: &[SurfaceSample]) -> Result<Vec<usize>, StageError> {
        let refusals: Vec<Option<Refusal>> = samples.par_iter().map(|s| self.refusal(s)).collect();
        let open: Vec<usize> = (0..samples.len()).filter(|&k| refusals[k].is_none()).collect();
        if open.is_empty() { Err(self.nowhere(&refusals)) } else { Ok(open) }
    }

    /// Why no marker may sit at a sample; `None` if one may.
    pub fn refusal(&self, sample: &SurfaceSample) -> Option<Refusal> {
        let SurfaceSample { position, normal, .. } = *sample;
        if position.z < self.floor {
            Some(Refusal::Low)
        } else if self.params.keep_out.iter().any(|region| region.contains(position)) {
            Some(Refusal::Boxed)
        } else if self.thickness(sample) < self.params.thickness_mm {
            Some(Refusal::Thin)
        } else if !self.has_room_for_end(position, normal) {
            Some(Refusal::Narrow)
        } else {
            None
        }
    }

    /// Depth of the body under a sample along the inward normal, mm, measured no further than needed.
    fn thickness(&self, sample: &SurfaceSample) -> f64 {
        let lift = self.params.lift_mm;
        let start = sample.position - sample.face_normal * lift;
        lift + self.scene.reach(start, -sample.normal, self.params.thickness_mm)
    }

    /// Whether the inner end of the straight end piece is far enough from the skin on all sides.
    fn has_room_for_end(&self, position: DVec3, normal: DVec3) -> bool {
        let inner = position - normal * (self.params.skin_mm + self.params.end_mm);
        let needed = self.params.fibre_diameter_mm / 2.0 + self.params.skin_mm;
        let (one, other) = normal.any_orthonormal_pair();
        (0..FEELERS).all(|k| {
            let angle = k as f64 * std::f64::consts::TAU / FEELERS as f64;
            let feeler = one * libm::cos(angle) + other * libm::sin(angle);
            self.scene.reach(inner, feeler, needed) >= needed
        })
    }

    fn nowhere(&self, refusals: &[Option<Refusal>]) -> StageError {
        let share = |reason: Refusal| {
            let count = refusals.iter().filter(|r| **r == Some(reason)).count();
            format!("{:.0} %", 100.0 * count as f64 / refusals.len() as f64)
        };
        StageError::input(format!(
            "a fibre can arrive nowhere on the surface: {} of it lies lower than {:.1} mm, {} in keep_out boxes, {} is thinner \
             than {} mm, {} too narrow for a fibre's end",
            share(Refusal::Low),
            self.floor,
            share(Refusal::Boxed),
            share(Refusal::Thin),
            self.params.thickness_mm,
            share(Refusal::Narrow)
        ))
        .hint("make the object larger (fit_mm of source-mesh), or lower rise_mm or thickness_mm")
    }
}
