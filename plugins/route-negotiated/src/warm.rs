//! A routing that starts from an earlier one: what still fits stays to the bit, the rest finds its way between.
//!
//! If that keeps no limits, the earlier fibres that are in the way are routed anew, too, more each time; at last all are.

use crate::crowd::Crowd;
use crate::inspect::Faults;
use crate::joint::Strand;
use crate::misfit::Unfit;
use crate::negotiate::{self, Outcome, finish, make_room, place_mouths, polish, reach};
use crate::nets::Net;
use crate::params::Params;
use crate::reroute::{Alone, loss_of};
use fibar_geometry::alone::World;
use fibar_geometry::course::Course;
use fibar_geometry::passage::Passages;
use fibar_plugin::{Job, StageError};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::OnceLock;

/// So often earlier fibres are released before all are.
const WIDENINGS: u32 = 6;
/// Who loses this much more than alone (a seventh of its range) has what is in its way released.
const MUCH: f64 = 0.3;

/// What is known of the nets.
struct Courses {
    /// Earlier courses that stay, by net.
    kept: BTreeMap<usize, Course>,
    /// Best courses alone of nets that are routed anew; none of one that cannot be reached.
    alone: BTreeMap<usize, Option<Course>>,
}

/// One try with some courses held.
struct Attempt {
    nets: Vec<usize>,
    strands: Vec<Strand>,
    alone: Vec<Alone>,
    fits: bool,
}

/// Routes all nets; `earlier` has the earlier course of each, where there is one.
pub fn route(
    world: &World,
    passages: &OnceLock<Passages>,
    nets: &[Net],
    earlier: Vec<Option<Course>>,
    params: &Params,
    job: &mut Job,
) -> Result<Outcome, Unfit> {
    let kept = keeping_limits(world, nets, earlier, params);
    let mut courses = Courses { kept, alone: BTreeMap::new() };
    let mut best: Option<Attempt> = None;
    for _ in 0..=WIDENINGS {
        if courses.kept.is_empty() {
            break;
        }
        courses.look_alone(world, passages, nets, params, job)?;
        let tried = attempt(world, nets, &courses, params, job)?;
        let release = if tried.fits { tried.costly(world, params) } else { tried.in_the_way(world, params) };
        let last = best.is_some() || release.is_empty();
        if tried.fits {
            best = Some(match best {
                Some(before) if before.loss(world) <= tried.loss(world) => before,
                _ => tried,
            });
        }
        if last || 2 * (nets.len() - courses.kept.len() + release.len()) > nets.len() {
            break;
        }
        job.log("info", &format!("{} earlier fibres are in the way and routed anew", release.len()));
        courses.kept.retain(|net, _| !release.contains(net));
    }
    match best {
        Some(best) => Ok(best.outcome()),
        None => {
            job.log("info", "all fibres are routed anew");
            negotiate::route(world, passages, nets, params, job)
        }
    }
}

/// The earlier courses that keep all limits, those of this run.
fn keeping_limits(
    world: &World,
    nets: &[Net],
    earlier: Vec<Option<Course>>,
    params: &Params,
) -> BTreeMap<usize, Course> {
    let all: Vec<(usize, Course)> =
        earlier.into_iter().enumerate().filter_map(|(net, course)| Some((net, course?))).collect();
    let strands: Vec<Strand> =
        all.iter().map(|(net, course)| negotiate::strand(&nets[*net], course, params)).collect();
    let faulty = Faults::of(world, &strands, params.apart()).strands();
    let sound = all.into_iter().enumerate().filter(|(k, _)| faulty.binary_search(k).is_err());
    sound.map(|(_, kept)| kept).collect()
}

impl Courses {
    /// Finds the best course alone of the nets that have none and keep none.
    fn look_alone(
        &mut self,
        world: &World,
        passages: &OnceLock<Passages>,
        nets: &[Net],
        params: &Params,
        job: &mut Job,
    ) -> Result<(), Unfit> {
        let is_new = |net: &usize| !self.kept.contains_key(net) && !self.alone.contains_key(net);
        let new: Vec<usize> = (0..nets.len()).filter(is_new).collect();
        if new.is_empty() {
            return Ok(());
        }
        let some: Vec<Net> = new.iter().map(|net| nets[*net]).collect();
        let found: BTreeMap<usize, Course> =
            reach(world, passages, &some, params, job)?.into_iter().collect();
        let alone = new.iter().enumerate().map(|(k, net)| (*net, found.get(&k).cloned()));
        self.alone.extend(alone);
        Ok(())
    }

    /// The course that a net keeps or starts from, and whether it keeps it.
    fn of(&self, net: usize) -> Option<(&Course, bool)> {
        let kept = self.kept.get(&net).map(|course| (course, true));
        kept.or_else(|| Some((self.alone.get(&net)?.as_ref()?, false)))
    }
}

fn attempt(
    world: &World,
    nets: &[Net],
    courses: &Courses,
    params: &Params,
    job: &mut Job,
) -> Result<Attempt, StageError> {
    let members: Vec<usize> = (0..nets.len()).filter(|&net| courses.of(net).is_some()).collect();
    let strand = |&net: &usize| {
        let (course, kept) = courses.of(net)?;
        Some(Strand { kept, held: kept, ..negotiate::strand(&nets[net], course, params) })
    };
    let mut strands: Vec<Strand> = members.iter().filter_map(strand).collect();
    if strands.iter().all(|strand| strand.kept) {
        return Ok(Attempt { nets: members, strands, alone: vec![], fits: true });
    }
    place_mouths(&mut strands, params);
    let alone = make_room(world, &mut strands, false, params, job)?;
    let kept = strands.iter().any(|strand| strand.kept);
    let rounds = if kept { negotiate::ROUNDS_AMONG_KEPT } else { negotiate::ROUNDS };
    let fits = finish(world, &mut strands, &alone, rounds, params, job)?;
    if fits {
        polish(world, &mut strands, params);
    }
    Ok(Attempt { nets: members, strands, alone, fits })
}

impl Attempt {
    fn outcome(self) -> Outcome {
        let kept = self.strands.iter().filter(|strand| strand.kept).count();
        let courses = self.nets.into_iter().zip(self.strands.into_iter().map(|strand| strand.course));
        Outcome { courses: courses.collect(), kept }
    }

    fn loss(&self, world: &World) -> f64 {
        self.strands.iter().fold(0.0, |sum, strand| sum + loss_of(world, &strand.course))
    }

    /// Nets whose earlier courses make another one lose much.
    fn costly(&self, world: &World, params: &Params) -> BTreeSet<usize> {
        let loses = |&k: &usize| {
            let strand = &self.strands[k];
            !strand.kept && loss_of(world, &strand.course) > self.alone[k].loss + MUCH
        };
        let losers: Vec<usize> = (0..self.alone.len()).filter(loses).collect();
        self.blockers(world, &losers, params)
    }

    /// Nets whose earlier courses touch one that breaks a limit, or stand in its best way.
    fn in_the_way(&self, world: &World, params: &Params) -> BTreeSet<usize> {
        let faults = Faults::of(world, &self.strands, params.apart());
        let at_fault: Vec<usize> = faults.strands().into_iter().filter(|k| !self.strands[*k].kept).collect();
        let touching = faults.contacts.iter().flat_map(|contact| contact.strands);
        let touching = touching.filter(|&k| self.strands[k].kept).map(|k| self.nets[k]);
        touching.chain(self.blockers(world, &at_fault, params)).collect()
    }

    /// Nets whose earlier courses come too close to the best courses alone of these strands.
    fn blockers(&self, world: &World, strands: &[usize], params: &Params) -> BTreeSet<usize> {
        let mut crowd = Crowd::within(world.room.surface().bounds());
        let kept: Vec<usize> = (0..self.strands.len()).filter(|&k| self.strands[k].kept).collect();
        kept.iter().for_each(|&k| crowd.push(self.strands[k].segments(world)));
        let mut blockers = BTreeSet::new();
        for &k in strands {
            let alone = Strand { course: self.alone[k].course.clone(), ..self.strands[k].clone() };
            for segment in alone.segments(world) {
                crowd.for_each_near(&segment, params.apart(), |[fibre, _], other| {
                    if segment.push(other, params.apart(), 1.0).is_some() {
                        blockers.insert(self.nets[kept[fibre as usize]]);
                    }
                });
            }
        }
        blockers
    }
}
