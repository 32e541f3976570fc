//! The parameters of the stage.

use fibar_plugin::StageError;

/// How the LEDs are laid out, and the size of their sockets.
#[derive(Clone, Debug, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Pattern of the places.
    pub layout: Layout,
    /// How many LEDs: the one in the centre and up to six around it.
    #[schemars(range(min = 1, max = 7))]
    pub count: u32,
    /// Distance between neighbouring LEDs, centre to centre.
    #[schemars(range(min = 1.0, max = 200.0), extend("unit" = "mm"))]
    pub pitch_mm: f64,
    /// Place of the centre LED in the base plane; left out, the place nearest the centroid of the base where every socket
    /// has its wall.
    #[schemars(extend("unit" = "mm"))]
    pub centre_mm: Option<[f64; 2]>,
    /// Turns the layout about +Z; at 0 the second LED lies towards +X of the first.
    #[schemars(range(min = -360.0, max = 360.0), extend("unit" = "deg"))]
    pub rotation_deg: f64,
    /// Diameter of the hole: a 5 mm package and 0.2 mm of play.
    #[schemars(range(min = 0.5, max = 50.0), extend("unit" = "mm"))]
    pub hole_diameter_mm: f64,
    /// From the base to the LED's tip: the length of a 5 mm package above its leads.
    #[schemars(range(min = 0.5, max = 100.0), extend("unit" = "mm"))]
    pub depth_mm: f64,
    /// Least material between a hole and the body's side, skin included.
    #[schemars(range(min = 0.0, max = 50.0), extend("unit" = "mm"))]
    pub wall_mm: f64,
    /// Straight leg of the fibres above the tip, which must lie inside the body too.
    #[schemars(range(min = 0.0, max = 50.0), extend("unit" = "mm"))]
    pub lead_mm: f64,
    /// How far from z = 0 a triangle of the base may reach.
    #[schemars(range(min = 0.0, max = 5.0), extend("unit" = "mm"))]
    pub flatness_mm: f64,
}

/// Pattern of the places.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize, serde::Serialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Layout {
    /// One in the centre, the others on the corners of a hexagon, counter-clockwise seen from above.
    Hexagon,
}

impl Default for Params {
    fn default() -> Params {
        Params {
            layout: Layout::Hexagon,
            count: 7,
            pitch_mm: 14.0,
            centre_mm: None,
            rotation_deg: 0.0,
            hole_diameter_mm: 5.2,
            depth_mm: 8.6,
            wall_mm: 1.0,
            lead_mm: 2.5,
            flatness_mm: 0.05,
        }
    }
}

impl Params {
    /// Least distance from an axis to the body's side, mm.
    pub fn needed_room_mm(&self) -> f64 {
        self.hole_diameter_mm / 2.0 + self.wall_mm
    }

    /// What the parameters demand of each other.
    pub fn check(&self) -> Result<(), StageError> {
        let needed = self.hole_diameter_mm + self.wall_mm;
        if self.count > 1 && self.pitch_mm < needed {
            let message = format!(
                "LEDs {} mm apart leave no {} mm wall between holes of {} mm",
                self.pitch_mm, self.wall_mm, self.hole_diameter_mm
            );
            let hint = format!("pitch_mm must be at least {needed} mm here");
            return Err(StageError::user(message).param("/pitch_mm").hint(hint));
        }
        Ok(())
    }
}
