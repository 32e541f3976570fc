//! `socket-led`: where the LEDs sit in the flat base of the body.
//!
//! Poses only; `sweep-solids` cuts the holes. The centre LED blinks the m-sequence, the six around it the companion codes
//! (Tone 2020, "Printed objects and experimental system"). Every hole, its wall and the fibres' straight first leg must
//! lie inside the body, or the stage says where they do not.

mod base;
mod best;
mod cavity;
mod face;
mod layout;
mod outline;
mod params;

use base::Base;
use face::Face;
use fibar_core::artefact::Document;
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_core::artefact::sockets::{Hole, Socket, Sockets};
use fibar_core::{LedId, PatternId};
use fibar_plugin::{Description, Job, Stage, StageError, serve};
use glam::{DVec2, DVec3};
use params::{Layout, Params};

struct SocketLed;

impl Stage for SocketLed {
    type Params = Params;

    fn describe() -> Description {
        Description::new(
            "socket-led",
            "Finds poses for the LED sockets in the flat base, or another flat face, of the body.",
        )
        .version(env!("CARGO_PKG_VERSION"))
        .input("body", "body", "The closed body, base at z = 0, mm.")
        .published(
            "sockets",
            "sockets",
            "sockets.json",
            "Tips and axes of the LEDs, the hole that takes one, and other cavities.",
        )
    }

    fn run(params: Params, job: &mut Job) -> Result<(), StageError> {
        let body = TriangleMesh::from_ply(&job.read("body")?)?;
        job.progress(0.1, "base")?;
        let (sockets, room) = place_sockets(&body, &params)?;
        job.metric("socket.count", sockets.sockets.len() as f64, "1");
        job.metric("socket.least_room_mm", room, "mm");
        job.write("sockets", "sockets.json", &sockets.to_json())
    }
}

/// The sockets, and the least distance from an axis to the body's side, mm.
fn place_sockets(body: &TriangleMesh, params: &Params) -> Result<(Sockets, f64), StageError> {
    params.check()?;
    let face = Face::choose(body, params)?;
    let laid = face.lay_down(body);
    let base = Base::new(&laid, params.flatness_mm, params.depth_mm + params.lead_mm);
    let Some(centroid) = base.centroid() else { return Err(no_base(body)) };
    let offsets = match params.layout {
        Layout::Best => best::places(&laid, &base, params)?,
        _ => layout::offsets(params),
    };
    let centre = match (params.centre_mm, params.layout) {
        (Some(centre), _) => DVec2::from(centre),
        (None, Layout::Free | Layout::Best) => DVec2::ZERO,
        (None, _) => base.nearest_place(centroid, &offsets, params.needed_room_mm()),
    };
    check_apart(&offsets, centre, &face, params)?;
    let (tightest, room) = base.tightest(centre, &offsets);
    if room < params.needed_room_mm() {
        return Err(no_room(tightest, room, face.place(centre + offsets[tightest], 0.0), params));
    }
    let leds: Vec<DVec2> = offsets.iter().map(|offset| centre + *offset).collect();
    let cavities = cavity::cavities(&laid, &face, &leds, params)?;
    Ok((sockets(centre, &offsets, &face, params).with_cavities(cavities), room))
}

/// LED `k` at offset `k`, blinking pattern `k + 1`.
fn sockets(centre: DVec2, offsets: &[DVec2], face: &Face, params: &Params) -> Sockets {
    let socket = |(k, offset): (u32, &DVec2)| Socket {
        led: LedId(k),
        pattern: PatternId(k + 1),
        position: face.place(centre + *offset, params.depth_mm),
        axis: face.inwards(),
    };
    let hole = Hole { diameter_mm: params.hole_diameter_mm, depth_mm: params.depth_mm };
    Sockets::new(hole, (0..).zip(offsets).map(socket).collect())
}

/// Holes of two LEDs need a wall between them.
fn check_apart(offsets: &[DVec2], centre: DVec2, face: &Face, params: &Params) -> Result<(), StageError> {
    let Some(([one, other], distance)) = layout::closest_pair(offsets) else { return Ok(()) };
    let needed = params.needed_pitch_mm();
    if distance >= needed * (1.0 - 1e-12) {
        return Ok(());
    }
    let message = format!(
        "LEDs {one} and {other}, {distance:.2} mm apart, leave no {} mm wall between holes of {} mm",
        params.wall_mm, params.hole_diameter_mm
    );
    let place = face.place(centre + offsets[one].midpoint(offsets[other]), 0.0);
    let error = match params.layout {
        Layout::Free => StageError::user(message).param("/places_mm").hint(format!("{needed} mm would do")),
        _ => StageError::user(message)
            .param("/pitch_mm")
            .hint(format!("pitch_mm must be at least {needed} mm here")),
    };
    Err(error.place_mm(place.to_array()))
}

fn no_base(body: &TriangleMesh) -> StageError {
    let low = body.vertices.iter().copied().min_by(|a, b| a.z.total_cmp(&b.z)).unwrap_or(DVec3::ZERO);
    StageError::input("the body has no flat face at z = 0 for the LEDs; its lowest point is the place given")
        .place_mm(low.to_array())
        .hint("cut one: flatten_base_mm of repair-manifold takes that much off the bottom; or choose another face by face_normal")
}

fn no_room(led: usize, room: f64, at: DVec3, params: &Params) -> StageError {
    let needed = params.needed_room_mm();
    let top = params.depth_mm + params.lead_mm;
    let (plane, under) = match params.face_normal {
        None => ("z = 0", "the body's flat base is not under it"),
        Some(_) => ("the face", "the chosen face is not under it"),
    };
    let found = if room > 0.0 { format!("the body leaves {room:.2} mm there") } else { under.to_string() };
    let message = format!(
        "no room for the socket of LED {led}: it needs {needed:.2} mm around its axis from {plane} to {top:.2} mm, and {found}"
    );
    let error = match (params.centre_mm, params.layout) {
        (_, Layout::Free) => StageError::user(message).param("/places_mm").hint("move this LED, or make wall_mm smaller"),
        (Some(_), _) => StageError::user(message).param("/centre_mm").hint(
            "leave centre_mm out to let the stage look for a place, or try a smaller pitch_mm",
        ),
        (None, _) => StageError::input(format!("{message} (this is the best place of the face)"))
            .hint("try a smaller pitch_mm or count, a larger fit_mm of source-mesh, or a larger flatten_base_mm of repair-manifold"),
    };
    error.place_mm(at.to_array())
}

fn main() -> std::process::ExitCode {
    serve::<SocketLed>()
}

#[cfg(test)]
pub mod tests {
    //! Bodies with flat faces.

    use super::*;

    /// A frustum with square ends: half widths at z = 0 and at the given height.
    pub fn frustum(bottom: f64, top: f64, height: f64) -> TriangleMesh {
        let ring = |h: f64, z: f64| [(-h, -h), (h, -h), (h, h), (-h, h)].map(|(x, y)| DVec3::new(x, y, z));
        let vertices = [ring(bottom, 0.0), ring(top, height)].concat();
        let side = |k: u32| [[k, (k + 1) % 4, 4 + k], [(k + 1) % 4, 4 + (k + 1) % 4, 4 + k]];
        let caps = [[0, 2, 1], [0, 3, 2], [4, 5, 6], [4, 6, 7]];
        TriangleMesh { vertices, triangles: caps.into_iter().chain((0..4).flat_map(side)).collect() }
    }

    /// A mesh elsewhere.
    pub fn moved(mut mesh: TriangleMesh, by: DVec3) -> TriangleMesh {
        mesh.vertices.iter_mut().for_each(|v| *v += by);
        mesh
    }

    #[test]
    fn seven_leds_in_a_box() {
        let body = moved(frustum(20.0, 20.0, 40.0), DVec3::new(3.0, -2.0, 0.0));
        let (sockets, room) = place_sockets(&body, &Params::default()).unwrap();
        assert_eq!(Sockets::from_json(&sockets.to_json()), Ok(sockets.clone()));
        assert!((room - 6.0).abs() < 1e-9, "{room}");
        let patterns: Vec<u32> = sockets.sockets.iter().map(|s| s.pattern.0).collect();
        assert_eq!(patterns, [1, 2, 3, 4, 5, 6, 7]);
        let centre = sockets.sockets[0].position;
        assert!(centre.distance(DVec3::new(3.0, -2.0, 8.6)) < 1e-9, "{centre}");
        for socket in &sockets.sockets[1..] {
            assert!((socket.position.distance(centre) - 14.0).abs() < 1e-9);
        }
    }

    #[test]
    fn errors_name_the_place_and_what_to_try() {
        let check = |body: &TriangleMesh, params: Params, says: &str| {
            let error = place_sockets(body, &params).unwrap_err().to_string();
            assert!(error.contains(says), "{error:?} does not say {says:?}");
        };
        let with = |change: fn(&mut Params)| {
            let mut params = Params::default();
            change(&mut params);
            params
        };
        let wide = frustum(20.0, 20.0, 40.0);
        check(&frustum(12.0, 12.0, 40.0), Params::default(), "no room for the socket of LED");
        check(&frustum(20.0, 1.0, 20.0), Params::default(), "no room for the socket of LED");
        check(&frustum(20.0, 20.0, 9.0), Params::default(), "from z = 0 to 11.10 mm");
        check(&moved(wide.clone(), DVec3::Z), Params::default(), "no flat face");
        check(&TriangleMesh::default(), Params::default(), "no flat face");
        check(&wide, with(|p| p.centre_mm = Some([9.0, 0.0])), "LED 1: it needs 3.60 mm");
        check(&wide, with(|p| p.centre_mm = Some([90.0, 0.0])), "flat base is not under it");
        check(&wide, with(|p| p.pitch_mm = 5.5), "holes of 5.2 mm");
        check(&wide, with(|p| p.count = 8), "a hexagon has seven places");
        check(&wide, with(|p| p.layout = Layout::Free), "no place for an LED");
        let free = |places: &[[f64; 2]]| Params {
            layout: Layout::Free,
            places_mm: places.to_vec(),
            ..Params::default()
        };
        check(&wide, free(&[[0.0, 0.0], [30.0, 0.0]]), "LED 1: it needs 3.60 mm");
        check(&wide, free(&[[0.0, 0.0], [9.0, 0.0], [9.0, 5.0]]), "LEDs 1 and 2, 5.00 mm apart");
        check(&wide, with(|p| p.face_normal = Some([1.0, 1.0, 1.0])), "no face that looks along");
        check(
            &frustum(20.0, 20.0, 9.0),
            with(|p| p.face_normal = Some([0.0, 0.0, 1.0])),
            "from the face to 11.10 mm",
        );
    }

    #[test]
    fn errors_carry_their_place() {
        let check = |params: Params, place: [f64; 3]| {
            let error = place_sockets(&frustum(20.0, 20.0, 40.0), &params).unwrap_err();
            assert_eq!(error.clone().place_mm(place), error);
        };
        let free = |places: &[[f64; 2]]| Params {
            layout: Layout::Free,
            places_mm: places.to_vec(),
            ..Params::default()
        };
        check(free(&[[0.0, 0.0], [30.0, 1.0]]), [30.0, 1.0, 0.0]);
        check(free(&[[0.0, 0.0], [9.0, 0.0], [9.0, 5.0]]), [9.0, 2.5, 0.0]);
        let top = Params { face_normal: Some([0.0, 0.0, 1.0]), ..free(&[[30.0, 0.0]]) };
        check(top, [30.0, 0.0, 40.0]);
    }

    #[test]
    fn leds_in_the_side_look_across() {
        let body = frustum(20.0, 20.0, 40.0);
        let params = Params {
            layout: Layout::Grid,
            count: 4,
            pitch_mm: 12.0,
            face_normal: Some([0.0, -1.0, 0.0]),
            ..Params::default()
        };
        let (sockets, room) = place_sockets(&body, &params).unwrap();
        assert!((room - 14.0).abs() < 1e-9, "{room}");
        for socket in &sockets.sockets {
            assert!(
                socket.axis.distance(DVec3::Y) < 1e-12 && (socket.position.y + 11.4).abs() < 1e-9,
                "{socket:?}"
            );
            assert!(
                (socket.position.x.abs() - 6.0).abs() < 1e-9
                    && ((socket.position.z - 20.0).abs() - 6.0).abs() < 1e-9
            );
        }
    }

    #[test]
    fn fewer_leds_need_less() {
        let params = Params { count: 1, ..Params::default() };
        assert_eq!(place_sockets(&frustum(5.0, 5.0, 20.0), &params).unwrap().0.sockets.len(), 1);
    }

    #[test]
    fn a_hole_in_the_base_is_avoided() {
        // Two boxes side by side, the centroid of their bases between them.
        let (left, right) = (frustum(20.0, 20.0, 40.0), frustum(20.0, 20.0, 40.0));
        let mut body = moved(left, DVec3::new(-30.0, 0.0, 0.0));
        let right = moved(right, DVec3::new(31.0, 0.0, 0.0));
        body.triangles.extend(right.triangles.iter().map(|t| t.map(|v| v + 8)));
        body.vertices.extend(right.vertices);
        let (sockets, room) = place_sockets(&body, &Params::default()).unwrap();
        assert!(room >= 3.6);
        assert!((10.0..50.0).contains(&sockets.sockets[0].position.x.abs()));
    }
}
