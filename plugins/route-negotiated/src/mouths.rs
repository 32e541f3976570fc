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
    fn fibres_start_on_the_side_they_leave_to() {
        let places = [DVec2::X, DVec2::Y, -DVec2::X];
        let wishes = [-DVec2::X * 3.0, DVec2::X * 0.1, DVec2::Y];
        assert_eq!(assign(&wishes, &places), [2, 0, 1]);
    }
}
