//! `sockets.json`: where the LEDs sit, and what else is cut out of the base: compartments for a board, a battery.

use super::{check_finite, check_unit, document};
use crate::id::{LedId, PatternId};
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// All LED sockets of an object.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sockets {
    /// `"fibar.sockets/1"`.
    pub format: String,
    /// Hole that takes one LED.
    pub hole: Hole,
    /// The sockets, in order of LED.
    pub sockets: Vec<Socket>,
    /// Compartments beside them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cavities: Vec<Cavity>,
}

/// The cylinder cut out for an LED, from its tip back through the base.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hole {
    /// Diameter, mm.
    pub diameter_mm: f64,
    /// From the LED's tip to the base, mm.
    pub depth_mm: f64,
}

/// One LED's place.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Socket {
    /// Which LED.
    pub led: LedId,
    /// What it blinks.
    pub pattern: PatternId,
    /// The LED's tip, where its fibres start, mm.
    pub position: DVec3,
    /// Unit vector from the LED into the body.
    pub axis: DVec3,
}

/// A compartment: a straight prism, cut out from its ceiling back through the base.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cavity {
    /// What it is for.
    pub name: String,
    /// Middle of its ceiling, mm: as an LED's tip is of its hole.
    pub position: DVec3,
    /// Unit vector from the base into the body.
    pub axis: DVec3,
    /// Unit vector across the axis, along which a rectangle is wide.
    pub across: DVec3,
    /// What it looks like from below.
    pub section: Section,
    /// From the ceiling to the base, mm.
    pub depth_mm: f64,
}

/// Cross-section of a cavity about its axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub enum Section {
    /// For a board.
    Rectangle {
        /// Along `across`, mm.
        width_mm: f64,
        /// Square to it, mm.
        length_mm: f64,
    },
    /// For a cell.
    Circle {
        /// Diameter, mm.
        diameter_mm: f64,
    },
}

impl Section {
    /// Half the width and half the length of the box around it, mm.
    pub fn half_size(self) -> [f64; 2] {
        match self {
            Section::Rectangle { width_mm, length_mm } => [width_mm / 2.0, length_mm / 2.0],
            Section::Circle { diameter_mm } => [diameter_mm / 2.0; 2],
        }
    }
}

impl Sockets {
    /// A document of the current format.
    pub fn new(hole: Hole, sockets: Vec<Socket>) -> Self {
        Sockets { format: "fibar.sockets/1".into(), hole, sockets, cavities: Vec::new() }
    }

    /// With compartments beside the LEDs.
    pub fn with_cavities(self, cavities: Vec<Cavity>) -> Self {
        Sockets { cavities, ..self }
    }
}

document!(Sockets, "fibar.sockets/1", |s| {
    if s.sockets.is_empty() {
        return Err("there is no socket".into());
    }
    if !(s.hole.diameter_mm > 0.0
        && s.hole.depth_mm > 0.0
        && s.hole.diameter_mm.is_finite()
        && s.hole.depth_mm.is_finite())
    {
        return Err(format!(
            "the hole must have a positive size, has Ø {} × {} mm",
            s.hole.diameter_mm, s.hole.depth_mm
        ));
    }
    for (k, socket) in s.sockets.iter().enumerate() {
        check_finite(&format!("sockets[{k}].position"), socket.position)?;
        check_unit(&format!("sockets[{k}].axis"), socket.axis)?;
        if s.sockets[..k].iter().any(|o| o.led == socket.led || o.pattern == socket.pattern) {
            return Err(format!("sockets[{k}] repeats LED {} or pattern {}", socket.led, socket.pattern));
        }
    }
    s.cavities.iter().enumerate().try_for_each(|(k, cavity)| check_cavity(k, cavity, &s.cavities[..k]))
});

fn check_cavity(k: usize, cavity: &Cavity, before: &[Cavity]) -> Result<(), String> {
    check_finite(&format!("cavities[{k}].position"), cavity.position)?;
    check_unit(&format!("cavities[{k}].axis"), cavity.axis)?;
    check_unit(&format!("cavities[{k}].across"), cavity.across)?;
    if cavity.axis.dot(cavity.across).abs() > 1e-6 {
        return Err(format!("cavities[{k}].across is not square to its axis"));
    }
    let [width, length] = cavity.section.half_size();
    if [width, length, cavity.depth_mm].iter().any(|size| !(size.is_finite() && *size > 0.0)) {
        return Err(format!("cavities[{k}] must have a positive size"));
    }
    match before.iter().any(|other| other.name == cavity.name) || cavity.name.is_empty() {
        true => Err(format!("cavities[{k}] needs a name of its own, has \"{}\"", cavity.name)),
        false => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::artefact::Document;

    fn sockets(cavities: Vec<Cavity>) -> Sockets {
        let socket =
            Socket { led: LedId(0), pattern: PatternId(1), position: DVec3::Z * 8.6, axis: DVec3::Z };
        Sockets::new(Hole { diameter_mm: 5.2, depth_mm: 8.6 }, vec![socket]).with_cavities(cavities)
    }

    fn board() -> Cavity {
        Cavity {
            name: "board".into(),
            position: DVec3::new(20.0, 0.0, 6.0),
            axis: DVec3::Z,
            across: DVec3::X,
            section: Section::Rectangle { width_mm: 20.0, length_mm: 30.0 },
            depth_mm: 6.0,
        }
    }

    #[test]
    fn cavities_come_back_as_they_went() {
        let cell = Cavity { name: "cell".into(), section: Section::Circle { diameter_mm: 20.2 }, ..board() };
        for cavities in [vec![], vec![board()], vec![board(), cell]] {
            let sockets = sockets(cavities);
            assert_eq!(Sockets::from_json(&sockets.to_json()).unwrap(), sockets);
        }
        assert!(!String::from_utf8(sockets(vec![]).to_json()).unwrap().contains("cavities"));
    }

    #[test]
    fn cavities_that_break_promises_are_refused() {
        let check = |cavities: Vec<Cavity>, says: &str| {
            let error = Sockets::from_json(&sockets(cavities).to_json()).unwrap_err().to_string();
            assert!(error.contains(says), "{error:?} does not say {says:?}");
        };
        check(vec![board(), board()], "cavities[1] needs a name of its own");
        check(vec![Cavity { axis: DVec3::Z * 2.0, ..board() }], "cavities[0].axis");
        check(vec![Cavity { across: DVec3::Z, ..board() }], "not square to its axis");
        check(vec![Cavity { depth_mm: 0.0, ..board() }], "must have a positive size");
        let flat = Section::Rectangle { width_mm: 3.0, length_mm: -1.0 };
        check(vec![Cavity { section: flat, ..board() }], "must have a positive size");
    }
}
