//! `clearance.ends`: every fibre starts under its LED's dome, in the plane of the tip and along the axis, and ends on the
//! surface, no more tilted than is allowed.

use crate::judgement::Judgement;
use crate::strand::Strand;
use crate::{Params, Scene};
use fibar_core::artefact::constellation::Constellation;
use fibar_core::artefact::sockets::{Socket, Sockets};
use fibar_core::artefact::verdict::{Finding, Place};
use fibar_ruler::bezier::angle_between;
use glam::DVec3;

/// How far off ends may be.
pub struct Rule {
    tolerance_mm: f64,
    mouth_offset_mm: f64,
    start_tilt: f64,
    arrival_tilt: f64,
}

impl Rule {
    /// The rule as the parameters set it.
    pub fn of(params: &Params) -> Rule {
        Rule {
            tolerance_mm: params.end_tolerance_mm,
            mouth_offset_mm: params.mouth_offset_mm,
            start_tilt: params.start_tilt_deg.to_radians(),
            arrival_tilt: params.arrival_tilt_deg.to_radians(),
        }
    }
}

/// One end of a fibre: its place with the distance from where it belongs, and whether that is well.
struct End {
    place: Place,
    sound: bool,
    /// Off the direction it should have, rad.
    tilt: f64,
    arrives: bool,
}

impl End {
    fn of(position: DVec3, value: f64, what: String, fault: Option<String>, rule: &Rule) -> End {
        let sound = fault.is_none() && value <= rule.tolerance_mm;
        let what = fault.map_or(what.clone(), |fault| format!("{what}: {fault}"));
        End { place: Place { position, value, what }, sound, tilt: 0.0, arrives: false }
    }
}

/// Looks at both ends of every fibre. The value is the largest distance of an end from where it belongs, mm.
pub fn judge(strands: &[Strand], scene: &Scene, rule: &Rule) -> Option<Judgement> {
    let ends = strands.iter().flat_map(|s| [start_of(s, scene.sockets, rule), end_of(s, scene, rule)]);
    let mut ends: Vec<End> = ends.collect();
    ends.sort_by(|a, b| a.sound.cmp(&b.sound).then(b.place.value.total_cmp(&a.place.value)));
    let broken = ends.iter().filter(|end| !end.sound).count();
    let furthest = ends.iter().map(|end| end.place.value).fold(0.0, f64::max);
    let arrivals = ends.iter().filter(|end| end.arrives).map(|end| end.tilt.to_degrees());
    let tilt_deg = arrivals.fold(0.0, f64::max);
    let message = match ends.first()? {
        End { sound: true, .. } => {
            format!(
                "all {} ends are where they belong, to {furthest:.1e} mm; fibres arrive up to {tilt_deg:.1}° off the normal",
                ends.len()
            )
        }
        End { place, .. } => {
            format!("{broken} of {} ends are not where they belong: {}", ends.len(), place.what)
        }
    };
    let finding = Finding {
        rule: "clearance.ends".into(),
        holds: broken == 0,
        value: furthest,
        unit: "mm".into(),
        bound: Some(rule.tolerance_mm),
        message,
        places: ends.into_iter().take(broken.clamp(5, 100)).map(|end| end.place).collect(),
    };
    let metrics = vec![
        ("clearance.max_end_offset_mm", furthest, "mm"),
        ("clearance.max_arrival_tilt_deg", tilt_deg, "deg"),
    ];
    Some(Judgement { finding, metrics })
}

fn start_of(strand: &Strand, sockets: &Sockets, rule: &Rule) -> End {
    let position = strand.curve.start();
    let what = format!("start of fibre {}", strand.id);
    let Some(socket) = sockets.sockets.iter().find(|socket| socket.led == strand.led) else {
        return End::of(position, 0.0, what, Some(format!("LED {} has no socket", strand.led)), rule);
    };
    let tilt = strand.curve.start_direction().map_or(0.0, |d| angle_between(d, socket.axis));
    let fault = if socket.pattern != strand.pattern {
        Some(format!(
            "LED {} blinks pattern {}, the fibre carries {}",
            socket.led, socket.pattern, strand.pattern
        ))
    } else if tilt > rule.start_tilt {
        Some(format!("it leaves LED {} at {:.1}° to the socket's axis", socket.led, tilt.to_degrees()))
    } else {
        None
    };
    End::of(position, off_the_dome(position, socket, rule), what, fault, rule)
}

/// How far a place is from where mouths may lie: a disc about the tip, square to the axis; mm.
fn off_the_dome(position: DVec3, socket: &Socket, rule: &Rule) -> f64 {
    let arm = position - socket.position;
    let height = arm.dot(socket.axis);
    let beside = ((arm - socket.axis * height).length() - rule.mouth_offset_mm).max(0.0);
    (height * height + beside * beside).sqrt()
}

fn end_of(strand: &Strand, scene: &Scene, rule: &Rule) -> End {
    let position = strand.curve.end();
    let marker = |c: &Constellation| {
        c.markers.binary_search_by_key(&strand.marker, |m| m.id).ok().map(|k| c.markers[k].normal)
    };
    let normal = scene.constellation.and_then(marker).unwrap_or_else(|| scene.body.outward(position));
    let tilt = strand.curve.end_direction().map_or(0.0, |d| angle_between(d, normal));
    let fault = (tilt > rule.arrival_tilt)
        .then(|| format!("it arrives at marker {} {:.1}° off the normal", strand.marker, tilt.to_degrees()));
    let what = format!("end of fibre {}, measured to the surface", strand.id);
    let end = End::of(position, scene.body.depth(position).abs(), what, fault, rule);
    End { tilt, arrives: true, ..end }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::strand::tests::{cube, socket, strand};
    use fibar_core::PatternId;
    use fibar_core::artefact::sockets::Hole;
    use fibar_ruler::surface::ClosedSurface;

    #[track_caller]
    fn check(from: DVec3, to: DVec3, pattern: u32, says: &str) {
        check_by(from, from.midpoint(to), to, pattern, says);
    }

    #[track_caller]
    fn check_by(from: DVec3, middle: DVec3, to: DVec3, pattern: u32, says: &str) {
        let hole = Hole { diameter_mm: 5.0, depth_mm: 8.0 };
        let sockets = Sockets::new(hole, vec![socket(0, DVec3::Z * 8.0)]);
        let rule = Rule { tolerance_mm: 0.01, mouth_offset_mm: 1.6, start_tilt: 0.02, arrival_tilt: 0.3 };
        let body = ClosedSurface::of(&cube(40.0));
        let scene = Scene { body: &body, sockets: &sockets, constellation: None };
        let fibre = Strand { pattern: PatternId(pattern), ..strand(1, 1, vec![from, middle, to]) };
        let finding = judge(&[fibre], &scene, &rule).unwrap().finding;
        assert_eq!(finding.holds, says.starts_with("all"), "{finding:?}");
        assert!(finding.message.contains(says), "{:?} does not say {says:?}", finding.message);
    }

    #[test]
    fn ends_where_they_belong_and_elsewhere() {
        let (tip, top) = (DVec3::Z * 8.0, DVec3::Z * 40.0);
        check(tip, top, 1, "all 2 ends");
        check(tip + DVec3::X * 0.009, top, 1, "all 2 ends");
        check(tip + DVec3::X * 1.605, top + DVec3::X, 1, "all 2 ends");
        check(
            tip + DVec3::X * 1.62,
            top + DVec3::X,
            1,
            "1 of 2 ends are not where they belong: start of fibre 1",
        );
        check(tip + DVec3::Z * 0.02, top, 1, "start of fibre 1");
        check(tip, top - DVec3::Z * 3.0, 1, "end of fibre 1");
        check(tip, top, 2, "LED 0 blinks pattern 1, the fibre carries 2");
        check(tip, DVec3::new(20.0, 0.0, 20.0), 1, "at 59.0° to the socket's axis");
        let knee = DVec3::Z * 20.0;
        check_by(tip, knee, DVec3::new(5.0, 0.0, 40.0), 1, "all 2 ends");
        check_by(tip, knee, DVec3::new(9.0, 0.0, 40.0), 1, "it arrives at marker 1 24.2° off the normal");
    }
}
