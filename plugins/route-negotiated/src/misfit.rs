//! Why fibres do not fit: the diagnosis.

use crate::gaps::Contact;
use crate::inspect::Faults;
use crate::neck::{Neck, Sizes, Way};
use crate::nets::Net;
use crate::params::Params;
use crate::remedy::Remedies;
use crate::{neck, trunks};
use fibar_core::MarkerId;
use fibar_geometry::alone::World;
use fibar_geometry::course::Course;
use fibar_plugin::StageError;
use glam::DVec3;
use std::collections::BTreeSet;

/// What did not fit.
pub enum Misfit {
    /// Something that is wrong before any routing: a place where no fibre can start or end, or that none reaches.
    Place(StageError),
    /// A cross-section with room for fewer patterns than want to pass.
    Neck(Box<Neck>),
    /// What routing could not mend.
    Crowd(Crowding),
}

/// Why there is no routing.
pub enum Unfit {
    /// The fibres do not fit.
    Misfit(Box<Misfit>),
    /// The work ended for another reason.
    Ended(StageError),
}

impl From<StageError> for Unfit {
    fn from(error: StageError) -> Unfit {
        Unfit::Ended(error)
    }
}

impl From<Misfit> for Unfit {
    fn from(misfit: Misfit) -> Unfit {
        Unfit::Misfit(Box::new(misfit))
    }
}

/// Fibres that stay too close, or break limits of their own.
pub struct Crowding {
    /// How many fibres break a limit, alone or in pairs.
    pub at_fault: usize,
    /// Pairs that stay too close.
    pairs: usize,
    /// Where they do, fullest first.
    jams: Vec<Jam>,
    /// Markers whose fibres break a limit of their own.
    strained: Vec<MarkerId>,
    /// Distance that axes have to keep, mm.
    apart: f64,
    /// Without these the others were routed, if that was tried.
    pub without: Option<Vec<MarkerId>>,
}

/// Pairs that stay too close about one place.
struct Jam {
    place: DVec3,
    pairs: usize,
    least: f64,
    markers: BTreeSet<MarkerId>,
    /// The cross-section there.
    section: Option<Neck>,
}

/// Contacts within this belong to one jam, mm.
const JAM_MM: f64 = 15.0;

impl Crowding {
    /// What is wrong with these courses, each with the number of its net.
    pub fn of(
        world: &World,
        nets: &[Net],
        courses: &[(usize, Course)],
        faults: &Faults,
        params: &Params,
    ) -> Crowding {
        let marker = |strand: usize| nets[courses[strand].0].marker;
        let strained = (0..courses.len()).filter(|&k| !faults.flaws[k].none()).map(marker).collect();
        let ways: Vec<Way> =
            courses.iter().map(|(net, course)| trunks::way(world, &nets[*net], course)).collect();
        let sizes = Sizes { radius: params.black_radius_mm, clearance: params.clearance_mm };
        let mut jams: Vec<Jam> = jams(&faults.contacts)
            .into_iter()
            .map(|contacts| {
                let first = contacts[0];
                let section = ways[first.strands[0]].plane_near(first.place);
                Jam {
                    place: first.place,
                    pairs: contacts.len(),
                    least: first.distance,
                    markers: contacts.iter().flat_map(|c| c.strands).map(marker).collect(),
                    section: section
                        .map(|plane| neck::at(world.room, plane, &ways, sizes))
                        .filter(|neck| neck.through.len() > 1),
                }
            })
            .collect();
        jams.sort_by_key(|jam| std::cmp::Reverse(jam.pairs));
        Crowding {
            at_fault: faults.strands().len(),
            pairs: faults.contacts.len(),
            jams,
            strained,
            apart: params.apart(),
            without: None,
        }
    }
}

/// Contacts by place, closest first within each.
fn jams(contacts: &[Contact]) -> Vec<Vec<Contact>> {
    let mut sorted = contacts.to_vec();
    sorted.sort_by(|a, b| a.distance.total_cmp(&b.distance).then(a.strands.cmp(&b.strands)));
    let mut jams: Vec<Vec<Contact>> = vec![];
    for contact in sorted {
        match jams.iter_mut().find(|jam| jam[0].place.distance(contact.place) <= JAM_MM) {
            Some(jam) => jam.push(contact),
            None => jams.push(vec![contact]),
        }
    }
    jams
}

impl Misfit {
    /// As an error; the hint says what was tried and fits, or what could be tried.
    pub fn error(&self, remedies: &Remedies, params: &Params) -> StageError {
        let message = self.message(params);
        let error = match self {
            Misfit::Place(error) => return remedies.add_to(error.clone()),
            Misfit::Neck(neck) => StageError::input(message).place_mm(neck.place.to_array()),
            Misfit::Crowd(crowding) => match crowding.jams.first() {
                Some(jam) => StageError::input(message).place_mm(jam.place.to_array()),
                None => StageError::input(message),
            },
        };
        remedies.add_to(error.hint(
            "fewer markers, further apart, given to LEDs that are nearer (bound-light before assign-covering), \
             effort = \"thorough\", or less clearance_mm or wall_mm",
        ))
    }

    /// What does not fit, and where.
    pub fn message(&self, params: &Params) -> String {
        let diameter = params.diameter();
        match self {
            Misfit::Place(error) => error.to_string(),
            Misfit::Neck(neck) => format!(
                "the fibres do not fit: through the neck at {}, {}; of Ø {diameter:.2} mm, one for each pattern, {} have room",
                at(neck.place),
                section(neck),
                neck.capacity
            ),
            Misfit::Crowd(crowding) => {
                format!("the fibres of Ø {diameter:.2} mm do not fit: {}", crowding.text())
            }
        }
    }

    /// Beyond this outer diameter nothing fits, as far as is known, mm.
    pub fn bound_mm(&self, params: &Params) -> f64 {
        match self {
            Misfit::Neck(neck) => neck.largest_diameter.min(params.diameter()),
            _ => params.diameter(),
        }
    }
}

impl Crowding {
    /// The same, with markers without which the others were routed.
    pub fn fits_without(self, without: Option<Vec<MarkerId>>) -> Crowding {
        Crowding { without, ..self }
    }

    fn text(&self) -> String {
        const SHOWN: usize = 3;
        let mut parts: Vec<String> = vec![];
        if self.pairs > 0 {
            let jam = |jam: &Jam| {
                let passing =
                    jam.section.as_ref().map_or(String::new(), |neck| format!("; there {}", section(neck)));
                format!(
                    "around {} {} of them, of markers {} (closest {:.3} mm between axes instead of {:.2}){passing}",
                    at(jam.place),
                    jam.pairs,
                    list(&jam.markers),
                    jam.least,
                    self.apart
                )
            };
            let jams: Vec<String> = self.jams.iter().take(SHOWN).map(jam).collect();
            let more = match self.jams.len().saturating_sub(SHOWN) {
                0 => String::new(),
                more => format!(", and at {more} more places"),
            };
            let pairs = match self.pairs {
                1 => "1 pair of different patterns stays".into(),
                many => format!("{many} pairs of different patterns stay"),
            };
            parts.push(format!("{pairs} too close: {}{more}", jams.join("; ")));
        }
        if !self.strained.is_empty() {
            parts.push(format!(
                "those of {} bend too tightly or come too close to the skin",
                named(&self.strained)
            ));
        }
        parts.join("; ")
    }
}

/// An error for markers that not even a fibre alone reaches.
pub fn unreachable(world: &World, missing: &[&Net]) -> StageError {
    let pairs: Vec<String> =
        missing.iter().map(|net| format!("marker {} from LED {}", net.marker, net.led)).collect();
    let error = StageError::input(format!(
        "no fibre reaches {}, with bends of {} mm or more and {} mm to the skin",
        pairs.join(", "),
        world.min_bend_radius,
        world.room.keeping().wall
    ))
    .hint("place them elsewhere or give them to another LED (bounds.json of bound-light says which); leave them out with on_misfit = \"drop\", or lower min_bend_radius_mm");
    match missing.first() {
        Some(net) => error.place_mm(net.ends.marker.to_array()),
        None => error,
    }
}

fn section(neck: &Neck) -> String {
    let fibres: usize = neck.through.values().map(Vec::len).sum();
    format!(
        "{:.0} mm² of free cross-section, {fibres} fibres of {} patterns want to pass",
        neck.area,
        neck.through.len()
    )
}

fn at(place: DVec3) -> String {
    format!("({:.1}, {:.1}, {:.1}) mm", place.x, place.y, place.z)
}

/// The markers of the patterns that have no room; those with most markers beyond the neck pass.
pub fn beyond_capacity(neck: &Neck) -> Vec<MarkerId> {
    let mut patterns: Vec<&Vec<MarkerId>> = neck.through.values().collect();
    patterns.sort_by_key(|markers| std::cmp::Reverse(markers.len()));
    let mut markers: Vec<MarkerId> = patterns.into_iter().skip(neck.capacity).flatten().copied().collect();
    markers.sort_unstable();
    markers
}

/// One marker or several, for a message.
pub fn named(markers: &[MarkerId]) -> String {
    match markers {
        [one] => format!("marker {one}"),
        many => format!("the {} markers {}", many.len(), list(many)),
    }
}

fn list<'a>(markers: impl IntoIterator<Item = &'a MarkerId>) -> String {
    markers.into_iter().map(MarkerId::to_string).collect::<Vec<_>>().join(", ")
}
