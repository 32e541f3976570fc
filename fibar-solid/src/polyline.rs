//! Curves as polylines within a chord error: few points where the curve is straight, many where it bends.

use fibar_geometry::curve::Curve;
use glam::DVec3;

/// How closely a polyline follows its curve.
#[derive(Clone, Copy, Debug)]
pub struct PolylineOptions {
    /// Greatest distance of the curve from its chord, mm.
    pub chord_error: f64,
    /// Greatest turn from one chord to the next, rad; kinks of the curve itself aside.
    pub max_turn: f64,
}

/// Share of the tolerances that the fine polyline takes; the rest is for dropping points of it.
const FINE: f64 = 0.25;
/// Halvings of a knot span after which a kink is taken for what it is.
const DEEPEST: u32 = 12;

/// Points of the curve from its first to its last, no two of them equal.
pub fn polyline(curve: &Curve, options: PolylineOptions) -> Vec<DVec3> {
    let fine = PolylineOptions { chord_error: options.chord_error * FINE, max_turn: options.max_turn * FINE };
    let breaks = curve.breaks();
    let mut points = vec![curve.point(breaks[0])];
    for span in breaks.windows(2) {
        let middle = 0.5 * (span[0] + span[1]);
        refine(curve, [span[0], middle], fine, DEEPEST, &mut points);
        refine(curve, [middle, span[1]], fine, DEEPEST, &mut points);
    }
    points.dedup_by(|next, kept| next.distance(*kept) < 1e-9);
    thin(&points, options)
}

/// Appends points of the interval, its start excluded.
fn refine(curve: &Curve, [from, to]: [f64; 2], fine: PolylineOptions, depth: u32, points: &mut Vec<DVec3>) {
    let middle = 0.5 * (from + to);
    let (start, centre, end) = (curve.point(from), curve.point(middle), curve.point(to));
    let turn = angle(centre - start, end - centre);
    let is_flat = distance_to_segment(centre, start, end) <= fine.chord_error;
    let is_straight = turn <= fine.max_turn || start.distance(end) < fine.chord_error;
    if depth == 0 || (is_flat && is_straight) {
        points.extend([centre, end]);
        return;
    }
    refine(curve, [from, middle], fine, depth - 1, points);
    refine(curve, [middle, to], fine, depth - 1, points);
}

/// Drops points greedily: each chord reaches as far as the tolerances allow.
fn thin(points: &[DVec3], options: PolylineOptions) -> Vec<DVec3> {
    let mut kept = vec![points[0]];
    let mut from = 0;
    while from + 1 < points.len() {
        let mut to = from + 1;
        while to + 1 < points.len() && may_skip(&points[from..=to + 1], options) {
            to += 1;
        }
        kept.push(points[to]);
        from = to;
    }
    kept
}

/// Whether the chord from the first to the last point stands for all between.
fn may_skip(points: &[DVec3], options: PolylineOptions) -> bool {
    let (first, last) = (points[0], points[points.len() - 1]);
    let budget = options.chord_error * (1.0 - FINE);
    let near = points[1..points.len() - 1].iter().all(|p| distance_to_segment(*p, first, last) <= budget);
    let turn = angle(points[1] - first, last - points[points.len() - 2]);
    near && turn <= options.max_turn * (1.0 - FINE)
}

/// Angle between two vectors, rad; 0 when one of them is zero.
pub(crate) fn angle(one: DVec3, other: DVec3) -> f64 {
    libm::atan2(one.cross(other).length(), one.dot(other))
}

fn distance_to_segment(point: DVec3, start: DVec3, end: DVec3) -> f64 {
    let along = end - start;
    let share = (point - start).dot(along) / along.length_squared().max(f64::MIN_POSITIVE);
    point.distance(start + along * share.clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Quarter circle as a rational quadratic.
    fn quarter(radius: f64) -> Curve {
        let points = [DVec3::X, DVec3::X + DVec3::Y, DVec3::Y].map(|p| p * radius);
        Curve::new(2, vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0], &points, &[1.0, 0.5f64.sqrt(), 1.0]).unwrap()
    }

    #[test]
    fn chords_stay_within_the_error_and_are_few() {
        for (radius, chord_error) in [(2.0, 0.02), (20.0, 0.02), (60.0, 0.01), (60.0, 0.1)] {
            let points = polyline(&quarter(radius), PolylineOptions { chord_error, max_turn: 0.3 });
            let worst = points.windows(2).map(|p| radius - (p[0] + p[1]).length() / 2.0).fold(0.0, f64::max);
            assert!(worst <= chord_error, "radius {radius}: {worst}");
            let least = std::f64::consts::FRAC_PI_2 / (8.0 * chord_error / radius).sqrt();
            assert!((points.len() as f64) < 2.0 * least + 3.0, "radius {radius}: {} points", points.len());
            assert_eq!(points.first().unwrap().x, radius);
            assert_eq!(points.last().unwrap().y, radius);
        }
    }

    #[test]
    fn a_straight_curve_is_one_chord() {
        let points: Vec<DVec3> = (0..12).map(|k| DVec3::new(f64::from(k), 0.0, 0.0)).collect();
        let curve = Curve::clamped_uniform(3, &points).unwrap();
        let options = PolylineOptions { chord_error: 0.01, max_turn: 0.2 };
        assert_eq!(polyline(&curve, options), [points[0], points[11]]);
    }

    #[test]
    fn a_kink_ends() {
        let points = [DVec3::ZERO, DVec3::X * 5.0, DVec3::X * 5.0, DVec3::X * 5.0, DVec3::new(5.0, 5.0, 0.0)];
        let curve = Curve::clamped_uniform(2, &points).unwrap();
        let points = polyline(&curve, PolylineOptions { chord_error: 0.01, max_turn: 0.2 });
        assert!(points.len() < 60, "{} points", points.len());
    }
}
