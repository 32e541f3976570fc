//! A parameter that names an axis, and the turn that makes it point up.

use serde::{Deserialize, Serialize};

/// An axis with its sign, as stages that read people's files take it: `up = "+y"`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, schemars::JsonSchema)]
#[expect(missing_docs, reason = "the name says it")]
pub enum Direction {
    #[serde(rename = "+x")]
    PlusX,
    #[serde(rename = "-x")]
    MinusX,
    #[serde(rename = "+y")]
    PlusY,
    #[serde(rename = "-y")]
    MinusY,
    #[serde(rename = "+z")]
    PlusZ,
    #[serde(rename = "-z")]
    MinusZ,
}

impl Direction {
    /// Rows of the rotation by right angles that turns this axis to +Z and keeps +X, where it can.
    pub fn turn_to_z(self) -> [[f64; 3]; 3] {
        const X: [f64; 3] = [1.0, 0.0, 0.0];
        const Y: [f64; 3] = [0.0, 1.0, 0.0];
        const Z: [f64; 3] = [0.0, 0.0, 1.0];
        // Subtraction leaves no negative zero, which would be another byte in a file.
        let minus = |axis: [f64; 3]| axis.map(|x| 0.0 - x);
        match self {
            Direction::PlusZ => [X, Y, Z],
            Direction::MinusZ => [X, minus(Y), minus(Z)],
            Direction::PlusY => [X, minus(Z), Y],
            Direction::MinusY => [X, Z, minus(Y)],
            Direction::PlusX => [minus(Z), Y, X],
            Direction::MinusX => [Z, Y, minus(X)],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Direction::{self, *};

    /// Product of the rows with a vector.
    fn turned(up: Direction, v: [f64; 3]) -> [f64; 3] {
        up.turn_to_z().map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
    }

    #[test]
    fn axes_turn_to_z() {
        let check = |up, axis: [f64; 3]| assert_eq!(turned(up, axis), [0.0, 0.0, 1.0], "{up:?}");
        check(PlusX, [1.0, 0.0, 0.0]);
        check(MinusX, [-1.0, 0.0, 0.0]);
        check(PlusY, [0.0, 1.0, 0.0]);
        check(MinusY, [0.0, -1.0, 0.0]);
        check(PlusZ, [0.0, 0.0, 1.0]);
        check(MinusZ, [0.0, 0.0, -1.0]);
    }

    /// Right-handed: the turned x and y axes span the turned z axis.
    #[test]
    fn every_turn_is_a_rotation() {
        for up in [PlusX, MinusX, PlusY, MinusY, PlusZ, MinusZ] {
            let [x, y, z] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|axis| turned(up, axis));
            let cross = [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]];
            assert_eq!(cross, z, "{up:?}");
            if !matches!(up, PlusX | MinusX) {
                assert_eq!(x, [1.0, 0.0, 0.0], "{up:?}");
            }
        }
    }
}
