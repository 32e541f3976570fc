//! Where under its LED each fibre starts: side by side, each on the side it leaves to.

use glam::DVec2;
use std::f64::consts::TAU;

/// Places for `count` mouths on a disc, mm off its centre: those that leave the nearest two furthest apart, of rings around a centre.
pub fn places(count: usize, radius: f64) -> Vec<DVec2> {
    let ring = |count: usize, radius: f64, turn: f64| {
        (0..count).map(move |k| {
            let (sine, cosine) = libm::sincos(TAU * (k as f64 + turn) / count as f64);
            radius * DVec2::new(cosine, sine)
        })
    };
    let layouts = (0..count.min(6)).flat_map(|inner| {
        let inner_radii = if inner < 2 { vec![0.0] } else { vec![0.3, 0.36, 0.42, 0.48] };
        inner_radii.into_iter().map(move |share| {
            let inner_ring = ring(inner, if inner == 1 { 0.0 } else { share * radius }, 0.5);
            ring(count - inner, radius, 0.0).chain(inner_ring).collect::<Vec<DVec2>>()
        })
    });
    let alone = if count == 1 { vec![vec![DVec2::ZERO]] } else { vec![] };
    alone.into_iter().chain(layouts).fold(vec![], |best, next| {
        if best.is_empty() || least_distance(&next) > least_distance(&best) + 1e-9 { next } else { best }
    })
}

fn least_distance(places: &[DVec2]) -> f64 {
    let pairs = places.iter().enumerate().flat_map(|(k, a)| places[..k].iter().map(move |b| a.distance(*b)));
    pairs.fold(f64::INFINITY, f64::min)
}

/// Places for `count` mouths beside some that stay: those of all that the others leave, or, if that keeps more distance, one after
/// the other the place furthest from all before it.
pub fn beside(stay: &[DVec2], count: usize, radius: f64) -> Vec<DVec2> {
    let left = without_nearest(places(stay.len() + count, radius), stay);
    if stay.is_empty() || count == 0 {
        return left;
    }
    let furthest = furthest_from(stay, count, radius);
    let to_those = |new: &[DVec2]| {
        stay.iter().flat_map(|s| new.iter().map(|n| s.distance(*n))).fold(f64::INFINITY, f64::min)
    };
    let distance = |new: &[DVec2]| to_those(new).min(least_distance(new));
    if distance(&furthest) > distance(&left) + 1e-9 { furthest } else { left }
}

/// The places that are left when each of these mouths, in order, has taken the nearest one.
fn without_nearest(mut places: Vec<DVec2>, mouths: &[DVec2]) -> Vec<DVec2> {
    for mouth in mouths {
        let distance = |k: &usize| places[*k].distance_squared(*mouth);
        if let Some(k) = (0..places.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))) {
            places.remove(k);
        }
    }
    places
}

/// Greedily, of places on a grid over the disc.
fn furthest_from(stay: &[DVec2], count: usize, radius: f64) -> Vec<DVec2> {
    const HALF: i32 = 24;
    let grid =
        (-HALF..=HALF).flat_map(|i| (-HALF..=HALF).map(move |j| DVec2::new(f64::from(i), f64::from(j))));
    let on_disc: Vec<DVec2> =
        grid.map(|at| at * radius / f64::from(HALF)).filter(|at| at.length() <= radius).collect();
    let mut taken = stay.to_vec();
    for _ in 0..count {
        let room = |at: &DVec2| taken.iter().fold(f64::INFINITY, |least, t| least.min(t.distance(*at)));
        let best = on_disc.iter().max_by(|a, b| room(a).total_cmp(&room(b)));
        taken.extend(best.copied());
    }
    taken.split_off(stay.len())
}

/// Which place each fibre takes: the assignment of least summed squared distance to where each would like to start, by exchanging
/// two for as long as that helps.
pub fn assign(wishes: &[DVec2], places: &[DVec2]) -> Vec<usize> {
    let mut taken: Vec<usize> = (0..wishes.len()).collect();
    let cost = |fibre: usize, place: usize| wishes[fibre].distance_squared(places[place]);
    loop {
        let mut changed = false;
        for a in 0..taken.len() {
            for b in 0..a {
                let now = cost(a, taken[a]) + cost(b, taken[b]);
                if cost(a, taken[b]) + cost(b, taken[a]) < now - 1e-12 {
                    taken.swap(a, b);
                    changed = true;
                }
            }
        }
        if !changed {
            return taken;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seven_mouths_are_a_hexagon_with_its_centre() {
        let seven = places(7, 2.0);
        assert!((least_distance(&seven) - 2.0).abs() < 1e-9, "{seven:?}");
        assert_eq!(places(1, 2.0), [DVec2::ZERO]);
        assert!((least_distance(&places(2, 2.0)) - 4.0).abs() < 1e-9);
    }

    #[test]
    fn more_mouths_stay_on_the_disc_and_apart() {
        for count in 1..=30 {
            let places = places(count, 1.625);
            assert_eq!(places.len(), count);
            assert!(places.iter().all(|p| p.length() <= 1.625 + 1e-9));
            assert!(least_distance(&places) > 0.5 * 1.625 / (count as f64).sqrt(), "{count}");
        }
    }

    #[test]
    fn mouths_that_stay_take_the_nearest_place_each() {
        let places = || vec![DVec2::X, DVec2::Y, -DVec2::X];
        assert_eq!(without_nearest(places(), &[]), places());
        assert_eq!(without_nearest(places(), &[DVec2::Y * 0.9]), [DVec2::X, -DVec2::X]);
        assert_eq!(without_nearest(places(), &[DVec2::X, DVec2::X]), [-DVec2::X]);
        assert_eq!(without_nearest(places(), &[DVec2::ZERO; 4]), []);
    }

    #[test]
    fn a_new_mouth_has_as_much_room_as_those_that_stay_leave() {
        let stay = places(7, 2.0);
        assert_eq!(beside(&stay[1..], 1, 2.0), stay[..1]);
        assert_eq!(beside(&[], 7, 2.0), stay);
        assert_eq!(beside(&stay, 0, 2.0), []);
        let eighth = beside(&stay, 1, 2.0);
        let all = [stay.as_slice(), &eighth].concat();
        assert!(eighth[0].length() <= 2.0 && least_distance(&all) > 1.0, "{all:?}");
    }

    #[test]
    fn fibres_start_on_the_side_they_leave_to() {
        let places = [DVec2::X, DVec2::Y, -DVec2::X];
        let wishes = [-DVec2::X * 3.0, DVec2::X * 0.1, DVec2::Y];
        assert_eq!(assign(&wishes, &places), [2, 0, 1]);
    }
}
