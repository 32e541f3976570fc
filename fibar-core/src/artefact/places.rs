//! Which vertices stand at the very same place: a hash table without surprises. Near is not equal.

use glam::DVec3;

const EMPTY: u32 = u32::MAX;

/// For each place the first of the list that equals it to the bit; −0 counts as 0.
pub fn first_at_place(places: &[DVec3]) -> Vec<u32> {
    // A soup of triangles has six corners at a place: the table grows with the places, not with the list.
    let mut table = Table::of(places.len() / 2);
    places.iter().zip(0..).map(|(place, number)| table.first(places, key(*place), number)).collect()
}

fn key(place: DVec3) -> [u64; 3] {
    place.to_array().map(|x| (x + 0.0).to_bits())
}

/// The first of every place so far, at the slot that its hash names or soon after; at most half full.
struct Table {
    slots: Vec<u32>,
    taken: usize,
}

impl Table {
    fn of(size: usize) -> Table {
        Table { slots: vec![EMPTY; size.next_power_of_two().max(2)], taken: 0 }
    }

    /// The first place that has the key, which is this one if there was none.
    fn first(&mut self, places: &[DVec3], own: [u64; 3], number: u32) -> u32 {
        let shift = 64 - self.slots.len().trailing_zeros();
        let mut at = (hash(own) >> shift) as usize;
        loop {
            match self.slots[at] {
                EMPTY => break,
                other if key(places[other as usize]) == own => return other,
                _ => at = (at + 1) & (self.slots.len() - 1),
            }
        }
        self.slots[at] = number;
        self.taken += 1;
        if 2 * self.taken > self.slots.len() {
            self.grow(places);
        }
        number
    }

    fn grow(&mut self, places: &[DVec3]) {
        let mut larger = Table::of(2 * self.slots.len());
        for &number in self.slots.iter().filter(|&&number| number != EMPTY) {
            larger.first(places, key(places[number as usize]), number);
        }
        *self = larger;
    }
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
