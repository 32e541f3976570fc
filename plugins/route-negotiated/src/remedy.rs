//! What is done where fibres do not fit: nothing but to say why and what would, fewer markers, or thinner fibres.
//!
//! Whatever is said to fit was routed and keeps every limit.

use crate::attempt::{Routed, Task};
use crate::misfit::{Crowding, Misfit, Unfit, named};
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
    remedies.without = match *misfit {
        Misfit::Crowd(Crowding { without: Some(ref without), .. }) => Some(without.clone()),
        _ => dropped(task, params, job)?,
    };
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

/// Downwards in growing steps, since what is a little thinner often fits; once two have failed the least is tried, to know whether to
/// go on. Then halves what lies between what fits and what does not.
fn thinner(task: &Task, misfit: &Misfit, params: &Params, job: &mut Job) -> Result<Thinner, StageError> {
    const FIRST_STEP_MM: f64 = 0.06;
    const TOLD_APART_MM: f64 = 0.03;
    const BEFORE_THE_LEAST: u32 = 2;
    let least = params.least_diameter();
    if least > params.diameter() - TOLD_APART_MM || !task.has_places(&params.of_diameter(least))? {
        return Ok(Thinner::Pointless);
    }
    let (mut fails, mut step, mut failures) = (misfit.bound_mm(params), FIRST_STEP_MM, 0);
    let mut next = if fails < params.diameter() { fails } else { fails - step };
    let mut thinnest: Option<Routed> = None;
    let mut found = loop {
        let diameter = hundredths(next);
        if diameter <= least {
            match thinnest.take() {
                Some(routed) => break routed,
                None => return Ok(least_or_nothing(of_diameter(task, least, params, job)?, least)),
            }
        }
        if let Some(routed) = of_diameter(task, diameter, params, job)? {
            break routed;
        }
        (fails, failures) = (diameter, failures + 1);
        if failures == BEFORE_THE_LEAST {
            thinnest = of_diameter(task, least, params, job)?;
            if thinnest.is_none() {
                return Ok(Thinner::NotEven(least));
            }
        }
        next = fails - step;
        step *= 2.0;
    };
    while fails - found.params.diameter() > TOLD_APART_MM {
        let diameter = hundredths(0.5 * (fails + found.params.diameter()));
        match of_diameter(task, diameter, params, job)? {
            Some(routed) => found = routed,
            None => fails = diameter,
        }
    }
    Ok(Thinner::Found(Box::new(found)))
}

fn least_or_nothing(routed: Option<Routed>, least: f64) -> Thinner {
    routed.map_or(Thinner::NotEven(least), |routed| Thinner::Found(Box::new(routed)))
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
    job.log("info", "trying fewer markers");
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
