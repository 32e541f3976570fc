//! Collapses, then measures; where the promise is not kept, that neighbourhood gets less room and it all starts again.

use crate::collapse::Collapse;
use crate::witnesses::{Witness, Witnesses};
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_geometry::crossings::crossings;
use fibar_geometry::deviation::{Deviation, deviations};
use fibar_geometry::distance::Surface;
use fibar_plugin::StageError;
use glam::DVec3;
use std::collections::BTreeMap;

/// What is asked for.
#[derive(Clone, Copy, Debug)]
pub struct Wish {
    /// How far the surfaces may lie apart, mm.
    pub chord_error: f64,
    /// Fewer triangles are not needed.
    pub triangles: usize,
}

/// What came out.
pub struct Simplified {
    /// The body.
    pub mesh: TriangleMesh,
    /// Its Hausdorff distance from what came in.
    pub deviation: Deviation,
    /// How often it was begun.
    pub rounds: usize,
}

/// A place where the promise was broken.
#[derive(Clone, Copy, Debug)]
struct Doubt {
    place: DVec3,
    radius: f64,
}

/// Share of the chord error that collapses may use: the rest is for what lies between the points they look at.
const ROOM: f64 = 0.95;
/// What becomes of that room around a doubt.
const LESS: f64 = 0.7;
/// Below this share of the room a place stays as it is.
const LEAST: f64 = 0.1;
/// After that many rounds the body stays as it was.
const ROUNDS: usize = 8;

/// Fewer triangles within the chord error; the body itself if there is no way.
pub fn simplify(
    body: &TriangleMesh,
    wish: &Wish,
    tick: &mut impl FnMut(usize) -> Result<(), StageError>,
) -> Result<Simplified, StageError> {
    let refused = |error| StageError::input(format!("the body cannot be searched: {error}"));
    let surface = Surface::unsigned(body).map_err(refused)?;
    let mut doubts: Vec<Doubt> = Vec::new();
    for rounds in 1..=ROUNDS {
        let mut witnesses = Witnesses::of(body, ROOM * wish.chord_error);
        let map = Map::of(&doubts);
        let lessen = |witness: &mut Witness| witness.reach = map.reach_at(witness.place, witness.reach);
        witnesses.all.iter_mut().for_each(lessen);
        let mesh = Collapse::of(body, &surface, witnesses).run(wish.triangles, tick)?;
        let (deviation, new) = judge(body, &surface, &mesh, wish.chord_error).map_err(refused)?;
        if new.is_empty() {
            return Ok(Simplified { mesh, deviation, rounds });
        }
        doubts.extend(new);
    }
    let deviation = Deviation { at_least: 0.0, at_most: 0.0, place: DVec3::ZERO };
    Ok(Simplified { mesh: body.clone(), deviation, rounds: ROUNDS })
}

/// Doubts by the cells of a grid that they reach into.
struct Map<'a> {
    cell: f64,
    doubts: BTreeMap<[i64; 3], Vec<&'a Doubt>>,
}

impl Map<'_> {
    fn of(doubts: &[Doubt]) -> Map<'_> {
        // Twice the mean radius: most doubts reach into eight cells.
        let cell = 2.0 * doubts.iter().map(|doubt| doubt.radius).sum::<f64>() / doubts.len().max(1) as f64;
        let mut map = Map { cell, doubts: BTreeMap::new() };
        for doubt in doubts {
            let [low, high] = [-doubt.radius, doubt.radius].map(|by| map.cell_of(doubt.place + by));
            for (x, y) in (low[0]..=high[0]).flat_map(|x| (low[1]..=high[1]).map(move |y| (x, y))) {
                for z in low[2]..=high[2] {
                    map.doubts.entry([x, y, z]).or_default().push(doubt);
                }
            }
        }
        map
    }

    fn cell_of(&self, place: DVec3) -> [i64; 3] {
        (place / self.cell).to_array().map(|x| x.floor() as i64)
    }

    /// What is allowed at a place.
    fn reach_at(&self, place: DVec3, reach: f64) -> f64 {
        let Some(doubts) = self.doubts.get(&self.cell_of(place)) else { return reach };
        let near = doubts.iter().filter(|doubt| doubt.place.distance(place) <= doubt.radius).count();
        let share = LESS.powi(near.min(100) as i32);
        if share < LEAST { 0.0 } else { share * reach }
    }
}

/// The distance of two surfaces, and where they lie too far apart or the new one passes through itself.
fn judge(
    body: &TriangleMesh,
    surface: &Surface,
    mesh: &TriangleMesh,
    limit: f64,
) -> Result<(Deviation, Vec<Doubt>), fibar_geometry::distance::SurfaceError> {
    let after = Surface::unsigned(mesh)?;
    let doubt = |place: DVec3, triangles: &[usize]| {
        let size = |&t: &usize| {
            let [a, b, c] = mesh.corners(t);
            a.distance(b).max(b.distance(c)).max(c.distance(a))
        };
        Doubt { place, radius: 0.5 * triangles.iter().map(size).fold(4.0 * limit, f64::max) }
    };
    let there = deviations(mesh, surface, limit);
    let back = deviations(body, &after, limit);
    let mut doubts: Vec<Doubt> = there
        .iter()
        .enumerate()
        .filter(|(_, found)| found.at_most > limit)
        .map(|(t, found)| doubt(found.place, &[t]))
        .collect();
    let far = back.iter().filter(|found| found.at_most > limit);
    doubts.extend(far.map(|found| doubt(found.place, &[after.nearest(found.place).1 as usize])));
    let crossed = crossings(mesh);
    doubts.extend(crossed.iter().map(|c| doubt(c.place, &c.triangles.map(|t| t as usize))));
    let all = there.into_iter().chain(back).reduce(Deviation::or_greater).expect("surfaces have triangles");
    Ok((all, doubts))
}
