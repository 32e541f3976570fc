//! What is done where fibres do not fit: nothing but to say why and what would, fewer markers, or thinner fibres.
//!
//! Whatever is said to fit was routed and keeps every limit.

use crate::attempt::{Routed, Task};
use crate::misfit::{Misfit, Unfit, named};
use crate::params::{OnMisfit, Params};
use fibar_core::MarkerId;
use fibar_plugin::{Job, StageError};

/// Routings that were found instead.
#[derive(Default)]
pub struct Remedies {
    /// Outer diameter of fibres that all fit, mm.
    pub diameter: Option<f64>,
    /// Not even fibres of this diameter fit, mm.
    pub too_thick: Option<f64>,
    /// Without these markers the others fit.
    pub without: Option<Vec<MarkerId>>,
}

impl Remedies {
    /// An error with what was tried in its hint.
    pub fn add_to(&self, error: StageError) -> StageError {
        let mut parts = vec![];
        if let Some(diameter) = self.diameter {
            parts.push(format!("fibres of {diameter:.2} mm do fit (on_misfit = \"thin\")"));
        }
        if let Some(diameter) = self.too_thick {
            parts.push(format!(
                "fibres of {diameter:.2} mm do not fit either (least_core_radius_mm allows no thinner ones)"
            ));
        }
        if let Some(without) = &self.without {
            parts.push(format!("without {} the others fit (on_misfit = \"drop\")", named(without)));
        }
        if parts.is_empty() { error } else { error.hint_first(&format!("tried: {}", parts.join("; "))) }
    }
}

/// Routes everything; where it does not fit does what `on_misfit` says.
pub fn route(task: &Task, params: &Params, job: &mut Job) -> Result<Routed, StageError> {
    let misfit = match task.attempt(params, job) {
        Ok(routed) => return Ok(routed),
        Err(Unfit::Ended(error)) => return Err(error),
        Err(Unfit::Misfit(misfit)) => misfit,
    };
    if params.on_misfit == OnMisfit::Drop {
        return Err(misfit.error(&Remedies::default(), params));
    }
    job.log("info", &format!("{}; looking for what would fit", misfit.message(params)));
    let mut remedies = Remedies::default();
    match thinner(task, &misfit, params, job)? {
        Thinner::Found(routed) if params.on_misfit == OnMisfit::Thin => {
            job.log("warn", &thinned(&routed.params, &misfit, params));
            return Ok(*routed);
        }
        Thinner::Found(routed) => remedies.diameter = Some(routed.params.diameter()),
        Thinner::NotEven(diameter) => remedies.too_thick = Some(diameter),
        Thinner::Pointless => (),
    }
    remedies.without = dropped(task, params, job)?;
    Err(misfit.error(&remedies, params))
}

/// What thinner fibres bring.
enum Thinner {
    /// The thickest found that all fit.
    Found(Box<Routed>),
    /// Nor do the thinnest, mm, fit.
    NotEven(f64),
    /// It is not the thickness, or there is none to give.
    Pointless,
}

/// Tries a little less first, or what a neck is known to leave; then the least; then halves what lies between.
fn thinner(task: &Task, misfit: &Misfit, params: &Params, job: &mut Job) -> Result<Thinner, StageError> {
    const STEP_MM: f64 = 0.06;
    const TOLD_APART_MM: f64 = 0.03;
    let least = params.least_diameter();
    if least > params.diameter() - TOLD_APART_MM || !task.has_places(&params.of_diameter(least))? {
        return Ok(Thinner::Pointless);
    }
    let mut fails = misfit.bound_mm(params);
    let first = hundredths(if fails < params.diameter() { fails } else { fails - STEP_MM }).max(least);
    let mut found = of_diameter(task, first, params, job)?;
    if found.is_none() && first > least {
        fails = first;
        found = of_diameter(task, least, params, job)?;
    }
    let Some(mut found) = found else { return Ok(Thinner::NotEven(least)) };
    while fails - found.params.diameter() > TOLD_APART_MM {
        let diameter = hundredths(0.5 * (fails + found.params.diameter()));
        match of_diameter(task, diameter, params, job)? {
            Some(routed) => found = routed,
            None => fails = diameter,
        }
    }
    Ok(Thinner::Found(Box::new(found)))
}

/// Routes with fibres of another outer diameter, mm.
fn of_diameter(
    task: &Task,
    diameter: f64,
    params: &Params,
    job: &mut Job,
) -> Result<Option<Routed>, StageError> {
    let params = Params { on_misfit: OnMisfit::Refuse, ..params.of_diameter(diameter) };
    job.log("info", &format!("trying fibres of {diameter:.2} mm"));
    match task.attempt(&params, job) {
        Ok(routed) => Ok(Some(routed)),
        Err(Unfit::Ended(error)) => Err(error),
        Err(Unfit::Misfit(misfit)) => {
            job.log("info", &misfit.message(&params));
            Ok(None)
        }
    }
}

/// The markers that are left out so that the others fit.
fn dropped(task: &Task, params: &Params, job: &mut Job) -> Result<Option<Vec<MarkerId>>, StageError> {
    let params = Params { on_misfit: OnMisfit::Drop, ..params.clone() };
    match task.attempt(&params, job) {
        Ok(routed) => Ok(Some(routed.left_out())),
        Err(Unfit::Ended(error)) => Err(error),
        Err(Unfit::Misfit(_)) => Ok(None),
    }
}

/// Rounded down to hundredths of a millimetre.
fn hundredths(diameter: f64) -> f64 {
    (100.0 * diameter + 1e-6).floor() / 100.0
}

fn thinned(now: &Params, misfit: &Misfit, params: &Params) -> String {
    format!(
        "all fibres are made {:.2} mm thick instead of {:.2} mm, their cores {:.2} instead of {:.2}: {}",
        now.diameter(),
        params.diameter(),
        2.0 * now.core_radius_mm,
        2.0 * params.core_radius_mm,
        misfit.message(params)
    )
}
