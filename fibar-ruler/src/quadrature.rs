//! Adaptive integration over an interval, with an estimate of its own error.

/// An integral and how far it may be off.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimate {
    /// The integral.
    pub value: f64,
    /// Sum of the differences between the 7-point Gauss and 15-point Kronrod rules over the final panels.
    pub error: f64,
}

impl std::ops::Add for Estimate {
    type Output = Estimate;
    fn add(self, other: Estimate) -> Estimate {
        Estimate { value: self.value + other.value, error: self.error + other.error }
    }
}

/// Nodes of the 15-point Kronrod rule on −1..=1, the non-negative half (QUADPACK, `qk15`).
const NODES: [f64; 8] = [
    0.991_455_371_120_812_6,
    0.949_107_912_342_758_5,
    0.864_864_423_359_769_1,
    0.741_531_185_599_394_4,
    0.586_087_235_467_691_1,
    0.405_845_151_377_397_2,
    0.207_784_955_007_898_47,
    0.0,
];
const KRONROD: [f64; 8] = [
    0.022_935_322_010_529_224,
    0.063_092_092_629_978_55,
    0.104_790_010_322_250_18,
    0.140_653_259_715_525_92,
    0.169_004_726_639_267_9,
    0.190_350_578_064_785_4,
    0.204_432_940_075_298_9,
    0.209_482_141_084_727_82,
];
/// Weights of the 7-point Gauss rule, which uses every second node.
const GAUSS: [f64; 4] =
    [0.129_484_966_168_869_7, 0.279_705_391_489_276_64, 0.381_830_050_505_118_9, 0.417_959_183_673_469_4];

/// Integrates over 0..=1, halving until the estimated error of the whole is about `tolerance`.
pub fn integrate(tolerance: f64, f: &impl Fn(f64) -> f64) -> Estimate {
    const DEEPEST: u32 = 40;
    panel(f, 0.0, 1.0, tolerance, DEEPEST)
}

fn panel(f: &impl Fn(f64) -> f64, from: f64, to: f64, tolerance: f64, depth: u32) -> Estimate {
    let whole = kronrod(f, from, to);
    if whole.error <= tolerance || depth == 0 {
        return whole;
    }
    let middle = 0.5 * (from + to);
    panel(f, from, middle, tolerance / 2.0, depth - 1) + panel(f, middle, to, tolerance / 2.0, depth - 1)
}

fn kronrod(f: &impl Fn(f64) -> f64, from: f64, to: f64) -> Estimate {
    let (centre, half) = (0.5 * (from + to), 0.5 * (to - from));
    let middle = f(centre);
    let (mut fine, mut coarse) = (KRONROD[7] * middle, GAUSS[3] * middle);
    for k in 0..7 {
        let pair = f(centre - half * NODES[k]) + f(centre + half * NODES[k]);
        fine += KRONROD[k] * pair;
        if k % 2 == 1 {
            coarse += GAUSS[k / 2] * pair;
        }
    }
    Estimate { value: fine * half, error: ((fine - coarse) * half).abs() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(expected: f64, f: impl Fn(f64) -> f64) {
        let found = integrate(1e-10, &f);
        assert!((found.value - expected).abs() < 1e-10, "{found:?} is not {expected}");
        assert!(found.error <= 1e-10);
    }

    #[test]
    fn known_integrals() {
        check(1.0, |_| 1.0);
        check(1.0 / 21.0, |t| t.powi(20));
        check(libm::exp(1.0) - 1.0, libm::exp);
        check(2.0 / 3.0, f64::sqrt);
        check(libm::atan(1e4) / 1e2, |t| 1e2 / (1.0 + 1e8 * t * t));
    }
}
