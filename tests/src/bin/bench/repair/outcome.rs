//! A tool's result on a mesh, judged.

use super::Patient;
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_ruler::surface::ClosedSurface;
use fibar_tests::judge::{Judgement, farthest};
use glam::DVec3;
use std::cmp::Ordering;
use std::collections::BTreeMap;

/// Of a real mesh no vertex may be left outside the result by more than this, mm; all are 100 mm long.
const LEFT_OUT_MM: f64 = 1.0;

/// A tool's own word.
#[derive(serde::Deserialize)]
pub struct Said {
    seconds: Option<f64>,
    refused: Option<String>,
    #[serde(default)]
    metrics: BTreeMap<String, f64>,
}

impl Said {
    /// How far the tool says that it moved everything, mm: `repair-manifold` puts it on the table, in the middle; others nowhere.
    fn moved(&self) -> DVec3 {
        let along = |axis: &str| self.metrics.get(&format!("repair.moved_{axis}_mm")).copied().unwrap_or(0.0);
        DVec3::new(along("x"), along("y"), along("z"))
    }
}

/// What came of a repair.
pub struct Outcome {
    /// Processor time, where the tool gave a result.
    pub seconds: Option<f64>,
    /// Nothing if the result is right, else what is wrong.
    pub wrong: Option<String>,
    /// Share by which the volume is off, where the true one is known and the result closed.
    pub volume_off: Option<f64>,
    /// Greatest distance of the result from the true surface, or of the surface that came in, mm.
    pub displacement: Option<f64>,
}

impl Outcome {
    /// Judges what a tool left.
    pub fn judge(patient: &Patient, said: &Said, result: Option<TriangleMesh>) -> Outcome {
        let blank = Outcome { seconds: None, wrong: None, volume_off: None, displacement: None };
        let Some(mut mesh) = result.filter(|_| said.refused.is_none()) else {
            let reason = said.refused.clone().unwrap_or_else(|| "no readable result".into());
            return Outcome { wrong: Some(format!("refused: {}", shortened(&reason))), ..blank };
        };
        let truth = patient.truth.as_ref();
        let reference = truth.and_then(|truth| truth.sound.as_ref());
        mesh.vertices.iter_mut().for_each(|v| *v -= said.moved());
        let seen = Judgement::of(&mesh);
        let volume_off = truth.filter(|_| seen.is_closed).map(|truth| seen.volume / truth.volume - 1.0);
        let wrong = match truth {
            Some(truth) => seen.differs_from(truth),
            None => seen.is_wrong().or_else(|| left_out(&patient.mesh, &mesh)),
        };
        let there = farthest(&mesh, reference.unwrap_or(&patient.mesh));
        let back = reference.map_or(0.0, |sound| farthest(sound, &mesh));
        Outcome { seconds: said.seconds, wrong, volume_off, displacement: Some(there.max(back)) }
    }

    /// Right ones first, then fast ones.
    pub fn compare(&self, other: &Outcome) -> Ordering {
        let time = |outcome: &Outcome| outcome.seconds.unwrap_or(f64::INFINITY);
        self.wrong.is_some().cmp(&other.wrong.is_some()).then(time(self).total_cmp(&time(other)))
    }
}

fn shortened(reason: &str) -> String {
    let line = reason.lines().next().unwrap_or_default();
    line.chars().take(110).collect::<String>().replace('|', "/")
}

/// Whether a piece of what came in is not in the result.
fn left_out(soup: &TriangleMesh, result: &TriangleMesh) -> Option<String> {
    let surface = ClosedSurface::of(result);
    let outside = soup.vertices.iter().map(|v| -surface.depth(*v)).fold(0.0, f64::max);
    (outside > LEFT_OUT_MM).then(|| format!("a piece is lost, {outside:.1} mm outside"))
}
