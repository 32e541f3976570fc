//! From fibres that know nothing of each other to fibres that keep apart.
//!
//! 1. Every fibre takes its best course alone, then a mouth of its own under its LED.
//! 2. All settle together while closeness costs little, so that they can pass through each other.
//! 3. Fibres that lost much are ripped up and look for another way; all settle again, closeness costing more each time.
//! 4. What still breaks a limit moves until nothing does, all else held.
//! 5. All settle once more; that is kept only if it keeps every limit.

use crate::crowd::Crowd;
use crate::inspect::Faults;
use crate::joint::{Apart, Strand, settle};
use crate::misfit::{self, Misfit, Unfit};
use crate::mouths;
use crate::neck::{self, Sizes, Way};
use crate::nets::Net;
use crate::omit::Routing;
use crate::params::{Effort, OnMisfit, Params};
use crate::reroute::{self, Alone, Looks, Reroute, loss_of};
use crate::trunks;
use fibar_geometry::alone::{Flaws, Watched, World, find};
use fibar_geometry::course::costs::Limits;
use fibar_geometry::course::{Course, Freedom};
use fibar_geometry::minimise::MinimiseOptions;
use fibar_geometry::passage::{Passages, Ways};
use fibar_plugin::{Job, StageError};
use glam::DVec2;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::OnceLock;

/// What came out.
pub struct Outcome {
    /// Number of the net and its course, in order.
    pub courses: Vec<(usize, Course)>,
    /// How many of them are those of an earlier routing.
    pub kept: usize,
}

/// Beyond the distance that has to be kept, mm, so that what is soft can be kept hard.
const APART_MARGIN: f64 = 0.02;

/// How far new ways lead to the side, mm.
const ASIDE_MM: f64 = 6.0;

/// Routes all nets.
pub fn route(
    world: &World,
    passages: &OnceLock<Passages>,
    nets: &[Net],
    params: &Params,
    job: &mut Job,
) -> Result<Outcome, Unfit> {
    let courses = reach(world, passages, nets, params, job)?;
    fit(world, nets, courses, params, job)
}

/// The best course alone of every net that can be reached, with its number; others are refused or left out.
pub fn reach(
    world: &World,
    passages: &OnceLock<Passages>,
    nets: &[Net],
    params: &Params,
    job: &mut Job,
) -> Result<Vec<(usize, Course)>, Unfit> {
    job.progress(0.1, "each fibre alone")?;
    let passages = passages.get_or_init(|| Passages::of(world.room, params.search_mm));
    let alone = each_alone(world, passages, nets, params);
    let missing: Vec<&Net> =
        nets.iter().zip(&alone).filter_map(|(net, course)| course.is_none().then_some(net)).collect();
    if !missing.is_empty() {
        let unreachable = misfit::unreachable(world, &missing);
        if params.on_misfit != OnMisfit::Drop || missing.len() == nets.len() {
            return Err(Misfit::Place(unreachable).into());
        }
        job.log("warn", &format!("{unreachable}: left out"));
    }
    Ok(alone.into_iter().enumerate().filter_map(|(k, course)| Some((k, course?))).collect())
}

/// Routes the courses given; where they do not fit, says why or leaves some out.
fn fit(
    world: &World,
    nets: &[Net],
    mut courses: Vec<(usize, Course)>,
    params: &Params,
    job: &mut Job,
) -> Result<Outcome, Unfit> {
    let sizes = Sizes { radius: params.black_radius_mm, clearance: params.clearance_mm };
    let neck = loop {
        job.progress(0.25, "necks")?;
        let ways: Vec<Way> =
            courses.iter().map(|(net, course)| trunks::way(world, &nets[*net], course)).collect();
        let neck = neck::fullest(world.room, &ways, sizes);
        let Some(full) = neck.clone().filter(|neck| neck.capacity < neck.through.len()) else { break neck };
        let beyond = misfit::beyond_capacity(&full);
        let misfit = Misfit::Neck(Box::new(full));
        let keeps = |net: usize| !beyond.contains(&nets[net].marker);
        if params.on_misfit != OnMisfit::Drop || !courses.iter().any(|(net, _)| keeps(*net)) {
            return Err(misfit.into());
        }
        let markers = misfit::named(&beyond);
        job.log("warn", &format!("left out: {markers}, as {}", misfit.message(params)));
        courses.retain(|(net, _)| keeps(*net));
    };
    let mut strands: Vec<Strand> =
        courses.iter().map(|(net, course)| strand(&nets[*net], course, params)).collect();
    place_mouths(&mut strands, params);
    let crowded = neck.filter(|neck| neck.is_crowded(sizes));
    if let Some(neck) = &crowded {
        job.log("info", "fibres of one LED share a trunk through a neck");
        let mut bundled: Vec<(usize, Course)> =
            courses.iter().zip(&strands).map(|((net, _), strand)| (*net, strand.course.clone())).collect();
        trunks::bundle(neck, nets, &mut bundled);
        strands.iter_mut().zip(bundled).for_each(|(strand, (_, course))| strand.course = course);
    }
    let alone = make_room(world, &mut strands, crowded.is_some(), params, job)?;
    let nets_of: Vec<usize> = courses.iter().map(|(net, _)| *net).collect();
    let mut routing = Routing { nets: nets_of, settled: strands.clone(), strands, alone };
    if !finish(world, &mut routing.strands, &routing.alone, ROUNDS, params, job)? {
        /// So few may be sorted by taking some out; more would take long to no avail.
        const FEW_AT_FAULT: usize = 8;
        let crowding = routing.crowding(world, nets, params);
        if params.on_misfit != OnMisfit::Drop && crowding.at_fault > FEW_AT_FAULT {
            return Err(Misfit::Crowd(crowding).into());
        }
        job.log("info", "some fibres are taken out and put back");
        match routing.thin_out(world, nets, params, job)? {
            Some(out) if out.is_empty() => (),
            Some(out) if params.on_misfit == OnMisfit::Drop => {
                let why = "their fibres find no way between the others";
                job.log("warn", &format!("left out: {}, as {why}", misfit::named(&out)));
            }
            without => return Err(Misfit::Crowd(crowding.fits_without(without)).into()),
        }
    }
    polish(world, &mut routing.strands, params);
    Ok(routing.outcome())
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
            let found = find(world, net.ends, ways[&net.led].as_ref(), keep, &options);
            found.map(|alone| alone.course)
        })
        .collect()
}

/// A course to be settled.
pub fn strand(net: &Net, course: &Course, params: &Params) -> Strand {
    Strand {
        pattern: net.pattern.0,
        course: course.clone(),
        margin: 0.0,
        limits: limits(params),
        watched: Watched::default(),
        held: false,
        kept: false,
    }
}

/// Limits of a fibre of its own before any was broken.
pub fn limits(params: &Params) -> Limits {
    Limits {
        curvature: 1.0 / (1.005 * params.min_bend_radius_mm),
        wall_margin: 0.02,
        wall_weight: 1.0,
        bend_weight: 3.0,
        speed_weight: 1.0,
    }
}

/// Gives each fibre a mouth of its own under its LED; kept ones have theirs.
pub fn place_mouths(strands: &mut [Strand], params: &Params) {
    for group in strands.chunk_by_mut(|a, b| a.pattern == b.pattern) {
        let (across, up) = group[0].course.ends.axis.any_orthonormal_pair();
        let wish = |strand: &Strand| {
            let mouth = strand.course.points[0] - strand.course.ends.tip;
            DVec2::new(mouth.dot(across), mouth.dot(up))
        };
        let wishes = |kept: bool| group.iter().filter(|s| s.kept == kept).map(wish).collect::<Vec<DVec2>>();
        let wishes_of_new = wishes(false);
        let places = mouths::beside(&wishes(true), wishes_of_new.len(), params.mouth_radius_mm);
        let taken = mouths::assign(&wishes_of_new, &places);
        for (strand, place) in group.iter_mut().filter(|strand| !strand.kept).zip(taken) {
            let course = &mut strand.course;
            let mouth = course.ends.tip + places[place].x * across + places[place].y * up;
            let shift = mouth - course.points[0];
            course.points[0] += shift;
            course.points[1] += shift;
            course.ends.tip = mouth;
            course.freedom = Freedom { mouth_radius: 0.0, ..course.freedom };
        }
    }
}

/// Settles all fibres together and rips up those that lose most, closeness costing more each time.
pub fn make_room(
    world: &World,
    strands: &mut [Strand],
    bundled: bool,
    params: &Params,
    job: &mut Job,
) -> Result<Vec<Alone>, StageError> {
    const WHILE_LOOKING: f64 = 0.04;
    let (iterations, weights): (usize, &[f64]) = match params.effort {
        _ if bundled => (80, &[0.15, 0.4, 1.0, 2.5]),
        Effort::Quick => (40, &[0.02, 0.15, 1.0]),
        Effort::Normal => (40, &[0.02, 0.06, 0.12, 0.25, 0.6, 2.0]),
        Effort::Thorough => (80, &[0.02, 0.04, 0.08, 0.15, 0.3, 0.6, 1.2, 2.4]),
    };
    let steps = MinimiseOptions { iterations, least_gain: 1e-3, patience: 10, longest_step: 2.0 };
    let alone =
        |strand: &Strand| Alone { course: strand.course.clone(), loss: loss_of(world, &strand.course) };
    let alone: Vec<Alone> = strands.par_iter().map(alone).collect();
    let distance = params.apart() + APART_MARGIN;
    let mut looks = Looks::new(world, strands);
    for (round, &weight) in weights.iter().enumerate() {
        let share = |t: f64| 0.3 + 0.5 * (round as f64 + t) / weights.len() as f64;
        if !bundled && round > 0 && round + 1 < weights.len() {
            let options = Reroute {
                apart: Apart { distance, weight: weight.min(WHILE_LOOKING) },
                least_excess: 0.1,
                aside: ASIDE_MM,
            };
            let changed = reroute::pass(world, strands, &alone, &mut looks, &options, &mut |t| {
                job.progress(share(0.7 * t), "other ways")
            })?;
            job.log("info", &format!("{changed} fibres took another way"));
        }
        job.progress(share(0.7), "all fibres together")?;
        settle(world, strands, Apart { distance, weight }, steps);
    }
    Ok(alone)
}

/// Rounds of [`finish`] for a whole routing.
pub const ROUNDS: u32 = 20;
/// The same among fibres that are kept, where some give way if there is no room.
pub const ROUNDS_AMONG_KEPT: u32 = 10;
/// The same for one fibre more.
pub const ROUNDS_FOR_ONE: u32 = 4;
/// Every so many rounds all that are still at fault are taken out and put back.
const ROUNDS_TO_A_START: u32 = 5;

/// All settle together, closeness costing much.
pub fn settle_anew(world: &World, strands: &mut [Strand], params: &Params) {
    let steps = MinimiseOptions { iterations: 40, least_gain: 1e-3, patience: 10, longest_step: 2.0 };
    settle(world, strands, Apart { distance: params.apart() + APART_MARGIN, weight: 2.0 }, steps);
}

/// A fibre on the cheapest way found for it among others that stay.
pub fn put_among(world: &World, others: &[Strand], net: &Net, alone: &Course, params: &Params) -> Strand {
    let mut crowd = Crowd::within(world.room.surface().bounds());
    others.iter().for_each(|strand| crowd.push(strand.segments(world)));
    let strand = strand(net, alone, params);
    let apart = Apart { distance: params.apart() + APART_MARGIN, weight: 1.0 };
    let options = Reroute { apart, least_excess: 0.0, aside: ASIDE_MM };
    match reroute::new_way((world, &crowd, &strand), alone, &options, None) {
        Some((_, course)) => Strand { course, ..strand },
        None => strand,
    }
}

/// Moves what breaks a limit until nothing does, all else held; whether that came to an end.
pub fn finish(
    world: &World,
    strands: &mut [Strand],
    alone: &[Alone],
    rounds: u32,
    params: &Params,
    job: &mut Job,
) -> Result<bool, StageError> {
    let steps = MinimiseOptions { iterations: 100, least_gain: 1e-4, patience: 10, longest_step: 1.0 };
    let apart = Apart { distance: params.apart() + APART_MARGIN, weight: 4.0 };
    let mut faults = Faults::of(world, strands, params.apart());
    let mut progress = Progress::default();
    for round in 0..rounds {
        job.progress(0.8 + 0.15 * f64::from(round) / f64::from(rounds), "limits")?;
        job.log(
            "debug",
            &format!(
                "{} contacts, {} of {} break a limit ({:.3})",
                faults.contacts.len(),
                faults.strands().len(),
                strands.len(),
                faults.sum(params.apart())
            ),
        );
        if faults.none() {
            strands.iter_mut().for_each(|strand| strand.held = strand.kept);
            return Ok(true);
        }
        let moving = at_fault(strands, &faults);
        if moving.is_empty() || progress.has_ended(round, faults.sum(params.apart())) {
            break;
        }
        let kinked = |k: &usize| faults.flaws[*k].bend > 0.5;
        let stuck: Vec<usize> = moving
            .iter()
            .copied()
            .filter(|k| round % ROUNDS_TO_A_START == ROUNDS_TO_A_START - 1 || (round > 0 && kinked(k)))
            .collect();
        if !stuck.is_empty() {
            start_again(world, strands, &stuck, alone, Apart { weight: 1.0, ..apart });
            faults.look_again(world, strands, |k| stuck.contains(&k), params.apart());
        }
        urge(strands, &faults, params.apart());
        let moving = at_fault(strands, &faults);
        for (k, strand) in strands.iter_mut().enumerate() {
            strand.held = moving.binary_search(&k).is_err();
        }
        settle(world, strands, apart, steps);
        faults.look_again(world, strands, |k| moving.binary_search(&k).is_ok(), params.apart());
    }
    strands.iter_mut().for_each(|strand| strand.held = strand.kept);
    Ok(faults.none())
}

/// Whether starting again still helps.
#[derive(Default)]
struct Progress {
    /// Least that was wrong before the last start, and since.
    least: [Option<f64>; 2],
}

impl Progress {
    /// Told every round how much is wrong: whether the last start left more than half of it.
    fn has_ended(&mut self, round: u32, wrong: f64) -> bool {
        const WORTH_IT: f64 = 0.5;
        let [before, since] = &mut self.least;
        *since = Some(since.map_or(wrong, |least| least.min(wrong)));
        if round % ROUNDS_TO_A_START != ROUNDS_TO_A_START - 1 {
            return false;
        }
        let ended = before.zip(*since).is_some_and(|(before, since)| since > WORTH_IT * before);
        *before = match (*before, since.take()) {
            (Some(a), Some(b)) => Some(a.min(b)),
            (a, b) => a.or(b),
        };
        ended
    }
}

/// The strands that have to move and may, in order.
fn at_fault(strands: &[Strand], faults: &Faults) -> Vec<usize> {
    faults.strands().into_iter().filter(|&k| !strands[k].kept).collect()
}

/// Takes stuck fibres out and puts them back one after the other, in the order of their numbers or the reverse, whichever is
/// cheaper in all; with fresh limits.
fn start_again(world: &World, strands: &mut [Strand], stuck: &[usize], alone: &[Alone], apart: Apart) {
    let options = Reroute { apart, least_excess: 0.0, aside: ASIDE_MM };
    let put_back = |order: &mut dyn Iterator<Item = usize>| {
        let mut crowd = Crowd::within(world.room.surface().bounds());
        let others = strands.iter().enumerate();
        others.filter(|(k, _)| !stuck.contains(k)).for_each(|(_, strand)| crowd.push(strand.segments(world)));
        let mut sum = 0.0;
        let mut put: Vec<(usize, Strand)> = vec![];
        for k in order {
            let mut strand = Strand { margin: 0.0, watched: Watched::default(), ..strands[k].clone() };
            strand.limits.bend_weight = 20.0;
            strand.limits.wall_weight = 4.0;
            if let Some((cost, course)) =
                reroute::new_way((world, &crowd, &strand), &alone[k].course, &options, None)
            {
                sum += cost;
                strand.course = course;
            }
            crowd.push(strand.segments(world));
            put.push((k, strand));
        }
        (sum, put)
    };
    let (forwards, backwards) =
        (put_back(&mut stuck.iter().copied()), put_back(&mut stuck.iter().rev().copied()));
    let cheaper = if backwards.0 < forwards.0 { backwards } else { forwards };
    cheaper.1.into_iter().for_each(|(k, strand)| strands[k] = strand);
}

/// Asks more of the fibres that break a limit.
fn urge(strands: &mut [Strand], faults: &Faults, apart: f64) {
    for (strand, flaws) in strands.iter_mut().zip(&faults.flaws).filter(|(_, flaws)| !flaws.none()) {
        watch(strand, flaws);
        if flaws.lack > 0.0 && flaws.lack.is_finite() {
            strand.limits.wall_margin = (strand.limits.wall_margin + 0.5 * flaws.lack.min(0.06)).min(0.15);
            strand.limits.wall_weight = (3.0 * strand.limits.wall_weight).min(40.0);
        }
        if flaws.bend > 0.0 {
            strand.limits.bend_weight = (4.0 * strand.limits.bend_weight).min(200.0);
            strand.limits.curvature /= 1.0 + flaws.bend.min(0.02);
        }
    }
    for contact in &faults.contacts {
        for k in contact.strands {
            strands[k].margin = (strands[k].margin + 0.25 * (apart - contact.distance).min(0.1)).min(0.06);
        }
    }
}

/// Watches where a limit is broken, and what lies beside it: on a course that slides along itself a single place escapes.
fn watch(strand: &mut Strand, flaws: &Flaws) {
    const BESIDE: i32 = 3;
    strand.watched.add(flaws);
    if flaws.lack > 0.0 && flaws.lack.is_finite() {
        let step = 1.0 / (16.0 * strand.course.points.len() as f64);
        let beside = (-BESIDE..=BESIDE).filter(|k| *k != 0).map(|k| flaws.place + f64::from(k) * step);
        strand.watched.walls.extend(beside.filter(|place| (0.0..=1.0).contains(place)));
    }
}

/// Settles all fibres once more from where every limit is kept; what then breaks one is undone.
pub fn polish(world: &World, strands: &mut [Strand], params: &Params) {
    let before = strands.to_vec();
    let loss = |strands: &[Strand]| strands.iter().fold(0.0, |sum, s| sum + loss_of(world, &s.course));
    let steps = MinimiseOptions { iterations: 100, least_gain: 1e-4, patience: 10, longest_step: 0.5 };
    let apart = Apart { distance: params.apart() + APART_MARGIN, weight: 3.0 };
    settle(world, strands, apart, steps);
    if !Faults::of(world, strands, params.apart()).none() || loss(strands) > loss(&before) {
        strands.clone_from_slice(&before);
    }
}
