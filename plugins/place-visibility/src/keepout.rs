//! Places without markers: too low for a fibre to turn up to, in a named box or part, too thin, or too narrow for a fibre's end.

use crate::params::Params;
use crate::parts::ForbiddenParts;
use fibar_core::artefact::sockets::Sockets;
use fibar_geometry::distance::Surface;
use fibar_geometry::rays::RayScene;
use fibar_geometry::sampling::SurfaceSample;
use fibar_plugin::StageError;
use rayon::prelude::*;

/// What makes a place impossible.
pub struct KeepOut<'a> {
    body: &'a Solid,
    params: &'a Params,
    parts: ForbiddenParts,
    floor: f64,
}

/// The body as rays and as distances find it.
pub struct Solid {
    /// For rays.
    pub scene: RayScene,
    /// For distances.
    pub surface: Surface,
}

/// Why a place is impossible.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Refusal {
    /// Lower than `rise_mm` above the highest LED tip; the base itself, too.
    Low,
    /// In a box of `keep_out`.
    Boxed,
    /// On one of the `keep_out_parts`.
    Painted,
    /// The opposite side is nearer than `thickness_mm`.
    Thin,
    /// A fibre's end piece would touch the skin, or come too near to it, beside its own end.
    Narrow,
}

impl<'a> KeepOut<'a> {
    /// The rules of `params` for a body and its LEDs, and parts of the source.
    pub fn new(body: &'a Solid, sockets: &Sockets, params: &'a Params, parts: ForbiddenParts) -> KeepOut<'a> {
        let tip = sockets.sockets.iter().map(|s| s.position.z).fold(0.0, f64::max);
        KeepOut { body, params, parts, floor: tip + params.rise_mm }
    }

    /// Indices of the samples where a marker may sit; an error that counts the reasons if there is none.
    pub fn open_samples(&self, samples: &[SurfaceSample]) -> Result<Vec<usize>, StageError> {
        let refusals: Vec<Option<Refusal>> = samples.par_iter().map(|s| self.refusal(s)).collect();
        let open: Vec<usize> = (0..samples.len()).filter(|&k| refusals[k].is_none()).collect();
        if open.is_empty() { Err(self.nowhere(&refusals)) } else { Ok(open) }
    }

    /// Why no marker may sit at a sample; `None` if one may.
    pub fn refusal(&self, sample: &SurfaceSample) -> Option<Refusal> {
        let position = sample.position;
        if position.z < self.floor {
            Some(Refusal::Low)
        } else if self.params.keep_out.iter().any(|region| region.contains(position)) {
            Some(Refusal::Boxed)
        } else if self.parts.contains(position) {
            Some(Refusal::Painted)
        } else if self.thickness(sample) < self.params.thickness_mm {
            Some(Refusal::Thin)
        } else if !self.has_room_for_end(sample) {
            Some(Refusal::Narrow)
        } else {
            None
        }
    }

    /// Depth of the body under a sample along the inward normal, mm, measured no further than needed.
    fn thickness(&self, sample: &SurfaceSample) -> f64 {
        let lift = self.params.lift_mm;
        let start = sample.position - sample.face_normal * lift;
        lift + self.body.scene.reach(start, -sample.normal, self.params.thickness_mm)
    }

    /// Whether the inner end of the straight end piece is far enough from the surface on all sides.
    fn has_room_for_end(&self, sample: &SurfaceSample) -> bool {
        let Params { skin_mm, end_mm, fibre_diameter_mm, wall_mm, .. } = *self.params;
        let inner = sample.position - sample.normal * (skin_mm + end_mm);
        let needed = fibre_diameter_mm / 2.0 + skin_mm + wall_mm;
        // A place outside is none, however far from the surface; what is not within the reach is far enough.
        let nearest = self.body.surface.closest_within(inner, needed);
        nearest.is_none() && self.body.surface.signed_distance(inner) < 0.0
    }

    fn nowhere(&self, refusals: &[Option<Refusal>]) -> StageError {
        let share = |reason: Refusal| {
            let count = refusals.iter().filter(|r| **r == Some(reason)).count();
            format!("{:.0} %", 100.0 * count as f64 / refusals.len() as f64)
        };
        StageError::input(format!(
            "a fibre can arrive nowhere on the surface: {} of it lies lower than {:.1} mm, {} in keep_out boxes, {} on \
             keep_out_parts, {} is thinner than {} mm, {} too narrow for a fibre's end",
            share(Refusal::Low),
            self.floor,
            share(Refusal::Boxed),
            share(Refusal::Painted),
            share(Refusal::Thin),
            self.params.thickness_mm,
            share(Refusal::Narrow)
        ))
        .hint("make the object larger (fit_mm of source-mesh), or lower rise_mm or thickness_mm")
    }
}
