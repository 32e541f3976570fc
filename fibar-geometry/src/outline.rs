//! Whether directed sides in a plane go around every point at most once: they meet at ends only, and whoever comes from below passes
//! them turn and turn about. By a sweep (Shamos & Hoey 1976) with exact predicates (Shewchuk 1997).

use glam::DVec2;
use robust::{Coord, orient2d};
use std::cmp::Ordering;

/// For the outline of triangles that all turn counter-clockwise: whether no two of them overlap. A chain of triangles covers a point
/// as often as its outline goes around it. May say no where they touch.
pub fn goes_around_once(sides: &[[u32; 2]], place: impl Fn(u32) -> DVec2) -> bool {
    let mut sweep =
        Sweep { sides: sides.iter().map(|&side| Side::of(side, &place)).collect(), active: Vec::new() };
    let mut events: Vec<Event> =
        sweep.sides.iter().zip(0..).flat_map(|(side, number)| side.events(number)).collect();
    events.sort_unstable_by(|a, b| before(a.place, b.place).then(a.side.cmp(&b.side)));
    events.chunk_by(|a, b| a.place == b.place).all(|here| sweep.passes(here))
}

/// Along x, then along y.
fn before(a: DVec2, b: DVec2) -> Ordering {
    a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y))
}

/// A side from its left to its right end.
struct Side {
    vertices: [u32; 2],
    ends: [DVec2; 2],
    /// Whether the outline runs along it from left to right: what it goes around lies above.
    is_floor: bool,
}

/// One end of a side.
struct Event {
    place: DVec2,
    vertex: u32,
    side: u32,
    begins: bool,
}

impl Side {
    fn of([from, to]: [u32; 2], place: impl Fn(u32) -> DVec2) -> Side {
        let [a, b] = [place(from), place(to)];
        match before(a, b) {
            Ordering::Less => Side { vertices: [from, to], ends: [a, b], is_floor: true },
            _ => Side { vertices: [to, from], ends: [b, a], is_floor: false },
        }
    }

    fn events(&self, side: u32) -> [Event; 2] {
        [0, 1].map(|end| Event { place: self.ends[end], vertex: self.vertices[end], side, begins: end == 0 })
    }

    /// Positive if the point lies above, or left of a side that stands upright.
    fn height(&self, point: DVec2) -> f64 {
        let coord = |p: DVec2| Coord { x: p.x, y: p.y };
        orient2d(coord(self.ends[0]), coord(self.ends[1]), coord(point))
    }
}

struct Sweep {
    sides: Vec<Side>,
    /// The sides that the sweep passes, from below.
    active: Vec<u32>,
}

impl Sweep {
    /// Passes the ends at a place; false if something is wrong there.
    fn passes(&mut self, here: &[Event]) -> bool {
        let (place, vertex) = (here[0].place, here[0].vertex);
        if here.iter().any(|event| event.vertex != vertex) {
            return false;
        }
        let side = |number: u32| &self.sides[number as usize];
        let first = self.active.partition_point(|&number| side(number).height(place) > 0.0);
        let touching =
            self.active[first..].iter().take_while(|&&number| side(number).height(place) == 0.0).count();
        let ends = |&&number: &&u32| side(number).vertices[1] == vertex;
        let ending = here.iter().filter(|event| !event.begins).count();
        if touching != ending || self.active[first..first + touching].iter().filter(ends).count() != ending {
            return false;
        }
        let mut starting: Vec<u32> =
            here.iter().filter(|event| event.begins).map(|event| event.side).collect();
        starting.sort_by(|&a, &b| 0.0f64.total_cmp(&(side(a).height(side(b).ends[1]) + 0.0)));
        let count = starting.len();
        self.active.splice(first..first + touching, starting);
        (first..=first + count).all(|upper| self.are_neighbours(upper))
    }

    /// Whether the active side at a place in the list, and the one below it, may be neighbours.
    fn are_neighbours(&self, upper: usize) -> bool {
        let at = |place: usize| self.active.get(place).map(|&number| &self.sides[number as usize]);
        let below = upper.checked_sub(1).and_then(at);
        match (below, at(upper)) {
            (None, Some(lowest)) => lowest.is_floor,
            (Some(below), Some(above)) => below.is_floor != above.is_floor && stay_apart(below, above),
            (Some(highest), None) => !highest.is_floor,
            (None, None) => true,
        }
    }
}

/// Whether a side stays below another up to where the first of them ends.
fn stay_apart(below: &Side, above: &Side) -> bool {
    let ([_, low], [_, high]) = (below.ends, above.ends);
    let meet = below.vertices[1] == above.vertices[1];
    let start_together = below.vertices[0] == above.vertices[0];
    match before(low, high) {
        _ if meet && start_together => false,
        _ if meet => true,
        Ordering::Less => above.height(low) < 0.0,
        _ => below.height(high) > 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(loops: &[&[[f64; 2]]], expected: bool) {
        let places: Vec<DVec2> = loops.iter().flat_map(|one| one.iter().map(|&p| p.into())).collect();
        let mut sides: Vec<[u32; 2]> = Vec::new();
        for one in loops {
            let (first, count) = (sides.len() as u32, one.len() as u32);
            sides.extend((0..count).map(|k| [first + k, first + (k + 1) % count]));
        }
        for turn in 0..4 {
            let turned = |v: u32| (0..turn).fold(places[v as usize], |p, _| DVec2::new(-p.y, p.x));
            assert_eq!(goes_around_once(&sides, turned), expected, "{loops:?}");
        }
    }

    #[test]
    fn only_simple_outlines_go_around_once() {
        const SQUARE: [[f64; 2]; 4] = [[0.0, 0.0], [9.0, 0.0], [9.0, 9.0], [0.0, 9.0]];
        let moved = |by: f64, scale: f64| SQUARE.map(|[x, y]| [by + scale * x, by + scale * y]);
        let turned = |mut one: [[f64; 2]; 4]| {
            one.reverse();
            one
        };
        check(&[], true);
        check(&[&SQUARE], true);
        check(&[&turned(SQUARE)], false);
        check(&[&SQUARE, &moved(20.0, 1.0)], true);
        check(&[&SQUARE, &turned(moved(1.0, 0.5))], true);
        check(&[&SQUARE, &turned(moved(1.0, 0.7)), &moved(2.0, 0.2)], true);
        check(&[&SQUARE, &moved(1.0, 0.5)], false);
        check(&[&SQUARE, &moved(5.0, 1.0)], false);
        check(&[&SQUARE, &turned(moved(5.0, 1.0))], false);
        // They touch: in a corner, along a side.
        check(&[&SQUARE, &moved(9.0, 1.0)], false);
        check(&[&SQUARE, &[[9.0, 2.0], [12.0, 2.0], [12.0, 3.0], [9.0, 3.0]]], false);
        // A bow tie, a comb, a spiral that goes around twice.
        check(&[&[[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.0]]], false);
        check(&[&[[0.0, 0.0], [5.0, 0.0], [5.0, 3.0], [4.0, 1.0], [3.0, 3.0], [2.0, 1.0], [1.0, 3.0]]], true);
        check(
            &[&[
                [0.0, 0.0],
                [9.0, 0.0],
                [9.0, 9.0],
                [1.0, 9.0],
                [1.0, 1.0],
                [8.0, 1.0],
                [8.0, 8.0],
                [0.0, 8.0],
            ]],
            false,
        );
    }

    #[test]
    fn a_vertex_may_be_passed_twice() {
        let places = [[0.0, 0.0], [2.0, -1.0], [2.0, 1.0], [-2.0, 1.0], [-2.0, -1.0]].map(DVec2::from);
        let check = |sides: &[[u32; 2]], expected| {
            assert_eq!(goes_around_once(sides, |v| places[v as usize]), expected, "{sides:?}");
        };
        check(&[[0, 1], [1, 2], [2, 0], [0, 3], [3, 4], [4, 0]], true);
        check(&[[0, 1], [1, 2], [2, 0], [0, 4], [4, 3], [3, 0]], false);
        check(&[[0, 1], [1, 2], [2, 0], [0, 1], [1, 2], [2, 0]], false);
    }
}
