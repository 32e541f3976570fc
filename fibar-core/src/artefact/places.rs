//! Which vertices stand at the very same place: a hash table without surprises. Near is not equal.

use glam::DVec3;

const EMPTY: u64 = u64::MAX;
/// The bits of a hash that are kept; more places than half of what these can tell apart fit into no memory.
const UPPER: u64 = 0xffff_ffff_0000_0000;
const AT_ONCE: usize = 64;
/// Meshes come in strips: a place is mostly one of the last few thousand, and these few slots stay in the nearest caches.
const RECENT: usize = 4096;

/// For each place the first of the list that equals it to the bit; −0 counts as 0.
pub fn first_at_place(places: &[DVec3]) -> Vec<u32> {
    let mut numbers = Vec::with_capacity(places.len());
    Places::with_room_for(places.len()).number(places, &mut numbers);
    let mut firsts = Vec::new();
    for (own, number) in (0..).zip(&mut numbers) {
        if *number as usize == firsts.len() {
            firsts.push(own);
        }
        *number = firsts[*number as usize];
    }
    numbers
}

/// Places that are all different, numbered in the order in which they came.
pub struct Places {
    places: Vec<DVec3>,
    /// The number of each, below the upper half of its hash, at the slot that the hash names or soon after; at most half full.
    slots: Vec<u64>,
    /// The number that came last of those whose hashes end alike.
    recent: Vec<u32>,
}

impl Default for Places {
    fn default() -> Places {
        Places::with_room_for(1)
    }
}

impl Places {
    /// None yet; up to so many come without the table having to grow.
    fn with_room_for(count: usize) -> Places {
        let slots = vec![EMPTY; (2 * count).next_power_of_two().max(2)];
        Places { places: Vec::with_capacity(count), slots, recent: vec![u32::MAX; RECENT] }
    }

    /// Appends the number of each place; −0 counts as 0.
    pub fn number(&mut self, places: &[DVec3], numbers: &mut Vec<u32>) {
        places.chunks(AT_ONCE).for_each(|places| self.number_few(places, numbers));
    }

    /// Slots lie far apart in memory: to look into several at once takes hardly longer than into one.
    fn number_few(&mut self, places: &[DVec3], numbers: &mut Vec<u32>) {
        let mut unknown = [(0, 0); AT_ONCE];
        let mut count = 0;
        let first = numbers.len();
        for (k, place) in places.iter().enumerate() {
            let hash = hash(key(*place));
            let recent = self.recent[hash as usize % RECENT];
            numbers.push(recent);
            unknown[count] = (k, hash);
            count += usize::from(!self.is_at(recent, *place));
        }
        let unknown = &unknown[..count];
        let mut slots = [EMPTY; AT_ONCE];
        for (slot, (_, hash)) in slots.iter_mut().zip(unknown) {
            *slot = self.slots[self.slot(*hash)];
        }
        for (&(k, hash), seen) in unknown.iter().zip(slots) {
            let known = holds(seen, hash) && self.is_at(seen as u32, places[k]);
            let number = if known { seen as u32 } else { self.find(hash, places[k]) };
            self.recent[hash as usize % RECENT] = number;
            numbers[first + k] = number;
        }
    }

    /// All of them; each as it came first.
    pub fn into_places(self) -> Vec<DVec3> {
        self.places
    }

    fn is_at(&self, number: u32, place: DVec3) -> bool {
        self.places.get(number as usize).is_some_and(|known| key(*known) == key(place))
    }

    fn find(&mut self, hash: u64, place: DVec3) -> u32 {
        let mut at = self.slot(hash);
        while self.slots[at] != EMPTY {
            if holds(self.slots[at], hash) && self.is_at(self.slots[at] as u32, place) {
                return self.slots[at] as u32;
            }
            at = (at + 1) & (self.slots.len() - 1);
        }
        let number = self.places.len() as u32;
        self.places.push(place);
        self.slots[at] = hash & UPPER | u64::from(number);
        if 2 * self.places.len() > self.slots.len() {
            self.grow();
        }
        number
    }

    fn slot(&self, hash: u64) -> usize {
        (hash >> (64 - self.slots.len().trailing_zeros())) as usize
    }

    /// The upper half of a hash names the slot, so the old table is read and the new one written from end to end.
    fn grow(&mut self) {
        let larger = vec![EMPTY; 2 * self.slots.len()];
        for old in std::mem::replace(&mut self.slots, larger).into_iter().filter(|&old| old != EMPTY) {
            let mut at = self.slot(old);
            while self.slots[at] != EMPTY {
                at = (at + 1) & (self.slots.len() - 1);
            }
            self.slots[at] = old;
        }
    }
}

/// Whether a slot may hold a place of this hash.
fn holds(slot: u64, hash: u64) -> bool {
    (slot ^ hash) & UPPER == 0
}

fn key(place: DVec3) -> [u64; 3] {
    place.to_array().map(|x| (x + 0.0).to_bits())
}

/// Mixes all bits upwards, from where the table takes them. Made-up input can only make it slow, and every table has the same order.
fn hash(key: [u64; 3]) -> u64 {
    const ODD: u64 = 0x9e37_79b9_7f4a_7c15;
    key.iter()
        .fold(0, |sum: u64, bits| {
            let mixed = (sum ^ bits).wrapping_mul(ODD);
            mixed ^ (mixed >> 32)
        })
        .wrapping_mul(ODD)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_places_have_one_first() {
        let check = |places: &[[f64; 3]], expected: &[u32]| {
            let places: Vec<DVec3> = places.iter().map(|&p| p.into()).collect();
            assert_eq!(first_at_place(&places), expected);
        };
        check(&[], &[]);
        check(&[[1.0, 2.0, 3.0]; 3], &[0, 0, 0]);
        check(
            &[[0.0; 3], [-0.0; 3], [0.0, 0.0, 1e-300], [1.0, 0.0, 0.0], [-0.0, 0.0, 0.0]],
            &[0, 0, 2, 3, 0],
        );
        // A lattice, which a weak hash would heap up.
        let lattice: Vec<[f64; 3]> =
            (0..9261).map(|k| [k % 21, k / 21 % 21, k / 441].map(f64::from)).collect();
        let twice = [lattice.clone(), lattice].concat();
        check(&twice, &(0..9261).chain(0..9261).collect::<Vec<_>>());
    }
}
