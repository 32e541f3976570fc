//! The parameters of the stage.

use crate::regions::Region;
use fibar_core::code_set::CodePlan;

/// What is covered, and how long the search lasts. Explained in `docs/assign-covering.md`.
#[derive(Clone, Debug, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// How many of the sites become markers; left out, as many as the spacing leaves room for.
    #[schemars(range(min = 4, max = 10_000))]
    pub markers: Option<u32>,
    /// Least distance between two markers, straight; 0 leaves the spacing to the stage that found the sites.
    #[schemars(range(min = 0.0, max = 1000.0), extend("unit" = "mm"))]
    pub spacing_mm: f64,
    /// Parts of the object with a number of markers of their own: `{ name = "head", low_mm = [-50, -50, 60], at_least = 20, at_most = 25 }`.
    pub regions: Vec<Region>,
    /// Cameras stand at least this far above the horizon of the base.
    #[schemars(range(min = -90.0, max = 89.0), extend("unit" = "deg"))]
    pub lowest_view_deg: f64,
    /// Least distance of a camera from the middle of the body.
    #[schemars(range(min = 10.0, max = 100_000.0), extend("unit" = "mm"))]
    pub nearest_mm: f64,
    /// Greatest distance.
    #[schemars(range(min = 10.0, max = 100_000.0), extend("unit" = "mm"))]
    pub farthest_mm: f64,
    /// A marker is seen only within this angle of its normal.
    #[schemars(range(min = 1.0, max = 90.0), extend("unit" = "deg"))]
    pub emission_limit_deg: f64,
    /// How far off the surface rays start.
    #[schemars(range(min = 0.0001, max = 10.0), extend("unit" = "mm"))]
    pub lift_mm: f64,
    /// Cuts of each edge of the pentakis dodecahedron whose corners are the cameras that count markers.
    #[schemars(range(min = 1, max = 20))]
    pub survey_frequency: u32,
    /// The same for the directions each of which must be sure of an m-sequence marker.
    #[schemars(range(min = 1, max = 40))]
    pub watch_frequency: u32,
    /// Share of the markers that a camera may miss without losing their names.
    #[schemars(range(min = 0.0, max = 0.9), extend("unit" = "1"))]
    pub missing_share: f64,
    /// With `bounds`: from how far away every marker should be seen, once its LED's light is shared.
    #[schemars(range(min = 1.0, max = 100_000.0), extend("unit" = "mm"))]
    pub reach_mm: f64,
    /// With `bounds`: how much light weighs beside recognition; 0 leaves it out.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub light_weight: f64,
    /// With `courses`: how much it weighs beside light that fibres lose to those in their way.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub clash_weight: f64,
    /// Share of the directions that may be left without an m-sequence marker in sight; more is an error.
    #[schemars(range(min = 0.0, max = 1.0), extend("unit" = "1"))]
    pub max_blind_share: f64,
    /// Changes of places tried in each start.
    #[schemars(range(min = 0, max = 100_000_000))]
    pub place_moves: u32,
    /// Changes of codes tried in each start.
    #[schemars(range(min = 0, max = 100_000_000))]
    pub code_moves: u32,
    /// Searches from different random numbers; the best one counts.
    #[schemars(range(min = 1, max = 1000))]
    pub starts: u32,
    /// Sequences of neighbours' patterns that are stored for each marker, those that most views see first.
    #[schemars(range(min = 1, max = 100))]
    pub sequences: u32,
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
            markers: None,
            spacing_mm: 0.0,
            regions: Vec::new(),
            lowest_view_deg: 0.0,
            nearest_mm: 600.0,
            farthest_mm: 1400.0,
            emission_limit_deg: 60.0,
            lift_mm: 0.02,
            survey_frequency: 6,
            watch_frequency: 12,
            missing_share: 0.3,
            reach_mm: 1600.0,
            light_weight: 1.0,
            clash_weight: 1.0,
            max_blind_share: 0.0,
            place_moves: 40_000,
            code_moves: 4_000,
            starts: 4,
            sequences: 6,
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
