//! Why fibres do not fit, and what would: the diagnosis.

use crate::inspect::Faults;
use crate::neck::{Neck, Sizes};
use crate::nets::Net;
use crate::params::Params;
use fibar_core::MarkerId;
use fibar_geometry::alone::World;
use fibar_geometry::course::Course;
use fibar_plugin::StageError;
use glam::DVec3;
use std::collections::BTreeMap;

/// What did not fit.
pub struct Misfit {
    /// The fullest cross-section, if it is too full.
    neck: Option<Neck>,
    /// Pairs that stayed too close, and where the closest are.
    contacts: usize,
    place: Option<DVec3>,
    /// Markers whose fibres break a limit of their own.
    strained: Vec<MarkerId>,
    sizes: Sizes,
    /// Without these markers the others should fit.
    pub leave_out: Vec<MarkerId>,
}

impl Misfit {
    /// A neck with room for fewer patterns than want to pass.
    pub fn of_neck(neck: Neck, sizes: Sizes) -> Misfit {
        let leave_out = beyond_capacity(&neck);
        Misfit { neck: Some(neck), contacts: 0, place: None, strained: vec![], sizes, leave_out }
    }

    /// What routing could not mend.
    pub fn of_faults(nets: &[Net], courses: &[(usize, Course)], faults: &Faults, params: &Params) -> Misfit {
        let marker = |strand: usize| nets[courses[strand].0].marker;
        let strained = (0..courses.len()).filter(|&k| !faults.flaws[k].none()).map(marker).collect();
        let closest = faults.contacts.iter().min_by(|a, b| a.distance.total_cmp(&b.distance));
        Misfit {
            neck: None,
            contacts: faults.contacts.len(),
            place: closest.map(|c| c.place),
            strained,
            sizes: Sizes { radius: params.black_radius_mm, clearance: params.clearance_mm },
            leave_out: vec![marker(most_at_fault(faults))],
        }
    }

    /// As an error with what to try.
    pub fn error(&self) -> StageError {
        let names = list(&self.leave_out);
        match &self.neck {
            Some(neck) => {
                let diameter = 2.0 * self.sizes.radius;
                let thinner = if neck.largest_diameter > 0.0 {
                    format!("fibres of {:.2} mm would all pass", neck.largest_diameter)
                } else {
                    "no fibre is thin enough for all to pass".into()
                };
                StageError::input(format!("the fibres do not fit: {}", describe(neck, diameter)))
                    .hint(format!("{thinner}; of {diameter:.2} mm all pass without markers {names} (on_misfit = \"drop\")"))
                    .place_mm(neck.place.to_array())
            }
            None => {
                let strained = match self.strained.as_slice() {
                    [] => String::new(),
                    some => format!(
                        "; those of markers {} bend too tightly or come too close to the skin",
                        list(some)
                    ),
                };
                let error = StageError::input(format!(
                    "the fibres do not fit: {} pairs of different patterns stay too close{strained}",
                    self.contacts
                ))
                .hint(format!("leave out marker {names} (on_misfit = \"drop\"), try effort = \"thorough\", or lower clearance_mm or wall_mm"));
                match self.place {
                    Some(place) => error.place_mm(place.to_array()),
                    None => error,
                }
            }
        }
    }

    /// What is left out, for the log.
    pub fn dropping(&self) -> String {
        let names = list(&self.leave_out);
        match &self.neck {
            Some(neck) => {
                format!("markers {names} are left out: {}", describe(neck, 2.0 * self.sizes.radius))
            }
            None => format!("markers {names} are left out: their fibres find no way between the others"),
        }
    }
}

/// An error for markers that not even a fibre alone reaches.
pub fn unreachable(world: &World, message: &str) -> StageError {
    StageError::input(format!(
        "{message}, with bends of {} mm or more and {} mm to the skin",
        world.min_bend_radius,
        world.room.keeping().wall
    ))
    .hint("place them elsewhere or give them to another LED (bounds.json of bound-light says which); leave them out with on_misfit = \"drop\", or lower min_bend_radius_mm")
}

fn describe(neck: &Neck, diameter: f64) -> String {
    let fibres: usize = neck.through.values().map(Vec::len).sum();
    format!(
        "through the neck at ({:.1}, {:.1}, {:.1}) mm, {:.0} mm² of free cross-section, {fibres} fibres of {} patterns want to pass; \
         of Ø {diameter:.2} mm, one for each pattern, {} have room",
        neck.place.x,
        neck.place.y,
        neck.place.z,
        neck.area,
        neck.through.len(),
        neck.capacity
    )
}

/// The markers of the patterns that have no room; those with most markers beyond the neck pass.
fn beyond_capacity(neck: &Neck) -> Vec<MarkerId> {
    let mut patterns: Vec<&Vec<MarkerId>> = neck.through.values().collect();
    patterns.sort_by_key(|markers| std::cmp::Reverse(markers.len()));
    let mut markers: Vec<MarkerId> = patterns.into_iter().skip(neck.capacity).flatten().copied().collect();
    markers.sort_unstable();
    markers
}

/// The strand with most contacts; without any, the first that breaks a limit of its own.
fn most_at_fault(faults: &Faults) -> usize {
    let mut counts: BTreeMap<usize, usize> = BTreeMap::new();
    for strand in faults.contacts.iter().flat_map(|c| c.strands) {
        *counts.entry(strand).or_default() += 1;
    }
    let most = counts.iter().max_by_key(|(strand, count)| (**count, std::cmp::Reverse(**strand)));
    most.map(|(strand, _)| *strand).or_else(|| faults.strands().first().copied()).unwrap_or(0)
}

fn list(markers: &[MarkerId]) -> String {
    markers.iter().map(MarkerId::to_string).collect::<Vec<_>>().join(", ")
}
