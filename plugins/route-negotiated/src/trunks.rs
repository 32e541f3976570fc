//! Trunks: where a neck is too crowded for single fibres, those of one pattern start as one through a place of their own.

use crate::mouths;
use crate::neck::{Neck, Way};
use crate::nets::Net;
use fibar_geometry::alone::World;
use fibar_geometry::course::Course;
use glam::{DVec2, DVec3};

/// The way of a net on its best course alone.
pub fn way(world: &World, net: &Net, course: &Course) -> Way {
    let mut nodes = vec![];
    world.tables.of(course.points.len()).sample(&course.points, &mut nodes);
    Way { pattern: net.pattern.0, marker: net.marker, places: nodes.iter().map(|n| n.position).collect() }
}

/// Leads every course through the neck by the place of its pattern: patterns take the places that lie as their LEDs do.
pub fn bundle(neck: &Neck, nets: &[Net], courses: &mut [(usize, Course)]) {
    let patterns: Vec<u32> = neck.through.keys().copied().collect();
    let (across, up) = neck.normal.any_orthonormal_pair();
    let flat = |place: DVec3| DVec2::new((place - neck.place).dot(across), (place - neck.place).dot(up));
    let tip = |pattern: &u32| nets.iter().find(|net| net.pattern.0 == *pattern).map(|net| flat(net.ends.tip));
    let tips: Vec<DVec2> = patterns.iter().filter_map(tip).collect();
    let places: Vec<DVec2> = neck.slots.iter().map(|slot| flat(*slot)).collect();
    let Some(taken) = closest_places(&tips, &places) else { return };
    for (net, course) in courses.iter_mut() {
        let net = &nets[*net];
        let through = neck.through.get(&net.pattern.0).is_some_and(|markers| markers.contains(&net.marker));
        if let (true, Ok(k)) = (through, patterns.binary_search(&net.pattern.0)) {
            *course = through_place(course, neck.slots[taken[k]], neck.normal);
        }
    }
}

/// A place for each tip, tips drawn in to the size of the neck; none if there are too few places.
fn closest_places(tips: &[DVec2], places: &[DVec2]) -> Option<Vec<usize>> {
    if places.len() < tips.len() {
        return None;
    }
    let extent = |points: &[DVec2]| points.iter().fold(1e-9, |most: f64, p| most.max(p.length()));
    let centre = tips.iter().copied().sum::<DVec2>() / tips.len() as f64;
    let off: Vec<DVec2> = tips.iter().map(|tip| *tip - centre).collect();
    let scale = extent(places) / extent(&off);
    // Places without a tip are wished for by nobody: they stand in the middle.
    let wishes: Vec<DVec2> =
        (0..places.len()).map(|k| off.get(k).map_or(DVec2::ZERO, |tip| *tip * scale)).collect();
    Some(mouths::assign(&wishes, places))
}

/// The course by way of a straight piece through a place.
fn through_place(course: &Course, place: DVec3, normal: DVec3) -> Course {
    const HALF_MM: f64 = 8.0;
    const LEG_MM: f64 = 5.0;
    let ends = course.ends;
    let forwards = if normal.dot(ends.marker - ends.tip) < 0.0 { -normal } else { normal };
    let line = [
        ends.tip,
        ends.tip + LEG_MM * ends.axis,
        place - HALF_MM * forwards,
        place + HALF_MM * forwards,
        ends.marker - LEG_MM * ends.normal,
        ends.marker,
    ];
    Course::along((ends, course.freedom), &line, course.points.len() + 3)
}
