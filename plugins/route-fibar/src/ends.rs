//! Which LED feeds which marker, and the straight pieces at either end of a fibre.

use crate::interior::Interior;
use crate::params::Params;
use fibar_core::artefact::constellation::{Constellation, Marker};
use fibar_core::artefact::sockets::{Socket, Sockets};
use fibar_core::{LedId, MarkerId, PatternId};
use fibar_plugin::StageError;
use glam::DVec3;

/// The two ends of a fibre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ends {
    /// What it carries.
    pub pattern: PatternId,
    /// Where it starts.
    pub led: LedId,
    /// Where it ends.
    pub marker: MarkerId,
    /// The LED's tip and the end of the straight piece above it, mm.
    pub start: [DVec3; 2],
    /// The end of the straight piece below the marker, and the marker, mm.
    pub finish: [DVec3; 2],
}

impl Ends {
    /// The four initial control points (Tone 2020, "Initial routing").
    pub fn control_points(&self) -> [DVec3; 4] {
        let ([a, b], [c, d]) = (self.start, self.finish);
        [a, b, c, d]
    }
}

/// The ends of all fibres, by pattern and then by marker: the order of the fibres.
pub fn of_fibres(
    sockets: &Sockets,
    constellation: &Constellation,
    interior: &Interior,
    params: &Params,
) -> Result<Vec<Ends>, StageError> {
    if constellation.markers.is_empty() {
        return Err(StageError::input("the constellation has no marker").hint("place some"));
    }
    sockets.sockets.iter().try_for_each(|socket| check_socket(socket, interior, params))?;
    let ends = |marker: &Marker| {
        check_marker(marker, interior, params)?;
        ends_of(marker, sockets, params.end_piece_mm)
    };
    let mut ends: Vec<Ends> = constellation.markers.iter().map(ends).collect::<Result<_, _>>()?;
    ends.sort_by_key(|e| (e.pattern, e.marker));
    Ok(ends)
}

fn ends_of(marker: &Marker, sockets: &Sockets, piece_mm: f64) -> Result<Ends, StageError> {
    let feeds = |socket: &&Socket| socket.pattern == marker.pattern;
    let socket = sockets.sockets.iter().find(feeds).ok_or_else(|| {
        StageError::input(format!(
            "marker {} blinks pattern {}, which no LED does",
            marker.id, marker.pattern
        ))
        .hint("give the sockets as many LEDs as the constellation has patterns")
        .place_mm(marker.position.to_array())
    })?;
    Ok(Ends {
        pattern: marker.pattern,
        led: socket.led,
        marker: marker.id,
        start: [socket.position, socket.position + piece_mm * socket.axis],
        finish: [marker.position - piece_mm * marker.normal, marker.position],
    })
}

fn check_socket(socket: &Socket, interior: &Interior, params: &Params) -> Result<(), StageError> {
    let launch = socket.position + params.end_piece_mm * socket.axis;
    match [socket.position, launch].into_iter().find(|p| interior.exact_distance(*p) >= 0.0) {
        None => Ok(()),
        Some(place) => {
            Err(StageError::input(format!("a fibre of LED {} would start outside the body", socket.led))
                .hint("move the sockets closer together, or scale the body up")
                .place_mm(place.to_array()))
        }
    }
}

fn check_marker(marker: &Marker, interior: &Interior, params: &Params) -> Result<(), StageError> {
    let fail = |message: String, place: DVec3| {
        Err(StageError::input(format!("marker {} {message}", marker.id)).place_mm(place.to_array()))
    };
    let off = interior.exact_distance(marker.position).abs();
    if off > params.marker_tolerance_mm {
        return fail(format!("is {off:.3} mm off the surface"), marker.position)
            .map_err(|e| e.hint("were the markers placed on this body?"));
    }
    let inner = marker.position - params.end_piece_mm * marker.normal;
    if interior.exact_distance(inner) >= 0.0 {
        return fail(format!("has no room for a fibre of {} mm below it", params.end_piece_mm), inner)
            .map_err(|e| e.hint("the body is too thin there, or the normal points inwards"));
    }
    Ok(())
}
