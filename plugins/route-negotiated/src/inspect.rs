//! What is still wrong with a routing: contacts between patterns, and limits that single fibres break.

use crate::gaps::{Chords, Contact, contacts};
use crate::joint::Strand;
use fibar_geometry::alone::{Flaws, World, flaws};
use fibar_geometry::pieces;
use rayon::prelude::*;

/// Everything that is wrong; nothing here is sampled.
pub struct Faults {
    /// Pairs of strands that are too close.
    pub contacts: Vec<Contact>,
    /// What each strand breaks of its own limits.
    pub flaws: Vec<Flaws>,
    chords: Vec<Chords>,
}

impl Faults {
    /// Looks at all strands; axes of two patterns have to be `apart` mm from each other.
    pub fn of(world: &World, strands: &[Strand], apart: f64) -> Faults {
        let looks: Vec<(Chords, Flaws)> = strands.par_iter().map(|strand| look(world, strand)).collect();
        let (chords, flaws): (Vec<Chords>, Vec<Flaws>) = looks.into_iter().unzip();
        Faults { contacts: contacts(&chords, apart, |_| true), flaws, chords }
    }

    /// Looks again, at strands that have moved; the others are as they were.
    pub fn look_again(
        &mut self,
        world: &World,
        strands: &[Strand],
        moved: impl Fn(usize) -> bool + Sync,
        apart: f64,
    ) {
        let looks = strands.par_iter().enumerate().map(|(k, strand)| moved(k).then(|| look(world, strand)));
        let looks: Vec<Option<(Chords, Flaws)>> = looks.collect();
        for (k, look) in looks.into_iter().enumerate() {
            if let Some(look) = look {
                (self.chords[k], self.flaws[k]) = look;
            }
        }
        self.contacts.retain(|contact| !contact.strands.into_iter().any(&moved));
        self.contacts.extend(contacts(&self.chords, apart, |pair| pair.into_iter().any(&moved)));
        self.contacts.sort_by_key(|contact| [contact.strands[1], contact.strands[0]]);
    }

    /// Whether all limits are kept.
    pub fn none(&self) -> bool {
        self.contacts.is_empty() && self.flaws.iter().all(Flaws::none)
    }

    /// Strands that have to move, in order.
    pub fn strands(&self) -> Vec<usize> {
        let mut strands: Vec<usize> = self.contacts.iter().flat_map(|c| c.strands).collect();
        strands.extend((0..self.flaws.len()).filter(|&k| !self.flaws[k].none()));
        strands.sort_unstable();
        strands.dedup();
        strands
    }

    /// How much is wrong in all: lacking mm, and relative excess of bends tenfold.
    pub fn sum(&self, apart: f64) -> f64 {
        let lack = |f: &Flaws| f.lack.clamp(0.0, 10.0) + 10.0 * f.bend.clamp(0.0, 1.0);
        let own = self.flaws.iter().fold(0.0, |sum, f| sum + lack(f));
        self.contacts.iter().fold(own, |sum, c| sum + apart - c.distance)
    }
}

fn look(world: &World, strand: &Strand) -> (Chords, Flaws) {
    let pieces = pieces::of(&strand.course.points);
    (Chords::of(strand.pattern, &pieces), flaws(world, &pieces))
}
