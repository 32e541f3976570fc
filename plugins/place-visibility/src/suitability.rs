//! How well cameras all around see a place: `s(p)` of Tone 2020, "Marker placement", and who sees what.

use crate::params::Params;
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_core::artefact::sites::View;
use fibar_geometry::rays::RayScene;
use fibar_geometry::sampling::SurfaceSample;
use fibar_geometry::viewsphere::geodesic_directions;
use fibar_plugin::StageError;
use glam::DVec3;
use rayon::prelude::*;

/// The viewpoints around a body.
pub struct Outlook {
    centre: DVec3,
    viewpoints: Vec<DVec3>,
    lift: f64,
}

impl Outlook {
    /// Viewpoints on a geodesic sphere around the centre of the bounding box, which must hold the whole body.
    pub fn new(body: &TriangleMesh, params: &Params) -> Result<Outlook, StageError> {
        let (low, high) = body.bounds().ok_or_else(|| StageError::input("the body is empty"))?;
        let radius = (high - low).length() / 2.0;
        if params.view_distance_mm <= radius {
            let message = format!(
                "viewpoints {} mm from the body's centre would lie inside it: its corners are {radius:.1} mm away",
                params.view_distance_mm
            );
            let hint = format!("view_distance_mm should be well above {radius:.0} mm");
            return Err(StageError::user(message).param("/view_distance_mm").hint(hint));
        }
        let centre = (low + high) / 2.0;
        let lowest = libm::sin(params.lowest_view_deg.to_radians());
        let directions = geodesic_directions(params.sphere.into(), params.frequency);
        let viewpoints: Vec<DVec3> = directions
            .into_iter()
            .filter(|d| d.z >= lowest)
            .map(|d| centre + d * params.view_distance_mm)
            .collect();
        if viewpoints.is_empty() {
            let message = format!("no viewpoint lies {}° above the horizon", params.lowest_view_deg);
            let error = StageError::user(message).param("/lowest_view_deg");
            return Err(error.hint("lower it, or raise frequency"));
        }
        Ok(Outlook { centre, viewpoints, lift: params.lift_mm })
    }

    /// Centre of the body's bounding box, mm.
    pub fn centre(&self) -> DVec3 {
        self.centre
    }

    /// `s(p) = Σ_v vis(p, v) θ(p, v)` of the named samples, rad (Tone 2020, eq. for `s(p_m)`).
    pub fn suitability(&self, samples: &[SurfaceSample], which: &[usize], scene: &RayScene) -> Vec<f64> {
        let suitability = |sample: &SurfaceSample| -> f64 {
            let seen = self.viewpoints.iter().filter(|v| self.sees(**v, sample, scene));
            seen.map(|v| incidence(*v, sample)).sum()
        };
        which.par_iter().map(|&k| suitability(&samples[k])).collect()
    }

    /// What every viewpoint sees, no further than `limit` from the normals, rad.
    pub fn views(&self, sites: &[SurfaceSample], scene: &RayScene, limit: f64) -> Vec<View> {
        let view = |&viewpoint: &DVec3| {
            let lit = |s: &SurfaceSample| std::f64::consts::PI - incidence(viewpoint, s) <= limit;
            let sees = |k: &u32| {
                let site = &sites[*k as usize];
                lit(site) && self.sees(viewpoint, site, scene)
            };
            View { position: viewpoint, visible: (0..sites.len() as u32).filter(sees).collect() }
        };
        self.viewpoints.par_iter().map(view).collect()
    }

    /// `vis(p, v)`: the surface faces the viewpoint there, and nothing is in between.
    fn sees(&self, viewpoint: DVec3, sample: &SurfaceSample, scene: &RayScene) -> bool {
        let arm = viewpoint - sample.position;
        arm.dot(sample.normal) > 0.0
            && arm.dot(sample.face_normal) > 0.0
            && scene.is_clear(sample.position + sample.face_normal * self.lift, viewpoint)
    }
}

/// `θ(p, v)`: angle between the normal and the incident vector from `v` to `p`; π is head-on, π/2 grazing.
fn incidence(viewpoint: DVec3, sample: &SurfaceSample) -> f64 {
    let incident = (sample.position - viewpoint).normalize();
    libm::acos(incident.dot(sample.normal).clamp(-1.0, 1.0))
}
