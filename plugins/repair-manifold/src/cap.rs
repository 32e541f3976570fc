//! Triangles over a rim: the cap of least area (Barequet & Sharir 1995), of all that use the rim's vertices alone.

use glam::DVec3;

/// Rims of more vertices are first cut in two by a short chord: the search takes cubic time.
const SEARCHED: usize = 160;

/// Triangles, by index into the rim, that close a rim; they run along it in its own direction.
pub fn cap(rim: &[DVec3]) -> Vec<[usize; 3]> {
    let mut triangles = Vec::new();
    let mut waiting = vec![(0..rim.len()).collect::<Vec<usize>>()];
    while let Some(part) = waiting.pop() {
        if part.len() <= SEARCHED {
            search(rim, &part, &mut triangles);
        } else {
            waiting.extend(cut_in_two(rim, &part));
        }
    }
    triangles
}

/// Cuts by the chord that is shortest for what it cuts off; each part keeps at least a quarter of the vertices.
fn cut_in_two(rim: &[DVec3], part: &[usize]) -> [Vec<usize>; 2] {
    let count = part.len();
    let chords =
        (0..count).flat_map(|i| (i + count / 4..count.min(i + count - count / 4)).map(move |j| (i, j)));
    let length = |&(i, j): &(usize, usize)| rim[part[i]].distance_squared(rim[part[j]]);
    let best = chords.min_by(|a, b| length(a).total_cmp(&length(b)));
    let (i, j) = best.expect("a part this long has chords");
    [part[i..=j].to_vec(), part[j..].iter().chain(&part[..=i]).copied().collect()]
}

/// Dynamic programming over the chords of a polygon; `best[i][j]` is the least cost of what lies between i and j.
fn search(rim: &[DVec3], part: &[usize], triangles: &mut Vec<[usize; 3]>) {
    let count = part.len();
    let at = |k: usize| rim[part[k]];
    let mut best = vec![vec![(0.0, 0); count]; count];
    for span in 2..count {
        for i in 0..count - span {
            let j = i + span;
            let through = |k: usize| best[i][k].0 + best[k][j].0 + cost([at(i), at(k), at(j)]);
            let options = (i + 1..j).map(|k| (through(k), k));
            best[i][j] = options.min_by(|a, b| a.0.total_cmp(&b.0)).expect("two apart have one between");
        }
    }
    let mut open = if count < 3 { Vec::new() } else { vec![(0, count - 1)] };
    while let Some((i, j)) = open.pop().filter(|(i, j)| j - i > 1).or_else(|| open.pop()) {
        if j - i > 1 {
            let k = best[i][j].1;
            triangles.push([part[i], part[k], part[j]]);
            open.extend([(i, k), (k, j)]);
        }
    }
}

/// Area, and a little for long sides, so that of all caps in a plane the one with short chords is taken.
fn cost([a, b, c]: [DVec3; 3]) -> f64 {
    const SIDES: f64 = 1e-4;
    let area = (b - a).cross(c - a).length() / 2.0;
    area + SIDES * (a.distance_squared(b) + b.distance_squared(c) + c.distance_squared(a))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A rim's cap has its area and two triangles fewer than vertices.
    fn check(rim: &[DVec3], area: f64) {
        let triangles = cap(rim);
        assert_eq!(triangles.len(), rim.len() - 2);
        let of = |[i, j, k]: [usize; 3]| (rim[j] - rim[i]).cross(rim[k] - rim[i]) / 2.0;
        let vector: DVec3 = triangles.iter().map(|&t| of(t)).sum();
        let total: f64 = triangles.iter().map(|&t| of(t).length()).sum();
        assert!((total - area).abs() < 1e-9 * area, "area {total}, not {area}");
        assert!((vector.length() - area).abs() < 1e-9 * area && vector.z > 0.0, "folded or turned: {vector}");
    }

    fn ring(count: usize, radius: impl Fn(usize) -> f64) -> Vec<DVec3> {
        let angle = |k: usize| std::f64::consts::TAU * k as f64 / count as f64;
        (0..count).map(|k| DVec3::new(libm::cos(angle(k)), libm::sin(angle(k)), 0.0) * radius(k)).collect()
    }

    #[test]
    fn flat_rims_get_flat_caps() {
        check(&[DVec3::ZERO, DVec3::X, DVec3::Y], 0.5);
        let arrow = [[0.0, 0.0], [2.0, 1.0], [0.0, 2.0], [1.0, 1.0]];
        check(&arrow.map(|[x, y]| DVec3::new(x, y, 0.0)), 1.0);
        let polygon = |count: usize| count as f64 / 2.0 * libm::sin(std::f64::consts::TAU / count as f64);
        check(&ring(50, |_| 1.0), polygon(50));
        check(&ring(1000, |_| 1.0), polygon(1000));
        check(&ring(40, |k| if k % 2 == 0 { 1.0 } else { 0.5 }), 0.5 * polygon(40));
    }
}
