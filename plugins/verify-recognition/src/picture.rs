//! The picture: recognition over the viewing sphere, and the worst view.
//!
//! Four maps of the hemisphere of directions (Lambert's azimuthal equal-area projection, zenith in the middle, horizon on the inner
//! circle, below it outside): share of visible markers named rightly by our recogniser with none and with 30 % missing and by the paper's
//! lookup at the same roll, and how many markers show. Below: the worst view as the camera saw it.

use crate::params::Params;
use crate::scene::Scene;
use crate::tally::Tally;
use crate::trial::ViewReport;
use fibar_picture::Canvas;
use fibar_picture::colour::{Colour, scale};
use fibar_picture::legend::LINE_PX;
use fibar_picture::text::{Anchor, Letters};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

const MAP_PX: usize = 340;
const MARGIN_PX: usize = 14;
/// As many visible markers have the last colour of the scale.
const MANY: f64 = 24.0;
const RIGHT: Colour = [0.0, 0.62, 0.3];
const WRONG: Colour = [0.85, 0.1, 0.1];
const UNNAMED: Colour = [0.95, 0.6, 0.0];

/// A map's title, the captions of its scale, and the value of a view from 0 to 1.
type Map = (&'static str, [&'static str; 2], fn(&ViewReport) -> f64);

const MAPS: [Map; 4] = [
    ("named rightly, none missing", ["0", "all"], |r| share(r.trials[0].ours, r.trials[0].blobs)),
    ("named rightly, 30 % missing", ["0", "all"], |r| share(r.trials[2].ours, r.trials[2].blobs)),
    ("paper's lookup, same roll, none missing", ["0", "all"], |r| {
        share(r.trials[0].paper_rolled, r.trials[0].blobs)
    }),
    ("markers in sight", ["0", "24 and more"], |r| r.sightings.len() as f64 / MANY),
];

fn share(count: usize, of: usize) -> f64 {
    count as f64 / of.max(1) as f64
}

/// Draws all of it.
pub fn draw(tally: &Tally, scene: &Scene, params: &Params) -> Vec<u8> {
    let (width, height) = (params.width_px as usize, params.height_px as usize);
    let total = (2 * MAP_PX + 3 * MARGIN_PX).max(width + 2 * MARGIN_PX);
    let tile = MAP_PX + 2 * LINE_PX + MARGIN_PX;
    let mut canvas = Canvas::new(total, 2 * tile + height + LINE_PX + 3 * MARGIN_PX);
    for (k, (title, captions, value)) in MAPS.into_iter().enumerate() {
        let corner = [MARGIN_PX + k % 2 * (total / 2), MARGIN_PX + k / 2 * tile];
        write(&mut canvas, title, corner);
        let map = DVec2::new(corner[0] as f64, (corner[1] + LINE_PX) as f64);
        draw_map(&mut canvas, map, tally, scene.middle, value);
        canvas.scale_bar(captions, [corner[0], corner[1] + LINE_PX + MAP_PX]);
    }
    let top = 2 * tile + MARGIN_PX;
    describe_worst(&mut canvas, tally, [MARGIN_PX, top]);
    draw_view(&mut canvas, [MARGIN_PX, top + LINE_PX], &tally.reports[tally.worst()], scene, params);
    canvas.to_png()
}

fn write(canvas: &mut Canvas, text: &str, [left, top]: [usize; 2]) {
    let at = DVec2::new(left as f64, (top + LINE_PX / 2) as f64);
    canvas.text(text, at, Anchor::Left, Letters::Small);
}

fn describe_worst(canvas: &mut Canvas, tally: &Tally, [left, top]: [usize; 2]) {
    let number = tally.worst();
    let trial = &tally.reports[number].trials[0];
    let text = format!("worst view, number {number}: {} of {} named rightly", trial.ours, trial.blobs);
    write(canvas, &text, [left, top]);
    let [letter, _] = Letters::Small.cell();
    let legend = left + letter * (text.chars().count() + 3);
    canvas.swatches(&[("rightly", RIGHT), ("wrongly", WRONG), ("not at all", UNNAMED)], [legend, top]);
}

/// A dot per view, the views named worst on top.
fn draw_map(canvas: &mut Canvas, corner: DVec2, tally: &Tally, middle: DVec3, value: fn(&ViewReport) -> f64) {
    let radius = MAP_PX as f64 / 2.0;
    let mut order: Vec<&ViewReport> = tally.reports.iter().collect();
    order.sort_by(|a, b| value(b).total_cmp(&value(a)));
    let dot = (radius * (2.0 / order.len() as f64).sqrt()).clamp(1.0, 8.0);
    for report in order {
        let direction = (report.viewpoint.eye - middle).normalize();
        // Lambert: radius √(1 − z) puts the horizon at 1/√2 of the nadir's circle; the map shows down to −45°.
        let reach = ((1.0 - direction.z) / (1.0 + 0.5_f64.sqrt())).sqrt();
        let flat = direction.truncate().normalize_or_zero() * reach * radius;
        let at = corner + DVec2::new(radius + flat.x, radius - flat.y);
        canvas.disc(at, dot, scale(value(report)));
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
            Some(marker) if *marker == sighting.marker => RIGHT,
            Some(_) => WRONG,
            None => UNNAMED,
        };
        let at = DVec2::new(left as f64, top as f64) + at;
        canvas.disc(at, 5.0, [0.0; 3]);
        canvas.disc(at, 3.8, colour);
    }
}
