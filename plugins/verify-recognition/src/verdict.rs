//! What was found, rule by rule.

use crate::params::Params;
use crate::tally::Tally;
use crate::trial::MISSING_PERCENT;
use fibar_core::artefact::verdict::{Finding, Place, Verdict};
use fibar_plugin::Violation;

/// The findings over all views.
pub fn verdict(tally: &Tally, params: &Params) -> Verdict {
    let rate = |slot: usize| tally.named_share(slot, |t| t.ours);
    let findings = vec![
        finding(
            "recognise.names",
            rate(0),
            params.min_rate_missing_00,
            names_in_words(tally, params, 0),
            worst_place(tally),
        ),
        finding(
            "recognise.names_missing",
            rate(2),
            params.min_rate_missing_30,
            names_in_words(tally, params, 2),
            vec![],
        ),
        finding(
            "recognise.views",
            tally.views_share(6),
            params.min_views_6_share,
            "share of views with at least six visible markers that are not in one plane".into(),
            vec![],
        ),
        finding(
            "recognise.mseq",
            tally.mseq_share(1),
            params.min_views_mseq_share,
            "share of views with a visible m-sequence marker".into(),
            vec![],
        ),
        finding(
            "recognise.two_mseq",
            tally.mseq_share(2),
            params.min_views_two_mseq_share,
            "share of views with two visible m-sequence markers".into(),
            vec![],
        ),
    ];
    Verdict::new("verify-recognition", findings)
}

/// A broken rule as the host hears of it.
pub fn violation(finding: &Finding) -> Violation {
    let bound = finding.bound.unwrap_or(0.0);
    Violation {
        rule: finding.rule.clone(),
        message: format!("{}: {:.4}, wanted {bound}", finding.message, finding.value),
        place_mm: finding.places.first().map(|p| p.position.to_array()),
    }
}

fn finding(rule: &str, value: f64, bound: f64, message: String, places: Vec<Place>) -> Finding {
    Finding {
        rule: rule.into(),
        holds: value >= bound,
        value,
        unit: "1".into(),
        bound: Some(bound),
        message,
        places,
    }
}

fn names_in_words(tally: &Tally, params: &Params, slot: usize) -> String {
    let paper = |rolled: bool| tally.named_share(slot, |t| if rolled { t.paper_rolled } else { t.paper });
    format!(
        "share of all visible markers of {} views named rightly at any roll, {} % missing; the paper's lookup {:.3} with an \
         upright camera, {:.3} at any roll. Seen within {}° of the normal, from {} to {} mm, blobs off by {} px",
        tally.reports.len(),
        MISSING_PERCENT[slot],
        paper(false),
        paper(true),
        params.emission_limit_deg,
        params.nearest_mm,
        params.farthest_mm,
        params.noise_px,
    )
}

/// The worst view: the place is the camera's.
fn worst_place(tally: &Tally) -> Vec<Place> {
    let number = tally.worst();
    let report = &tally.reports[number];
    let trial = &report.trials[0];
    let what = format!(
        "camera of the worst view, number {number}: {} of {} visible markers named rightly, roll {:.1}°",
        trial.ours,
        trial.blobs,
        report.viewpoint.roll_rad.to_degrees()
    );
    vec![Place { position: report.viewpoint.eye, value: trial.ours as f64 / trial.blobs.max(1) as f64, what }]
}
