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

#[cfg(test)]
mod tests {
    use super::*;
    use fibar_core::artefact::constellation::Pattern;
    use fibar_core::artefact::mesh::TriangleMesh;
    use fibar_core::artefact::sockets::Hole;
    use fibar_geometry::distance::Surface;
    use fibar_geometry::room::{Keeping, RoomOptions};

    /// A block of 40 × 40 mm that reaches from z = 0 to `height`.
    fn block(height: f64) -> TriangleMesh {
        let corner = |k: u32| {
            let [x, y, z] = [k & 1, k >> 1 & 1, k >> 2].map(f64::from);
            DVec3::new((x - 0.5) * 40.0, (y - 0.5) * 40.0, z * height)
        };
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let halves = |[a, b, c, d]: [u32; 4]| [[a, b, c], [a, c, d]];
        TriangleMesh {
            vertices: (0..8).map(corner).collect(),
            triangles: quads.into_iter().flat_map(halves).collect(),
        }
    }

    fn socket(led: u32, x: f64) -> Socket {
        Socket {
            led: LedId(led),
            pattern: PatternId(led + 1),
            position: DVec3::new(x, 0.0, 8.6),
            axis: DVec3::Z,
        }
    }

    fn marker(id: u32, pattern: u32, position: [f64; 3], normal: DVec3) -> Marker {
        let position = DVec3::from(position);
        Marker { id: MarkerId(id), position, normal, pattern: PatternId(pattern), neighbours: vec![] }
    }

    fn route(height: f64, sockets: Vec<Socket>, markers: Vec<Marker>) -> Result<Vec<Net>, String> {
        let sockets = Sockets::new(Hole { diameter_mm: 5.2, depth_mm: 8.6 }, sockets);
        let pattern = |id| Pattern { id: PatternId(id), bits: vec![true] };
        let constellation = Constellation::new(350.0, vec![pattern(1), pattern(2)], markers);
        let keeping = Keeping { radius: 1.875, skin: 0.4, wall: 0.05 };
        let options = RoomOptions { spacing: 1.0, band: 6.0, exact: f64::INFINITY };
        let room = Room::new(Surface::new(&block(height)).unwrap(), &sockets, keeping, options);
        let rules = Rules { marker_tolerance: 0.5, apart: 3.85 };
        of(&sockets, &constellation, &room, &rules).map_err(|e| e.to_string())
    }

    #[test]
    fn nets_are_in_order_of_pattern_then_marker() {
        let top = |id: u32, pattern| marker(id, pattern, [5.0 * f64::from(id) - 10.0, 0.0, 40.0], DVec3::Z);
        let nets = route(40.0, vec![socket(0, -7.0), socket(1, 7.0)], vec![top(1, 2), top(2, 1), top(3, 1)]);
        let order: Vec<(u32, u32)> = nets.unwrap().iter().map(|n| (n.led.0, n.marker.0)).collect();
        assert_eq!(order, [(0, 2), (0, 3), (1, 1)]);
    }

    #[track_caller]
    fn check(height: f64, sockets: Vec<Socket>, markers: Vec<Marker>, says: &str) {
        let error = route(height, sockets, markers).unwrap_err();
        assert!(error.contains(says), "{error:?} does not say {says:?}");
    }

    #[test]
    fn what_cannot_be_routed_is_named() {
        let one = || vec![socket(0, 0.0)];
        let top = |id, x, pattern| marker(id, pattern, [x, 0.0, 40.0], DVec3::Z);
        check(40.0, one(), vec![], "no marker");
        check(40.0, one(), vec![top(7, 0.0, 2)], "marker 7 blinks pattern 2, which no LED does");
        check(40.0, one(), vec![marker(7, 1, [0.0, 0.0, 41.0], DVec3::Z)], "marker 7 is 1.000 mm off");
        check(40.0, one(), vec![marker(7, 1, [0.0, 0.0, 40.0], -DVec3::Z)], "marker 7 has no room");
        check(40.0, vec![socket(0, 21.0)], vec![top(7, 0.0, 1)], "LED 0 would start outside the body");
        check(40.0, vec![socket(0, 18.5)], vec![top(7, 0.0, 1)], "too close to the skin");
    }

    #[test]
    fn markers_of_two_patterns_closer_than_a_fibre_are_refused() {
        let two = || vec![socket(0, -7.0), socket(1, 7.0)];
        let pair = |x: f64, pattern| {
            vec![marker(1, 1, [0.0, 0.0, 40.0], DVec3::Z), marker(2, pattern, [x, 0.0, 40.0], DVec3::Z)]
        };
        check(40.0, two(), pair(3.0, 2), "markers 1 and 2 of patterns 1 and 2 are 3.00 mm apart");
        assert!(route(40.0, two(), pair(3.0, 1)).is_ok(), "fibres of one pattern may touch");
        assert!(route(40.0, two(), pair(3.9, 2)).is_ok());
    }

    #[test]
    fn a_body_thinner_than_a_fibre_is_refused() {
        let side = |depth: f64| vec![marker(1, 1, [0.0, 0.0, depth], DVec3::Z)];
        check(11.0, vec![socket(0, 0.0)], side(11.0), "outside the body");
    }
}
