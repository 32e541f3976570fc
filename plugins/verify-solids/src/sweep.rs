//! Along one line after the other: who is inside.

use crate::sum::{Spot, Sums};
use glam::{DVec2, DVec3};
use std::cmp::Ordering;

/// What a line enters or leaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Owner {
    /// A solid, by its place in the list.
    Part(u16),
    /// The object before anything was cut.
    Body,
    /// The hole of an LED, with some allowance.
    Hole,
}

/// A line enters or leaves something.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Event {
    /// Which line of the row.
    pub column: u32,
    /// Where on it, mm.
    pub x: f64,
    /// In, not out.
    pub enters: bool,
    /// What.
    pub owner: Owner,
    /// |cos| of the angle between the line and the surface's normal.
    pub slope: f32,
}

/// Surfaces no further apart than this coincide: rounding to single precision moves each by up to 8e-6 mm within 128 mm of
/// the origin and 1.5e-5 mm within 256 mm.
const COINCIDENCE_MM: f64 = 5e-5;

impl Event {
    /// By line, then along it; ties in an order that does not depend on how the events were found.
    pub fn order(&self, other: &Event) -> Ordering {
        let ties = || self.owner.cmp(&other.owner).then(self.enters.cmp(&other.enters));
        self.column.cmp(&other.column).then(self.x.total_cmp(&other.x)).then_with(ties)
    }
}

/// Adds up the lengths of one row's lines. `events` are in order.
pub fn sweep(events: &[Event], part_count: usize, place: impl Fn(u32) -> DVec2) -> Sums {
    let mut sums = Sums::default();
    let mut inside = Inside::new(part_count);
    for line in events.chunk_by(|a, b| a.column == b.column) {
        inside.clear();
        if !balanced(line, &mut inside) {
            sums.skipped_lines += 1;
            continue;
        }
        let place = place(line[0].column);
        for pair in line.windows(2) {
            inside.pass(&pair[0]);
            let [from, to] = [pair[0].x, pair[1].x];
            let spot = Spot { length: to - from, place: DVec3::new(0.5 * (from + to), place.x, place.y) };
            let thickness = spot.length * f64::from(pair[0].slope.max(pair[1].slope));
            inside.account(spot, thickness <= COINCIDENCE_MM, &mut sums);
        }
        inside.pass(&line[line.len() - 1]);
    }
    sums
}

/// Whether a line leaves everything as often as it enters it.
fn balanced(line: &[Event], inside: &mut Inside) -> bool {
    line.iter().for_each(|event| inside.pass(event));
    let balanced = inside.is_clear();
    inside.clear();
    balanced
}

/// How often the line is inside of what.
struct Inside {
    parts: Vec<i32>,
    body: i32,
    hole: i32,
    /// Number of parts that it is inside of.
    cover: usize,
}

impl Inside {
    fn new(part_count: usize) -> Inside {
        Inside { parts: vec![0; part_count], body: 0, hole: 0, cover: 0 }
    }

    fn clear(&mut self) {
        self.parts.fill(0);
        (self.body, self.hole, self.cover) = (0, 0, 0);
    }

    fn is_clear(&self) -> bool {
        self.parts.iter().all(|count| *count == 0) && [self.body, self.hole] == [0; 2]
    }

    fn pass(&mut self, event: &Event) {
        let step = if event.enters { 1 } else { -1 };
        match event.owner {
            Owner::Body => self.body += step,
            Owner::Hole => self.hole += step,
            Owner::Part(k) => {
                let count = &mut self.parts[k as usize];
                let was_inside = *count > 0;
                *count += step;
                match (was_inside, *count > 0) {
                    (false, true) => self.cover += 1,
                    (true, false) => self.cover -= 1,
                    _ => {}
                }
            }
        }
    }

    fn account(&self, spot: Spot, coincident: bool, sums: &mut Sums) {
        if coincident {
            return;
        }
        let in_body = self.body > 0;
        if self.cover > 1 {
            sums.overlap.add(spot, self.pair());
        }
        if self.cover == 0 && in_body && self.hole == 0 {
            sums.gap.add(spot, None);
        }
        if self.cover > 0 && !in_body {
            sums.outside.add(spot, self.pair());
        }
    }

    /// The first two parts that the line is inside of; the first one twice if it is alone.
    fn pair(&self) -> Option<(usize, usize)> {
        let mut inside = self.parts.iter().enumerate().filter(|(_, count)| **count > 0).map(|(k, _)| k);
        let first = inside.next()?;
        Some((first, inside.next().unwrap_or(first)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use Owner::{Body, Hole, Part};

    fn line(stretches: &[(Owner, f64, f64)]) -> Vec<Event> {
        let event = |owner, x, enters| Event { column: 0, x, enters, owner, slope: 1.0 };
        let both =
            |&(owner, from, to): &(Owner, f64, f64)| [event(owner, from, true), event(owner, to, false)];
        let mut events: Vec<Event> = stretches.iter().flat_map(both).collect();
        events.sort_unstable_by(Event::order);
        events
    }

    #[track_caller]
    fn check(stretches: &[(Owner, f64, f64)], [overlap, gap, outside]: [f64; 3]) {
        let found = sweep(&line(stretches), 2, |_| DVec2::ZERO);
        let lengths = [found.overlap.length, found.gap.length, found.outside.length];
        assert_eq!(lengths, [overlap, gap, outside]);
        assert_eq!(found.skipped_lines, 0);
    }

    #[test]
    fn stretches_are_told_apart() {
        check(&[(Body, 0.0, 8.0), (Part(0), 0.0, 4.0), (Part(1), 4.0, 8.0)], [0.0; 3]);
        check(&[(Body, 0.0, 8.0), (Part(0), 0.0, 5.0), (Part(1), 4.0, 8.0)], [1.0, 0.0, 0.0]);
        check(&[(Body, 0.0, 8.0), (Part(0), 0.0, 3.0), (Part(1), 5.0, 8.0)], [0.0, 2.0, 0.0]);
        check(&[(Body, 0.0, 8.0), (Part(0), -1.0, 4.0), (Part(1), 4.0, 9.5)], [0.0, 0.0, 2.5]);
        check(&[(Body, 0.0, 8.0), (Part(0), 0.0, 3.0), (Hole, 2.5, 5.5), (Part(1), 5.0, 8.0)], [0.0; 3]);
    }

    #[test]
    fn faces_that_coincide_do_not_count() {
        let crack = 1e-5;
        check(&[(Body, 0.0, 8.0), (Part(0), 0.0, 4.0 + crack), (Part(1), 4.0, 8.0)], [0.0; 3]);
        check(&[(Body, 0.0, 8.0), (Part(0), 0.0, 4.0 - crack), (Part(1), 4.0, 8.0 + crack)], [0.0; 3]);
    }

    #[test]
    fn a_line_that_does_not_come_out_again_is_skipped() {
        let mut events = line(&[(Body, 0.0, 8.0), (Part(0), 0.0, 4.0)]);
        events.remove(2);
        assert_eq!(sweep(&events, 2, |_| DVec2::ZERO).skipped_lines, 1);
    }
}
