//! Courses of an earlier routing that still lead from their LED to their marker.
//!
//! Ids and numbers do not count: a course is known by its pattern and by where it lies.

use crate::nets::Net;
use crate::params::Params;
use fibar_core::artefact::Document;
use fibar_core::artefact::routes::{Fibre, Routes};
use fibar_core::material::LayerRadii;
use fibar_geometry::course::nodes::MOST_POINTS;
use fibar_geometry::course::{Course, DEGREE, Ends, FEWEST_POINTS, Freedom};
use fibar_geometry::curve::clamped_uniform_knots;
use fibar_plugin::StageError;

/// What is within this is the same place, mm.
const SAME_MM: f64 = 1e-9;

/// Reads the routes that the parameter `warm_start` names, if it does.
pub fn read(params: &Params) -> Result<Option<Routes>, StageError> {
    let blame = |message: String| StageError::input(message).param("/warm_start");
    let Some(file) = &params.warm_start else { return Ok(None) };
    let bytes =
        std::fs::read(file.path()).map_err(|e| blame(format!("cannot read the earlier routes: {e}")))?;
    Routes::from_json(&bytes).map(Some).map_err(|e| {
        blame(format!("these are no earlier routes: {e}"))
            .hint("name a copy of build/NAME/routes.json, or leave warm_start out to route anew")
    })
}

/// The earlier course of each net, where one leads from its LED to its marker and is as thick as asked for.
pub fn courses(routes: &Routes, nets: &[Net], freedom: Freedom, params: &Params) -> Vec<Option<Course>> {
    let usable: Vec<&Fibre> =
        routes.fibres.iter().filter(|fibre| is_ours(fibre) && has_radii(fibre, params.radii())).collect();
    let of = |net: &Net| {
        let fibre =
            usable.iter().find(|fibre| fibre.pattern == net.pattern && leads(fibre, &net.ends, freedom));
        fibre.map(|fibre| course(fibre, net, freedom))
    };
    nets.iter().map(of).collect()
}

/// Why none of the earlier courses can be used.
pub fn why_none(routes: &Routes, params: &Params) -> String {
    let count = routes.fibres.len();
    if !routes.fibres.iter().any(is_ours) {
        return format!("none of their {count} fibres is a cubic of equal spans, as this stage writes them");
    }
    match routes.fibres.iter().any(|fibre| has_radii(fibre, params.radii())) {
        false => format!("their {count} fibres have other radii"),
        true => format!("none of their {count} fibres leads from an LED to a marker of its pattern here"),
    }
}

fn has_radii(fibre: &Fibre, radii: LayerRadii) -> bool {
    let LayerRadii { core, cladding, black } = fibre.radii_mm;
    let same = |a: f64, b: f64| (a - b).abs() <= SAME_MM;
    same(core, radii.core) && same(cladding, radii.cladding) && same(black, radii.black)
}

/// Whether this stage could have written it.
fn is_ours(fibre: &Fibre) -> bool {
    let count = fibre.points.len();
    fibre.degree == DEGREE
        && (FEWEST_POINTS..=MOST_POINTS).contains(&count)
        && fibre.weights.iter().all(|&weight| weight == 1.0)
        && fibre.knots == clamped_uniform_knots(DEGREE, count)
}

/// Whether it starts under the LED, along its axis, and ends at the marker, near its normal.
fn leads(fibre: &Fibre, ends: &Ends, freedom: Freedom) -> bool {
    let [first, second, .., before, last] = fibre.points[..] else { return false };
    let (mouth, leg, arrival) = (first - ends.tip, second - first, ends.marker - before);
    let along = arrival.dot(ends.normal);
    mouth.dot(ends.axis).abs() <= SAME_MM
        && mouth.length() <= freedom.mouth_radius + SAME_MM
        && leg.dot(ends.axis) > 0.0
        && leg.cross(ends.axis).length() <= SAME_MM
        && last.distance(ends.marker) <= SAME_MM
        && along > 0.0
        && (arrival / along - ends.normal).length() <= freedom.tilt + SAME_MM
}

/// Its mouth is its own already.
fn course(fibre: &Fibre, net: &Net, freedom: Freedom) -> Course {
    Course {
        ends: Ends { tip: fibre.points[0], ..net.ends },
        freedom: Freedom { mouth_radius: 0.0, ..freedom },
        points: fibre.points.clone(),
    }
}
