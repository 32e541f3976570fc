//! The parameters of the stage.

use fibar_core::code_set::CodePlan;

/// The objective of Tone 2020 and what its genetic algorithm leaves open; see `docs/assign-genetic.md`.
#[derive(Clone, Debug, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// `k1`: what a rightly named marker counts in a view, and a wrongly named one costs.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub k1: f64,
    /// `k2`: m-sequence markers that a view should have.
    #[schemars(range(min = 1, max = 100))]
    pub k2: u32,
    /// Iterations without gain after which the search ends.
    #[schemars(range(min = 1, max = 10_000_000))]
    pub stop_after: u32,
    /// Iterations after which it ends in any case; a guard, the paper has none.
    #[schemars(range(min = 1, max = 10_000_000))]
    pub most_iterations: u32,
    /// Chromosomes that are kept.
    #[schemars(range(min = 2, max = 10_000))]
    pub population: u32,
    /// New chromosomes in each iteration.
    #[schemars(range(min = 1, max = 10_000))]
    pub offspring: u32,
    /// Share of the offspring that take a region of the object from a second parent.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub crossover_share: f64,
    /// Chance of each gene to change in an offspring; one changes at least.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub mutation_rate: f64,
    /// Share of changes of a marker that drop it.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub drop_share: f64,
    /// Blinking speed.
    #[schemars(range(min = 1.0, max = 1_000_000.0), extend("unit" = "bit/s"))]
    pub bit_rate_hz: f64,
    /// Degree `m` of the m-sequence of `2^m − 1` bits.
    #[schemars(range(min = 3, max = 8))]
    pub degree: u32,
    /// Length `b` of the other codes, a divisor of `2^m − 1`.
    #[schemars(range(min = 1, max = 24))]
    pub companion_bits: u32,
    /// How many codes blink; left out, one for each LED.
    #[schemars(range(min = 1, max = 15))]
    pub codes: Option<u32>,
}

impl Default for Params {
    fn default() -> Params {
        Params {
            k1: 5.0,
            k2: 2,
            stop_after: 1000,
            most_iterations: 50_000,
            population: 12,
            offspring: 6,
            crossover_share: 0.2,
            mutation_rate: 0.002,
            drop_share: 0.1,
            bit_rate_hz: 350.0,
            degree: 4,
            companion_bits: 3,
            codes: None,
        }
    }
}

impl Params {
    /// What is said about the codes.
    pub fn code_plan(&self) -> CodePlan {
        CodePlan { degree: self.degree, companion_bits: self.companion_bits, codes: self.codes }
    }
}
