//! From fibres that know nothing of each other to fibres that keep apart.

use crate::gaps::{Chords, Contact, contacts};
use crate::joint::{Apart, Strand, settle};
use crate::mouths;
use crate::nets::Net;
use crate::params::Params;
use fibar_geometry::alone::{World, best, flaws, promising_starts};
use fibar_geometry::course::costs::Limits;
use fibar_geometry::course::{Course, Freedom};
use fibar_geometry::minimise::MinimiseOptions;
use fibar_geometry::passage::{Passages, Ways};
use fibar_plugin::{Job, StageError};
use glam::DVec2;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// What came out.
pub struct Outcome {
    /// Number of the net and its course, in order.
    pub courses: Vec<(usize, Course)>,
}

/// Routes all nets.
pub fn route(
    world: &World,
    passages: &Passages,
    nets: &[Net],
    params: &Params,
    job: &mut Job,
) -> Result<Outcome, StageError> {
    job.progress(0.1, "each fibre alone")?;
    let alone = each_alone(world, passages, nets, params);
    let courses: Vec<(usize, Course)> =
        alone.into_iter().enumerate().filter_map(|(k, course)| Some((k, course?))).collect();
    if courses.len() < nets.len() {
        let missing: Vec<String> = (0..nets.len())
            .filter(|k| courses.iter().all(|(net, _)| net != k))
            .map(|k| nets[k].marker.to_string())
            .collect();
        return Err(StageError::input(format!("no fibre reaches markers {}", missing.join(", "))));
    }
    job.progress(0.4, "all fibres together")?;
    let mut strands: Vec<Strand> = courses.iter().map(|(net, course)| strand(&nets[*net], course)).collect();
    place_mouths(&mut strands, nets, params);
    negotiate(world, &mut strands, params, job)?;
    let courses = courses.iter().zip(strands).map(|((net, _), strand)| (*net, strand.course)).collect();
    Ok(Outcome { courses })
}

fn each_alone(world: &World, passages: &Passages, nets: &[Net], params: &Params) -> Vec<Option<Course>> {
    let mut leds: Vec<&Net> = nets.iter().collect();
    leds.dedup_by_key(|net| net.led);
    let ways: BTreeMap<_, Option<Ways>> = leds
        .par_iter()
        .map(|net| (net.led, passages.from(net.ends.tip + 4.0 * net.ends.axis, 0.0, &|_| 0.0)))
        .collect();
    let (keep, options) = params.alone();
    nets.par_iter()
        .map(|net| {
            let starts = promising_starts(world, net.ends, ways[&net.led].as_ref(), keep, &options);
            best(world, net.ends, &starts, &options).map(|alone| alone.course)
        })
        .collect()
}

fn strand(net: &Net, course: &Course) -> Strand {
    Strand {
        pattern: net.pattern.0,
        course: course.clone(),
        weight: 1.0,
        margin: 0.0,
        limits: Limits { curvature: 0.0, wall_margin: 0.0, wall_weight: 0.0, bend_weight: 0.0, speed_weight: 1.0 },
        watched: vec![],
        held: false,
    }
}

/// Gives each fibre a mouth of its own under its LED.
fn place_mouths(strands: &mut [Strand], nets: &[Net], params: &Params) {
    for group in strands.chunk_by_mut(|a, b| a.pattern == b.pattern) {
        let ends = group[0].course.ends;
        let (across, up) = ends.axis.any_orthonormal_pair();
        let wish = |strand: &Strand| {
            let mouth = strand.course.points[0] - strand.course.ends.tip;
            DVec2::new(mouth.dot(across), mouth.dot(up))
        };
        let wishes: Vec<DVec2> = group.iter().map(wish).collect();
        let places = mouths::places(group.len(), params.mouth_radius_mm);
        for (strand, place) in group.iter_mut().zip(mouths::assign(&wishes, &places)) {
            let course = &mut strand.course;
            let shift = course.ends.tip + places[place].x * across + places[place].y * up - course.points[0];
            course.points[0] += shift;
            course.points[1] += shift;
            course.ends.tip = course.points[0];
            course.freedom = Freedom { mouth_radius: 0.0, ..course.freedom };
        }
    }
    let _ = nets;
}

/// Rounds of settling with growing weights, until all limits are kept.
fn negotiate(world: &World, strands: &mut [Strand], params: &Params, job: &mut Job) -> Result<(), StageError> {
    let mut apart = Apart { distance: params.apart() + 0.02, weight: 0.02 };
    let mut weight = 0.3;
    for strand in strands.iter_mut() {
        strand.limits = Limits {
            curvature: 1.0 / (1.005 * params.min_bend_radius_mm),
            wall_margin: 0.02,
            wall_weight: weight,
            bend_weight: 3.0,
            speed_weight: 1.0,
        };
    }
    for round in 0..10 {
        job.progress(0.4 + 0.05 * f64::from(round), "all fibres together")?;
        let options = MinimiseOptions { iterations: 80, least_gain: 1e-3, patience: 10, longest_step: 2.0 };
        let value = settle(world, strands, apart, options);
        let chords: Vec<Chords> =
            strands.par_iter().map(|s| Chords::of(s.pattern, &s.course.curve())).collect();
        let contacts: Vec<Contact> = contacts(&chords, params.apart());
        let flaws: Vec<_> = strands.par_iter().map(|s| flaws(world, &s.course)).collect();
        let flawed = flaws.iter().filter(|f| !f.none()).count();
        let least = contacts.iter().fold(f64::INFINITY, |l, c| l.min(c.distance));
        job.log("info", &format!("round {round}: cost {value:.3}, {} contacts, least {least:.3}, {flawed} flawed", contacts.len()));
        if contacts.is_empty() && flawed == 0 {
            return Ok(());
        }
        if apart.weight < 2.0 {
            apart.weight *= 3.0;
        }
        weight *= 1.5;
        for (strand, flaws) in strands.iter_mut().zip(&flaws) {
            if !flaws.none() {
                strand.watched.push(flaws.place);
                strand.limits.wall_margin += flaws.lack.clamp(0.0, 0.1);
                strand.limits.wall_weight = strand.limits.wall_weight.max(weight) * 2.0;
                strand.limits.bend_weight *= 2.0;
                strand.limits.curvature /= 1.0 + flaws.bend.clamp(0.0, 0.03);
            }
        }
        if round >= 4 {
            for contact in &contacts {
                for k in contact.strands {
                    strands[k].margin = (strands[k].margin + 0.5 * (params.apart() - contact.distance).min(0.1)).min(0.3);
                }
            }
        }
    }
    Ok(())
}
