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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interior::tests::cuboid;
    use fibar_core::artefact::constellation::Pattern;
    use fibar_core::artefact::sockets::Hole;

    fn socket(led: u32, x: f64) -> Socket {
        Socket {
            led: LedId(led),
            pattern: PatternId(led + 1),
            position: DVec3::new(x, 0.0, -12.0),
            axis: DVec3::Z,
        }
    }

    fn marker(id: u32, pattern: u32, position: DVec3, normal: DVec3) -> Marker {
        Marker { id: MarkerId(id), position, normal, pattern: PatternId(pattern), neighbours: vec![] }
    }

    fn route(sockets: Vec<Socket>, markers: Vec<Marker>) -> Result<Vec<Ends>, String> {
        let sockets = Sockets::new(Hole { diameter_mm: 5.2, depth_mm: 8.0 }, sockets);
        let pattern = |id| Pattern { id: PatternId(id), bits: vec![true] };
        let constellation = Constellation::new(350.0, vec![pattern(1), pattern(2), pattern(3)], markers);
        let interior = Interior::of(&cuboid(DVec3::splat(20.0)), &Params::default()).unwrap();
        of_fibres(&sockets, &constellation, &interior, &Params::default()).map_err(|e| e.to_string())
    }

    #[test]
    fn fibres_are_in_order_of_pattern_then_marker() {
        let top = |id, pattern| marker(id, pattern, DVec3::new(f64::from(id), 0.0, 20.0), DVec3::Z);
        let ends =
            route(vec![socket(0, -5.0), socket(1, 5.0)], vec![top(1, 2), top(2, 1), top(3, 1)]).unwrap();
        assert_eq!(ends.iter().map(|e| e.marker.0).collect::<Vec<_>>(), [2, 3, 1]);
        let [tip, launch, below, marker] = ends[2].control_points();
        assert_eq!(
            (ends[2].led, tip, launch),
            (LedId(1), DVec3::new(5.0, 0.0, -12.0), DVec3::new(5.0, 0.0, -9.5))
        );
        assert_eq!((below, marker), (DVec3::new(1.0, 0.0, 17.5), DVec3::new(1.0, 0.0, 20.0)));
    }

    #[test]
    fn what_cannot_be_routed_is_named() {
        let check = |sockets, markers, says: &str| {
            let error = route(sockets, markers).unwrap_err();
            assert!(error.contains(says), "{error:?} does not say {says:?}");
        };
        let top = DVec3::Z * 20.0;
        let one = || vec![socket(0, 0.0)];
        check(one(), vec![], "no marker");
        check(one(), vec![marker(7, 2, top, DVec3::Z)], "marker 7 blinks pattern 2, which no LED does");
        check(one(), vec![marker(7, 1, top + DVec3::Z, DVec3::Z)], "marker 7 is 1.000 mm off the surface");
        check(one(), vec![marker(7, 1, top, -DVec3::Z)], "marker 7 has no room");
        check(vec![socket(0, 21.0)], vec![marker(7, 1, top, DVec3::Z)], "LED 0 would start outside");
    }
}
