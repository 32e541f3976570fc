//! The whole stage on a ball of sites, and the ball that the unit tests share.

use super::*;
use fibar_core::artefact::sites::{Site, View};
use fibar_geometry::viewsphere::{Polyhedron, geodesic_directions, geodesic_mesh};
use glam::DVec3;

/// A ball of 50 mm around (0, 0, 60).
pub fn ball() -> TriangleMesh {
    let mut mesh = geodesic_mesh(Polyhedron::Icosahedron, 8);
    mesh.vertices.iter_mut().for_each(|v| *v = *v * 50.0 + DVec3::Z * 60.0);
    mesh
}

/// Sites on the ball, and what 122 viewpoints see of them.
pub fn sites(frequency: u32) -> Sites {
    let centre = DVec3::Z * 60.0;
    let shake = |k: usize| DVec3::new((k * 7 % 5) as f64, (k * 3 % 7) as f64, (k * 5 % 11) as f64) * 0.01;
    let directions = geodesic_directions(Polyhedron::Icosahedron, frequency).into_iter().enumerate();
    let site = |(k, d): (usize, DVec3)| {
        let normal = (d + shake(k)).normalize();
        Site { position: centre + normal * 50.5, normal, suitability_rad: 1.0 }
    };
    let sites: Vec<Site> = directions.map(site).collect();
    let sees = |eye: DVec3, s: &Site| (eye - s.position).angle_between(s.normal).to_degrees() <= 60.0;
    let view = |d: DVec3| View {
        position: centre + d * 1000.0,
        visible: (0..).zip(&sites).filter(|(_, s)| sees(centre + d * 1000.0, s)).map(|(k, _)| k).collect(),
    };
    let views = geodesic_directions(Polyhedron::PentakisDodecahedron, 2).into_iter().map(view).collect();
    Sites::new(centre, sites, views)
}

pub fn params(change: impl Fn(&mut Params)) -> Params {
    let mut params = Params {
        survey_frequency: 3,
        watch_frequency: 6,
        place_moves: 3000,
        code_moves: 500,
        starts: 2,
        ..Params::default()
    };
    change(&mut params);
    params
}

fn run(sites: &Sites, params: &Params) -> Result<Constellation, StageError> {
    let sites = seen_sites(sites)?;
    let lines = Sightlines::cast(&ball(), &sites, params);
    let crowd = Crowd::new(&sites, params.spacing_mm);
    let task = Task { sites: &sites, light: None, clashes: None, codes: 7, params };
    let choice = task.choose_places(&lines, &crowd, 1)?;
    let codes = fibar_core::code::design_codes(4, 3, 6).unwrap();
    let patterns = codes.into_iter().map(|c| Pattern { id: c.pattern, bits: c.bits }).collect();
    Ok(Chosen::new(&choice, &task, 1).into_constellation(patterns, params))
}

/// How many markers that `counts` names a camera sees of a convex body.
fn seen(constellation: &Constellation, eye: DVec3, counts: impl Fn(&Marker) -> bool) -> usize {
    let sees = |m: &&Marker| (eye - m.position).angle_between(m.normal).to_degrees() < 60.0 && counts(m);
    constellation.markers.iter().filter(sees).count()
}

#[test]
fn every_camera_sees_an_m_sequence_and_six_markers() {
    let found = run(&sites(6), &params(|p| (p.markers, p.spacing_mm) = (Some(40), 12.0))).unwrap();
    assert_eq!(Constellation::from_json(&found.to_json()), Ok(found.clone()));
    assert_eq!(found.markers.len(), 40);
    let mut pairs = 0;
    let held_out = geodesic_directions(Polyhedron::PentakisDodecahedron, 17);
    let above: Vec<DVec3> = held_out.into_iter().filter(|d| d.z >= 0.0).collect();
    for (k, direction) in above.iter().enumerate() {
        let eye = DVec3::Z * 60.0 + *direction * (600.0 + 800.0 * (k % 9) as f64 / 8.0);
        let m_sequences = seen(&found, eye, |m| m.pattern == PatternId::M_SEQUENCE);
        assert!(m_sequences >= 1, "none from {eye}");
        assert!(seen(&found, eye, |_| true) >= 6, "few from {eye}");
        pairs += usize::from(m_sequences >= 2);
    }
    assert!(pairs as f64 > 0.95 * above.len() as f64, "two from {pairs} of {}", above.len());
}

#[test]
fn markers_keep_their_distance_and_use_all_codes() {
    let found = run(&sites(6), &params(|p| (p.markers, p.spacing_mm) = (Some(40), 12.0))).unwrap();
    for (k, marker) in found.markers.iter().enumerate() {
        assert!(found.markers[..k].iter().all(|o| o.position.distance(marker.position) >= 12.0));
        assert!((1..=6).contains(&marker.neighbours.len()));
    }
    for pattern in 1..=7 {
        let count = found.markers.iter().filter(|m| m.pattern == PatternId(pattern)).count();
        assert!((3..=12).contains(&count), "{count} markers blink pattern {pattern}");
    }
}

#[test]
fn without_a_number_all_places_with_room_are_taken() {
    let all = sites(3);
    assert_eq!(run(&all, &params(|_| ())).unwrap().markers.len(), all.sites.len());
}

#[test]
fn same_bytes_for_any_thread_count() {
    let bytes = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| run(&sites(4), &params(|p| p.markers = Some(30))).unwrap().to_json())
    };
    assert_eq!(bytes(1), bytes(3));
}

#[test]
fn errors_say_what_is_wrong() {
    let check = |sites: &Sites, params: Params, says: &str| {
        let error = run(sites, &params).unwrap_err().to_string();
        assert!(error.contains(says), "{error:?} does not say {says:?}");
    };
    let mut dark = sites(3);
    dark.views.iter_mut().for_each(|v| v.visible.clear());
    check(&dark, params(|_| ()), "only 0 of 92 candidate places are seen by any of 122 viewpoints");
    check(&sites(3), params(|p| p.markers = Some(300)), "300 markers are wanted, but only 92 of 92");
    check(&sites(3), params(|p| p.spacing_mm = 500.0), "4 markers are wanted, but only 1 of 92");
    let mut bald = sites(4);
    bald.sites.retain(|s| s.normal.x < 0.3);
    let count = bald.sites.len() as u32;
    bald.views.iter_mut().for_each(|v| v.visible = (0..count).collect());
    check(&bald, params(|_| ()), "no m-sequence marker is surely in sight from");
    assert!(run(&bald, &params(|p| p.max_blind_share = 1.0)).is_ok());
}

#[test]
fn places_that_no_led_reaches_are_left_out_and_too_few_others_are_an_error() {
    let all = sites(3);
    let bounds = |lit: usize| Bounds {
        format: "fibar.bounds/1".into(),
        law: fibar_core::light::LightLaw::TONE_2020,
        min_bend_radius_mm: 12.0,
        wall_mm: 0.0,
        arrival_tilt_deg: 0.0,
        leds: vec![fibar_core::LedId(0)],
        targets: (0..)
            .zip(&all.sites)
            .map(|(k, s)| fibar_core::artefact::bounds::Target {
                position: s.position,
                normal: s.normal,
                certified_mm: vec![900.0],
                best_mm: vec![if k < lit { 800.0 } else { 0.0 }],
            })
            .collect(),
    };
    assert_eq!(reached_sites(&all, &bounds(40)).unwrap().sites.len(), 40);
    let error = reached_sites(&all, &bounds(3)).unwrap_err().to_string();
    assert!(error.contains("only 3 of 92 candidate places can be reached by any LED"), "{error}");
}

#[test]
fn regions_have_as_many_markers_as_asked() {
    let region = |low_z: f64, at_least: u32, at_most: Option<u32>| regions::Region {
        name: "top".into(),
        low_mm: Some([-100.0, -100.0, low_z]),
        high_mm: None,
        at_least,
        at_most,
    };
    let above = |regions: Vec<regions::Region>| {
        let found = run(
            &sites(6),
            &params(|p| (p.markers, p.spacing_mm, p.regions) = (Some(40), 12.0, regions.clone())),
        );
        found.map(|c| c.markers.iter().filter(|m| m.position.z >= 80.0).count()).map_err(|e| e.to_string())
    };
    let free = above(vec![]).unwrap();
    assert_eq!(above(vec![region(80.0, free as u32 + 3, None)]), Ok(free + 3));
    assert_eq!(above(vec![region(80.0, 0, Some(free as u32 - 4))]), Ok(free - 4));
    assert_eq!(above(vec![region(80.0, free as u32 + 1, Some(free as u32 + 1))]), Ok(free + 1));
    let error = above(vec![region(108.0, 9, None)]).unwrap_err();
    assert!(
        error.contains("\"top\" is to have at least 9 markers, but the best choice found has "),
        "{error}"
    );
}
