//! Where fibres get in each other's way most: the cross-section of the room that is fullest, and what would pass it.
//!
//! Every course is cut by planes square to it. The part of such a plane that axes can reach from the course is the free
//! cross-section there; each pattern that crosses it needs a place of its own, since fibres of one pattern may run as one.

use fibar_core::MarkerId;
use fibar_geometry::room::Room;
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::{PI, TAU};

/// One fibre on its best way alone.
pub struct Way {
    /// What it carries.
    pub pattern: u32,
    /// Where it ends.
    pub marker: MarkerId,
    /// Places along its axis, mm.
    pub places: Vec<DVec3>,
}

impl Way {
    /// The plane square to it where it comes nearest to a place, as a place and a normal.
    pub fn plane_near(&self, place: DVec3) -> Option<(DVec3, DVec3)> {
        let far = |w: &&[DVec3]| w[0].midpoint(w[1]).distance_squared(place);
        let legs = self.places.windows(2);
        let nearest = legs.min_by(|a, b| far(a).total_cmp(&far(b)))?;
        Some((nearest[0].midpoint(nearest[1]), (nearest[1] - nearest[0]).try_normalize()?))
    }
}

/// A narrow place.
#[derive(Clone, Debug)]
pub struct Neck {
    /// Middle of the free cross-section, mm.
    pub place: DVec3,
    /// Area that fibres could fill there, mm².
    pub area: f64,
    /// Markers beyond it, by pattern.
    pub through: BTreeMap<u32, Vec<MarkerId>>,
    /// How many patterns can pass side by side.
    pub capacity: usize,
    /// Where they could, mm, and the direction of passing.
    pub slots: Vec<DVec3>,
    /// Unit vector square to the cross-section.
    pub normal: DVec3,
    /// The largest outer diameter with which all patterns could pass, mm; 0 if none, the present one if they can as they are.
    pub largest_diameter: f64,
}

/// Sizes that decide what passes.
#[derive(Clone, Copy, Debug)]
pub struct Sizes {
    /// Outer radius of a fibre, mm.
    pub radius: f64,
    /// Between fibres of two patterns, mm.
    pub clearance: f64,
}

impl Sizes {
    /// Between axes, mm.
    fn apart(&self) -> f64 {
        2.0 * self.radius + self.clearance
    }
}

/// Between the planes along a way, mm.
const STEP_MM: f64 = 4.0;
/// Cells of coarse and fine cross-sections, mm.
const COARSE_MM: f64 = 1.5;
const FINE_MM: f64 = 0.4;
/// Cross-sections are not followed further than this from the way, mm.
const REACH_MM: f64 = 30.0;

impl Neck {
    /// Whether single fibres would fill more than half of it, so that those of one pattern should run as one.
    pub fn is_crowded(&self, sizes: Sizes) -> bool {
        let fibres = self.through.values().map(Vec::len).sum::<usize>() as f64;
        let disc = PI * 0.25 * sizes.apart() * sizes.apart();
        fibres * disc > 0.5 * self.area
    }
}

/// The fullest cross-section along all ways, if there is any that two patterns share.
pub fn fullest(room: &Room, ways: &[Way], sizes: Sizes) -> Option<Neck> {
    let planes = told_apart(ways.iter().flat_map(|way| planes_along(&way.places)));
    let most = most_filled(room, &planes, ways, sizes)?;
    Some(measure(room, planes[most], ways, sizes))
}

/// The plane whose cross-section has most patterns for its area, if two share any; of equals the first. Large ones are looked at to
/// the end only if no small one is certain to be fuller.
fn most_filled(room: &Room, planes: &[(DVec3, DVec3)], ways: &[Way], sizes: Sizes) -> Option<usize> {
    const CELLS: [usize; 4] = [128, 320, 800, usize::MAX];
    let patterns = ways.iter().map(|way| way.pattern).collect::<BTreeSet<u32>>().len();
    let mut known: Vec<Option<f64>> = vec![None; planes.len()];
    for most_cells in CELLS {
        let fullness = |(plane, known): (&(DVec3, DVec3), &Option<f64>)| {
            known.or_else(|| {
                let section = Section::flood_up_to(most_cells, room, *plane, COARSE_MM, 0.0)?;
                let patterns = section.crossing(ways).len();
                Some(if patterns < 2 { 0.0 } else { patterns as f64 / section.fillable(sizes.radius) })
            })
        };
        known = planes.par_iter().zip(&known).map(fullness).collect();
        let known = || known.iter().enumerate().filter_map(|(k, fullness)| Some((k, (*fullness)?)));
        let best = known().max_by(|(a, x), (b, y)| x.total_cmp(y).then(b.cmp(a)));
        let of_larger = patterns as f64 / fillable(most_cells as f64 * COARSE_MM * COARSE_MM, sizes.radius);
        if let Some((most, fullness)) = best.filter(|(_, fullness)| *fullness > of_larger) {
            return (fullness > 0.0).then_some(most);
        }
    }
    None
}

/// The cross-section in a plane: what axes can reach of it from its place, and what passes there.
pub fn at(room: &Room, plane: (DVec3, DVec3), ways: &[Way], sizes: Sizes) -> Neck {
    measure(room, plane, ways, sizes)
}

fn measure(room: &Room, plane: (DVec3, DVec3), ways: &[Way], sizes: Sizes) -> Neck {
    let section = Section::flood(room, plane, FINE_MM, 0.0);
    let mut through: BTreeMap<u32, Vec<MarkerId>> = BTreeMap::new();
    for way in section.crossing(ways) {
        through.entry(way.0).or_default().extend(way.1);
    }
    let slots: Vec<DVec3> = section.slots(sizes.apart()).into_iter().map(|flat| section.lift(flat)).collect();
    Neck {
        place: section.middle(),
        area: section.fillable(sizes.radius),
        capacity: slots.len(),
        normal: plane.1,
        largest_diameter: if slots.len() < through.len() {
            largest_diameter(room, plane, through.len(), sizes)
        } else {
            2.0 * sizes.radius
        },
        slots,
        through,
    }
}

/// By bisection: a thinner fibre comes nearer to the wall, and leaves more room beside it.
fn largest_diameter(room: &Room, plane: (DVec3, DVec3), patterns: usize, sizes: Sizes) -> f64 {
    let fits = |radius: f64| {
        let section = Section::flood(room, plane, FINE_MM, radius - sizes.radius);
        section.capacity(2.0 * radius + sizes.clearance) >= patterns
    };
    let (mut small, mut large) = (0.05, 2.0 * sizes.radius);
    if !fits(small) {
        return 0.0;
    }
    for _ in 0..9 {
        let middle = 0.5 * (small + large);
        *if fits(middle) { &mut small } else { &mut large } = middle;
    }
    2.0 * small
}

/// Planes square to a way, ends left out.
fn planes_along(places: &[DVec3]) -> Vec<(DVec3, DVec3)> {
    let mut planes = vec![];
    let mut walked = 0.0;
    for w in places.windows(2).skip(2) {
        walked += w[0].distance(w[1]);
        if walked >= STEP_MM {
            planes.extend((w[1] - w[0]).try_normalize().map(|normal| (w[0].midpoint(w[1]), normal)));
            walked = 0.0;
        }
    }
    planes
}

/// One of all planes that are nearly the same.
fn told_apart(planes: impl Iterator<Item = (DVec3, DVec3)>) -> Vec<(DVec3, DVec3)> {
    const TURN: f64 = 0.25;
    let mut seen = BTreeSet::new();
    let key = |(place, normal): &(DVec3, DVec3)| {
        // A plane and its other side are the same.
        let normal = if normal.z < 0.0 { -*normal } else { *normal };
        [(place / STEP_MM).round(), (normal / TURN).round()].map(|v| v.as_ivec3().to_array())
    };
    planes.filter(|plane| seen.insert(key(plane))).collect()
}

/// Area that fibres of a radius could fill where axes can reach this much, mm².
fn fillable(reached: f64, radius: f64) -> f64 {
    let reach = (reached / PI).sqrt() + radius;
    PI * reach * reach
}

/// What axes can reach of a plane from a place on it.
struct Section {
    place: DVec3,
    axes: [DVec3; 3],
    cell: f64,
    half: i32,
    inside: Vec<bool>,
    cells: Vec<DVec2>,
}

impl Section {
    /// Floods the cells with at least `least_slack` mm from the middle.
    fn flood(room: &Room, plane: (DVec3, DVec3), cell: f64, least_slack: f64) -> Section {
        let section = Section::flood_up_to(usize::MAX, room, plane, cell, least_slack);
        section.expect("no section has so many cells")
    }

    /// The same; none if there are more cells than this.
    fn flood_up_to(
        most_cells: usize,
        room: &Room,
        (place, normal): (DVec3, DVec3),
        cell: f64,
        least_slack: f64,
    ) -> Option<Section> {
        let (across, up) = normal.any_orthonormal_pair();
        let half = (REACH_MM / cell) as i32;
        let side = 2 * half + 1;
        let mut section = Section {
            place,
            axes: [across, up, normal],
            cell,
            half,
            inside: vec![false; (side * side) as usize],
            cells: vec![],
        };
        let mut open = vec![(0, 0)];
        while let Some((i, j)) = open.pop() {
            let Some(n) = section.number(i, j).filter(|&n| !section.inside[n]) else { continue };
            let flat = DVec2::new(f64::from(i), f64::from(j)) * cell;
            let place = section.lift(flat);
            if !room.surely_has(place, least_slack) && room.slack(place).0 < least_slack {
                continue;
            }
            section.inside[n] = true;
            section.cells.push(flat);
            if section.cells.len() > most_cells {
                return None;
            }
            open.extend([(i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1)]);
        }
        section.cells.sort_by(|a, b| a.y.total_cmp(&b.y).then(a.x.total_cmp(&b.x)));
        Some(section)
    }

    fn number(&self, i: i32, j: i32) -> Option<usize> {
        let side = 2 * self.half + 1;
        let within = i.abs() <= self.half && j.abs() <= self.half;
        within.then(|| ((j + self.half) * side + i + self.half) as usize)
    }

    fn lift(&self, flat: DVec2) -> DVec3 {
        self.place + flat.x * self.axes[0] + flat.y * self.axes[1]
    }

    fn holds(&self, flat: DVec2) -> bool {
        let at = (flat / self.cell).round();
        self.number(at.x as i32, at.y as i32).is_some_and(|n| self.inside[n])
    }

    fn centre(&self) -> DVec2 {
        self.cells.iter().copied().sum::<DVec2>() / self.cells.len().max(1) as f64
    }

    fn middle(&self) -> DVec3 {
        self.lift(self.centre())
    }

    /// Area of the disc that is as large as what axes can reach, widened by the fibre's radius, mm².
    fn fillable(&self, radius: f64) -> f64 {
        fillable(self.cells.len() as f64 * self.cell * self.cell, radius)
    }

    /// Patterns that cross it, with their markers.
    fn crossing(&self, ways: &[Way]) -> BTreeMap<u32, Vec<MarkerId>> {
        let mut crossing: BTreeMap<u32, Vec<MarkerId>> = BTreeMap::new();
        for way in ways.iter().filter(|way| self.is_crossed_by(&way.places)) {
            crossing.entry(way.pattern).or_default().push(way.marker);
        }
        crossing
    }

    fn is_crossed_by(&self, places: &[DVec3]) -> bool {
        let height = |p: DVec3| (p - self.place).dot(self.axes[2]);
        places.windows(2).any(|w| {
            let (a, b) = (height(w[0]), height(w[1]));
            let crosses = (a < 0.0) != (b < 0.0);
            crosses && {
                let arm = w[0].lerp(w[1], a / (a - b)) - self.place;
                self.holds(DVec2::new(arm.dot(self.axes[0]), arm.dot(self.axes[1])))
            }
        })
    }

    /// How many axes `apart` mm from each other have room.
    fn capacity(&self, apart: f64) -> usize {
        self.slots(apart).len()
    }

    /// Places for axes `apart` mm from each other: the most of grids and single rings about the middle.
    fn slots(&self, apart: f64) -> Vec<DVec2> {
        const TURNS: u32 = 12;
        let centre = self.centre();
        let room_for = |layout: &[DVec2], turn: DVec2| -> Vec<DVec2> {
            layout.iter().map(|node| centre + turn.rotate(*node)).filter(|node| self.holds(*node)).collect()
        };
        let turns: Vec<DVec2> =
            (0..TURNS).map(|k| unit(TAU / 6.0 * f64::from(k) / f64::from(TURNS))).collect();
        let layouts = grids(apart).into_iter().chain(rings(apart));
        let tried = layouts.flat_map(|l| turns.iter().map(|turn| room_for(&l, *turn)).collect::<Vec<_>>());
        tried.fold(vec![], |best, next| if next.len() > best.len() { next } else { best })
    }
}

/// Hexagonal and square grids with a node, the middle of an edge, or that of a cell in the origin.
fn grids(apart: f64) -> Vec<Vec<DVec2>> {
    let count = (2.0 * REACH_MM / apart).min(60.0) as i32;
    let a = DVec2::X * apart;
    let grid = |b: DVec2, shift: DVec2| {
        let nodes = (-count..=count).flat_map(|i| (-count..=count).map(move |j| (i, j)));
        let node = |(i, j)| f64::from(i) * a + f64::from(j) * b + shift;
        nodes.map(node).filter(|node| node.length() < 1.5 * REACH_MM).collect()
    };
    let bases = [(DVec2::new(0.5, 0.75f64.sqrt()) * apart, 3.0), (DVec2::Y * apart, 2.0)];
    let shifts =
        |(b, corners): (DVec2, f64)| [DVec2::ZERO, 0.5 * a, 0.5 * b, (a + b) / corners].map(|s| (b, s));
    bases.into_iter().flat_map(shifts).map(|(b, shift)| grid(b, shift)).collect()
}

/// Rings of two to six that touch.
fn rings(apart: f64) -> Vec<Vec<DVec2>> {
    let ring = |count: u32| {
        let radius = 0.5 * apart / libm::sin(PI / f64::from(count));
        (0..count).map(|k| radius * unit(TAU * f64::from(k) / f64::from(count))).collect()
    };
    (2..=6).map(ring).collect()
}

fn unit(angle: f64) -> DVec2 {
    let (sine, cosine) = libm::sincos(angle);
    DVec2::new(cosine, sine)
}

#[cfg(test)]
mod tests {
    use super::*;
    use fibar_core::artefact::mesh::TriangleMesh;
    use fibar_core::artefact::sockets::{Hole, Socket, Sockets};
    use fibar_core::{LedId, PatternId};
    use fibar_geometry::distance::Surface;
    use fibar_geometry::room::{Keeping, RoomOptions};

    /// A square column of this width, 80 mm high.
    fn column(width: f64) -> Room {
        let corner = |k: u32| {
            let [x, y, z] = [k & 1, k >> 1 & 1, k >> 2].map(f64::from);
            DVec3::new((x - 0.5) * width, (y - 0.5) * width, z * 80.0)
        };
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let halves = |[a, b, c, d]: [u32; 4]| [[a, b, c], [a, c, d]];
        let mesh = TriangleMesh {
            vertices: (0..8).map(corner).collect(),
            triangles: quads.into_iter().flat_map(halves).collect(),
        };
        let led = Socket { led: LedId(0), pattern: PatternId(1), position: DVec3::Z * 8.0, axis: DVec3::Z };
        let sockets = Sockets::new(Hole { diameter_mm: 5.2, depth_mm: 8.0 }, vec![led]);
        let keeping = Keeping { radius: 1.875, skin: 0.4, wall: 0.0 };
        let options = RoomOptions { spacing: 0.5, band: 6.0, exact: f64::INFINITY };
        Room::new(Surface::new(&mesh).unwrap(), &sockets, keeping, options)
    }

    fn check(width: f64, patterns: u32, capacity: usize, diameter: f64) {
        let way = |pattern: u32| Way {
            pattern,
            marker: MarkerId(pattern),
            places: (0..20).map(|k| DVec3::new(0.0, 0.0, 20.0 + 2.0 * f64::from(k))).collect(),
        };
        let ways: Vec<Way> = (1..=patterns).map(way).collect();
        let sizes = Sizes { radius: 1.875, clearance: 0.1 };
        let neck = fullest(&column(width), &ways, sizes).unwrap();
        assert_eq!((neck.through.len(), neck.capacity), (patterns as usize, capacity), "{neck:?}");
        assert!((neck.largest_diameter - diameter).abs() < 0.25, "{neck:?}");
        assert!(neck.place.truncate().length() < 0.5, "{neck:?}");
    }

    #[test]
    fn a_column_holds_what_grids_and_rings_hold() {
        // Axes have a square of width − 4.55 mm.
        check(8.6, 2, 4, 3.75);
        check(8.6, 4, 4, 3.75);
        check(8.6, 5, 4, 3.15);
        check(16.6, 7, 16, 3.75);
    }

    #[test]
    fn one_pattern_alone_is_never_too_many() {
        let way = Way {
            pattern: 1,
            marker: MarkerId(1),
            places: (0..20).map(|k| DVec3::Z * f64::from(20 + 2 * k)).collect(),
        };
        assert!(fullest(&column(9.0), &[way], Sizes { radius: 1.875, clearance: 0.1 }).is_none());
    }
}
