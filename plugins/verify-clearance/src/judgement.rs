//! Measured places held against a bound: metric, finding and violation.

use fibar_core::artefact::verdict::{Finding, Place};
use fibar_plugin::{Job, Violation};

/// So many of the tightest places are always listed.
const LISTED: usize = 5;
/// No more than so many are listed, even if all of them break the rule.
const LISTED_AT_MOST: usize = 100;

/// One rule, measured.
pub struct Judgement {
    /// What goes into the verdict.
    pub finding: Finding,
    /// What goes into the metrics: name, value, unit.
    pub metrics: Vec<(&'static str, f64, &'static str)>,
}

/// What a rule is called and held against.
pub struct Rule {
    /// Name that a recipe may allow.
    pub name: &'static str,
    /// Metric that takes the least value.
    pub metric: &'static str,
    /// Least value allowed, mm.
    pub at_least: f64,
    /// What is measured, for the message.
    pub subject: &'static str,
}

impl Rule {
    /// The least of the places against the bound; none without places.
    pub fn judge(&self, mut places: Vec<Place>) -> Option<Judgement> {
        places.sort_by(|a, b| a.value.total_cmp(&b.value));
        let worst = places.first()?.clone();
        let broken = places.iter().filter(|place| place.value < self.at_least).count();
        let subject = self.subject;
        let message = format!(
            "{subject}: least {:.3} mm, {}; {broken} below {} mm",
            worst.value, worst.what, self.at_least
        );
        places.truncate(broken.clamp(LISTED, LISTED_AT_MOST));
        let finding = Finding {
            rule: self.name.into(),
            holds: broken == 0,
            value: worst.value,
            unit: "mm".into(),
            bound: Some(self.at_least),
            message,
            places,
        };
        Some(Judgement { finding, metrics: vec![(self.metric, worst.value, "mm")] })
    }
}

impl Judgement {
    /// Sends metrics, and the violation if the rule is broken.
    pub fn report(&self, job: &mut Job) {
        let worst = self.finding.places.first().map(|place| place.position.to_array());
        for &(name, value, unit) in &self.metrics {
            match worst.filter(|_| unit == "mm") {
                Some(place) => job.metric_at(name, value, unit, place),
                None => job.metric(name, value, unit),
            }
        }
        if !self.finding.holds {
            let Finding { rule, message, .. } = &self.finding;
            job.violation(Violation { rule: rule.clone(), message: message.clone(), place_mm: worst });
        }
    }
}
