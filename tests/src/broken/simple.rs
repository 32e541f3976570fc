//! Sound meshes, and meshes with one fault.

use super::Case;
use super::shapes::{ball, block, cells, inverted, knot, moved, polygon, prism, scaled, torus};
use super::ways::*;
use fibar_core::artefact::mesh::TriangleMesh;
use glam::{DVec2, DVec3};

fn star() -> Vec<DVec2> {
    polygon(60, |k| if k % 2 == 0 { 30.0 } else { 18.0 })
}

fn pipe() -> TriangleMesh {
    prism(&polygon(48, |_| 25.0), Some(&polygon(48, |_| 18.0)), 40.0)
}

/// A plate of 30 × 30 × 6 mm with four square holes, in cells of 2 mm.
pub(super) fn plate() -> TriangleMesh {
    let is_hole = |k: i32| (3..6).contains(&k) || (9..12).contains(&k);
    scaled(cells([15, 15, 3], |[x, y, _]| !(is_hole(x) && is_hole(y))), 2.0)
}

fn cup() -> TriangleMesh {
    scaled(cells([12, 12, 12], |[x, y, z]| z < 2 || !((2..10).contains(&x) && (2..10).contains(&y))), 3.0)
}

/// Nothing to do.
pub(super) fn sound() -> Vec<Case> {
    let sound = |name, what, mesh: TriangleMesh| Case::new(name, what, &mesh, mesh.clone());
    vec![
        sound("sound-box", "sound: a box", block([0.0; 3], [40.0, 30.0, 20.0])),
        sound("sound-ball", "sound: a ball, 3,072 triangles", ball(40.0, 16)),
        sound("sound-knot", "sound: a trefoil knot", knot(30.0, 12.0, 5.0, 200, 16)),
        sound("sound-plate", "sound: a plate with four holes", plate()),
        sound("sound-cup", "sound: a cup", cup()),
    ]
}

/// Something is missing.
pub(super) fn open() -> Vec<Case> {
    let case = |name, what, sound: TriangleMesh, away: &dyn Fn(DVec3) -> bool| {
        Case::new(name, what, &sound, without(sound.clone(), away))
    };
    let lifted = moved(prism(&star(), None, 25.0), [0.0; 3]);
    vec![
        case("hole-flat", "a box without its top", block([0.0; 3], [40.0, 30.0, 20.0]), &|p| p.z > 19.9),
        case("hole-star", "a star-shaped prism without top and bottom", lifted, &|p| p.z < 0.1 || p.z > 24.9),
        case("hole-tube", "a pipe with no wall at one end", pipe(), &|p| p.z > 39.9),
        case("hole-both-ends", "a pipe with no wall at either end", pipe(), &|p| p.z > 39.9 || p.z < 0.1),
        case("hole-plate", "a plate with four holes, without its top", plate(), &|p| p.z > 5.9),
        case(
            "hole-corner",
            "a box of cells without one corner",
            scaled(cells([6; 3], |_| true), 5.0),
            &|p| p.min_element() > 24.0 || (p.x > 24.0 && p.y > 24.0 && p.z > 24.0),
        ),
        case("hole-ball-small", "a ball, 20° of it missing", ball(40.0, 24), &|p| p.z > 40.0 * cos(20.0)),
        case("hole-ball-wide", "a ball, 40° of it missing", ball(40.0, 24), &|p| p.z > 40.0 * cos(40.0)),
        case(
            "hole-torus",
            "a ring with a piece of its outer wall missing",
            torus(30.0, 12.0, 72, 36),
            &|p| p.x > 36.0 && p.y.abs() < 9.0 && p.z.abs() < 7.0,
        ),
        Case::new(
            "hole-sieve",
            "a ball, 4 % of its triangles missing",
            &ball(40.0, 24),
            sieved(ball(40.0, 24), 0.04, 1),
        ),
        Case::new(
            "t-junctions",
            "sides divided on one side only",
            &ball(40.0, 16),
            with_t_junctions(ball(40.0, 16), 0.3, 2),
        ),
        Case::new(
            "t-junctions-flat",
            "a box of cells, some sides divided",
            &scaled(cells([5; 3], |_| true), 6.0),
            with_t_junctions(scaled(cells([5; 3], |_| true), 6.0), 0.4, 3),
        ),
        Case::new(
            "rims-near",
            "every corner up to 0.002 mm off",
            &torus(30.0, 12.0, 60, 30),
            jittered(&torus(30.0, 12.0, 60, 30), 0.002, 4),
        ),
        Case::new("rims-torn", "two halves 0.004 mm apart", &ball(40.0, 16), torn(&ball(40.0, 16), 0.004)),
    ]
}

fn cos(degrees: f64) -> f64 {
    degrees.to_radians().cos()
}

/// Something is there twice, or the wrong way round, or should not be there.
pub(super) fn wrong() -> Vec<Case> {
    let (ball, ring) = (ball(40.0, 16), torus(30.0, 12.0, 60, 30));
    let turned = |share| flipped(ring.clone(), share, 5);
    let mut backed = doubled(ball.clone(), 0.1, 6);
    backed.triangles[ball.triangles.len()..].iter_mut().for_each(|triangle| triangle.swap(1, 2));
    let needles = knot(30.0, 12.0, 5.0, 400, 6);
    vec![
        Case::new("soup", "triangles in random order", &ring, shuffled(&ring, 7)),
        Case::new("double", "every third triangle twice", &ball, doubled(ball.clone(), 0.33, 8)),
        Case::new("double-all", "every triangle twice", &ball, doubled(ball.clone(), 2.0, 8)),
        Case::new("double-turned", "a tenth of the triangles also turned over", &ball, backed),
        Case::new("degenerate", "triangles with a corner twice", &ball, with_degenerate(ball.clone(), 60, 9)),
        Case::new(
            "needles",
            "triangles with three corners in a row",
            &ring,
            with_needles(ring.clone(), 0.2, 10),
        ),
        Case::new(
            "slivers",
            "a knot of thin triangles, 0.01 mm steps",
            &needles,
            rounded(needles.clone(), 0.01),
        ),
        Case::new("turned-third", "a third of the triangles turned", &ring, turned(0.33)),
        Case::new("turned-half", "half of the triangles turned", &ring, turned(0.5)),
        Case::new("turned-all", "inside out", &ring, inverted(ring.clone())),
        Case::new("flaps", "twenty triangles hang on sides", &ball, with_flaps(ball.clone(), 20, 4.0, 11)),
        Case::new("strays", "ten triangles float about", &ball, with_strays(ball.clone(), 10, 12)),
        Case::new("digits", "coordinates of two digits", &ball, rounded(ball.clone(), 0.01)),
    ]
}
