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
//! Every border between two solids is one surface, taken from the same mesh on both sides; nothing is compared by
//! distance. Within an LED inner roles win; between LEDs the lower pattern does (it is the one with more to lose: pattern
//! 1 carries the phase).

use crate::layers::LedTubes;
use fibar_core::id::{LedId, PatternId};
use fibar_core::material::Role;
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
    pub fn of(room: &Room, tubes: &[LedTubes]) -> Result<Partition, SolidError> {
        let (filler, shares) = rayon::join(|| filler(room, tubes), || shares(room, tubes));
        let mut parts = vec![
            Part { role: Role::Skin, owner: None, solid: room.skin.clone() },
            Part { role: Role::Filler, owner: None, solid: filler? },
        ];
        let mut collisions = Vec::new();
        for share in shares? {
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
    let part = |role, solid| Part { role, owner: Some((led.led, led.pattern)), solid };
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
