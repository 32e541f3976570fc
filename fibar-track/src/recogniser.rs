//! Our recognition: names and pose at once, from any side and at any roll.
//!
//! Three blobs whose patterns are known can only be some markers of those patterns. For each such choice P3P (see `p3p`)
//! gives up to four poses, and every pose is judged by what it explains: blobs where it puts markers of their
//! pattern speak for it, markers that it shows and nobody sees speak against it. No neighbourhood is needed, so nothing
//! is lost when markers are missing.
//!
//! When to stop is decided a contrario (Desolneux, Moisan & Morel, "From Gestalt Theory to Image Analysis", 2008; Moisan
//! & Stival, IJCV 2004, for correspondences): a pose is certain when chance would hardly have made any of all the
//! poses tried explain so many blobs.

use crate::camera::Camera;
use crate::consensus::Estimate;
use crate::judge::{Judge, Judgement};
use crate::model::{Blob, Model};
use crate::p3p;
use crate::pose::Pose;
use crate::refinement::{Correspondence, refine};
use crate::triples::{Triple, Triples};
use crate::twin::{better_of_twins, twin};

/// How to recognise.
#[derive(Clone, Copy, Debug)]
pub struct RecogniserOptions {
    /// How far a blob may lie from where a refined pose puts its marker, px.
    pub gate_px: f64,
    /// The same for the raw pose of three blobs, which their noise turns, px.
    pub raw_gate_px: f64,
    /// A pose is certain below this expected number of poses that would look as good by chance.
    pub max_false_alarms: f64,
    /// The search ends early only with a certain pose that explains this share of the blobs.
    pub early_share: f64,
    /// Triples of neighbouring blobs tried at most, each only with markers near one another.
    pub max_near_triples: usize,
    /// Triples of any blobs tried afterwards at most, each with all markers that they could be.
    pub max_wide_triples: usize,
    /// Triples of named blobs tried at the end at most, when the best pose leaves blobs unexplained.
    pub max_named_triples: usize,
}

impl Default for RecogniserOptions {
    fn default() -> RecogniserOptions {
        RecogniserOptions {
            gate_px: 3.0,
            raw_gate_px: 8.0,
            max_false_alarms: 1e-4,
            early_share: 0.75,
            max_near_triples: 24,
            max_wide_triples: 12,
            max_named_triples: 12,
        }
    }
}

/// What an image shows.
#[derive(Clone, Debug)]
pub struct Recognition {
    /// Each blob's marker, by index.
    pub names: Vec<Option<usize>>,
    /// The pose, with indices of blobs as inliers.
    pub estimate: Option<Estimate>,
    /// Expected number of poses that would look as good by chance: certain well below 1, a guess above.
    pub false_alarms: f64,
}

/// Names the blobs and finds the pose that explains them best.
pub fn recognise(model: &Model, camera: &Camera, blobs: &[Blob], options: &RecogniserOptions) -> Recognition {
    let mut search = Search { judge: Judge::new(model, camera, blobs), options, best: None, tried: 0 };
    search.try_near();
    search.try_wide();
    search.try_named();
    search.conclude()
}

struct Search<'a> {
    judge: Judge<'a>,
    options: &'a RecogniserOptions,
    best: Option<Candidate>,
    tried: usize,
}

struct Candidate {
    pose: Pose,
    judgement: Judgement,
}

impl Search<'_> {
    /// Tries neighbouring blobs as markers near one another.
    fn try_near(&mut self) {
        let Judge { model, blobs, .. } = self.judge;
        for triple in Triples::near(model, blobs).take(self.options.max_near_triples) {
            let [first, second, third] = triple.map(|k| blobs[k].pattern);
            for &a in model.of_pattern(first) {
                let near = |pattern| {
                    model.near(a).iter().copied().filter(move |&k| model.markers()[k].pattern == pattern)
                };
                for b in near(second) {
                    for c in near(third).filter(|c| *c != b) {
                        self.try_markers(&triple, [a, b, c]);
                    }
                }
            }
            if self.is_settled() {
                return;
            }
        }
    }

    /// Tries blobs far apart as all markers that they could be.
    fn try_wide(&mut self) {
        let Judge { model, blobs, .. } = self.judge;
        if self.is_settled() {
            return;
        }
        for triple in Triples::wide(model, blobs).take(self.options.max_wide_triples) {
            let [first, second, third] = triple.map(|k| model.of_pattern(blobs[k].pattern));
            for &a in first {
                for &b in second.iter().filter(|b| **b != a) {
                    for &c in third.iter().filter(|c| **c != a && **c != b) {
                        self.try_markers(&triple, [a, b, c]);
                    }
                }
                if self.is_settled() {
                    return;
                }
            }
        }
    }

    /// Tries the poses of blobs far apart with the names that the best pose gives them. A pose may name most blobs rightly and still be
    /// turned by ten degrees: on few near markers two poses look almost alike, and refinement does not lead from one to the other.
    fn try_named(&mut self) {
        let Some(best) = &self.best else { return };
        let Judge { model, camera, blobs, .. } = self.judge;
        let names = model.name(camera, &best.pose, blobs, self.options.gate_px);
        if names.iter().all(Option::is_some) {
            return;
        }
        let named =
            |triple: &Triple| Some((*triple, [names[triple[0]]?, names[triple[1]]?, names[triple[2]]?]));
        let triples: Vec<(Triple, [usize; 3])> = Triples::wide(model, blobs)
            .filter_map(|t| named(&t))
            .take(self.options.max_named_triples)
            .collect();
        triples.iter().for_each(|(triple, markers)| self.try_markers(triple, *markers));
    }

    /// Tries three blobs as three markers.
    fn try_markers(&mut self, triple: &Triple, markers: [usize; 3]) {
        let Judge { model, camera, blobs, .. } = self.judge;
        let bearings = triple.map(|k| camera.bearing(blobs[k].at));
        let points = markers.map(|k| model.markers()[k].position);
        for pose in p3p::solve(bearings, points).iter() {
            self.try_pose(pose, markers);
        }
    }

    /// Judges a raw pose; one that explains enough is refined and judged again.
    fn try_pose(&mut self, pose: &Pose, sample: [usize; 3]) {
        self.tried += 1;
        let Judge { model, camera, .. } = self.judge;
        if sample.iter().any(|&marker| model.project(camera, pose, marker).is_none()) {
            return;
        }
        let best = self.best.as_ref().map_or(0, |best| best.judgement.explained);
        let wanted = (best.saturating_sub(1)).max(4).min(self.judge.blobs.len());
        if self.judge.explains(pose, self.options.raw_gate_px, wanted) {
            let (pose, judgement) = self.polish(pose);
            self.keep(pose, judgement);
        }
    }

    fn keep(&mut self, pose: Pose, judgement: Judgement) {
        if self.best.as_ref().is_none_or(|best| judgement.merit > best.judgement.merit) {
            self.best = Some(Candidate { pose, judgement });
        }
    }

    /// Refines a pose on the blobs that it explains, from the wide gate to the narrow one.
    fn polish(&self, pose: &Pose) -> (Pose, Judgement) {
        let mut pose = *pose;
        for gate_px in [self.options.raw_gate_px, self.options.gate_px] {
            let seen = self.explained(&pose, gate_px);
            if seen.len() > 3
                && let Some(fit) = refine(self.judge.camera, &pose, &seen, 5)
            {
                pose = fit.pose;
            }
        }
        (pose, self.judge.judge(&pose, self.options.gate_px))
    }

    fn explained(&self, pose: &Pose, gate_px: f64) -> Vec<Correspondence> {
        let Judge { model, camera, blobs, .. } = self.judge;
        let names = model.name(camera, pose, blobs, gate_px);
        let pair = |(blob, name): (&Blob, &Option<usize>)| {
            name.map(|k| Correspondence { point: model.markers()[k].position, pixel: blob.at })
        };
        blobs.iter().zip(&names).filter_map(pair).collect()
    }

    /// Whether the best pose needs no rival.
    fn is_settled(&self) -> bool {
        let enough = self.options.early_share * self.judge.blobs.len() as f64;
        self.best.as_ref().is_some_and(|best| {
            best.judgement.explained as f64 >= enough
                && self.false_alarms(best) < self.options.max_false_alarms
        })
    }

    fn false_alarms(&self, best: &Candidate) -> f64 {
        self.judge.false_alarms(&best.judgement, self.tried, self.options.gate_px)
    }

    /// The best pose against its mirror twin, refined, and the names it gives; those of misread blobs too if it is certain.
    fn conclude(mut self) -> Recognition {
        let Some(first) = &self.best else {
            let names = vec![None; self.judge.blobs.len()];
            return Recognition { names, estimate: None, false_alarms: f64::INFINITY };
        };
        let seen = self.explained(&first.pose, self.options.gate_px);
        // Once more from where it stands: a better pose brings far markers within the wide gate.
        for start in [first.pose, twin(&first.pose, &seen)] {
            let (pose, judgement) = self.polish(&start);
            self.keep(pose, judgement);
        }
        let best = self.best.as_ref().expect("kept above");
        let (false_alarms, gate_px) = (self.false_alarms(best), self.options.gate_px);
        let Judge { model, camera, blobs, .. } = self.judge;
        let estimate = self.estimate(&best.pose);
        let pose = estimate.as_ref().map_or(best.pose, |e| e.pose);
        let mut names = model.name(camera, &pose, blobs, gate_px);
        if false_alarms < self.options.max_false_alarms {
            model.name_misread(camera, &pose, blobs, gate_px, &mut names);
        }
        Recognition { names, estimate, false_alarms }
    }

    fn estimate(&self, pose: &Pose) -> Option<Estimate> {
        let Judge { model, camera, blobs, .. } = self.judge;
        let seen = self.explained(pose, self.options.gate_px);
        let fit = refine(camera, pose, &seen, 10)?;
        let (_, twin_margin) = better_of_twins(camera, fit, &seen, 10);
        let names = model.name(camera, pose, blobs, self.options.gate_px);
        Some(Estimate {
            pose: fit.pose,
            inliers: (0..names.len()).filter(|&k| names[k].is_some()).collect(),
            rms_px: (fit.error_px2 / seen.len() as f64).sqrt(),
            uncertainty: fit.uncertainty,
            twin_margin,
        })
    }
}

#[cfg(test)]
mod bunny;
#[cfg(test)]
mod tests;
