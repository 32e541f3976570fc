//! `routes.json`: the fibres, each a NURBS curve from its LED to its marker.

use super::{check_finite, document};
use crate::id::{LedId, MarkerId, PatternId};
use crate::material::LayerRadii;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// All fibres of an object.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Routes {
    /// `"fibar.routes/1"`.
    pub format: String,
    /// The fibres, in order of id.
    pub fibres: Vec<Fibre>,
}

/// One fibre. Its curve runs from the LED's tip to the marker on the outer surface.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fibre {
    /// Its number, from 1.
    pub id: u32,
    /// Where it ends.
    pub marker: MarkerId,
    /// Where it starts.
    pub led: LedId,
    /// What it carries.
    pub pattern: PatternId,
    /// Degree of the curve.
    pub degree: usize,
    /// Knots, `points + degree + 1` of them, never falling, clamped at both ends.
    pub knots: Vec<f64>,
    /// Control points, mm.
    pub points: Vec<DVec3>,
    /// One positive weight per control point.
    pub weights: Vec<f64>,
    /// Radii of the layers.
    pub radii_mm: LayerRadii,
}

impl Routes {
    /// A document of the current format.
    pub fn new(fibres: Vec<Fibre>) -> Self {
        Routes { format: "fibar.routes/1".into(), fibres }
    }
}

document!(Routes, "fibar.routes/1", |r| {
    if !r.fibres.is_sorted_by(|a, b| a.id < b.id) {
        return Err("fibres must be in order of id, each once".into());
    }
    r.fibres.iter().try_for_each(|f| check_fibre(f).map_err(|what| format!("fibre {}: {what}", f.id)))
});

fn check_fibre(f: &Fibre) -> Result<(), String> {
    check_counts(f)?;
    f.points.iter().enumerate().try_for_each(|(k, p)| check_finite(&format!("points[{k}]"), *p))?;
    if !f.knots.iter().all(|k| k.is_finite()) || !f.knots.is_sorted() {
        return Err("knots must be finite and never fall".into());
    }
    let (first, last) = (f.knots[0], f.knots[f.knots.len() - 1]);
    let clamped = f.knots[..=f.degree].iter().all(|&k| k == first)
        && f.knots[f.points.len()..].iter().all(|&k| k == last)
        && first < last;
    if !clamped {
        return Err("knots must be clamped: degree + 1 equal ones at either end".into());
    }
    if !f.weights.iter().all(|w| w.is_finite() && *w > 0.0) {
        return Err("weights must be finite and positive".into());
    }
    let LayerRadii { core, cladding, black } = f.radii_mm;
    if !(0.0 < core && core < cladding && cladding < black && black.is_finite()) {
        return Err(format!("radii must grow outwards: core {core}, cladding {cladding}, black {black} mm"));
    }
    Ok(())
}

fn check_counts(f: &Fibre) -> Result<(), String> {
    if f.degree == 0 || f.degree > 16 || f.points.len() <= f.degree {
        return Err(format!(
            "degree {} needs at least {} control points, has {}",
            f.degree,
            f.degree + 1,
            f.points.len()
        ));
    }
    if f.knots.len() != f.points.len() + f.degree + 1 {
        return Err(format!(
            "{} knots do not fit {} points of degree {}",
            f.knots.len(),
            f.points.len(),
            f.degree
        ));
    }
    if f.weights.len() != f.points.len() {
        return Err(format!("{} weights do not fit {} points", f.weights.len(), f.points.len()));
    }
    Ok(())
}
