//! Several faults at once, and many triangles.

use super::Case;
use super::shapes::{ball, block, inverted, knot, moved, rippled_ball, together, torus};
use super::ways::*;
use fibar_core::artefact::mesh::TriangleMesh;
use glam::DVec3;

/// Combinations of faults.
pub(super) fn combined() -> Vec<Case> {
    let (whole, ring) = (ball(40.0, 24), torus(30.0, 12.0, 72, 36));
    let holed = sieved(with_flaps(ring.clone(), 6, 3.0, 21), 0.02, 22);
    let bodies = [
        ball(20.0, 12),
        moved(ring.clone(), [80.0, 0.0, 0.0]),
        moved(block([0.0; 3], [20.0; 3]), [0.0, 50.0, 0.0]),
    ];
    let lidless = without(together(&bodies), |p| p.z > 19.9 && p.y > 49.0);
    let crossing = together(&[ball(20.0, 12), moved(ball(20.0, 12), [17.3, 9.1, 3.7])]);
    let pricked = sieved(crossing.clone(), 0.01, 23);
    let hollow = together(&[ball(40.0, 24), inverted(ball(30.0, 16))]);
    vec![
        Case::new(
            "mix-holes-turned",
            "holes, turned triangles, random order",
            &whole,
            shuffled(&flipped(sieved(whole.clone(), 0.03, 24), 0.3, 25), 26),
        ),
        Case::new("mix-holes-flaps", "holes, flaps, turned triangles", &ring, flipped(holed, 0.2, 27)),
        Case::new(
            "mix-double-t",
            "double triangles, T-junctions, no-area ones",
            &whole,
            with_degenerate(doubled(with_t_junctions(whole.clone(), 0.1, 28), 0.1, 29), 40, 30),
        ),
        Case::new(
            "mix-near-holes",
            "corners 0.002 mm off, holes, turned",
            &whole,
            flipped(jittered(&sieved(whole.clone(), 0.01, 31), 0.002, 32), 0.4, 33),
        ),
        Case::new(
            "mix-bodies",
            "three bodies with holes, turned, doubled",
            &together(&bodies),
            shuffled(&doubled(flipped(sieved(lidless, 0.01, 34), 0.3, 35), 0.1, 36), 37),
        ),
        Case::overlapping(
            ["mix-crossing-holes", "two balls in each other, with holes, turned"],
            Some(0),
            &crossing,
            flipped(pricked, 0.2, 38),
        ),
        Case::new(
            "mix-cavity-holes",
            "a hollow ball with holes, turned",
            &hollow,
            flipped(sieved(hollow.clone(), 0.01, 39), 0.3, 40),
        ),
        Case::new("mix-all", "holes, flaps, strays, doubles, no-area, turned", &whole, everything(&whole)),
    ]
}

fn everything(mesh: &TriangleMesh) -> TriangleMesh {
    let more = with_strays(with_flaps(sieved(mesh.clone(), 0.02, 41), 8, 3.0, 42), 5, 43);
    shuffled(&flipped(with_degenerate(doubled(more, 0.05, 44), 30, 45), 0.3, 46), 47)
}

/// A hundred thousand triangles and more.
pub(super) fn large() -> Vec<Case> {
    let ball = rippled_ball(50.0, 360);
    let knot = knot(30.0, 12.0, 5.0, 3000, 40);
    let pits = |p: DVec3| (p * 0.7).to_array().iter().map(|x| x.sin()).sum::<f64>() > 2.55;
    vec![
        Case::new("large-sound", "sound: a rippled ball of 258,480 triangles", &ball, shuffled(&ball, 51)),
        Case::new(
            "large-holes",
            "the same with some hundred curved holes",
            &ball,
            without(ball.clone(), pits),
        ),
        Case::new(
            "large-turned",
            "a knot of 240,000 triangles, some turned, some twice",
            &knot,
            doubled(flipped(knot.clone(), 0.1, 52), 0.05, 53),
        ),
        Case::new("large-t", "the knot with T-junctions", &knot, with_t_junctions(knot.clone(), 0.05, 54)),
        Case::new(
            "large-near",
            "the knot with every corner up to 0.001 mm off",
            &knot,
            jittered(&knot, 0.001, 55),
        ),
    ]
}
