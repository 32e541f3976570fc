//! All fibres' reach together: statistics and the verdict.

use crate::attenuation::Attenuation;
use crate::law::MonotoneLaw;
use fibar_core::artefact::verdict::{Finding, Place, Verdict};
use fibar_core::light::{CALIBRATED_RADIUS_MM, CALIBRATION_ERROR_MM};
use fibar_core::{LedId, MarkerId};
use glam::DVec3;

/// One fibre's reach.
#[derive(Clone, Debug, PartialEq)]
pub struct Sight {
    /// Its number.
    pub fibre: u32,
    /// The LED that feeds it.
    pub led: LedId,
    /// The marker that it lights.
    pub marker: MarkerId,
    /// Where it ends, mm.
    pub end: DVec3,
    /// Reach by the monotone law, mm.
    pub d_cam_mm: f64,
    /// Reach by the law as printed, mm.
    pub printed_d_cam_mm: f64,
    /// What it loses on the way.
    pub attenuation: Attenuation,
}

/// All fibres, the weakest first; never empty.
pub struct Summary {
    /// The fibres by reach, then by number.
    pub sights: Vec<Sight>,
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

    /// Mean of a quantity over the fibres.
    pub fn mean(&self, quantity: impl Fn(&Sight) -> f64) -> f64 {
        self.sights.iter().map(quantity).sum::<f64>() / self.sights.len() as f64
    }

    /// Reach that a tenth of the fibres falls short of, mm, interpolated between neighbours in order.
    pub fn tenth_percentile_mm(&self) -> f64 {
        let position = 0.1 * (self.sights.len() - 1) as f64;
        let (below, share) = (position.floor() as usize, position.fract());
        let above = (below + 1).min(self.sights.len() - 1);
        self.sights[below].d_cam_mm * (1.0 - share) + self.sights[above].d_cam_mm * share
    }

    /// Share of all length that bends tighter than the calibration's prints.
    pub fn tight_share(&self) -> f64 {
        self.mean(|s| s.attenuation.tight_mm) / self.mean(|s| s.attenuation.length_mm)
    }

    /// How many fibres are seen from less than `bound_mm`.
    pub fn darker_than(&self, bound_mm: f64) -> usize {
        self.sights.iter().filter(|s| s.d_cam_mm < bound_mm).count()
    }

    /// The findings, every fibre a place.
    pub fn verdict(&self, law: &MonotoneLaw, bound_mm: f64) -> Verdict {
        let reach = Finding {
            rule: "light.reach".into(),
            holds: self.worst().d_cam_mm >= bound_mm,
            value: self.worst().d_cam_mm,
            unit: "mm".into(),
            bound: Some(bound_mm),
            message: self.reach_in_words(law),
            places: self.sights.iter().map(Sight::place).collect(),
        };
        let calibrated = Finding {
            rule: "light.calibrated".into(),
            holds: true,
            value: self.tight_share(),
            unit: "1".into(),
            bound: None,
            message: format!(
                "share of all length that bends tighter than the calibration's {CALIBRATED_RADIUS_MM} mm, where the law is extrapolated"
            ),
            places: Vec::new(),
        };
        Verdict::new("verify-light", vec![reach, calibrated])
    }

    fn reach_in_words(&self, law: &MonotoneLaw) -> String {
        let error =
            self.sights.iter().map(|s| 0.5 * s.d_cam_mm * s.attenuation.monotone.error).fold(0.0, f64::max);
        format!(
            "mean {:.1} mm, a tenth below {:.1} mm, the weakest {:.1} mm; by the law as printed the mean is {:.1} mm. Monotone \
             law with r* = {:.3} mm; quadrature off by less than {:.0e} mm, the law itself by {CALIBRATION_ERROR_MM} mm \
             (standard error of its calibration)",
            self.mean(|s| s.d_cam_mm),
            self.tenth_percentile_mm(),
            self.worst().d_cam_mm,
            self.mean(|s| s.printed_d_cam_mm),
            law.peak_radius_mm,
            error.max(1e-9),
        )
    }
}

impl Sight {
    fn place(&self) -> Place {
        let Attenuation { length_mm, tight_mm, .. } = self.attenuation;
        let what = format!(
            "fibre {}: LED {} to marker {}, {length_mm:.1} mm long, {tight_mm:.1} mm of it bent below \
             {CALIBRATED_RADIUS_MM} mm; {:.1} mm by the law as printed",
            self.fibre, self.led, self.marker, self.printed_d_cam_mm
        );
        Place { position: self.end, value: self.d_cam_mm, what }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sight(fibre: u32, d_cam_mm: f64) -> Sight {
        Sight {
            fibre,
            led: LedId(0),
            marker: MarkerId(fibre),
            end: DVec3::ZERO,
            d_cam_mm,
            printed_d_cam_mm: d_cam_mm,
            attenuation: Attenuation::default(),
        }
    }

    #[test]
    fn percentiles_are_interpolated() {
        let check = |reaches: &[f64], expected: f64| {
            let sights = reaches.iter().enumerate().map(|(k, d)| sight(k as u32, *d)).collect();
            assert!((Summary::of(sights).tenth_percentile_mm() - expected).abs() < 1e-9, "{reaches:?}");
        };
        check(&[700.0], 700.0);
        check(&[300.0, 100.0], 120.0);
        check(&[0.0, 100.0, 200.0, 300.0, 400.0, 500.0, 600.0, 700.0, 800.0, 900.0, 1000.0], 100.0);
    }
}
