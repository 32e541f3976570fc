//! Parameters of the stage: the paper's constants, and what the paper leaves open.

use fibar_core::light::LightLaw;
use fibar_core::material::LayerRadii;
use fibar_plugin::StageError;

/// Parameters of `route-fibar`; `docs/route-fibar.md` says which are the paper's and why the others are as they are.
#[derive(Clone, Debug, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Length of the fixed straight piece at the LED and at the marker.
    #[schemars(range(min = 0.1, max = 50.0), extend("unit" = "mm"))]
    pub end_piece_mm: f64,
    /// A marker further than this from the surface is refused.
    #[schemars(range(min = 0.0, max = 10.0), extend("unit" = "mm"))]
    pub marker_tolerance_mm: f64,

    /// Rounds of the initial routing; each puts a control point between any two but the end pairs.
    #[schemars(range(min = 1, max = 8))]
    pub rounds: u32,
    /// Moves of every control point in a round.
    #[schemars(range(min = 0, max = 100000))]
    pub moves: u32,
    /// Share of the length move l that is carried out; 0.5 and more oscillates.
    #[schemars(range(min = 0.0, max = 0.5))]
    pub length_gain: f64,
    /// Share of the curvature move r that is carried out.
    #[schemars(range(min = 0.0, max = 0.5))]
    pub bend_gain: f64,
    /// Step of the collision move f for every control point that is too close.
    #[schemars(range(min = 0.0, max = 10.0), extend("unit" = "mm"))]
    pub fibre_step_mm: f64,
    /// Control points of other patterns closer than this are moved away from.
    #[schemars(range(min = 0.0, max = 50.0), extend("unit" = "mm"))]
    pub fibre_threshold_mm: f64,
    /// Step of the surface move s.
    #[schemars(range(min = 0.0, max = 10.0), extend("unit" = "mm"))]
    pub surface_step_mm: f64,
    /// A surface closer than this is moved away from.
    #[schemars(range(min = 0.0, max = 50.0), extend("unit" = "mm"))]
    pub surface_threshold_mm: f64,
    /// Longest single move of a control point.
    #[schemars(range(min = 0.001, max = 50.0), extend("unit" = "mm"))]
    pub longest_move_mm: f64,
    /// Control points are put back to at least this depth below the surface.
    #[schemars(range(min = 0.0, max = 50.0), extend("unit" = "mm"))]
    pub least_depth_mm: f64,

    /// Weight of E_fib, the nearness of other patterns' fibres.
    #[schemars(range(min = 0.0))]
    pub k3: f64,
    /// Weight of E_surf, the nearness of the surface.
    #[schemars(range(min = 0.0))]
    pub k4: f64,
    /// Weight of E_reg, the unevenness of the control points' distances.
    #[schemars(range(min = 0.0), extend("unit" = "1/mm"))]
    pub k5: f64,
    /// Decay of E_fib with distance.
    #[schemars(range(min = 0.05, max = 50.0), extend("unit" = "1/mm"))]
    pub k6: f64,
    /// Decay of E_surf with distance.
    #[schemars(range(min = 0.05, max = 50.0), extend("unit" = "1/mm"))]
    pub k7: f64,
    /// Exponentials of E_fib and E_surf below this are left out.
    #[schemars(range(min = 1e-12, max = 0.1))]
    pub cut_off: f64,
    /// Surface points per area in E_surf.
    #[schemars(range(min = 0.0, max = 1000.0), extend("unit" = "1/mm2"))]
    pub surface_points_per_mm2: f64,
    /// Unevenness below this counts by its square, so that Adam does not jump to and fro across the crease of E_reg; 0 is
    /// the term as printed.
    #[schemars(range(min = 0.0, max = 10.0), extend("unit" = "mm"))]
    pub even_within_mm: f64,
    /// Whether E_reg compares the fixed end pieces with the legs next to them, too; short fibres then zigzag until their
    /// legs are as long as the end pieces.
    pub even_out_ends: bool,

    /// Most iterations of Adam.
    #[schemars(range(min = 0, max = 1000000))]
    pub iterations: u32,
    /// Adam's learning rate at the start: about the longest step.
    #[schemars(range(min = 1e-6, max = 10.0), extend("unit" = "mm"))]
    pub learning_rate_mm: f64,
    /// Adam stops after this many iterations without a gain of `least_gain`.
    #[schemars(range(min = 1))]
    pub patience: u32,
    /// Smallest relative gain of the objective that counts.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub least_gain: f64,

    /// Distance between samples of the distance and wall fields.
    #[schemars(range(min = 0.1, max = 10.0), extend("unit" = "mm"))]
    pub grid_mm: f64,

    /// Absorption of a straight fibre, c1.
    #[schemars(range(min = 0.0), extend("unit" = "1/mm"))]
    pub c1_per_mm: f64,
    /// Further absorption of the tightest bend, c2.
    #[schemars(range(min = 0.0), extend("unit" = "1/mm"))]
    pub c2_per_mm: f64,
    /// Decay of the bend's absorption with its radius, c3.
    #[schemars(range(min = 0.0), extend("unit" = "1/mm"))]
    pub c3_per_mm: f64,
    /// Distance from which the camera would see a lossless fibre, c5.
    #[schemars(range(min = 0.0), extend("unit" = "mm"))]
    pub c5_mm: f64,

    /// Radius of the core.
    #[schemars(range(min = 0.01), extend("unit" = "mm"))]
    pub core_radius_mm: f64,
    /// Radius of the cladding.
    #[schemars(range(min = 0.01), extend("unit" = "mm"))]
    pub cladding_radius_mm: f64,
    /// Radius of the black layer.
    #[schemars(range(min = 0.01), extend("unit" = "mm"))]
    pub black_radius_mm: f64,
}

impl Default for Params {
    fn default() -> Params {
        let light = LightLaw::TONE_2020;
        let radii = LayerRadii::TONE_2020;
        Params {
            end_piece_mm: 2.5,
            marker_tolerance_mm: 0.5,
            rounds: 5,
            moves: 1000,
            length_gain: 0.45,
            bend_gain: 0.015,
            fibre_step_mm: 0.01,
            fibre_threshold_mm: 4.2,
            surface_step_mm: 0.02,
            surface_threshold_mm: 3.0,
            longest_move_mm: 0.5,
            least_depth_mm: 1.0,
            k3: 1.5,
            k4: 0.5,
            k5: 1.0,
            k6: 1.5,
            k7: 1.5,
            cut_off: 1e-5,
            surface_points_per_mm2: 0.8,
            even_within_mm: 0.1,
            even_out_ends: false,
            iterations: 3000,
            learning_rate_mm: 0.01,
            patience: 300,
            least_gain: 1e-4,
            grid_mm: 1.5,
            c1_per_mm: light.c1_per_mm,
            c2_per_mm: light.c2_per_mm,
            c3_per_mm: light.c3_per_mm,
            c5_mm: light.c5_mm,
            core_radius_mm: radii.core,
            cladding_radius_mm: radii.cladding,
            black_radius_mm: radii.black,
        }
    }
}

impl Params {
    /// What the ranges of single parameters cannot say.
    pub fn check(&self) -> Result<(), StageError> {
        let LayerRadii { core, cladding, black } = self.radii();
        if core < cladding && cladding < black {
            return Ok(());
        }
        let radii = format!("core {core}, cladding {cladding}, black {black} mm");
        Err(StageError::user(format!("the layers' radii must grow outwards: {radii}"))
            .hint("each layer is 0.5 mm or more outside the one before")
            .param(if core < cladding { "/black_radius_mm" } else { "/cladding_radius_mm" }))
    }

    /// The law of light.
    pub fn light(&self) -> LightLaw {
        let Params { c1_per_mm, c2_per_mm, c3_per_mm, c5_mm, .. } = *self;
        LightLaw { c1_per_mm, c2_per_mm, c3_per_mm, c5_mm }
    }

    /// Radii of the layers.
    pub fn radii(&self) -> LayerRadii {
        LayerRadii {
            core: self.core_radius_mm,
            cladding: self.cladding_radius_mm,
            black: self.black_radius_mm,
        }
    }
}
