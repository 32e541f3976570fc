//! The monotone law: absorption by curvature, continued so that tightening a bend past its dearest radius never pays.
//!
//! Tone 2020 fits `a(r) = c1 + c2·exp(−c3·r)` per mm of fibre. The loss of a bend per radian is `r·a(r)`, which peaks at
//! `r*` (11.35 mm with the paper's constants) and falls to 0 as r → 0: a kink would be free. So below `r*` we take
//! `a(r) = r*·a(r*)/r`: every radian costs there what it costs at the peak. In terms of the curvature κ = 1/r the
//! continuation is continuous and so is its slope.

use fibar_core::light::LightLaw;

/// The law with its continuation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MonotoneLaw {
    law: LightLaw,
    /// `r*`, mm; 0 if the printed law needs no continuation.
    pub peak_radius_mm: f64,
    /// `r*·a(r*)`: what a radian of anything tighter costs.
    pub loss_per_radian: f64,
}

impl MonotoneLaw {
    /// Finds the peak of `r·a(r)`: its derivative `c1 + c2·exp(−c3·r)·(1 − c3·r)` falls until `r = 2/c3`.
    pub fn of(law: LightLaw) -> MonotoneLaw {
        let slope = |r: f64| {
            law.c1_per_mm + law.c2_per_mm * libm::exp(-law.c3_per_mm * r) * (1.0 - law.c3_per_mm * r)
        };
        let (mut low, mut high) = (0.0, 2.0 / law.c3_per_mm);
        if slope(high) >= 0.0 {
            return MonotoneLaw { law, peak_radius_mm: 0.0, loss_per_radian: 0.0 };
        }
        for _ in 0..80 {
            let middle = 0.5 * (low + high);
            if slope(middle) > 0.0 { low = middle } else { high = middle }
        }
        let loss_per_radian = low * absorption(&law, 1.0 / low);
        MonotoneLaw { law, peak_radius_mm: low, loss_per_radian }
    }

    /// Absorption at a curvature (1/mm), per mm.
    pub fn monotone(&self, curvature: f64) -> f64 {
        if curvature * self.peak_radius_mm > 1.0 {
            self.loss_per_radian * curvature
        } else {
            absorption(&self.law, curvature)
        }
    }

    /// Absorption at a curvature (1/mm) by the law as printed, per mm.
    pub fn printed(&self, curvature: f64) -> f64 {
        absorption(&self.law, curvature)
    }

    /// `d_cam = c5·exp(−½∫a ds)` (Tone 2020, eq. for `d_cam`), mm.
    pub fn detection_distance(&self, integral: f64) -> f64 {
        self.law.c5_mm * libm::exp(-0.5 * integral)
    }
}

fn absorption(law: &LightLaw, curvature: f64) -> f64 {
    law.c1_per_mm + law.c2_per_mm * libm::exp(-law.c3_per_mm / curvature)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn law() -> MonotoneLaw {
        MonotoneLaw::of(LightLaw::TONE_2020)
    }

    #[test]
    fn the_peak_is_where_the_paper_s_constants_put_it() {
        assert!((law().peak_radius_mm - 11.35).abs() < 0.01, "{:?}", law());
        assert!((law().loss_per_radian - 3.11).abs() < 0.005, "{:?}", law());
    }

    #[test]
    fn tightening_never_pays() {
        let law = law();
        let loss = |r: f64| r * law.monotone(1.0 / r);
        let losses: Vec<f64> = (1..=500).map(|k| loss(0.1 * f64::from(k))).collect();
        assert!(losses.windows(2).all(|pair| pair[1] <= pair[0] + 1e-12));
        assert_eq!(law.monotone(0.0), LightLaw::TONE_2020.c1_per_mm);
    }

    #[test]
    fn a_law_without_a_peak_stays_as_printed() {
        let plain = LightLaw { c2_per_mm: 0.01, ..LightLaw::TONE_2020 };
        let law = MonotoneLaw::of(plain);
        assert_eq!(law.peak_radius_mm, 0.0);
        assert_eq!(law.monotone(5.0), law.printed(5.0));
    }
}
