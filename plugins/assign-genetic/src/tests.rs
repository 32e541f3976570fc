//! The whole stage on a globe of sites, and the globe that the unit tests share.

use super::*;
use fibar_core::LedId;
use fibar_core::artefact::sites::{Site, View};
use fibar_core::artefact::sockets::{Hole, Socket};
use glam::DVec3;

/// About evenly spread unit vectors (a spiral of golden angles), shaken so that nothing is symmetric.
fn directions(count: usize) -> impl Iterator<Item = DVec3> {
    (0..count).map(move |k| {
        let z = 1.0 - (2.0 * k as f64 + 1.0) / count as f64;
        let angle = k as f64 * 2.399_963_229_728_653;
        let shake = DVec3::new((k * 7 % 5) as f64, (k * 3 % 7) as f64, (k * 5 % 11) as f64) * 0.02;
        (DVec3::new(angle.cos(), angle.sin(), 0.0) * (1.0 - z * z).sqrt() + DVec3::Z * z + shake).normalize()
    })
}

/// Sites on a ball of 50 mm, seen from 60 viewpoints up to so many degrees off their normals.
fn globe_sites(count: usize, limit_deg: f64) -> Sites {
    let site = |d: DVec3| Site { position: d * 50.0, normal: d, suitability_rad: 1.0 };
    let sites: Vec<Site> = directions(count).map(site).collect();
    let sees = |from: DVec3, s: &Site| (from - s.position).angle_between(s.normal).to_degrees() <= limit_deg;
    let view = |d: DVec3| View {
        position: d * 1000.0,
        visible: (0..count as u32).filter(|&k| sees(d * 1000.0, &sites[k as usize])).collect(),
    };
    let views = directions(60).map(view).collect();
    Sites::new(DVec3::ZERO, sites, views)
}

pub fn globe(count: usize, limit_deg: f64) -> Images {
    Images::new(&globe_sites(count, limit_deg))
}

fn base(leds: u32) -> Sockets {
    let socket = |k: u32| Socket {
        led: LedId(k),
        pattern: PatternId(k + 1),
        position: DVec3::X * f64::from(k),
        axis: DVec3::Z,
    };
    Sockets::new(Hole { diameter_mm: 5.2, depth_mm: 8.6 }, (0..leds).map(socket).collect())
}

fn params(change: impl Fn(&mut Params)) -> Params {
    let mut params = Params { stop_after: 100, ..Params::default() };
    change(&mut params);
    params
}

fn find(images: &Images, patterns: u8, params: &Params) -> Found {
    genetic::search(images, patterns, params, 5, |_, _| Ok::<(), ()>(())).unwrap()
}

#[test]
fn the_best_objective_never_falls_and_the_search_stops_when_it_stays() {
    let found = find(&globe(30, 60.0), 7, &params(|_| ()));
    assert!(found.history.is_sorted());
    let end = found.history.len() - 1;
    assert_eq!(found.history[end], found.history[end - 100]);
    assert!(found.history[end - 101] < found.history[end]);
    assert!(found.history[end] > 1.2 * found.history[0], "{} → {}", found.history[0], found.history[end]);
}

#[test]
fn a_small_case_ends_at_the_best_of_all_chromosomes() {
    let images = globe(6, 80.0);
    let rules = objective::Rules::new(5.0, 2);
    let blank = Evaluated::blank(&images);
    let genes = |code: u32| (0..6).map(|k| (code / 4u32.pow(k) % 4) as u8).collect::<Vec<u8>>();
    let value = |code| blank.changed_to(genes(code), &images, &rules).objective;
    let best = (0..4u32.pow(6)).map(value).fold(f64::MIN, f64::max);
    let thorough = params(|p| {
        (p.population, p.offspring, p.stop_after) = (40, 20, 300);
        (p.mutation_rate, p.drop_share) = (0.3, 0.2);
    });
    assert_eq!(find(&images, 3, &thorough).best.objective, best);
}

#[test]
fn same_result_for_any_thread_count() {
    let images = globe(25, 60.0);
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| find(&images, 7, &params(|_| ())))
    };
    let (one, three) = (run(1), run(3));
    assert_eq!(one.history, three.history);
    assert_eq!(one.best.genes, three.best.genes);
}

#[test]
fn the_constellation_keeps_its_promises() {
    let images = globe(30, 60.0);
    let best = find(&images, 7, &params(|_| ())).best;
    let codes = codes_for(&base(7), Params::default().code_plan()).unwrap();
    let constellation = name_markers(&best, &images, codes, 350.0).unwrap();
    assert_eq!(Constellation::from_json(&constellation.to_json()), Ok(constellation.clone()));
    assert_eq!(constellation.markers.len(), best.genes.iter().filter(|&&g| g != 0).count());
    assert!(constellation.markers.iter().all(|m| m.neighbours.len() == 1 && !m.neighbours[0].is_empty()));
    assert_eq!(constellation.patterns.len(), 7);
}

#[test]
fn too_few_visible_sites_are_refused() {
    let check = |sites: &Sites, says: &str| {
        let error = take_images(sites).err().unwrap().to_string();
        assert!(error.contains(says), "{error:?} does not say {says:?}");
    };
    let mut dark = globe_sites(30, 60.0);
    dark.views.iter_mut().for_each(|v| v.visible.clear());
    check(&dark, "only 0 of 30 candidate places are seen by any of 60 viewpoints");
    check(&globe_sites(3, 60.0), "a pose needs 4 markers");
}

#[test]
fn names_that_cost_too_much_end_in_an_error() {
    let images = globe(8, 60.0);
    let blank = Evaluated::blank(&images);
    let error = name_markers(&blank, &images, Vec::new(), 350.0).unwrap_err().to_string();
    assert!(error.contains("keeps only 0 markers"), "{error}");
}
