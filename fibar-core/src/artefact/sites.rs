//! `sites.json`: candidate marker places, and what each viewpoint sees of them.

use super::{check_finite, check_unit, document};
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// Candidate places and the simulated views over them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sites {
    /// `"fibar.sites/1"`.
    pub format: String,
    /// Centre of the sphere of viewpoints: that of the body's bounding box, mm.
    pub centre: DVec3,
    /// The candidates, in order of choice.
    pub sites: Vec<Site>,
    /// The viewpoints, each with the candidates it sees.
    pub views: Vec<View>,
}

/// A surface point that may carry a marker.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Site {
    /// On the outer surface, mm.
    pub position: DVec3,
    /// Outward unit normal.
    pub normal: DVec3,
    /// Suitability `s(p)`, rad summed over viewpoints (Tone 2020, eq. for `s(p_m)`).
    pub suitability_rad: f64,
}

/// A simulated camera on the viewing sphere, looking at its centre.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct View {
    /// Camera centre, mm.
    pub position: DVec3,
    /// Indices into `sites` of the candidates it sees, rising.
    pub visible: Vec<u32>,
}

impl Sites {
    /// A document of the current format.
    pub fn new(centre: DVec3, sites: Vec<Site>, views: Vec<View>) -> Self {
        Sites { format: "fibar.sites/1".into(), centre, sites, views }
    }
}

document!(Sites, "fibar.sites/1", |s| {
    check_finite("centre", s.centre)?;
    for (k, site) in s.sites.iter().enumerate() {
        check_finite(&format!("sites[{k}].position"), site.position)?;
        check_unit(&format!("sites[{k}].normal"), site.normal)?;
    }
    for (k, view) in s.views.iter().enumerate() {
        check_finite(&format!("views[{k}].position"), view.position)?;
        if !view.visible.is_sorted_by(|a, b| a < b)
            || view.visible.last().is_some_and(|&i| i as usize >= s.sites.len())
        {
            return Err(format!(
                "views[{k}].visible must rise strictly and index the {} sites",
                s.sites.len()
            ));
        }
    }
    Ok(())
});
