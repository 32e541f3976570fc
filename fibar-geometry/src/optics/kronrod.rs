//! Adaptive Gauss–Kronrod quadrature (Kronrod 1965; nodes and weights as in QUADPACK's `qk15`).

/// An integral and its estimated error.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Estimate {
    pub value: f64,
    pub error: f64,
}

impl Estimate {
    /// Both added up.
    pub fn plus(self, other: Estimate) -> Estimate {
        Estimate { value: self.value + other.value, error: self.error + other.error }
    }
}

/// Halvings after which an interval is taken as it is, its error stated: a millionth of the whole.
const DEEPEST: u32 = 20;

/// Integrates `f` over an interval, halving it until the estimated error is below the tolerance.
pub(super) fn integrate(f: &impl Fn(f64) -> f64, interval: (f64, f64), tolerance: f64) -> Estimate {
    refine(f, interval, tolerance, DEEPEST)
}

fn refine(f: &impl Fn(f64) -> f64, (a, b): (f64, f64), tolerance: f64, depth: u32) -> Estimate {
    let whole = kronrod_15(f, a, b);
    if whole.error <= tolerance || depth == 0 {
        return whole;
    }
    let middle = 0.5 * (a + b);
    let left = refine(f, (a, middle), 0.5 * tolerance, depth - 1);
    left.plus(refine(f, (middle, b), 0.5 * tolerance, depth - 1))
}

/// Positive nodes, their Kronrod weights and, for every second one, their Gauss weights.
const NODES: [(f64, f64, f64); 7] = [
    (0.991_455_371_120_812_6, 0.022_935_322_010_529_22, 0.0),
    (0.949_107_912_342_758_5, 0.063_092_092_629_978_55, 0.129_484_966_168_869_7),
    (0.864_864_423_359_769_1, 0.104_790_010_322_250_18, 0.0),
    (0.741_531_185_599_394_4, 0.140_653_259_715_525_92, 0.279_705_391_489_276_67),
    (0.586_087_235_467_691_1, 0.169_004_726_639_267_9, 0.0),
    (0.405_845_151_377_397_2, 0.190_350_578_064_785_4, 0.381_830_050_505_118_9),
    (0.207_784_955_007_898_47, 0.204_432_940_075_298_9, 0.0),
];
const CENTRE: (f64, f64) = (0.209_482_141_084_727_83, 0.417_959_183_673_469_4);

/// The 15-point value; the error is its difference from the 7-point Gauss value, which overstates it for smooth `f`.
fn kronrod_15(f: &impl Fn(f64) -> f64, a: f64, b: f64) -> Estimate {
    let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
    let centre = f(middle);
    let (mut kronrod, mut gauss) = (CENTRE.0 * centre, CENTRE.1 * centre);
    for (node, kronrod_weight, gauss_weight) in NODES {
        let pair = f(middle - half * node) + f(middle + half * node);
        kronrod += kronrod_weight * pair;
        gauss += gauss_weight * pair;
    }
    Estimate { value: half * kronrod, error: half * (kronrod - gauss).abs() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(f: impl Fn(f64) -> f64, interval: (f64, f64), exact: f64) {
        let estimate = integrate(&f, interval, 1e-10);
        assert!(estimate.error <= 1e-10, "{estimate:?}");
        assert!((estimate.value - exact).abs() <= 1e-10, "{estimate:?} is not {exact}");
    }

    #[test]
    fn closed_forms_come_out() {
        check(|_| 1.0, (-1.0, 1.0), 2.0);
        check(|x| x.powi(13), (0.0, 1.0), 1.0 / 14.0);
        check(|x| (-x * x).exp(), (-9.0, 9.0), std::f64::consts::PI.sqrt());
        check(|x| (x - 0.3).abs(), (0.0, 1.0), 0.29); // a crease off the nodes
        check(|x| 1e-3 / (x * x + 1e-6), (-1.0, 1.0), 2.0 * 1e3f64.atan()); // a spike a thousandth wide
    }

    #[test]
    fn what_cannot_be_resolved_says_so() {
        let step = integrate(&|x| if x < 0.3 { 0.0 } else { 1.0 }, (0.0, 1.0), 1e-12);
        assert!(step.error > 1e-12 && (step.value - 0.7).abs() < 1e-5, "{step:?}");
    }
}
