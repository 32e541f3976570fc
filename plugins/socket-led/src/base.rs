//! The flat base of the body, and how much room there is above it.

use crate::outline::{Outline, clip_to_slab, contains};
use fibar_core::artefact::mesh::TriangleMesh;
use glam::{DVec2, DVec3};

/// Step of the search for a place, mm: fine beside any LED. A base wider than [`SEARCH_STEPS`] of it is searched in that
/// many longer ones.
const SEARCH_STEP: f64 = 1.0;
const SEARCH_STEPS: f64 = 200.0;

/// The faces in the plane z = 0, and what else of the body is low enough to be in a socket's way.
pub struct Base {
    faces: Vec<[DVec2; 3]>,
    obstacles: Vec<Outline>,
}

impl Base {
    /// Faces within `flatness` of z = 0 are the base; all others count as obstacles where they pass below `height`, mm.
    pub fn new(body: &TriangleMesh, flatness: f64, height: f64) -> Base {
        let corners = (0..body.triangles.len()).map(|t| body.corners(t));
        let is_base = |c: &[DVec3; 3]| c.iter().all(|p| p.z.abs() <= flatness);
        let (faces, others): (Vec<_>, Vec<_>) = corners.partition(is_base);
        let obstacles = others.iter().filter_map(|c| clip_to_slab(*c, 0.0, height)).collect();
        Base { faces: faces.iter().map(|c| c.map(|p| p.truncate())).collect(), obstacles }
    }

    /// Centroid of the base's area; `None` without a base.
    pub fn centroid(&self) -> Option<DVec2> {
        let area = |[a, b, c]: &[DVec2; 3]| (b - a).perp_dot(c - a).abs() / 2.0;
        let total: f64 = self.faces.iter().map(area).sum();
        let moment: DVec2 = self.faces.iter().map(|f| (f[0] + f[1] + f[2]) / 3.0 * area(f)).sum();
        (total > 0.0).then(|| moment / total)
    }

    /// Area of the base, mm².
    pub fn area(&self) -> f64 {
        self.faces.iter().map(|[a, b, c]| (*b - *a).perp_dot(*c - *a).abs() / 2.0).sum()
    }

    /// Points of a square grid over the base, nearest to its centroid first, with the needed room around each.
    pub fn roomy_places(&self, step: f64, needed: f64) -> Vec<DVec2> {
        let Some(centroid) = self.centroid() else { return vec![] };
        let places = self.grid(centroid, step);
        places.into_iter().filter(|place| self.has_room(*place, needed)).collect()
    }

    /// Whether a socket that needs so much room has it here.
    pub fn fits(&self, axis: DVec2, needed: f64) -> bool {
        self.has_room(axis, needed)
    }

    /// The centre nearest to `wish` around which every offset has the needed room; if there is none, the one whose
    /// tightest offset has the most.
    pub fn nearest_place(&self, wish: DVec2, offsets: &[DVec2], needed: f64) -> DVec2 {
        let places = self.grid_around(wish);
        let fits = |place: &&DVec2| offsets.iter().all(|o| self.has_room(**place + *o, needed));
        let roomy = |place: &&DVec2| self.tightest(**place, offsets).1;
        let found = places.iter().find(fits);
        let best = || places.iter().max_by(|a, b| roomy(a).total_cmp(&roomy(b)));
        found.or_else(best).copied().unwrap_or(wish)
    }

    /// The offset with the least room around its axis, and that room.
    pub fn tightest(&self, centre: DVec2, offsets: &[DVec2]) -> (usize, f64) {
        let rooms = offsets.iter().map(|o| self.room(centre + *o)).enumerate();
        rooms.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, 0.0))
    }

    /// Horizontal distance from an upright axis to the nearest obstacle, mm; 0 off the base.
    fn room(&self, axis: DVec2) -> f64 {
        if !self.is_over(axis) {
            return 0.0;
        }
        self.obstacles.iter().map(|o| o.distance(axis)).fold(f64::INFINITY, f64::min)
    }

    /// Horizontal distance from an upright prism to the nearest obstacle, mm; 0 where it is not all over the base.
    pub fn room_of(&self, prism: &Outline) -> f64 {
        if !prism.corners().iter().all(|corner| self.is_over(*corner)) {
            return 0.0;
        }
        self.obstacles.iter().map(|o| o.distance_between(prism)).fold(f64::INFINITY, f64::min)
    }

    fn has_room(&self, axis: DVec2, needed: f64) -> bool {
        self.is_over(axis) && self.obstacles.iter().all(|o| o.is_beyond(axis, needed))
    }

    fn is_over(&self, axis: DVec2) -> bool {
        self.faces.iter().any(|face| contains(face, axis))
    }

    /// Points of a square grid through `wish` over the base, nearest first.
    fn grid_around(&self, wish: DVec2) -> Vec<DVec2> {
        let corners = || self.faces.iter().flatten();
        let low = corners().fold(wish, |low, p| low.min(*p));
        let high = corners().fold(wish, |high, p| high.max(*p));
        self.grid(wish, SEARCH_STEP.max((high - low).max_element() / SEARCH_STEPS))
    }

    /// Points of a square grid through `wish` over the base, nearest first.
    fn grid(&self, wish: DVec2, step: f64) -> Vec<DVec2> {
        let corners = || self.faces.iter().flatten();
        let low = corners().fold(wish, |low, p| low.min(*p));
        let high = corners().fold(wish, |high, p| high.max(*p));
        let steps = |from: f64, to: f64| ((to - from) / step).floor() as i32;
        let columns = -steps(low.x, wish.x)..=steps(wish.x, high.x);
        let rows = -steps(low.y, wish.y)..=steps(wish.y, high.y);
        let mut cells: Vec<(i32, i32)> = columns.flat_map(|i| rows.clone().map(move |j| (i, j))).collect();
        cells.sort_by_key(|&(i, j)| (i64::from(i).pow(2) + i64::from(j).pow(2), i, j));
        let place = |(i, j): (i32, i32)| wish + DVec2::new(f64::from(i), f64::from(j)) * step;
        cells.into_iter().map(place).collect()
    }
}
