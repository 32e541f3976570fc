//! The stage on a pebble.

use super::*;
use crate::fixture::{markers, pebble};
use crate::trial::ViewReport;
use glam::DVec3;

fn try_pebble(count: usize, params: &Params, seed: u64) -> Tally {
    let constellation = markers(count);
    let (body, model) = (pebble(40), Model::new(&constellation, params.emission_rad()));
    let occluder = Occluder::of(&body);
    let scene = Scene { constellation: &constellation, occluder: &occluder, middle: DVec3::ZERO };
    try_views(&Bench { scene, model: &model, params, seed }, &mut |_| Ok(())).expect("nobody cancels")
}

#[test]
fn a_pebble_is_recognised_from_everywhere() {
    let params = Params { views: 150, lowest_view_deg: -90.0, ..Params::default() };
    let tally = try_pebble(60, &params, 1);
    let rate = |slot: usize| tally.named_share(slot, |t| t.ours);
    assert!(rate(0) > 0.995 && rate(2) > 0.98, "{} {}", rate(0), rate(2));
    assert!(tally.pose_share(0) > 0.99);
    assert_eq!(tally.named_share(2, |t| t.falsely_certain), 0.0);
}

#[test]
fn visible_markers_are_those_that_rays_reach() {
    let params = Params { views: 40, lowest_view_deg: -90.0, lift_mm: 0.5, ..Params::default() };
    let (constellation, body) = (markers(60), pebble(40));
    let occluder = Occluder::of(&body);
    for ViewReport { viewpoint, sightings, .. } in try_pebble(60, &params, 2).reports {
        for (k, m) in constellation.markers.iter().enumerate() {
            let arm = viewpoint.eye - m.position;
            let lit = arm.angle_between(m.normal) < params.emission_rad();
            let clear = occluder.is_clear(m.position + m.normal * params.lift_mm, viewpoint.eye);
            assert_eq!(
                sightings.iter().any(|s| s.marker == k),
                lit && clear,
                "marker {k} from {}",
                viewpoint.eye
            );
        }
    }
}

#[test]
fn threads_change_nothing() {
    let params = Params { views: 30, ..Params::default() };
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| format!("{:?}", try_pebble(50, &params, 3).metrics()))
    };
    assert_eq!(run(1), run(3));
}

#[test]
fn an_object_of_no_use_is_reported_and_no_crash() {
    let check = |count: usize| {
        let params = Params { views: 20, ..Params::default() };
        let tally = try_pebble(count, &params, 4);
        assert!(tally.metrics().iter().all(|(_, value, _)| value.is_finite()));
        let broken = verdict::verdict(&tally, &params).findings.iter().filter(|f| !f.holds).count();
        assert!(broken >= 3, "{broken} rules broken by {count} markers");
    };
    check(1);
    check(3);
    check(7);
}

#[test]
fn every_view_is_a_line_of_the_table() {
    let params = Params { views: 25, ..Params::default() };
    let table = listing::list(&try_pebble(5, &params, 6));
    let lines: Vec<&str> = table.lines().collect();
    assert_eq!(lines.len(), 26);
    let columns = |line: &str| line.split(',').count();
    assert!(lines.iter().all(|line| columns(line) == columns(lines[0])), "{table}");
    assert!(lines[0].contains("pose_right_30,error_turn_deg_30"));
}
