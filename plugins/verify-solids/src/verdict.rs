//! What was measured against what is asked.

use crate::Params;
use crate::hole::{self, volume_within};
use crate::layers::RoleWalls;
use crate::part::Object;
use crate::sum::{Sums, Total};
use crate::topology::{self, Topology};
use crate::wall::Wall;
use fibar_core::artefact::verdict::{Finding, Place};
use fibar_core::material::Role;
use fibar_plugin::{Job, Violation};
use glam::DVec3;

/// Findings and metrics.
#[derive(Default)]
pub struct Judged {
    /// One per rule (three for the walls).
    pub findings: Vec<Finding>,
    /// Name, value, unit, place.
    metrics: Vec<(String, f64, &'static str, Option<DVec3>)>,
}

impl Judged {
    /// Sends metrics and violations.
    pub fn report(&self, job: &mut Job) {
        for (name, value, unit, place) in &self.metrics {
            match place {
                Some(place) => job.metric_at(name, *value, unit, place.to_array()),
                None => job.metric(name, *value, unit),
            }
        }
        for Finding { rule, message, places, .. } in self.findings.iter().filter(|finding| !finding.holds) {
            let place_mm = places.first().map(|place| place.position.to_array());
            job.violation(Violation { rule: rule.clone(), message: message.clone(), place_mm });
        }
    }

    fn metric(&mut self, name: &str, value: f64, unit: &'static str) {
        self.metrics.push((name.into(), value, unit, None));
    }
}

/// Holds every measurement against its bound.
pub fn judge(
    params: &Params,
    object: &Object,
    topologies: &[Topology],
    scanned: &Sums,
    walls: &[RoleWalls],
) -> Judged {
    let mut judged = Judged::default();
    judge_closedness(object, topologies, &mut judged);
    judge_components(object, topologies, &mut judged);
    judge_volume(params, object, topologies, &mut judged);
    judge_overlap(params, object, scanned, &mut judged);
    judge_gaps(params, object, scanned, &mut judged);
    walls.iter().for_each(|role| judge_walls(params, object, role, &mut judged));
    add_thinnest(walls, &mut judged);
    judged
}

fn judge_closedness(object: &Object, topologies: &[Topology], judged: &mut Judged) {
    let bad: usize = topologies.iter().map(|t| t.bad_edges).sum();
    let merged: usize = object.parts.iter().map(|part| part.merged_vertices).sum();
    let triangles: usize = object.parts.iter().map(|part| part.mesh.triangles.len()).sum();
    let named = object.parts.iter().zip(topologies);
    let place = |(part, topology): (&crate::part::Part, &Topology)| {
        let what = format!("{}: {} bad edges", part.name, topology.bad_edges);
        Some(Place { position: topology.bad_place?, value: topology.bad_edges as f64, what })
    };
    judged.findings.push(Finding {
        rule: "solids.closed".into(),
        holds: bad == 0,
        value: bad as f64,
        unit: "1".into(),
        bound: Some(0.0),
        message: format!(
            "{bad} edges of {triangles} triangles are open, doubled or turned the wrong way; {merged} vertices would fall \
             together in single precision"
        ),
        places: named.filter_map(place).collect(),
    });
    judged.metric("solids.bad_edges", bad as f64, "1");
    judged.metric("solids.triangles", triangles as f64, "1");
}

fn judge_components(object: &Object, topologies: &[Topology], judged: &mut Judged) {
    let total: usize = topologies.iter().map(|t| t.components).sum();
    let in_words = object.parts.iter().zip(topologies).map(|(part, t)| {
        format!(
            "{}: {} of {:.1} mm³, the smallest {:.3}, {} hollows, genus {}",
            part.name, t.components, t.volume_mm3, t.smallest_mm3, t.cavities, t.genus
        )
    });
    judged.findings.push(Finding {
        rule: "solids.components".into(),
        holds: true,
        value: total as f64,
        unit: "1".into(),
        bound: None,
        message: in_words.collect::<Vec<_>>().join("; "),
        places: Vec::new(),
    });
    judged.metric("solids.components", total as f64, "1");
}

fn judge_volume(params: &Params, object: &Object, topologies: &[Topology], judged: &mut Judged) {
    let sum: f64 = topologies.iter().map(|t| t.volume_mm3).sum();
    let holes: f64 =
        hole::all(&object.sockets).iter().map(|cavity| volume_within(&object.body, cavity)).sum();
    let expected = topology::volume(&object.body) - holes;
    let ratio = (sum - expected).abs() / expected;
    judged.findings.push(Finding {
        rule: "solids.volume".into(),
        holds: ratio <= params.max_volume_error_ratio,
        value: ratio,
        unit: "1".into(),
        bound: Some(params.max_volume_error_ratio),
        message: format!("the solids add up to {sum:.3} mm³; the body less its holes has {expected:.3} mm³"),
        places: Vec::new(),
    });
    judged.metric("solids.volume_error_ratio", ratio, "1");
}

fn judge_overlap(params: &Params, object: &Object, scanned: &Sums, judged: &mut Judged) {
    let overlap = &scanned.overlap;
    judged.findings.push(Finding {
        rule: "solids.overlap".into(),
        holds: overlap.length <= params.max_overlap_mm3,
        value: overlap.length,
        unit: "mm3".into(),
        bound: Some(params.max_overlap_mm3),
        message: format!("{:.4} mm³ belong to two solids{}", overlap.length, seen(params, scanned)),
        places: longest(overlap, object).into_iter().collect(),
    });
    judged.metric("solids.overlap_mm3", overlap.length, "mm3");
}

fn judge_gaps(params: &Params, object: &Object, scanned: &Sums, judged: &mut Judged) {
    let Sums { gap, outside, .. } = scanned;
    let worst = gap.length.max(outside.length);
    judged.findings.push(Finding {
        rule: "solids.gap".into(),
        holds: worst <= params.max_gap_mm3,
        value: worst,
        unit: "mm3".into(),
        bound: Some(params.max_gap_mm3),
        message: format!(
            "{:.4} mm³ of the body belong to no solid, {:.4} mm³ of the solids lie outside of it{}",
            gap.length,
            outside.length,
            seen(params, scanned)
        ),
        places: [gap, outside].into_iter().filter_map(|total| longest(total, object)).collect(),
    });
    judged.metric("solids.gap_mm3", gap.length, "mm3");
    judged.metric("solids.outside_mm3", outside.length, "mm3");
}

fn seen(params: &Params, scanned: &Sums) -> String {
    let skipped = match scanned.skipped_lines {
        0 => String::new(),
        n => format!(", {n} of them untold"),
    };
    format!(" (lines {} mm apart{skipped})", params.line_spacing_mm)
}

fn longest(total: &Total, object: &Object) -> Option<Place> {
    let what = match total.between {
        Some((a, b)) if a != b => format!("{} and {}", object.parts[a].name, object.parts[b].name),
        Some((a, _)) => object.parts[a].name.clone(),
        None => "nothing".into(),
    };
    let spot = total.longest;
    (spot.length > 0.0).then(|| Place {
        position: spot.place,
        value: spot.length,
        what: format!("{what}, {:.4} mm along x", spot.length),
    })
}

fn judge_walls(params: &Params, object: &Object, role: &RoleWalls, judged: &mut Judged) {
    let Some((name, thinnest)) = role.walls.first() else { return };
    let asked = if role.role == Role::Skin { object.skin_mm } else { params.min_layer_mm };
    let bound = asked - params.wall_tolerance_mm;
    let thin = role.walls.iter().filter(|(_, wall)| wall.thickness < bound).count();
    let where_not = if role.role == Role::Skin {
        String::new()
    } else {
        format!(", {} mm and more from the fibres' ends", params.end_zone_mm)
    };
    judged.findings.push(Finding {
        rule: "solids.min_wall".into(),
        holds: thin == 0,
        value: thinnest.thickness,
        unit: "mm".into(),
        bound: Some(bound),
        message: format!(
            "{}: thinnest {:.4} mm ({name}), {asked} mm less {} mm asked; {thin} of {} too thin{where_not}",
            role.role.name(),
            thinnest.thickness,
            params.wall_tolerance_mm,
            role.walls.len()
        ),
        places: role.walls.iter().map(place_of_wall).collect(),
    });
    let metric = format!("solids.min_{}_mm", role.role.name());
    judged.metrics.push((metric, thinnest.thickness, "mm", Some(thinnest.place)));
}

/// Holds the gaps between fibres of different LEDs, the nearest pair first, against what is asked.
pub fn judge_fibre_gaps(params: &Params, bridges: &[(String, Wall)], judged: &mut Judged) {
    const LISTED: usize = 5;
    let Some((name, nearest)) = bridges.first() else { return };
    let bound = params.min_fibre_gap_mm - params.wall_tolerance_mm;
    let near = bridges.iter().filter(|(_, bridge)| bridge.thickness < bound).count();
    judged.findings.push(Finding {
        rule: "solids.fibre_gap".into(),
        holds: near == 0,
        value: nearest.thickness,
        unit: "mm".into(),
        bound: Some(bound),
        message: format!(
            "gap between the meshes of two LEDs' fibres: least {:.4} mm ({name}), {} mm less {} mm asked; {near} of {} pairs too near",
            nearest.thickness,
            params.min_fibre_gap_mm,
            params.wall_tolerance_mm,
            bridges.len()
        ),
        places: bridges.iter().take(near.max(LISTED)).map(place_of_wall).collect(),
    });
    judged.metrics.push(("solids.min_fibre_gap_mm".into(), nearest.thickness, "mm", Some(nearest.place)));
}

fn place_of_wall((name, wall): &(String, Wall)) -> Place {
    Place { position: wall.place, value: wall.thickness, what: name.clone() }
}

/// The thinnest wall of any role.
fn add_thinnest(walls: &[RoleWalls], judged: &mut Judged) {
    let each = walls.iter().filter_map(|role| role.walls.first());
    if let Some((_, wall)) = each.min_by(|a, b| a.1.thickness.total_cmp(&b.1.thickness)) {
        judged.metrics.push(("solids.min_wall_mm".into(), wall.thickness, "mm", Some(wall.place)));
    }
}
