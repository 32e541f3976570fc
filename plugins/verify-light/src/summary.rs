//! All fibres' reach together: statistics and the verdict.

use crate::law::MonotoneLaw;
use crate::params::Params;
use crate::sight::Sight;
use fibar_core::artefact::verdict::{Finding, Verdict};
use fibar_core::light::CALIBRATED_RADIUS_MM;

/// A marker seen from this far away counts as well lit, mm.
const WELL_LIT_MM: f64 = 700.0;
/// Standard errors to either side that hold 95 %.
const CONFIDENCE_95: f64 = 1.96;

/// All fibres, the weakest first; never empty.
pub struct Summary {
    /// The fibres by reach, then by number.
    pub sights: Vec<Sight>,
}

/// From how far away cameras see enough markers.
#[derive(Clone, Debug, PartialEq)]
pub struct Range {
    /// With the light that fibres share, mm.
    pub coupled_mm: f64,
    /// The same for half of the views, mm.
    pub half_mm: f64,
    /// Were every fibre its LED's only one, mm.
    pub uncoupled_mm: f64,
    /// Share of the views that see enough, by distance in mm.
    pub shares: Vec<(f64, f64)>,
}

impl Summary {
    /// Sorts the fibres.
    pub fn of(mut sights: Vec<Sight>) -> Summary {
        sights.sort_by(|a, b| a.d_cam_mm.total_cmp(&b.d_cam_mm).then(a.fibre.cmp(&b.fibre)));
        Summary { sights }
    }

    /// The weakest fibre.
    pub fn worst(&self) -> &Sight {
        &self.sights[0]
    }

    /// The fibre that is weakest with the light it shares.
    pub fn worst_coupled(&self) -> &Sight {
        let by_reach = |a: &&Sight, b: &&Sight| a.coupled_d_cam_mm().total_cmp(&b.coupled_d_cam_mm());
        self.sights.iter().min_by(by_reach).unwrap_or(&self.sights[0])
    }

    /// Mean of a quantity over the fibres.
    pub fn mean(&self, quantity: impl Fn(&Sight) -> f64) -> f64 {
        self.sights.iter().map(quantity).sum::<f64>() / self.sights.len() as f64
    }

    /// Mean of a quantity over the fibres that have it; none if none has.
    pub fn mean_known(&self, quantity: impl Fn(&Sight) -> Option<f64>) -> Option<f64> {
        let known: Vec<f64> = self.sights.iter().filter_map(quantity).collect();
        (!known.is_empty()).then(|| known.iter().sum::<f64>() / known.len() as f64)
    }

    /// Value that a tenth of the fibres falls short of, interpolated between neighbours in order.
    pub fn tenth_percentile(&self, quantity: impl Fn(&Sight) -> f64) -> f64 {
        let mut values: Vec<f64> = self.sights.iter().map(quantity).collect();
        values.sort_by(f64::total_cmp);
        let position = 0.1 * (values.len() - 1) as f64;
        let (below, share) = (position.floor() as usize, position.fract());
        let above = (below + 1).min(values.len() - 1);
        values[below] * (1.0 - share) + values[above] * share
    }

    /// Share of all length that bends tighter than the calibration's prints.
    pub fn tight_share(&self) -> f64 {
        self.mean(|s| s.attenuation.tight_mm) / self.mean(|s| s.attenuation.length_mm)
    }

    /// Share of the fibres whose quantity is at least 700 mm.
    pub fn well_lit_share(&self, quantity: impl Fn(&Sight) -> f64) -> f64 {
        self.mean(|s| if quantity(s) >= WELL_LIT_MM { 1.0 } else { 0.0 })
    }

    /// How many fibres are seen from less than `bound_mm`.
    pub fn darker_than(&self, bound_mm: f64) -> usize {
        self.sights.iter().filter(|s| s.d_cam_mm < bound_mm).count()
    }

    /// Half the width of the 95 % interval of the mean d_cam, mm, if fibres err independently as the calibration's did.
    pub fn mean_uncertainty_mm(&self, params: &Params) -> f64 {
        CONFIDENCE_95 * params.standard_error_mm / (self.sights.len() as f64).sqrt()
    }

    /// The findings, every fibre a place of the first.
    pub fn verdict(&self, law: &MonotoneLaw, params: &Params, range: Option<&Range>) -> Verdict {
        let mut findings =
            vec![self.reach(law, params), self.calibrated(), self.coupled(params), self.certified()];
        findings.extend(range.map(Range::finding));
        Verdict::new("verify-light", findings)
    }

    fn reach(&self, law: &MonotoneLaw, params: &Params) -> Finding {
        let error =
            self.sights.iter().map(|s| 0.5 * s.d_cam_mm * s.attenuation.monotone.error).fold(0.0, f64::max);
        let message = format!(
            "mean {:.1} ± {:.1} mm, a tenth below {:.1} mm, the weakest {:.1} mm; by the law as printed the mean is {:.1} mm. \
             Monotone law with r* = {:.3} mm; quadrature off by less than {:.0e} mm. The calibration's standard error is {} mm \
             a fibre, from which the ± (95 %, fibres erring independently)",
            self.mean(|s| s.d_cam_mm),
            self.mean_uncertainty_mm(params),
            self.tenth_percentile(|s| s.d_cam_mm),
            self.worst().d_cam_mm,
            self.mean(|s| s.printed_d_cam_mm),
            law.peak_radius_mm,
            error.max(1e-9),
            params.standard_error_mm,
        );
        let places = self.sights.iter().map(Sight::place).collect();
        let holds = self.worst().d_cam_mm >= params.min_d_cam_mm;
        let bound = Some(params.min_d_cam_mm);
        Finding { holds, bound, places, ..finding("light.reach", self.worst().d_cam_mm, "mm", message) }
    }

    fn calibrated(&self) -> Finding {
        let message = format!(
            "share of all length that bends tighter than the calibration's {CALIBRATED_RADIUS_MM} mm, where the law is extrapolated"
        );
        finding("light.calibrated", self.tight_share(), "1", message)
    }

    fn coupled(&self, params: &Params) -> Finding {
        let mean = self.mean(Sight::coupled_d_cam_mm);
        let message = format!(
            "mean with the LEDs' light shared among their fibres, by a beam of ± {}° at half intensity from a dome of {} mm \
             radius; a fibre has {:.3} of a lone one's light on average, and {:.3} at least",
            params.half_angle_deg,
            params.dome_radius_mm,
            self.mean(|s| s.coupling),
            self.sights.iter().map(|s| s.coupling).fold(f64::INFINITY, f64::min),
        );
        finding("light.coupling", mean, "mm", message)
    }

    /// A fibre beyond what is certified to be possible says that the bound or the light is wrong.
    fn certified(&self) -> Finding {
        const ROUNDING: f64 = 1e-6;
        let known = self.sights.iter().filter_map(|s| Some((s, s.certified_share()?)));
        let mut shares: Vec<(&Sight, f64)> = known.collect();
        shares.sort_by(|a, b| b.1.total_cmp(&a.1));
        let greatest = shares.first().map_or(0.0, |(_, share)| *share);
        let beyond = shares.iter().filter(|(_, share)| *share > 1.0 + ROUNDING);
        let message = format!(
            "greatest share of a certified bound, over {} of {} fibres whose bounds are known; {} beyond their bound",
            shares.len(),
            self.sights.len(),
            beyond.clone().count()
        );
        let places = beyond.map(|(sight, _)| sight.place()).collect();
        let holds = greatest <= 1.0 + ROUNDING;
        Finding { holds, bound: Some(1.0), places, ..finding("light.certified", greatest, "1", message) }
    }
}

impl Range {
    fn finding(&self) -> Finding {
        let shares: Vec<String> =
            self.shares.iter().map(|(d, share)| format!("{:.1} % at {d} mm", 100.0 * share)).collect();
        let message = format!(
            "largest distance at which 99 % of held-out views see at least six markers that are not in one plane; {:.0} mm for half \
             of the views, {:.0} mm for 99 % were every fibre its LED's only one. Views that see them: {}",
            self.half_mm,
            self.uncoupled_mm,
            shares.join(", ")
        );
        finding("light.range", self.coupled_mm, "mm", message)
    }
}

fn finding(rule: &str, value: f64, unit: &str, message: String) -> Finding {
    let (rule, unit) = (rule.into(), unit.into());
    Finding { rule, holds: true, value, unit, bound: None, message, places: Vec::new() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::attenuation::Attenuation;
    use crate::sight::Pair;
    use fibar_core::light::LightLaw;
    use fibar_core::{LedId, MarkerId};
    use glam::DVec3;

    fn sight(fibre: u32, d_cam_mm: f64) -> Sight {
        Sight {
            fibre,
            led: LedId(0),
            marker: MarkerId(fibre),
            end: DVec3::ZERO,
            d_cam_mm,
            printed_d_cam_mm: d_cam_mm,
            coupling: 0.25,
            pair: None,
            attenuation: Attenuation::default(),
        }
    }

    fn summary(reaches: &[f64]) -> Summary {
        Summary::of(reaches.iter().zip(1..).map(|(d, k)| sight(k, *d)).collect())
    }

    #[test]
    fn percentiles_are_interpolated() {
        let check = |reaches: &[f64], expected: f64| {
            let found = summary(reaches).tenth_percentile(|s| s.d_cam_mm);
            assert!((found - expected).abs() < 1e-9, "{reaches:?}");
        };
        check(&[700.0], 700.0);
        check(&[300.0, 100.0], 120.0);
        check(&[0.0, 100.0, 200.0, 300.0, 400.0, 500.0, 600.0, 700.0, 800.0, 900.0, 1000.0], 100.0);
    }

    #[test]
    fn shares_count_what_they_say() {
        let mut all = summary(&[600.0, 700.0, 1400.0]);
        assert!((all.well_lit_share(|s| s.d_cam_mm) - 2.0 / 3.0).abs() < 1e-12);
        assert!((all.well_lit_share(Sight::coupled_d_cam_mm) - 1.0 / 3.0).abs() < 1e-12);
        assert_eq!(all.mean_known(Sight::bound_share), None);
        all.sights[0].pair = Some(Pair { certified_mm: 1000.0, best_mm: 800.0 });
        all.sights[1].pair = Some(Pair { certified_mm: 1000.0, best_mm: 0.0 });
        assert_eq!(all.mean_known(Sight::bound_share), Some(0.75));
        assert_eq!(all.mean_known(Sight::certified_share), Some((0.6 + 0.7) / 2.0));
    }

    #[test]
    fn more_than_is_possible_breaks_a_rule() {
        let mut all = summary(&[600.0, 700.0]);
        let (law, params) = (MonotoneLaw::of(LightLaw::TONE_2020), Params::default());
        let certified = |all: &Summary| all.verdict(&law, &params, None).findings[3].clone();
        assert!(certified(&all).holds);
        all.sights[1].pair = Some(Pair { certified_mm: 699.0, best_mm: 690.0 });
        let found = certified(&all);
        assert!(
            !found.holds && found.places.len() == 1 && found.places[0].what.contains("fibre 2"),
            "{found:?}"
        );
        // A pair that was certified to be hopeless has light.
        all.sights[1].pair = Some(Pair { certified_mm: 0.0, best_mm: 0.0 });
        assert!(!certified(&all).holds);
    }
}
