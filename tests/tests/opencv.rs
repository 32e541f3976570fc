//! Poses of fibar-track against OpenCV's `solvePnPRansac` on the same points.

use fibar_tests::Peer;
use fibar_track::camera::Camera;
use fibar_track::consensus::{ConsensusOptions, find_consensus};
use fibar_track::pose::Pose;
use fibar_track::refinement::Correspondence;
use glam::{DMat3, DVec2, DVec3};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use serde_json::{Value, json};

#[test]
fn opencv_finds_the_same_poses() {
    let camera = Camera::centred(1100.0, 720.0, 540.0);
    let options = ConsensusOptions::default();
    let mut random = ChaCha8Rng::seed_from_u64(11);
    let problems: Vec<Value> =
        (0..60).map(|k| problem(&camera, &options, 8 + k % 16, k % 5, &mut random)).collect();
    let document = json!({
        "focal_px": camera.focal_px, "centre_px": camera.centre_px.to_array(), "gate_px": options.gate_px, "problems": problems,
    });
    let folder = tempfile::tempdir().expect("a folder for the problems");
    let file = folder.path().join("problems.json");
    std::fs::write(&file, document.to_string()).expect("room for the problems");
    if let Some(outcome) = Peer::Vision("check_pose.py").run(&[&file]) {
        println!("{}", outcome.expect(0).stdout);
    }
}

/// Points in a ball, seen from somewhere with noise, `wrong` of them elsewhere; and our pose.
fn problem(
    camera: &Camera,
    options: &ConsensusOptions,
    count: usize,
    wrong: usize,
    random: &mut ChaCha8Rng,
) -> Value {
    let mut within =
        |low: f64, high: f64| low + (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64 * (high - low);
    let mut point = |size: f64| DVec3::new(within(-size, size), within(-size, size), within(-size, size));
    let eye = point(1.0).normalize() * 800.0;
    let truth = Pose::looking(eye, point(30.0), point(3.0).x);
    let mut see = |k: usize| {
        let (on_object, noise) = (point(60.0), point(0.5));
        let lost = if k < wrong { DVec2::new(90.0, 40.0 + 30.0 * k as f64) } else { DVec2::ZERO };
        Correspondence {
            point: on_object,
            pixel: camera.project(truth.apply(on_object)) + noise.truncate() + lost,
        }
    };
    let seen: Vec<Correspondence> = (0..count).map(&mut see).collect();
    let found = find_consensus(camera, &seen, options).expect("most points agree");
    let points: Vec<[f64; 3]> = seen.iter().map(|s| s.point.to_array()).collect();
    let pixels: Vec<[f64; 2]> = seen.iter().map(|s| s.pixel.to_array()).collect();
    json!({
        "points": points, "pixels": pixels, "inliers": found.inliers,
        "rotation": rows(found.pose.rotation), "translation": found.pose.translation.to_array(),
        "truth": { "rotation": rows(truth.rotation), "translation": truth.translation.to_array() },
    })
}

fn rows(matrix: DMat3) -> [[f64; 3]; 3] {
    matrix.transpose().to_cols_array_2d()
}
