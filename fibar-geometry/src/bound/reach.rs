//! Which places no fibre of an LED can reach, however thin its way: the room of axes is not connected to them.
//!
//! Slack changes by no more than 1 mm per mm, so a cube about a sample that lacks more than half its diagonal holds no place for an
//! axis. All other cubes are taken as free. A fibre's axis keeps to free cubes except within [`Room::exempt_start`] of the mouth and
//! [`Room::exempt_end`] of the marker, and goes from cube to touching cube. What a flood over free cubes does not reach, no fibre does.

use crate::course::Ends;
use crate::distance::Lattice;
use crate::room::Room;
use glam::DVec3;

/// Where fibres of one LED can be.
pub struct Reach<'a> {
    room: &'a Room,
    tip: DVec3,
    /// How far from the tip a fibre's axis may be where slack begins to count, mm.
    leg: f64,
    /// The free cubes that the flood came to, by sample.
    reached: Vec<bool>,
}

impl Reach<'_> {
    /// Floods the room from an LED's tip, about which fibres start within `mouth_radius` mm.
    pub fn from(room: &Room, tip: DVec3, mouth_radius: f64) -> Reach<'_> {
        let lattice = room.lattice();
        let leg = room.exempt_start() + mouth_radius;
        let half = half_diagonal(lattice);
        let free = |n: usize| room.sample(n) >= -half;
        let mut reached = vec![false; lattice.len()];
        let start = |n: &usize| free(*n) && lattice.place(*n).distance(tip) <= leg + half;
        let mut open: Vec<usize> = (0..lattice.len()).filter(start).collect();
        for &n in &open {
            reached[n] = true;
        }
        while let Some(here) = open.pop() {
            for next in touching(lattice, here) {
                if !reached[next] && free(next) {
                    reached[next] = true;
                    open.push(next);
                }
            }
        }
        Reach { room, tip, leg, reached }
    }

    /// Whether a fibre to the marker is not ruled out.
    pub fn reaches(&self, ends: Ends) -> bool {
        let lattice = self.room.lattice();
        let exempt = self.room.exempt_end();
        let near = exempt + half_diagonal(lattice);
        // So short that its exempt ends meet.
        let adjoining = ends.marker.distance(self.tip) <= self.leg + exempt;
        adjoining
            || cubes_within(lattice, ends.marker, near)
                .any(|n| self.reached[n] && lattice.place(n).distance(ends.marker) <= near)
    }
}

/// All cubes whose samples lie within `reach` mm of a place along every axis.
fn cubes_within(lattice: &Lattice, place: DVec3, reach: f64) -> impl Iterator<Item = usize> + use<> {
    let [nx, ny, nz] = lattice.counts;
    let at = ((place - lattice.origin) / lattice.spacing).to_array();
    let steps = reach / lattice.spacing;
    let range = move |axis: usize, count: usize| {
        (at[axis] - steps).ceil().max(0.0) as usize
            ..((at[axis] + steps).floor() + 1.0).clamp(0.0, count as f64) as usize
    };
    let plane = move |k: usize| range(1, ny).map(move |j| (k * ny + j) * nx);
    range(2, nz).flat_map(plane).flat_map(move |row| range(0, nx).map(move |i| row + i))
}

/// Half the diagonal of a cube about a sample, rounded up, mm.
fn half_diagonal(lattice: &Lattice) -> f64 {
    0.8661 * lattice.spacing
}

/// The cubes that touch one.
fn touching(lattice: &Lattice, cube: usize) -> impl Iterator<Item = usize> + use<> {
    let [nx, ny, nz] = lattice.counts;
    let (i, j, k) = (cube % nx, cube / nx % ny, cube / (nx * ny));
    let range = |at: usize, count: usize| at.saturating_sub(1)..(at + 2).min(count);
    let plane = move |k: usize| range(j, ny).map(move |j| (k * ny + j) * nx);
    range(k, nz).flat_map(plane).flat_map(move |row| range(i, nx).map(move |i| row + i))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::distance::Surface;
    use crate::room::{Keeping, RoomOptions};
    use fibar_core::artefact::mesh::TriangleMesh;
    use fibar_core::artefact::sockets::{Hole, Socket, Sockets};
    use fibar_core::id::{LedId, PatternId};

    /// Two blocks of 40 × 40 × 30 mm, one above the other, joined by a square neck of `width` mm: a lathe of four sides.
    fn hourglass(width: f64) -> TriangleMesh {
        let rings =
            [(20.0, 0.0), (20.0, 30.0), (0.5 * width, 30.0), (0.5 * width, 50.0), (20.0, 50.0), (20.0, 80.0)];
        let corners = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)];
        let ring = |(half, z): (f64, f64)| corners.map(|(x, y)| DVec3::new(half * x, half * y, z));
        let vertices: Vec<DVec3> = rings.into_iter().flat_map(ring).collect();
        let side = |ring: u32, k: u32| {
            let (a, b) = (4 * ring + k, 4 * ring + (k + 1) % 4);
            [[a, b, b + 4], [a, b + 4, a + 4]]
        };
        let sides = (0..5).flat_map(|ring| (0..4).flat_map(move |k| side(ring, k)));
        let lids = [[0, 2, 1], [0, 3, 2], [20, 21, 22], [20, 22, 23]];
        TriangleMesh { vertices, triangles: sides.chain(lids).collect() }
    }

    fn check(width: f64, marker: DVec3, reaches: bool) {
        let hole = Hole { diameter_mm: 5.0, depth_mm: 5.0 };
        let tip = DVec3::Z * 5.0;
        let socket = Socket { led: LedId(0), pattern: PatternId(0), position: tip, axis: DVec3::Z };
        let keeping = Keeping { radius: 1.875, skin: 0.4, wall: 0.0 };
        let surface = Surface::new(&hourglass(width)).expect("a body");
        let options = RoomOptions { spacing: 0.5, band: 6.0, exact: f64::INFINITY };
        let room = Room::new(surface, &Sockets::new(hole, vec![socket]), keeping, options);
        let ends = Ends { tip, axis: DVec3::Z, marker, normal: DVec3::Z };
        assert_eq!(Reach::from(&room, tip, 1.625).reaches(ends), reaches, "{width} mm, {marker}");
    }

    #[test]
    fn a_neck_thinner_than_a_fibre_is_hopeless() {
        let (above, below) = (DVec3::new(5.0, 3.0, 80.0), DVec3::new(20.0, 0.0, 15.0));
        check(6.0, above, true); // a fibre with its skin takes 4.55 mm
        check(4.6, above, true);
        check(3.0, above, false);
        check(3.0, below, true);
        check(3.0, DVec3::new(1.5, 0.0, 33.0), true); // just above the neck's foot
    }
}
