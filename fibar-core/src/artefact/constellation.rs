//! `constellation.json`: all the tracker needs to know of an object.

use super::{check_finite, check_unit, document};
use crate::code::{bits_from_str, bits_to_string};
use crate::id::{MarkerId, PatternId};
use glam::DVec3;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Markers, their codes and the lookup table of Tone 2020, "Marker ID recognition".
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Constellation {
    /// `"fibar.constellation/1"`.
    pub format: String,
    /// Blinking speed, bit/s.
    pub bit_rate_hz: f64,
    /// The codes, in order of pattern.
    pub patterns: Vec<Pattern>,
    /// The markers, in order of id.
    pub markers: Vec<Marker>,
}

/// A pattern and the bits that it repeats.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pattern {
    /// Which pattern.
    pub id: PatternId,
    /// One period, first bit first; text of `0` and `1` in the file.
    #[serde(serialize_with = "write_bits", deserialize_with = "read_bits")]
    pub bits: Vec<bool>,
}

/// One marker.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Marker {
    /// Its name, unique.
    pub id: MarkerId,
    /// On the outer surface, mm.
    pub position: DVec3,
    /// Outward unit normal.
    pub normal: DVec3,
    /// What it blinks.
    pub pattern: PatternId,
    /// Sequences of the neighbours' patterns, clockwise as seen from outside; the paper stores one per marker.
    pub neighbours: Vec<Vec<PatternId>>,
}

impl Constellation {
    /// A document of the current format.
    pub fn new(bit_rate_hz: f64, patterns: Vec<Pattern>, markers: Vec<Marker>) -> Self {
        Constellation { format: "fibar.constellation/1".into(), bit_rate_hz, patterns, markers }
    }
}

fn write_bits<S: Serializer>(bits: &[bool], s: S) -> Result<S::Ok, S::Error> {
    s.serialize_str(&bits_to_string(bits))
}

fn read_bits<'de, D: Deserializer<'de>>(d: D) -> Result<Vec<bool>, D::Error> {
    let text = String::deserialize(d)?;
    bits_from_str(&text)
        .ok_or_else(|| serde::de::Error::custom(format!("bits must be 0 and 1 only, got \"{text}\"")))
}

document!(Constellation, "fibar.constellation/1", |c| {
    if !(c.bit_rate_hz > 0.0 && c.bit_rate_hz.is_finite()) {
        return Err(format!("bit_rate_hz must be positive, is {}", c.bit_rate_hz));
    }
    if !c.patterns.is_sorted_by(|a, b| a.id < b.id) {
        return Err("patterns must be in order of id, each once".into());
    }
    if !c.markers.is_sorted_by(|a, b| a.id < b.id) {
        return Err("markers must be in order of id, each once".into());
    }
    let known = |p: &PatternId| c.patterns.binary_search_by_key(p, |q| q.id).is_ok();
    for marker in &c.markers {
        check_finite(&format!("marker {}: position", marker.id), marker.position)?;
        check_unit(&format!("marker {}: normal", marker.id), marker.normal)?;
        let named = std::iter::once(&marker.pattern).chain(marker.neighbours.iter().flatten());
        if let Some(stranger) = named.into_iter().find(|p| !known(p)) {
            return Err(format!("marker {} names pattern {stranger}, which has no code", marker.id));
        }
    }
    Ok(())
});
