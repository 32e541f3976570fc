//! The nets: which LED is to be led to which marker, checked before anything is routed.

use fibar_core::artefact::constellation::{Constellation, Marker};
use fibar_core::artefact::sockets::{Socket, Sockets};
use fibar_core::{LedId, MarkerId, PatternId};
use fibar_geometry::course::Ends;
use fibar_geometry::room::Room;
use fibar_plugin::StageError;
use glam::DVec3;

/// One fibre to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Net {
    /// What it carries.
    pub pattern: PatternId,
    /// Where it starts.
    pub led: LedId,
    /// Where it ends.
    pub marker: MarkerId,
    /// Both ends in space; the mouth is still the LED's tip.
    pub ends: Ends,
}

/// What nets are checked against.
pub struct Rules {
    /// A marker further than this from the surface is refused, mm.
    pub marker_tolerance: f64,
    /// Distance that axes of different patterns keep, mm.
    pub apart: f64,
}

/// All nets, by pattern and then by marker: the order of the fibres.
pub fn of(
    sockets: &Sockets,
    constellation: &Constellation,
    room: &Room,
    rules: &Rules,
) -> Result<Vec<Net>, StageError> {
    if constellation.markers.is_empty() {
        return Err(StageError::input("the constellation has no marker").hint("place some"));
    }
    sockets.sockets.iter().try_for_each(|socket| check_socket(socket, room))?;
    let net = |marker: &Marker| {
        check_marker(marker, room, rules)?;
        net_of(marker, sockets)
    };
    let mut nets: Vec<Net> = constellation.markers.iter().map(net).collect::<Result<_, _>>()?;
    nets.sort_by_key(|n| (n.pattern, n.marker));
    check_distances(&nets, rules)?;
    Ok(nets)
}

fn net_of(marker: &Marker, sockets: &Sockets) -> Result<Net, StageError> {
    let feeds = |socket: &&Socket| socket.pattern == marker.pattern;
    let socket = sockets.sockets.iter().find(feeds).ok_or_else(|| {
        StageError::input(format!(
            "marker {} blinks pattern {}, which no LED does",
            marker.id, marker.pattern
        ))
        .hint("give the sockets as many LEDs as the constellation has patterns")
        .place_mm(marker.position.to_array())
    })?;
    let ends =
        Ends { tip: socket.position, axis: socket.axis, marker: marker.position, normal: marker.normal };
    Ok(Net { pattern: marker.pattern, led: socket.led, marker: marker.id, ends })
}

/// Where the leg of the LED ends, a fibre must have room.
fn check_socket(socket: &Socket, room: &Room) -> Result<(), StageError> {
    let outside = |place: DVec3| room.surface().signed_distance(place) >= 0.0;
    let launch = socket.position + room.exempt_start() * socket.axis;
    if outside(socket.position) || outside(launch) {
        return Err(StageError::input(format!("a fibre of LED {} would start outside the body", socket.led))
            .hint("move the sockets closer together, or scale the body up")
            .place_mm(socket.position.to_array()));
    }
    let slack = room.exact_slack(launch + 0.1 * socket.axis, 1.0);
    if slack < 0.0 {
        let message = format!(
            "fibres of LED {} would start {:.2} mm too close to the skin or to another LED's hole",
            socket.led, -slack
        );
        return Err(StageError::input(message)
            .hint("move the sockets, scale the body up, or lower wall_mm")
            .place_mm(launch.to_array()));
    }
    Ok(())
}

fn check_marker(marker: &Marker, room: &Room, rules: &Rules) -> Result<(), StageError> {
    let off = room.surface().signed_distance(marker.position).abs();
    if off > rules.marker_tolerance {
        return Err(StageError::input(format!("marker {} is {off:.3} mm off the surface", marker.id))
            .hint("were the markers placed on this body?")
            .place_mm(marker.position.to_array()));
    }
    let inner = marker.position - room.exempt_end() * marker.normal;
    if room.surface().signed_distance(inner) >= 0.0 {
        let message =
            format!("marker {} has no room for a fibre of {:.1} mm below it", marker.id, room.exempt_end());
        return Err(StageError::input(message)
            .hint("the body is thinner there than a fibre needs, or the normal points inwards")
            .place_mm(inner.to_array()));
    }
    Ok(())
}

/// Fibres of two patterns cannot end closer than they may run.
fn check_distances(nets: &[Net], rules: &Rules) -> Result<(), StageError> {
    let pairs = nets.iter().enumerate().flat_map(|(k, a)| nets[..k].iter().map(move |b| (b, a)));
    let too_close =
        |(a, b): &(&Net, &Net)| a.pattern != b.pattern && a.ends.marker.distance(b.ends.marker) < rules.apart;
    let Some((a, b)) = pairs.into_iter().find(too_close) else { return Ok(()) };
    let distance = a.ends.marker.distance(b.ends.marker);
    let message = format!(
        "markers {} and {} of patterns {} and {} are {distance:.2} mm apart; their fibres need {:.2} mm",
        a.marker, b.marker, a.pattern, b.pattern, rules.apart
    );
    Err(StageError::input(message)
        .hint("place markers further apart, or give both one pattern")
        .place_mm(a.ends.marker.midpoint(b.ends.marker).to_array()))
}
