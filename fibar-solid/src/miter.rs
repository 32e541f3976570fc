//! The point behind a corner that is deep enough under every triangle around it.

use glam::DVec3;

/// More different normals around one corner are not looked at: the search takes all threes of them.
const MOST: usize = 20;
/// Normals nearer than this are one.
const SAME: f64 = 1e-12;

/// Unit normal, outward; zero for a triangle without area.
pub fn unit_normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a).normalize_or_zero()
}

/// The shortest vector `m` with `n · m ≥ 1` for all unit normals: the axis of the least cone that holds them, over the cosine of its
/// half angle. `None` if there is none, or too many normals to tell.
pub fn miter(normals: &[DVec3]) -> Option<DVec3> {
    let mut distinct: Vec<DVec3> = Vec::new();
    for &normal in normals {
        if !distinct.iter().any(|known| known.distance_squared(normal) < SAME) {
            distinct.push(normal);
        }
    }
    if distinct.is_empty() || distinct.len() > MOST {
        return None;
    }
    let found = candidates(&distinct).filter_map(|m| deep_enough(m, normals));
    found.min_by(|a, b| a.length_squared().total_cmp(&b.length_squared()))
}

/// The least cone touches one, two or three of the normals; their mean serves where those are too much alike to tell.
fn candidates(normals: &[DVec3]) -> impl Iterator<Item = DVec3> {
    let mean = normals.iter().sum::<DVec3>().normalize_or_zero();
    let later = |i: usize| normals[i + 1..].iter().copied().enumerate().map(move |(k, n)| (i + 1 + k, n));
    let pairs = (0..normals.len()).flat_map(move |i| later(i).map(move |(_, n)| between(normals[i], n)));
    let threes = (0..normals.len()).flat_map(move |i| {
        later(i).flat_map(move |(k, n)| later(k).filter_map(move |(_, last)| among(normals[i], n, last)))
    });
    std::iter::once(mean).chain(normals.iter().copied()).chain(pairs).chain(threes)
}

fn between(a: DVec3, b: DVec3) -> DVec3 {
    (a + b) / (1.0 + a.dot(b)).max(f64::MIN_POSITIVE)
}

fn among(a: DVec3, b: DVec3, c: DVec3) -> Option<DVec3> {
    let volume = a.dot(b.cross(c));
    (volume.abs() > 1e-6).then(|| (b.cross(c) + c.cross(a) + a.cross(b)) / volume)
}

/// Lengthened until it is deep enough for all normals; at most by what rounding and the candidate's own error ask for.
fn deep_enough(m: DVec3, normals: &[DVec3]) -> Option<DVec3> {
    let least = normals.iter().map(|normal| normal.dot(m)).fold(f64::INFINITY, f64::min);
    (least > 1e-3).then(|| m / least.min(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shortest_point_deep_enough() {
        let check = |normals: &[[f64; 3]], expected: Option<[f64; 3]>| {
            let normals: Vec<DVec3> = normals.iter().map(|n| DVec3::from(*n).normalize()).collect();
            match (miter(&normals), expected.map(DVec3::from)) {
                (Some(found), Some(expected)) => {
                    assert!(found.distance(expected) < 1e-12, "{found} instead of {expected}");
                    assert!(normals.iter().all(|n| n.dot(found) >= 1.0 - 1e-15));
                }
                (found, expected) => assert_eq!(found, expected),
            }
        };
        let [x, y, z] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        check(&[], None);
        check(&[z], Some(z));
        check(&[z, z, z], Some(z));
        check(&[z, [0.0, 0.0, -1.0]], None);
        check(&[x, y, y], Some([1.0, 1.0, 0.0]));
        check(&[x, y, z], Some([1.0, 1.0, 1.0]));
        check(&[x, [1.0, 1.0, 0.0], y], Some([1.0, 1.0, 0.0]));
        // The third lies within the cone of the outer two.
        check(&[[1.0, 0.0, 1.0], [-1.0, 0.0, 1.0], [0.0, 0.1, 1.0]], Some([0.0, 0.0, 2f64.sqrt()]));
        check(&[x, y, z, [-1.0, -1.0, -1.0]], None);
    }
}
