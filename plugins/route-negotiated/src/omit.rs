//! Fibres that do not find together: some are taken out, and put back where there is room then.
//!
//! Those most at fault go, the others settle anew from where they were before limits were asked for, until every limit is kept. Then each
//! that went looks for a way among those that stayed. Often all are back in the end; if not, the markers of the rest are left out.

use crate::inspect::Faults;
use crate::joint::Strand;
use crate::misfit::Crowding;
use crate::negotiate::{self, Outcome, finish};
use crate::nets::Net;
use crate::params::Params;
use crate::reroute::Alone;
use fibar_core::MarkerId;
use fibar_geometry::alone::{Watched, World};
use fibar_geometry::course::Course;
use fibar_plugin::{Job, StageError};
use std::collections::{BTreeMap, BTreeSet};

/// A routing under way; all lists in the same order.
pub struct Routing {
    /// Numbers of the nets.
    pub nets: Vec<usize>,
    /// Their courses as they are now.
    pub strands: Vec<Strand>,
    /// As they had settled, before limits were asked for.
    pub settled: Vec<Strand>,
    /// What they were before they met.
    pub alone: Vec<Alone>,
}

impl Routing {
    /// Every course with the number of its net.
    pub fn outcome(self) -> Outcome {
        let courses = self.strands.into_iter().map(|strand| strand.course);
        Outcome { courses: self.nets.into_iter().zip(courses).collect(), kept: 0 }
    }

    /// What is wrong with it.
    pub fn crowding(&self, world: &World, nets: &[Net], params: &Params) -> Crowding {
        let faults = Faults::of(world, &self.strands, params.apart());
        let courses = self.strands.iter().map(|strand| strand.course.clone());
        let courses: Vec<(usize, Course)> = self.nets.iter().copied().zip(courses).collect();
        Crowding::of(world, nets, &courses, &faults, params)
    }

    /// Takes fibres out until the others keep every limit, then each in again that then fits. The markers that are left out, in order:
    /// none, if that has sorted them; `None` if nothing would be left.
    pub fn thin_out(
        &mut self,
        world: &World,
        nets: &[Net],
        params: &Params,
        job: &mut Job,
    ) -> Result<Option<Vec<MarkerId>>, StageError> {
        let mut out: Vec<(usize, Alone)> = vec![];
        loop {
            let faults = Faults::of(world, &self.strands, params.apart());
            if faults.none() {
                break;
            }
            let worst = worst(&faults, params.apart());
            if worst.len() == self.strands.len() {
                return Ok(None);
            }
            for k in worst.into_iter().rev() {
                self.settled.remove(k);
                out.push((self.nets.remove(k), self.alone.remove(k)));
            }
            negotiate::settle_anew(world, &mut self.settled, params);
            self.strands = self.settled.clone();
            self.finish(world, negotiate::ROUNDS, params, job)?;
        }
        let mut left_out: Vec<MarkerId> = vec![];
        for (net, alone) in out.into_iter().rev() {
            if !self.takes_in(world, (net, &nets[net]), alone, params, job)? {
                left_out.push(nets[net].marker);
            }
        }
        left_out.sort_unstable();
        Ok(Some(left_out))
    }

    /// Takes a fibre in again if with it, too, every limit can be kept.
    fn takes_in(
        &mut self,
        world: &World,
        (number, net): (usize, &Net),
        alone: Alone,
        params: &Params,
        job: &mut Job,
    ) -> Result<bool, StageError> {
        let at = self.nets.partition_point(|other| *other < number);
        let before = self.strands.clone();
        self.strands.insert(at, negotiate::put_among(world, &self.strands, net, &alone.course, params));
        self.alone.insert(at, alone);
        self.nets.insert(at, number);
        let fits = self.finish(world, negotiate::ROUNDS_FOR_ONE, params, job)?;
        if !fits {
            self.strands = before;
            self.alone.remove(at);
            self.nets.remove(at);
        }
        Ok(fits)
    }

    /// Moves what breaks a limit, with its limits as they were at first.
    fn finish(
        &mut self,
        world: &World,
        rounds: u32,
        params: &Params,
        job: &mut Job,
    ) -> Result<bool, StageError> {
        for k in Faults::of(world, &self.strands, params.apart()).strands() {
            let strand = &mut self.strands[k];
            let limits = negotiate::limits(params);
            *strand = Strand { margin: 0.0, limits, watched: Watched::default(), ..strand.clone() };
        }
        finish(world, &mut self.strands, &self.alone, rounds, params, job)
    }
}

/// The strand most at fault of every jam, in order: what is in contact, through others too, is one.
fn worst(faults: &Faults, apart: f64) -> Vec<usize> {
    let mut blame: BTreeMap<usize, f64> = BTreeMap::new();
    for contact in &faults.contacts {
        for strand in contact.strands {
            *blame.entry(strand).or_default() += apart - contact.distance;
        }
    }
    for k in faults.strands() {
        let flaws = &faults.flaws[k];
        *blame.entry(k).or_default() += flaws.lack.clamp(0.0, apart) + apart * flaws.bend.clamp(0.0, 1.0);
    }
    let mut order: Vec<usize> = blame.keys().copied().collect();
    order.sort_by(|a, b| blame[b].total_cmp(&blame[a]).then(a.cmp(b)));
    let mut jammed: BTreeSet<usize> = BTreeSet::new();
    let mut worst: Vec<usize> = vec![];
    for k in order {
        if !jammed.contains(&k) {
            worst.push(k);
            jammed.extend(in_contact(k, faults));
        }
    }
    worst.sort_unstable();
    worst
}

/// A strand and all that are in contact with it, through others too.
fn in_contact(strand: usize, faults: &Faults) -> BTreeSet<usize> {
    let mut found = BTreeSet::from([strand]);
    let mut open = vec![strand];
    while let Some(k) = open.pop() {
        for [a, b] in faults.contacts.iter().map(|contact| contact.strands).filter(|pair| pair.contains(&k)) {
            let other = if a == k { b } else { a };
            if found.insert(other) {
                open.push(other);
            }
        }
    }
    found
}
