//! The picture: recognition over the viewing sphere, and the worst view.
//!
//! Upper row, two maps of the hemisphere of directions (Lambert's azimuthal equal-area projection, zenith in the middle, horizon on
//! the inner circle, below it outside): share of visible markers named rightly by our recogniser, left, and by the
//! paper's lookup at the same roll, right, with none missing; dark blue 0, yellow 1. Below: the worst view as the camera saw
//! it; markers named rightly green, wrongly red, not at all orange.

use crate::params::Params;
use crate::scene::Scene;
use crate::tally::Tally;
use crate::trial::{Trial, ViewReport};
use fibar_picture::Canvas;
use fibar_picture::colour::{Colour, scale};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

const MAP_PX: usize = 360;
const MARGIN_PX: usize = 12;

/// Draws all of it.
pub fn draw(tally: &Tally, scene: &Scene, params: &Params) -> Vec<u8> {
    let (width, height) = (params.width_px as usize, params.height_px as usize);
    let total = (2 * MAP_PX + 3 * MARGIN_PX).max(width + 2 * MARGIN_PX);
    let mut canvas = Canvas::new(total, MAP_PX + height + 3 * MARGIN_PX);
    let maps: [fn(&Trial) -> usize; 2] = [|t| t.ours, |t| t.paper_rolled];
    for (column, count) in maps.into_iter().enumerate() {
        let corner = DVec2::new((MARGIN_PX + column * (MAP_PX + MARGIN_PX)) as f64, MARGIN_PX as f64);
        draw_map(&mut canvas, corner, tally, scene.middle, count);
    }
    let corner = [MARGIN_PX, MAP_PX + 2 * MARGIN_PX];
    draw_view(&mut canvas, corner, &tally.reports[tally.worst()], scene, params);
    canvas.to_png()
}

/// A dot per view, the views named worst on top.
fn draw_map(canvas: &mut Canvas, corner: DVec2, tally: &Tally, middle: DVec3, count: fn(&Trial) -> usize) {
    let radius = MAP_PX as f64 / 2.0;
    let share = |r: &ViewReport| count(&r.trials[0]) as f64 / r.trials[0].blobs.max(1) as f64;
    let mut order: Vec<&ViewReport> = tally.reports.iter().collect();
    order.sort_by(|a, b| share(b).total_cmp(&share(a)));
    let dot = (radius * (2.0 / order.len() as f64).sqrt()).clamp(1.0, 8.0);
    for report in order {
        let direction = (report.viewpoint.eye - middle).normalize();
        // Lambert: radius √(1 − z) puts the horizon at 1/√2 of the nadir's circle; the map shows down to −45°.
        let reach = ((1.0 - direction.z) / (1.0 + 0.5_f64.sqrt())).sqrt();
        let flat = direction.truncate().normalize_or_zero() * reach * radius;
        let at = corner + DVec2::new(radius + flat.x, radius - flat.y);
        canvas.disc(at, dot, scale(share(report)));
    }
}

/// The body in grey, by rays, with the markers that were visible.
fn draw_view(
    canvas: &mut Canvas,
    [left, top]: [usize; 2],
    report: &ViewReport,
    scene: &Scene,
    params: &Params,
) {
    let (camera, pose) = (params.camera(), report.viewpoint.pose());
    let (width, height) = (params.width_px as usize, params.height_px as usize);
    let far = 4.0 * report.viewpoint.eye.distance(scene.middle);
    let shade = |k: usize| {
        let pixel = DVec2::new((k % width) as f64 + 0.5, (k / width) as f64 + 0.5);
        let ray = pose.rotation.transpose() * camera.bearing(pixel);
        let hit = scene.occluder.nearest_hit(report.viewpoint.eye, report.viewpoint.eye + ray * far);
        hit.map_or([1.0; 3], |(_, normal)| [0.25 + 0.6 * normal.dot(ray).abs(); 3])
    };
    let shades: Vec<Colour> = (0..width * height).into_par_iter().map(shade).collect();
    canvas.paste(&Canvas::painted(width, height, |k| shades[k]), [left, top]);
    for (sighting, name) in report.sightings.iter().zip(&report.trials[0].names) {
        let at = camera.project(pose.apply(scene.constellation.markers[sighting.marker].position));
        let colour = match name {
            Some(marker) if *marker == sighting.marker => [0.0, 0.62, 0.3],
            Some(_) => [0.85, 0.1, 0.1],
            None => [0.95, 0.6, 0.0],
        };
        let at = DVec2::new(left as f64, top as f64) + at;
        canvas.disc(at, 5.0, [0.0; 3]);
        canvas.disc(at, 3.8, colour);
    }
}
