//! Gauss points of a course: place, velocity and acceleration at every one, and the way back for gradients.

use super::DEGREE;
use crate::curve::Curve;
use glam::DVec3;

/// Gauss points in a span, and their places and weights on 0..1.
pub const NODES_A_SPAN: usize = 4;
const GAUSS_4: [(f64, f64); NODES_A_SPAN] = [
    (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
    (0.330_009_478_207_571_87, 0.326_072_577_431_273_07),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
];

/// The basis functions at the nodes of all courses of one number of control points.
#[derive(Clone, Debug)]
pub struct Table {
    rows: Vec<Row>,
    count: usize,
}

/// One node: the control points it depends on, its basis functions with two derivatives, its weight in the parameter.
#[derive(Clone, Copy, Debug)]
struct Row {
    first: usize,
    basis: [[f64; DEGREE + 1]; 3],
    parameter: f64,
    weight: f64,
}

/// A course at one node, over the parameter 0..1: place (mm) and two derivatives.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Node {
    /// Place, mm.
    pub position: DVec3,
    /// First derivative, mm.
    pub velocity: DVec3,
    /// Second derivative, mm.
    pub acceleration: DVec3,
    /// Its parameter.
    pub parameter: f64,
    /// Share of the parameter.
    pub weight: f64,
}

/// Derivatives of a cost by what a [`Node`] holds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pull {
    /// By place.
    pub position: DVec3,
    /// By velocity.
    pub velocity: DVec3,
    /// By acceleration.
    pub acceleration: DVec3,
}

impl Row {
    fn at(curve: &Curve, parameter: f64, weight: f64) -> Row {
        let (first, basis) = curve.basis_at(parameter);
        let basis = basis.map(|values| [values[0], values[1], values[2], values[3]]);
        Row { first, basis, parameter, weight }
    }
}

impl Table {
    /// The table for `count` control points.
    pub fn of(count: usize) -> Table {
        let line = vec![DVec3::ZERO; count];
        let curve = Curve::clamped_uniform(DEGREE, &line).expect("a course has six points or more");
        let spans = count - DEGREE;
        let row = |k: usize| {
            let (at, weight) = GAUSS_4[k % NODES_A_SPAN];
            let u = ((k / NODES_A_SPAN) as f64 + at) / spans as f64;
            Row::at(&curve, u, weight / spans as f64)
        };
        Table { rows: (0..spans * NODES_A_SPAN).map(row).collect(), count }
    }

    /// Single places of courses of `count` control points, without weight.
    pub fn at(count: usize, parameters: &[f64]) -> Table {
        let line = vec![DVec3::ZERO; count];
        let curve = Curve::clamped_uniform(DEGREE, &line).expect("a course has six points or more");
        Table { rows: parameters.iter().map(|u| Row::at(&curve, *u, 0.0)).collect(), count }
    }

    /// Number of control points that it is for.
    pub fn control_points(&self) -> usize {
        self.count
    }

    /// The nodes of a course, from LED to marker.
    pub fn sample(&self, points: &[DVec3], nodes: &mut Vec<Node>) {
        nodes.clear();
        nodes.extend(self.rows.iter().map(|row| {
            let points = &points[row.first..=row.first + DEGREE];
            let blend =
                |basis: &[f64; 4]| points.iter().zip(basis).fold(DVec3::ZERO, |sum, (p, b)| sum + *p * *b);
            let [position, velocity, acceleration] = [0, 1, 2].map(|k| blend(&row.basis[k]));
            Node { position, velocity, acceleration, parameter: row.parameter, weight: row.weight }
        }));
    }

    /// Adds the gradient by the control points, given that by the nodes.
    pub fn pull_back(&self, pulls: &[Pull], by_points: &mut [DVec3]) {
        for (row, pull) in self.rows.iter().zip(pulls) {
            for k in 0..=DEGREE {
                by_points[row.first + k] += pull.position * row.basis[0][k]
                    + pull.velocity * row.basis[1][k]
                    + pull.acceleration * row.basis[2][k];
            }
        }
    }
}

/// Tables for any number of control points up to a largest, made once.
#[derive(Clone, Debug)]
pub struct Tables {
    tables: Vec<Table>,
}

/// Most control points of a course.
pub const MOST_POINTS: usize = 64;

impl Tables {
    /// All tables.
    pub fn all() -> Tables {
        Tables { tables: (super::FEWEST_POINTS..=MOST_POINTS).map(Table::of).collect() }
    }

    /// The table for this many control points.
    pub fn of(&self, count: usize) -> &Table {
        &self.tables[count - super::FEWEST_POINTS]
    }
}
