//! Where markers sit and what they blink: what the stages do, beside a straightforward version of the same on one thread.
//!
//! *Visibility*: 20,000 places of a lumpy ball of 302,580 triangles from 482 viewpoints; plainly, through the verifiers' binary tree of
//! boxes in f64. *GA*: a whole run of `assign-genetic`; plainly, every chromosome evaluated from nothing by the definitions in
//! `fibar-core`. Both plain versions do a part of the work, which is said, and are scaled up.

use super::stopwatch::{once, text};
use fibar_core::adjacency::clockwise_neighbours;
use fibar_core::artefact::Document;
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_core::artefact::sites::{Site, Sites, View};
use fibar_core::artefact::sockets::{Hole, Socket, Sockets};
use fibar_core::images::{Image, Images};
use fibar_core::levenshtein::sequence_distance;
use fibar_core::recognition::{Entry, look_up, most_frequent};
use fibar_core::{LedId, PatternId};
use fibar_geometry::rays::RayScene;
use fibar_geometry::sampling::{SurfaceSample, sample_surface};
use fibar_geometry::viewsphere::{Polyhedron, geodesic_directions, geodesic_mesh};
use fibar_ruler::surface::ClosedSurface;
use fibar_tests::executables;
use glam::{DVec2, DVec3};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::process::Command;
use std::time::{Duration, Instant};

/// How much of the work the plain versions do.
const PLAIN_SAMPLES: usize = 400;
const PLAIN_CHROMOSOMES: u32 = 20;

/// Prints the table.
pub fn run() {
    println!("| markers | stage, all cores | plain, one thread | ratio |\n| --- | --- | --- | --- |");
    row("visibility, 302,580 triangles, 20,000 places, 482 viewpoints", visibility());
    row("whole genetic algorithm, 76 places, 482 viewpoints", genetic());
}

fn row(name: &str, times: Result<[Duration; 2], String>) {
    match times {
        Ok([ours, plain]) => {
            let ratio = plain.as_secs_f64() / ours.as_secs_f64();
            println!("| {name} | {} | {} | {ratio:.1} × |", text(ours), text(plain));
        }
        Err(reason) => println!("| {name} | skipped: {} | | |", reason.lines().last().unwrap_or_default()),
    }
}

fn visibility() -> Result<[Duration; 2], String> {
    let mut ball = geodesic_mesh(Polyhedron::Icosahedron, 123);
    ball.vertices
        .iter_mut()
        .for_each(|v| *v *= 60.0 + 8.0 * (9.0 * v.x).sin() * (7.0 * v.y + 3.0 * v.z).sin());
    let samples = sample_surface(&ball, 20_000, 0.7, &mut ChaCha8Rng::seed_from_u64(1));
    let eyes: Vec<DVec3> =
        geodesic_directions(Polyhedron::PentakisDodecahedron, 4).iter().map(|d| *d * 1000.0).collect();
    let start = Instant::now();
    let scene = RayScene::new(&ball);
    let clear = |from, to| scene.is_clear(from, to);
    let ours: Vec<usize> = samples.par_iter().map(|sample| count_seeing(sample, &eyes, clear)).collect();
    let took = start.elapsed();
    let every = samples.len() / PLAIN_SAMPLES;
    let start = Instant::now();
    let plain = plain_visibility(&ball, samples.iter().step_by(every), &eyes);
    let plain_took = start.elapsed() * every as u32;
    let ours: Vec<usize> = ours.into_iter().step_by(every).collect();
    let apart: usize = std::iter::zip(&ours, &plain).map(|(a, b)| a.abs_diff(*b)).sum();
    let all: usize = plain.iter().sum();
    // Rays in f32 and f64 may differ where they graze a triangle's edge.
    if apart * 1000 > all {
        return Err(format!("the two disagree in {apart} of {all} sights"));
    }
    Ok([took, plain_took])
}

fn plain_visibility<'a>(
    body: &TriangleMesh,
    samples: impl Iterator<Item = &'a SurfaceSample>,
    eyes: &[DVec3],
) -> Vec<usize> {
    let surface = ClosedSurface::of(body);
    samples.map(|sample| count_seeing(sample, eyes, |from, to| !surface.bvh().blocks(from, to))).collect()
}

fn count_seeing(sample: &SurfaceSample, eyes: &[DVec3], clear: impl Fn(DVec3, DVec3) -> bool) -> usize {
    let start = sample.position + sample.face_normal * 0.01;
    let faces = |eye: &&DVec3| {
        let arm = **eye - sample.position;
        arm.dot(sample.normal) > 0.0 && arm.dot(sample.face_normal) > 0.0
    };
    eyes.iter().filter(faces).filter(|eye| clear(start, **eye)).count()
}

fn genetic() -> Result<[Duration; 2], String> {
    let folder = tempfile::tempdir().map_err(|e| e.to_string())?;
    let sites = globe(76);
    let place = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let write = |name: &str, bytes: &[u8]| std::fs::write(place(name), bytes).map_err(|e| e.to_string());
    write("sites.json", &sites.to_json())?;
    write("sockets.json", &base().to_json())?;
    let input = |name: &str| serde_json::json!([{ "path": place(name), "digest": "0" }]);
    let request = serde_json::json!({
        "inputs": { "sites": input("sites.json"), "sockets": input("sockets.json") },
        "out_dir": place("out"), "seed": 7, "threads": 2,
    });
    write("request.json", request.to_string().as_bytes())?;
    let mut command = Command::new(executables().join("assign-genetic"));
    command.arg("--request").arg(place("request.json"));
    let took = once(&mut command)?;
    std::fs::remove_dir_all(place("out")).map_err(|e| e.to_string())?;
    let iterations = iterations(&mut command)?;
    let images = Images::new(&sites);
    let start = Instant::now();
    let objectives: f64 = (0..PLAIN_CHROMOSOMES).map(|k| plain_objective(&images, k)).sum();
    let each = start.elapsed() / PLAIN_CHROMOSOMES;
    // A population of 12, then 6 offspring in each iteration.
    let evaluations = 12 + 6 * iterations;
    if objectives.is_finite() { Ok([took, each * evaluations]) } else { Err("no objective".into()) }
}

/// `assign.iterations` of a run.
fn iterations(command: &mut Command) -> Result<u32, String> {
    let output = command.output().map_err(|e| e.to_string())?;
    let lines = String::from_utf8_lossy(&output.stdout).into_owned();
    let metric = |line: &str| {
        let message: serde_json::Value = serde_json::from_str(line).ok()?;
        (message["name"] == "assign.iterations").then(|| message["value"].as_f64()).flatten()
    };
    lines.lines().find_map(metric).map(|n| n as u32).ok_or("the stage reported no iterations".into())
}

/// `Σ_v E_rcg(v)·E_mseq(v)` (Tone 2020, "Marker placement") of some chromosome, with k1 = 5 and k2 = 2.
fn plain_objective(images: &Images, number: u32) -> f64 {
    let gene = |site: u32| PatternId((site * 31 + number * 17) % 97 % 7 + 1);
    let read = |image: &Image| -> BTreeMap<u32, Vec<PatternId>> {
        let rings = clockwise_neighbours(&image.points as &[DVec2]).into_iter();
        let patterns = |ring: Vec<usize>| ring.into_iter().map(|k| gene(image.sites[k])).collect();
        std::iter::zip(image.sites.iter().copied(), rings.map(patterns)).collect()
    };
    let views: Vec<_> = images.views.iter().map(read).collect();
    let stored = |site: u32| most_frequent(views.iter().filter_map(|view| view.get(&site).cloned()));
    let table: Vec<(u32, Vec<PatternId>)> =
        (0..images.sites.len() as u32).filter_map(|site| Some((site, stored(site)?))).collect();
    let lines: Vec<Entry> =
        table.iter().map(|(site, s)| Entry { pattern: gene(*site), neighbours: s }).collect();
    let recognition = |(site, seen): (&u32, &Vec<PatternId>)| {
        let line = look_up(Entry { pattern: gene(*site), neighbours: seen }, &lines);
        match line.map(|k| &table[k]) {
            Some((found, s)) if found == site => 5.0 - sequence_distance(seen, s) as f64,
            _ => -5.0,
        }
    };
    let value = |view: &BTreeMap<u32, Vec<PatternId>>| {
        let m_sequences = view.keys().filter(|&&s| gene(s) == PatternId::M_SEQUENCE).count().min(2);
        view.iter().map(recognition).sum::<f64>() * ((m_sequences as f64).sqrt() + 1.0)
    };
    views.iter().map(value).sum()
}

/// Places on a ball of 50 mm in a spiral of golden angles, seen up to 60° off their normals from 482 viewpoints.
fn globe(count: usize) -> Sites {
    let normal = |k: usize| {
        let (z, angle) = (1.0 - (2.0 * k as f64 + 1.0) / count as f64, k as f64 * 2.399_963_229_728_653);
        (DVec3::new(angle.cos(), angle.sin(), 0.0) * (1.0 - z * z).sqrt()).with_z(z)
    };
    let site = |k| Site { position: normal(k) * 50.0, normal: normal(k), suitability_rad: 1.0 };
    let sites: Vec<Site> = (0..count).map(site).collect();
    let sees = |eye: DVec3, s: &Site| (eye - s.position).angle_between(s.normal).to_degrees() <= 60.0;
    let view = |d: &DVec3| {
        let seen = (0..).zip(&sites).filter(|(_, s)| sees(*d * 1000.0, s)).map(|(k, _)| k);
        View { position: *d * 1000.0, visible: seen.collect() }
    };
    let views = geodesic_directions(Polyhedron::PentakisDodecahedron, 4).iter().map(view).collect();
    Sites::new(DVec3::ZERO, sites, views)
}

fn base() -> Sockets {
    let socket = |k: u32| Socket {
        led: LedId(k),
        pattern: PatternId(k + 1),
        position: DVec3::X * f64::from(k),
        axis: DVec3::Z,
    };
    Sockets::new(Hole { diameter_mm: 5.2, depth_mm: 8.6 }, (0..7).map(socket).collect())
}
