//! The views added up.

use crate::trial::{MISSING_PERCENT, PoseError, Trial, ViewReport};

/// A view with at least so many markers, thicker than this, fixes a pose.
const PLANE_MM: f64 = 1.0;

/// All views.
pub struct Tally {
    /// In order of their numbers; never empty.
    pub reports: Vec<ViewReport>,
}

/// A metric's stem and what it counts of a trial.
type Counter = (&'static str, fn(&Trial) -> usize);

/// The shares of visible markers that are reported for each share missing.
const NAMED: [Counter; 5] = [
    ("paper_rate", |t| t.paper),
    ("paper_roll_rate", |t| t.paper_rolled),
    ("corrected_rate", |t| t.corrected),
    ("ours_rate", |t| t.ours),
    ("falsely_certain_rate", |t| t.falsely_certain),
];

impl Tally {
    /// Every metric with its unit, in the order in which they are reported.
    pub fn metrics(&self) -> Vec<(String, f64, &'static str)> {
        let mut metrics = Vec::new();
        for (slot, percent) in MISSING_PERCENT.into_iter().enumerate() {
            for (stem, count) in NAMED {
                metrics.push((
                    format!("recognise.{stem}_missing_{percent:02}"),
                    self.named_share(slot, count),
                    "1",
                ));
            }
            metrics.push((format!("recognise.pose_rate_missing_{percent:02}"), self.pose_share(slot), "1"));
            metrics.push((
                format!("recognise.certain_share_missing_{percent:02}"),
                self.share(|r| r.trials[slot].certain),
                "1",
            ));
        }
        let mut add = |name: &str, value: f64, unit| metrics.push((format!("recognise.{name}"), value, unit));
        add("views", self.reports.len() as f64, "1");
        add("views_4_share", self.views_share(4), "1");
        add("views_6_share", self.views_share(6), "1");
        add("views_mseq_share", self.mseq_share(1), "1");
        add("views_2_mseq_share", self.mseq_share(2), "1");
        add("visible_mean", self.mean(|r| r.sightings.len() as f64), "1");
        let errors = self.right_poses();
        for (name, unit, of) in POSE_FIGURES {
            add(&format!("{name}_median"), quantile(&errors, 0.5, of), unit);
            add(&format!("{name}_p95"), quantile(&errors, 0.95, of), unit);
        }
        metrics
    }

    /// Share of all visible markers of all views that are counted, with the slot's share missing.
    pub fn named_share(&self, slot: usize, count: impl Fn(&Trial) -> usize) -> f64 {
        let sum =
            |of: &dyn Fn(&Trial) -> usize| self.reports.iter().map(|r| of(&r.trials[slot])).sum::<usize>();
        let all = sum(&|t| t.blobs);
        if all == 0 { 0.0 } else { sum(&count) as f64 / all as f64 }
    }

    /// Share of all views whose pose our recogniser found.
    pub fn pose_share(&self, slot: usize) -> f64 {
        self.share(|r| r.trials[slot].pose.is_some_and(|p| p.right))
    }

    /// Share of all views with at least so many visible markers that do not lie in one plane.
    pub fn views_share(&self, markers: usize) -> f64 {
        self.share(|r| r.sightings.len() >= markers && r.thickness_mm > PLANE_MM)
    }

    /// Share of all views with at least so many visible m-sequence markers.
    pub fn mseq_share(&self, markers: usize) -> f64 {
        self.share(|r| r.m_sequences >= markers)
    }

    /// The view of which our recogniser names the smallest share with none missing; of equals the one with the fewest markers, then
    /// the first.
    pub fn worst(&self) -> usize {
        let key = |r: &ViewReport| {
            let trial = &r.trials[0];
            (trial.ours as f64 / trial.blobs.max(1) as f64, trial.blobs)
        };
        let worse = |a: usize, b: usize| {
            let (a, b) = (key(&self.reports[a]), key(&self.reports[b]));
            a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))
        };
        (1..self.reports.len()).fold(0, |worst, k| if worse(k, worst).is_lt() { k } else { worst })
    }

    fn share(&self, holds: impl Fn(&ViewReport) -> bool) -> f64 {
        self.reports.iter().filter(|r| holds(r)).count() as f64 / self.reports.len() as f64
    }

    fn mean(&self, of: impl Fn(&ViewReport) -> f64) -> f64 {
        self.reports.iter().map(of).sum::<f64>() / self.reports.len() as f64
    }

    /// Poses that are right, none missing.
    fn right_poses(&self) -> Vec<PoseError> {
        self.reports.iter().filter_map(|r| r.trials[0].pose.filter(|p| p.right)).collect()
    }
}

/// Figures of right poses with none missing: predicted deviations for the given noise, and true errors beside them.
type PoseFigure = (&'static str, &'static str, fn(&PoseError) -> f64);

const POSE_FIGURES: [PoseFigure; 5] = [
    ("sigma_along_mm", "mm", |p| p.sigma_along_mm),
    ("sigma_across_mm", "mm", |p| p.sigma_across_mm),
    ("sigma_turn_deg", "deg", |p| p.sigma_turn_rad.to_degrees()),
    ("error_shift_mm", "mm", |p| p.shift_mm),
    ("error_turn_deg", "deg", |p| p.turn_rad.to_degrees()),
];

/// The value that a share of the poses does not exceed; 0 without poses.
fn quantile(errors: &[PoseError], share: f64, of: fn(&PoseError) -> f64) -> f64 {
    let mut values: Vec<f64> = errors.iter().map(of).collect();
    values.sort_by(f64::total_cmp);
    values.get((share * values.len().saturating_sub(1) as f64).round() as usize).copied().unwrap_or(0.0)
}
