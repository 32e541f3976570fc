//! Which vertices stand at the very same place: a hash table without surprises. Near is not equal.

use glam::DVec3;

const EMPTY: u32 = u32::MAX;

/// For each place the first of the list that equals it to the bit; −0 counts as 0.
pub fn first_at_place(places: &[DVec3]) -> Vec<u32> {
    let mut numbers = Vec::with_capacity(places.len());
    Places::default().number(places, &mut numbers);
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
    /// The number of each at the slot that its hash names or soon after; at most half full.
    slots: Vec<u32>,
}

impl Default for Places {
    fn default() -> Places {
        Places { places: Vec::new(), slots: vec![EMPTY; 2] }
    }
}

impl Places {
    /// Appends the number of each place; −0 counts as 0.
    pub fn number(&mut self, places: &[DVec3], numbers: &mut Vec<u32>) {
        // Slots lie far apart in memory: to look into several at once takes hardly longer than into one.
        const AT_ONCE: usize = 64;
        let mut seen = [(0, EMPTY); AT_ONCE];
        for places in places.chunks(AT_ONCE) {
            for (seen, place) in seen.iter_mut().zip(places) {
                let hash = hash(key(*place));
                *seen = (hash, self.slots[self.slot(hash)]);
            }
            for ((hash, number), place) in seen.iter().zip(places) {
                numbers.push(if self.is_at(*number, *place) { *number } else { self.find(*hash, *place) });
            }
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
            if self.is_at(self.slots[at], place) {
                return self.slots[at];
            }
            at = (at + 1) & (self.slots.len() - 1);
        }
        let number = self.places.len() as u32;
        self.places.push(place);
        self.slots[at] = number;
        if 2 * self.places.len() > self.slots.len() {
            self.grow();
        }
        number
    }

    fn slot(&self, hash: u64) -> usize {
        (hash >> (64 - self.slots.len().trailing_zeros())) as usize
    }

    fn grow(&mut self) {
        self.slots = vec![EMPTY; 2 * self.slots.len()];
        for (number, place) in (0..).zip(&self.places) {
            let mut at = self.slot(hash(key(*place)));
            while self.slots[at] != EMPTY {
                at = (at + 1) & (self.slots.len() - 1);
            }
            self.slots[at] = number;
        }
    }
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
