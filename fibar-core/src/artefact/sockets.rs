//! `sockets.json`: where the LEDs sit.

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

impl Sockets {
    /// A document of the current format.
    pub fn new(hole: Hole, sockets: Vec<Socket>) -> Self {
        Sockets { format: "fibar.sockets/1".into(), hole, sockets }
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
    Ok(())
});
