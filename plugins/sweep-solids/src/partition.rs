//! Who gets which part of the object.
//!
//! ```text
//! room      = inset − sockets                      what lies inside the skin
//! owned_k   = (black tubes of k ∩ room) − black tubes of every lower pattern
//! core_k    = core tubes of k ∩ owned_k
//! cladding_k = (cladding tubes of k ∩ owned_k) − core tubes of k
//! black_k   = owned_k − cladding tubes of k
//! skin      = body − inset − sockets               filler = room − all black tubes
//! ```
//!
//! Skin and filler are then divided by the user's parts (`regions.rs`); fibres run through all of them and stay whole.
//!
//! Every border between two solids is one surface, taken from the same mesh on both sides; nothing is compared by
//! distance. Within an LED inner roles win; between LEDs the lower pattern does (pattern 1 carries the phase).

use crate::internal;
use crate::layers::LedTubes;
use crate::regions::{Label, Regions};
use fibar_core::id::{LedId, PatternId};
use fibar_core::material::Role;
use fibar_plugin::StageError;
use fibar_solid::{Solid, SolidError};
use glam::DVec3;
use rayon::prelude::*;

/// The object before the fibres.
pub struct Room {
    skin: Solid,
    inside: Solid,
}

/// A solid with its part to play.
pub struct Part {
    /// Its role.
    pub role: Role,
    /// Whose fibres; none for skin and filler.
    pub owner: Option<(LedId, PatternId)>,
    /// The user's part that it is a piece of.
    pub label: Option<Label>,
    /// The solid.
    pub solid: Solid,
}

/// A place that fibres of two LEDs claim.
pub struct Collision {
    /// The lower pattern, which keeps the place.
    pub winner: PatternId,
    /// The other.
    pub loser: PatternId,
    /// Common volume inside the skin, mm³.
    pub volume_mm3: f64,
    /// Middle of the common volume's bounding box, mm.
    pub place_mm: DVec3,
}

/// The object, shared out.
pub struct Partition {
    /// All solids that are not empty, by role, then by pattern.
    pub parts: Vec<Part>,
    /// By patterns.
    pub collisions: Vec<Collision>,
}

impl Room {
    /// `inside` is the body without its skin, `holes` what the sockets take away.
    pub fn new(body: Solid, inside: Solid, holes: Solid) -> Result<Room, SolidError> {
        let skin = body.subtract([&inside, &holes])?;
        Ok(Room { skin, inside: inside.subtract([&holes])? })
    }
}

impl Partition {
    /// Shares the object out; `tubes` in order of patterns.
    pub fn of(room: &Room, tubes: &[LedTubes], regions: &Regions) -> Result<Partition, StageError> {
        let (filler, shares) = rayon::join(|| filler(room, tubes), || shares(room, tubes));
        let filler = filler.map_err(internal)?;
        let (skin, filler) =
            rayon::join(|| regions.divide("skin", &room.skin), || regions.divide("filler", &filler));
        let of_role = |role| move |(label, solid)| Part { role, owner: None, label, solid };
        let mut parts: Vec<Part> = skin?.into_iter().map(of_role(Role::Skin)).collect();
        parts.extend(filler?.into_iter().map(of_role(Role::Filler)));
        let mut collisions = Vec::new();
        for share in shares.map_err(internal)? {
            parts.extend(share.parts);
            collisions.extend(share.collisions);
        }
        parts.retain(|part| !part.solid.is_empty());
        parts.sort_by_key(|part| (part.role, part.owner.map(|(_, pattern)| pattern)));
        collisions.sort_by_key(|c| (c.winner, c.loser));
        Ok(Partition { parts, collisions })
    }
}

fn filler(room: &Room, tubes: &[LedTubes]) -> Result<Solid, SolidError> {
    room.inside.subtract(tubes.iter().map(|led| &led.black))
}

/// What one LED gets.
struct Share {
    parts: [Part; 3],
    collisions: Vec<Collision>,
}

fn shares(room: &Room, tubes: &[LedTubes]) -> Result<Vec<Share>, SolidError> {
    (0..tubes.len()).into_par_iter().map(|k| share(room, &tubes[k], &tubes[..k])).collect()
}

fn share(room: &Room, led: &LedTubes, lower: &[LedTubes]) -> Result<Share, SolidError> {
    let claimed = led.black.intersect(&room.inside)?;
    let mut collisions = Vec::new();
    let mut winners = Vec::new();
    for winner in lower {
        if let Some(collision) = collide(&claimed, led.pattern, winner)? {
            collisions.push(collision);
            winners.push(&winner.black);
        }
    }
    let owned = if winners.is_empty() { claimed } else { claimed.subtract(winners)? };
    let part = |role, solid| Part { role, owner: Some((led.led, led.pattern)), label: None, solid };
    let parts = [
        part(Role::Core, led.core.intersect(&owned)?),
        part(Role::Cladding, led.cladding.intersect(&owned)?.subtract([&led.core])?),
        part(Role::Black, owned.subtract([&led.cladding])?),
    ];
    Ok(Share { parts, collisions })
}

fn collide(claimed: &Solid, loser: PatternId, winner: &LedTubes) -> Result<Option<Collision>, SolidError> {
    let common = claimed.intersect(&winner.black)?;
    let collision = common.bounds().map(|(low, high)| Collision {
        winner: winner.pattern,
        loser,
        volume_mm3: common.volume(),
        place_mm: (low + high) * 0.5,
    });
    Ok(collision)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layers::sweep_all;
    use crate::socket;
    use fibar_core::artefact::routes::{Fibre, Routes};
    use fibar_core::artefact::sockets::{Hole, Socket, Sockets};
    use fibar_core::id::MarkerId;
    use fibar_core::material::LayerRadii;
    use fibar_geometry::curve::clamped_uniform_knots;
    use fibar_solid::{InsetOptions, inset};

    const LEDS: [DVec3; 2] = [DVec3::new(-8.0, 0.0, 6.0), DVec3::new(8.0, 0.0, 6.0)];

    fn sockets() -> Sockets {
        let socket = |k: usize| Socket {
            led: LedId(k as u32),
            pattern: PatternId(2 - k as u32),
            position: LEDS[k],
            axis: DVec3::Z,
        };
        Sockets::new(Hole { diameter_mm: 5.2, depth_mm: 6.0 }, vec![socket(0), socket(1)])
    }

    /// From an LED to a place on the top of the block.
    fn fibre(id: u32, led: usize, x: f64, y: f64) -> Fibre {
        let top = DVec3::new(x, y, 30.0);
        let points = vec![LEDS[led], LEDS[led] + DVec3::Z * 12.0, top - DVec3::Z * 12.0, top];
        Fibre {
            id,
            marker: MarkerId(id),
            led: LedId(led as u32),
            pattern: PatternId(2 - led as u32),
            degree: 3,
            knots: clamped_uniform_knots(3, 4),
            points,
            weights: vec![1.0; 4],
            radii_mm: LayerRadii::TONE_2020,
        }
    }

    fn block() -> Solid {
        let corner = |k: usize| {
            let end = |axis: usize, low, high| if k >> axis & 1 == 0 { low } else { high };
            DVec3::new(end(0, -16.0, 16.0), end(1, -8.0, 8.0), end(2, 0.0, 30.0))
        };
        Solid::hull(&(0..8).map(corner).collect::<Vec<_>>()).unwrap()
    }

    fn share_out(fibres: Vec<Fibre>) -> (f64, Partition) {
        let inside = inset(&block(), InsetOptions { thickness: 0.4, simplify: 0.0 }).unwrap();
        let holes = socket::holes(&sockets(), 0.05).unwrap();
        let volume = block().subtract([&holes]).unwrap().volume();
        let room = Room::new(block(), inside, holes).unwrap();
        let tubes = sweep_all(&Routes::new(fibres), &sockets(), 0.05).unwrap();
        (volume, Partition::of(&room, &tubes, &Regions::default()).unwrap())
    }

    /// Parts fill the object, do not overlap, and are those named; collisions as (winner, loser).
    fn check(fibres: Vec<Fibre>, names: &[&str], collisions: &[(u32, u32)]) -> Partition {
        let (volume, partition) = share_out(fibres);
        let name =
            |p: &Part| format!("{}{}", p.role.name(), p.owner.map_or(String::new(), |(_, p)| p.to_string()));
        assert_eq!(partition.parts.iter().map(name).collect::<Vec<_>>(), names);
        let sum: f64 = partition.parts.iter().map(|p| p.solid.volume()).sum();
        assert!((sum / volume - 1.0).abs() < 1e-9, "{sum} of {volume}");
        for (k, one) in partition.parts.iter().enumerate() {
            for other in &partition.parts[..k] {
                let overlap = one.solid.intersect(&other.solid).unwrap().volume();
                assert!(overlap < 1e-6, "{} and {}: {overlap} mm³", name(one), name(other));
            }
        }
        let found: Vec<(u32, u32)> = partition.collisions.iter().map(|c| (c.winner.0, c.loser.0)).collect();
        assert_eq!(found, collisions);
        partition
    }

    #[test]
    fn fibres_of_two_leds_share_the_block() {
        let names = ["core1", "core2", "cladding1", "cladding2", "black1", "black2", "skin", "filler"];
        let fibres = vec![fibre(1, 0, -12.0, 2.0), fibre(2, 0, -6.0, -3.0), fibre(3, 1, 9.0, 0.0)];
        let partition = check(fibres, &names, &[]);
        for part in partition.parts.iter().filter(|p| p.owner.is_some()) {
            assert_eq!(part.solid.components().unwrap().len(), 1, "fibres of one LED merge at its tip");
            let (low, high) = part.solid.bounds().unwrap();
            assert!((low.z - 6.0).abs() < 1e-9 && (high.z - 29.6).abs() < 1e-9, "from the tip to the skin");
        }
    }

    #[test]
    fn mouths_beside_the_tip_are_cut_by_the_hole_and_lie_under_the_dome() {
        let names = ["core1", "core2", "cladding1", "cladding2", "black1", "black2", "skin", "filler"];
        let beside = |id: u32, led: usize, by: DVec3| {
            let mut fibre = fibre(id, led, LEDS[led].x, 0.0);
            fibre.points.iter_mut().for_each(|point| *point += by);
            fibre
        };
        let [left, right, up] = [DVec3::NEG_X, DVec3::X, DVec3::Y].map(|d| d * 1.625);
        let fibres = vec![beside(1, 0, left), beside(2, 0, right), beside(3, 1, up)];
        let partition = check(fibres, &names, &[]);
        for part in partition.parts.iter().filter(|p| p.role == Role::Core) {
            let (low, high) = part.solid.bounds().unwrap();
            assert!((low.z - 6.0).abs() < 1e-9 && (high.z - 29.6).abs() < 1e-9, "from the tip to the skin");
        }
        let pieces = |k: usize| partition.parts[k].solid.components().unwrap().len();
        assert_eq!((pieces(0), pieces(1)), (1, 2), "two mouths of LED 0, one of LED 1");
    }

    #[test]
    fn the_lower_pattern_keeps_a_crossing() {
        let names = ["core1", "core2", "cladding1", "cladding2", "black1", "black2", "skin", "filler"];
        let crossing = vec![fibre(1, 0, 8.0, 1.0), fibre(2, 1, -8.0, 0.0)];
        let partition = check(crossing, &names, &[(1, 2)]);
        let collision = &partition.collisions[0];
        assert!(collision.volume_mm3 > 20.0 && collision.place_mm.x.abs() < 2.0);
        let pieces = |k: usize| partition.parts[k].solid.components().unwrap().len();
        assert_eq!((pieces(0), pieces(1)), (1, 2), "the core of pattern 2 is cut through");
    }

    #[test]
    fn a_block_without_fibres_is_skin_with_filler() {
        check(vec![], &["skin", "filler"], &[]);
    }
}
