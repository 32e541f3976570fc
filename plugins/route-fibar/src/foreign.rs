//! Who is near whom: for every control point those of other patterns, found once and good for many small moves (Verlet
//! 1967).

use crate::bundle::Bundle;
use crate::neighbours::Cells;
use glam::DVec3;
use rayon::prelude::*;

/// Lists of foreign control points that stay complete until somebody has moved by half the slack.
pub struct Foreign {
    reach: f64,
    slack: f64,
    /// Where the points were when the lists were made, mm.
    snapshot: Vec<DVec3>,
    lists: Vec<Vec<u32>>,
}

impl Foreign {
    /// Lists of all foreign points within `reach` mm; `slack` mm more are looked at, to look less often.
    pub fn of(bundle: &Bundle, reach: f64, slack: f64) -> Foreign {
        let cells = Cells::of(&bundle.points, reach + slack);
        let of_point = |k: usize| foreign_within(bundle, &cells, k, reach + slack);
        let lists = (0..bundle.points.len()).into_par_iter().map(of_point).collect();
        Foreign { reach, slack, snapshot: bundle.points.clone(), lists }
    }

    /// Makes the lists anew if they may have become incomplete.
    pub fn refresh(&mut self, bundle: &Bundle) {
        let far = 0.25 * self.slack * self.slack;
        let moved = |(now, then): (&DVec3, &DVec3)| now.distance_squared(*then) >= far;
        if self.snapshot.len() != bundle.points.len() || bundle.points.iter().zip(&self.snapshot).any(moved) {
            *self = Foreign::of(bundle, self.reach, self.slack);
        }
    }

    /// Numbers of all foreign points that may be within reach of a point, rising; some are further.
    pub fn near(&self, point: usize) -> &[u32] {
        &self.lists[point]
    }
}

fn foreign_within(bundle: &Bundle, cells: &Cells, k: usize, reach: f64) -> Vec<u32> {
    let (here, pattern) = (bundle.points[k], bundle.pattern(k));
    let wanted = |other: &usize| {
        bundle.pattern(*other) != pattern && here.distance_squared(bundle.points[*other]) < reach * reach
    };
    let mut list: Vec<u32> = cells.near(here).filter(wanted).map(|other| other as u32).collect();
    list.sort_unstable();
    list
}
