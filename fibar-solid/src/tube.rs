//! Tubes about a polyline, of several radii, with exact walls between them.
//!
//! ```text
//! d_i   direction of segment i          N    sides of the cross-section, a regular polygon
//! p_i   joint between i − 1 and i       a    its apothem: distance of its sides from the axis
//! m_i   normal of the mitre at p_i      R    its circumradius, a / cos(π/N)
//! ```
//!
//! Each segment is a prism along `d_i`, cut at both ends by the mitre planes that halve the turn to its neighbours. The
//! cross-section is carried over a joint by the least rotation (parallel transport, the rotation-minimising frame of a
//! polyline), under which the two prisms meet in the mitre plane exactly. So walls are planar, and tubes of apothems `a`
//! and `b` about the same axis are exactly `b − a` apart, at every joint and for any turn.
//!
//! A mitre is possible while `R·(tan θ_i/2 + tan θ_i+1/2)` is less than the segment's length, that is, while the bend
//! radius exceeds R. Where it is not, where it would stick out by more than the chord error, and where the axis comes
//! back to itself, the tube is cut into runs, each a solid of its own with flat ends, and an elbow fills the gap between
//! them (`elbow.rs`). The union of the parts is a valid solid whatever the axis does. Where it folds over itself the walls
//! follow from distances alone: all within `a` of the axis is inside, all beyond `R` but for the mitres is outside.

use crate::ball::ball_frequency;
use crate::elbow::{Elbow, elbow_corners};
use crate::polyline::{PolylineOptions, polyline};
use crate::runs::cut_into_runs;
use crate::{Solid, SolidError};
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_geometry::curve::Curve;
use glam::DVec3;
use std::f64::consts::{PI, TAU};
use std::ops::Range;

/// How an axis is tessellated. One axis serves all layers of a fibre, or their walls would not match.
#[derive(Clone, Copy, Debug)]
pub struct AxisOptions {
    /// Radius of the outermost layer, mm.
    pub outer_radius: f64,
    /// Greatest distance of the polyline from the curve, and of a corner from the round tube, mm.
    pub chord_error: f64,
    /// Straight continuation before the start, mm.
    pub extend_start: f64,
    /// Straight continuation past the end, mm.
    pub extend_end: f64,
}

/// One of the nested tubes about an axis.
#[derive(Clone, Copy, Debug)]
pub struct Layer {
    /// Distance of the sides from the axis, mm.
    pub apothem: f64,
    /// How far the tube goes on past either end of the axis, mm. Layers that end in one plane and are subtracted from each
    /// other leave membranes there, as thick as rounding; an inner layer that stands out leaves none.
    pub overhang: f64,
}

/// A tessellated axis, ready to be given a radius.
#[derive(Clone, Debug)]
pub struct Axis {
    points: Vec<DVec3>,
    /// One direction and cross-section frame per segment.
    frames: Vec<SegmentFrame>,
    /// Segments that form one mitred solid each.
    runs: Vec<Range<usize>>,
    sides: usize,
    max_turn: f64,
    /// Fineness of the balls at hairpins; the same for all layers, or their walls would not match.
    ball_frequency: usize,
}

/// Right-handed axes of a segment's cross-section.
#[derive(Clone, Copy, Debug)]
struct SegmentFrame {
    direction: DVec3,
    first: DVec3,
    second: DVec3,
}

impl Axis {
    /// Tessellates a curve; an error when it has no length or the options are not positive lengths.
    pub fn new(curve: &Curve, options: AxisOptions) -> Result<Axis, SolidError> {
        let AxisOptions { outer_radius, chord_error, .. } = options;
        if !(outer_radius > 0.0 && chord_error > 0.0 && chord_error < outer_radius) {
            return Err(SolidError::Argument(format!(
                "a chord error of {chord_error} mm does not suit a radius of {outer_radius} mm"
            )));
        }
        let max_turn = widest_turn(outer_radius, chord_error);
        let points = extend(polyline(curve, PolylineOptions { chord_error, max_turn }), options)
            .ok_or_else(|| SolidError::Argument("the curve has no length".into()))?;
        let sides = side_count(outer_radius, chord_error);
        let frames = transport(&points);
        let reach = outer_radius / libm::cos(PI / sides as f64);
        let runs = cut_into_runs(&points, reach, max_turn);
        let ball_frequency = ball_frequency(reach, chord_error);
        Ok(Axis { points, frames, runs, sides, max_turn, ball_frequency })
    }

    /// Number of sides of the cross-section.
    pub fn sides(&self) -> usize {
        self.sides
    }

    /// Number of joints that no mitre fits, covered by an elbow.
    pub fn elbows(&self) -> usize {
        self.runs.len() - 1
    }

    /// Apothem of the cross-section with the area of a circle, mm.
    pub fn apothem_of_equal_area(&self, radius: f64) -> f64 {
        let half_angle = PI / self.sides as f64;
        radius * (half_angle / libm::tan(half_angle)).sqrt()
    }

    /// Apothem of the layer around one of apothem `inner` that leaves a wall, mm.
    ///
    /// Without elbows that is their sum. Where tubes fold over themselves at elbows, only distances from the axis
    /// count: the inner layer stays within its circumradius, the outer holds all within its apothem.
    pub fn apothem_around(&self, inner: f64, wall: f64) -> f64 {
        if self.elbows() == 0 { inner + wall } else { inner / libm::cos(PI / self.sides as f64) + wall }
    }

    /// A tube, as parts that overlap where the axis is too tight for one; their union is the tube.
    pub fn tube(&self, Layer { apothem, overhang }: Layer) -> Result<Vec<Solid>, SolidError> {
        let circumradius = apothem / libm::cos(PI / self.sides as f64);
        let mut parts = Vec::with_capacity(2 * self.runs.len());
        for run in &self.runs {
            parts.push(Solid::from_mesh(&self.mitred_run(run.clone(), circumradius, overhang))?);
        }
        for run in &self.runs[1..] {
            parts.push(Solid::hull(&self.elbow(run.start, circumradius)?)?);
        }
        Ok(parts)
    }

    /// Corners of the convex solid between the flat ends that meet at a joint.
    fn elbow(&self, joint: usize, circumradius: f64) -> Result<Vec<DVec3>, SolidError> {
        let ring = |segment| (0..self.sides).map(|side| self.offset(segment, side, circumradius)).collect();
        let elbow = Elbow {
            joint: self.points[joint],
            before: self.frames[joint - 1].direction,
            after: self.frames[joint].direction,
            end: ring(joint - 1),
            start: ring(joint),
            max_turn: self.max_turn,
        };
        elbow_corners(&elbow, circumradius, self.ball_frequency)
    }

    /// A closed mesh: a ring of vertices per joint, flat ends; those of the whole axis stand out by `overhang`.
    fn mitred_run(&self, run: Range<usize>, circumradius: f64, overhang: f64) -> TriangleMesh {
        let rings = run.len() + 1;
        let mut mesh = TriangleMesh::default();
        for joint in run.start..=run.end {
            let shift = self.outwards(joint) * overhang;
            let corner = |side| self.corner(&run, joint, side, circumradius) + shift;
            mesh.vertices.extend((0..self.sides).map(corner));
        }
        let n = self.sides as u32;
        for (ring, side) in (0..rings as u32 - 1).flat_map(|ring| (0..n).map(move |side| (ring, side))) {
            let (a, b) = (ring * n + side, ring * n + (side + 1) % n);
            mesh.triangles.extend([[a, b, b + n], [a, b + n, a + n]]);
        }
        let last = (rings as u32 - 1) * n;
        for side in 1..n - 1 {
            mesh.triangles.extend([[0, side + 1, side], [last, last + side, last + side + 1]]);
        }
        mesh
    }

    /// Direction in which the axis ends at its first and last joint; zero at all others.
    fn outwards(&self, joint: usize) -> DVec3 {
        match joint {
            0 => -self.frames[0].direction,
            last if last == self.frames.len() => self.frames[last - 1].direction,
            _ => DVec3::ZERO,
        }
    }

    /// A corner of the cross-section, slid along its segment onto the mitre plane of the joint.
    fn corner(&self, run: &Range<usize>, joint: usize, side: usize, circumradius: f64) -> DVec3 {
        let segment = if joint == run.start { joint } else { joint - 1 };
        let frame = self.frames[segment];
        let offset = self.offset(segment, side, circumradius);
        if joint == run.start || joint == run.end {
            return self.points[joint] + offset;
        }
        let mitre = frame.direction + self.frames[joint].direction;
        self.points[joint] + offset - frame.direction * (offset.dot(mitre) / frame.direction.dot(mitre))
    }

    /// A corner of a segment's cross-section, as seen from the axis.
    fn offset(&self, segment: usize, side: usize, circumradius: f64) -> DVec3 {
        let frame = self.frames[segment];
        let (sine, cosine) = libm::sincos(TAU * side as f64 / self.sides as f64);
        (frame.first * cosine + frame.second * sine) * circumradius
    }
}

/// Sides whose corners stand off a circle around which they run by at most the chord error.
fn side_count(radius: f64, chord_error: f64) -> usize {
    let half_angle = libm::acos(radius / (radius + chord_error));
    ((PI / half_angle).ceil() as usize).clamp(8, 256)
}

/// The turn at which a mitre's outer corner stands off the round joint by the chord error, rad.
fn widest_turn(radius: f64, chord_error: f64) -> f64 {
    2.0 * libm::acos(radius / (radius + chord_error))
}

/// Adds the straight continuations; `None` for a polyline without length.
fn extend(mut points: Vec<DVec3>, options: AxisOptions) -> Option<Vec<DVec3>> {
    let (&[start, second, ..], &[.., last_but_one, end]) = (points.as_slice(), points.as_slice()) else {
        return None;
    };
    if options.extend_start > 0.0 {
        points[0] = start - (second - start).normalize() * options.extend_start;
    }
    if options.extend_end > 0.0 {
        let last = points.len() - 1;
        points[last] = end + (end - last_but_one).normalize() * options.extend_end;
    }
    Some(points)
}

/// Frames carried from segment to segment by the least rotation that turns `d_i−1` into `d_i`.
fn transport(points: &[DVec3]) -> Vec<SegmentFrame> {
    let directions: Vec<DVec3> = points.windows(2).map(|p| (p[1] - p[0]).normalize()).collect();
    let mut first = directions[0].any_orthonormal_vector();
    let mut previous = directions[0];
    let mut frames = Vec::with_capacity(directions.len());
    for direction in directions {
        first = carry(first, previous, direction);
        frames.push(SegmentFrame { direction, first, second: direction.cross(first) });
        previous = direction;
    }
    frames
}

/// A vector across `from`, after the least rotation that turns `from` into `to`.
fn carry(vector: DVec3, from: DVec3, to: DVec3) -> DVec3 {
    let halving = 1.0 + from.dot(to);
    if halving < 1e-9 {
        return to.any_orthonormal_vector();
    }
    let carried = vector - (from + to) * (vector.dot(to) / halving);
    (carried - to * carried.dot(to)).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(curve: &Curve, chord_error: f64) -> Axis {
        let options = AxisOptions { outer_radius: 1.875, chord_error, extend_start: 0.0, extend_end: 0.0 };
        Axis::new(curve, options).unwrap()
    }

    fn through(points: &[[f64; 3]]) -> Curve {
        let points: Vec<DVec3> = points.iter().map(|&p| p.into()).collect();
        Curve::clamped_uniform(3.min(points.len() - 1), &points).unwrap()
    }

    fn arc(radius: f64) -> Curve {
        let points = [DVec3::X, DVec3::X + DVec3::Y, DVec3::Y].map(|p| p * radius);
        Curve::new(2, vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0], &points, &[1.0, 0.5f64.sqrt(), 1.0]).unwrap()
    }

    /// Axes from friendly to impossible: straight, arcs down to less than the tube, a kink, a hairpin, a crossing.
    fn zoo() -> Vec<(&'static str, Curve)> {
        vec![
            ("straight", through(&[[0.0; 3], [0.0, 0.0, 30.0]])),
            ("wide arc", arc(40.0)),
            ("arc", arc(5.0)),
            ("tight arc", arc(2.4)),
            ("arc within the tube", arc(1.0)),
            (
                "kink",
                through(&[[0.0; 3], [9.0, 0.0, 0.0], [9.0, 0.0, 0.0], [9.0, 0.0, 0.0], [9.0, 9.0, 0.0]]),
            ),
            ("hairpin", through(&[[0.0; 3], [15.0, 0.0, 0.0], [15.0, 1.0, 0.0], [0.0, 1.5, 0.0]])),
            ("back on itself", through(&[[0.0; 3], [15.0, 0.0, 0.0], [1.0, 0.0, 0.0]])),
            ("crossing", through(&[[0.0; 3], [60.0, 0.0, 0.0], [60.0, 60.0, 0.0], [8.0, -40.0, 2.0]])),
            (
                "helix",
                through(&[
                    [9.0, 0.0, 0.0],
                    [0.0, 9.0, 3.0],
                    [-9.0, 0.0, 6.0],
                    [0.0, -9.0, 9.0],
                    [9.0, 0.0, 12.0],
                ]),
            ),
        ]
    }

    fn apothems(axis: &Axis) -> [f64; 3] {
        let cladding = axis.apothem_around(0.87, 0.5);
        [0.87, cladding, axis.apothem_around(cladding, 0.5)]
    }

    fn bare(apothem: f64) -> Layer {
        Layer { apothem, overhang: 0.0 }
    }

    fn unite(axis: &Axis, apothem: f64) -> Solid {
        Solid::union(&axis.tube(bare(apothem)).unwrap()).unwrap().without_specks(1e-6).unwrap()
    }

    #[test]
    fn a_straight_tube_has_the_volume_of_its_prism() {
        let axis = axis(&zoo()[0].1, 0.02);
        let tube = Solid::union(&axis.tube(bare(1.0)).unwrap()).unwrap();
        let area = axis.sides() as f64 * libm::tan(PI / axis.sides() as f64);
        assert!((tube.volume() - 30.0 * area).abs() < 1e-9);
        let round = axis.apothem_of_equal_area(1.0);
        let tube = Solid::union(&axis.tube(bare(round)).unwrap()).unwrap();
        assert!((tube.volume() - 30.0 * PI).abs() < 1e-9);
    }

    #[test]
    fn an_arc_has_the_volume_of_a_torus() {
        for radius in [40.0, 5.0] {
            let axis = axis(&arc(radius), 0.005);
            assert_eq!(axis.elbows(), 0, "radius {radius}");
            let tube = Solid::union(&axis.tube(bare(axis.apothem_of_equal_area(1.875))).unwrap()).unwrap();
            let expected = PI * PI / 2.0 * radius * 1.875 * 1.875;
            assert!((tube.volume() / expected - 1.0).abs() < 2e-3, "radius {radius}: {tube:?}");
        }
    }

    #[test]
    fn every_axis_gives_one_solid_that_grows_with_its_radius() {
        for (name, curve) in zoo() {
            let axis = axis(&curve, 0.05);
            let tubes = apothems(&axis).map(|apothem| unite(&axis, apothem));
            for tube in &tubes {
                assert_eq!(tube.components().unwrap().len(), 1, "{name}");
                let least = PI * 0.87 * 0.87 * curve.length() * 0.4;
                assert!(tube.volume() > least, "{name}: {tube:?}");
            }
            let sticks_out = |inner: &Solid, outer: &Solid| {
                let trimmed = inner.intersect(outer).unwrap();
                inner.volume() - trimmed.volume()
            };
            assert!(sticks_out(&tubes[0], &tubes[1]) < 1e-6, "{name}: core in cladding");
            assert!(sticks_out(&tubes[1], &tubes[2]) < 1e-6, "{name}: cladding in black");
        }
    }

    /// Walls by brute force: from points of the core's surface to the cladding's, flat ends aside.
    #[test]
    fn walls_are_what_the_apothems_say() {
        for (name, curve) in zoo() {
            let axis = axis(&curve, 0.05);
            let [core, cladding, _] = apothems(&axis).map(|apothem| unite(&axis, apothem).to_mesh().unwrap());
            let surface = fibar_geometry::distance::Surface::new(&cladding).unwrap();
            let ends = [axis.points[0], axis.points[axis.points.len() - 1]];
            let centres = (0..core.triangles.len()).map(|t| core.corners(t).iter().sum::<DVec3>() / 3.0);
            let wall = core
                .vertices
                .iter()
                .copied()
                .chain(centres)
                .filter(|p| ends.iter().all(|end| p.distance(*end) > 1.5))
                .map(|p| surface.closest(p).point.distance(p))
                .fold(f64::MAX, f64::min);
            assert!(wall > 0.5 - 1e-6, "{name}: {wall}");
        }
    }

    #[test]
    fn only_impossible_bends_are_cut() {
        let mut cut: Vec<&str> = Vec::new();
        for (name, curve) in zoo() {
            if axis(&curve, 0.05).elbows() > 0 {
                cut.push(name);
            }
        }
        assert_eq!(cut, ["arc within the tube", "kink", "hairpin", "back on itself", "crossing"]);
    }

    #[test]
    fn nonsense_is_refused() {
        let options =
            AxisOptions { outer_radius: 1.0, chord_error: 0.02, extend_start: 0.0, extend_end: 0.0 };
        assert!(Axis::new(&through(&[[1.0; 3], [1.0; 3]]), options).is_err());
        assert!(Axis::new(&arc(5.0), AxisOptions { chord_error: 0.0, ..options }).is_err());
        assert!(Axis::new(&arc(5.0), AxisOptions { outer_radius: f64::NAN, ..options }).is_err());
    }
}
