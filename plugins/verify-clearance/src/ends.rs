//! `clearance.ends`: every fibre starts at its LED's tip, along its axis, and ends on the surface.

use crate::Params;
use crate::judgement::Judgement;
use crate::strand::Strand;
use fibar_core::artefact::sockets::Sockets;
use fibar_core::artefact::verdict::{Finding, Place};
use fibar_ruler::bezier::angle_between;
use fibar_ruler::surface::ClosedSurface;

/// How far off ends may be.
pub struct Rule {
    tolerance_mm: f64,
    tilt: f64,
}

impl Rule {
    /// The rule as the parameters set it.
    pub fn of(params: &Params) -> Rule {
        Rule { tolerance_mm: params.end_tolerance_mm, tilt: params.start_tilt_deg.to_radians() }
    }
}

/// One end of a fibre: its place with the distance from where it belongs, and whether that is well.
struct End {
    place: Place,
    sound: bool,
}

/// Looks at both ends of every fibre. The value is the largest distance of an end from where it belongs, mm.
pub fn judge(strands: &[Strand], sockets: &Sockets, body: &ClosedSurface, rule: &Rule) -> Option<Judgement> {
    let ends = strands.iter().flat_map(|s| [start_of(s, sockets, rule), end_of(s, body, rule)]);
    let mut ends: Vec<End> = ends.collect();
    ends.sort_by(|a, b| a.sound.cmp(&b.sound).then(b.place.value.total_cmp(&a.place.value)));
    let broken = ends.iter().filter(|end| !end.sound).count();
    let furthest = ends.iter().map(|end| end.place.value).fold(0.0, f64::max);
    let message = match ends.first()? {
        End { sound: true, .. } => {
            format!("all {} ends are where they belong, to {furthest:.1e} mm", ends.len())
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
    Some(Judgement { finding, metrics: vec![("clearance.max_end_offset_mm", furthest, "mm")] })
}

fn start_of(strand: &Strand, sockets: &Sockets, rule: &Rule) -> End {
    let position = strand.curve.start();
    let end = |value: f64, fault: Option<String>| {
        let fault = fault.map_or(String::new(), |fault| format!(": {fault}"));
        let sound = fault.is_empty() && value <= rule.tolerance_mm;
        End { place: Place { position, value, what: format!("start of fibre {}{fault}", strand.id) }, sound }
    };
    let Some(socket) = sockets.sockets.iter().find(|socket| socket.led == strand.led) else {
        return end(0.0, Some(format!("LED {} has no socket", strand.led)));
    };
    let tilt = strand.curve.start_direction().map_or(0.0, |d| angle_between(d, socket.axis));
    let fault = if socket.pattern != strand.pattern {
        Some(format!(
            "LED {} blinks pattern {}, the fibre carries {}",
            socket.led, socket.pattern, strand.pattern
        ))
    } else if tilt > rule.tilt {
        Some(format!("it leaves LED {} at {:.1}° to the socket's axis", socket.led, tilt.to_degrees()))
    } else {
        None
    };
    end(position.distance(socket.position), fault)
}

fn end_of(strand: &Strand, body: &ClosedSurface, rule: &Rule) -> End {
    let position = strand.curve.end();
    let value = body.depth(position).abs();
    let what = format!("end of fibre {}, measured to the surface", strand.id);
    End { place: Place { position, value, what }, sound: value <= rule.tolerance_mm }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::strand::tests::{cube, socket, strand};
    use fibar_core::PatternId;
    use fibar_core::artefact::sockets::Hole;
    use glam::DVec3;

    #[track_caller]
    fn check(from: DVec3, to: DVec3, pattern: u32, says: &str) {
        let hole = Hole { diameter_mm: 5.0, depth_mm: 8.0 };
        let sockets = Sockets::new(hole, vec![socket(0, DVec3::Z * 8.0)]);
        let rule = Rule { tolerance_mm: 0.01, tilt: 0.02 };
        let body = ClosedSurface::of(&cube(40.0));
        let fibre = Strand { pattern: PatternId(pattern), ..strand(1, 1, vec![from, to]) };
        let finding = judge(&[fibre], &sockets, &body, &rule).unwrap().finding;
        assert_eq!(finding.holds, says.starts_with("all"), "{finding:?}");
        assert!(finding.message.contains(says), "{:?} does not say {says:?}", finding.message);
    }

    #[test]
    fn ends_where_they_belong_and_elsewhere() {
        let (tip, top) = (DVec3::Z * 8.0, DVec3::Z * 40.0);
        check(tip, top, 1, "all 2 ends");
        check(tip + DVec3::X * 0.009, top, 1, "all 2 ends");
        check(tip + DVec3::X, top + DVec3::X, 1, "1 of 2 ends are not where they belong: start of fibre 1");
        check(tip, top - DVec3::Z * 3.0, 1, "end of fibre 1");
        check(tip, top, 2, "LED 0 blinks pattern 1, the fibre carries 2");
        check(tip, DVec3::new(20.0, 0.0, 20.0), 1, "at 59.0° to the socket's axis");
    }
}
