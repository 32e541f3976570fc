//! Which vertices stand at the very same place: a hash table without surprises. Near is not equal.

use glam::DVec3;

const EMPTY: u32 = u32::MAX;

/// For each place the first of the list that equals it to the bit; −0 counts as 0.
pub fn first_at_place(places: &[DVec3]) -> Vec<u32> {
    let size = (2 * places.len()).next_power_of_two().max(2);
    let shift = 64 - size.trailing_zeros();
    let mut slots = vec![EMPTY; size];
    let key = |place: DVec3| place.to_array().map(|x| (x + 0.0).to_bits());
    let mut first = Vec::with_capacity(places.len());
    for (number, &place) in places.iter().enumerate() {
        let own = key(place);
        let mut at = (hash(own) >> shift) as usize;
        let found = loop {
            match slots[at] {
                EMPTY => {
                    slots[at] = number as u32;
                    break number as u32;
                }
                other if key(places[other as usize]) == own => break other,
                _ => at = (at + 1) & (size - 1),
            }
        };
        first.push(found);
    }
    first
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
