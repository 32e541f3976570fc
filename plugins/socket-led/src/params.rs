//! The parameters of the stage.

use crate::cavity::CavityParams;
use fibar_plugin::StageError;

/// How the LEDs are laid out, and the size of their sockets.
#[derive(Clone, Debug, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Pattern of the places.
    pub layout: Layout,
    /// How many LEDs; `hexagon` takes up to seven, `free` as many as it has places.
    #[schemars(range(min = 1, max = 64))]
    pub count: u32,
    /// Places of the LEDs when `layout` is `free`: on the base in the body's x and y, on another face along its own u and v.
    #[schemars(extend("unit" = "mm"))]
    pub places_mm: Vec<[f64; 2]>,
    /// Outward direction of the flat face that takes the LEDs; left out, the base at z = 0. Of several such faces the largest.
    pub face_normal: Option<[f64; 3]>,
    /// Of several faces that look along `face_normal`, the one whose middle is nearest to this place.
    #[schemars(extend("unit" = "mm"))]
    pub face_near_mm: Option<[f64; 3]>,
    /// How far off `face_normal` the face may look.
    #[schemars(range(min = 0.0, max = 45.0), extend("unit" = "deg"))]
    pub face_tilt_deg: f64,
    /// Distance between neighbouring LEDs, centre to centre.
    #[schemars(range(min = 1.0, max = 200.0), extend("unit" = "mm"))]
    pub pitch_mm: f64,
    /// Place of the layout's centre in the base plane (in u and v on another face); left out, the place nearest the centroid
    /// of the face where every socket has its wall, and 0, 0 when `layout` is `free`.
    #[schemars(extend("unit" = "mm"))]
    pub centre_mm: Option<[f64; 2]>,
    /// Turns the layout counter-clockwise seen from inside (about +Z on the base); at 0 the second LED of a hexagon lies
    /// towards +X of the first.
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
    /// How far from its plane a triangle of the base or face may reach.
    #[schemars(range(min = 0.0, max = 5.0), extend("unit" = "mm"))]
    pub flatness_mm: f64,
    /// Compartments beside the LEDs, `{ name = "board", centre_mm = [25, 0], size_mm = [20, 30], depth_mm = 6 }` say; fibres keep
    /// away from them as from holes.
    pub cavities: Vec<CavityParams>,
}

/// Pattern of the places.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize, serde::Serialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Layout {
    /// One in the centre, the others on the corners of a hexagon, counter-clockwise seen from above.
    Hexagon,
    /// Evenly round a circle, neighbours `pitch_mm` apart, none in the centre.
    Ring,
    /// A square grid, `pitch_mm` apart, the middle ones first.
    Grid,
    /// At `places_mm`.
    Free,
    /// Where they bring most light to this object's surface, `pitch_mm` apart or more.
    Best,
}

impl Default for Params {
    fn default() -> Params {
        Params {
            layout: Layout::Hexagon,
            count: 7,
            places_mm: Vec::new(),
            face_normal: None,
            face_near_mm: None,
            face_tilt_deg: 1.0,
            pitch_mm: 14.0,
            centre_mm: None,
            rotation_deg: 0.0,
            hole_diameter_mm: 5.2,
            depth_mm: 8.6,
            wall_mm: 1.0,
            lead_mm: 2.5,
            flatness_mm: 0.05,
            cavities: Vec::new(),
        }
    }
}

impl Params {
    /// Least distance from an axis to the body's side, mm.
    pub fn needed_room_mm(&self) -> f64 {
        self.hole_diameter_mm / 2.0 + self.wall_mm
    }

    /// Least distance between two axes: a hole and a wall, mm.
    pub fn needed_pitch_mm(&self) -> f64 {
        self.hole_diameter_mm + self.wall_mm
    }

    /// What the parameters demand of each other.
    pub fn check(&self) -> Result<(), StageError> {
        match self.layout {
            Layout::Hexagon if self.count > 7 => {
                let message = format!("a hexagon has seven places, not {}", self.count);
                Err(StageError::user(message).param("/count").hint("layouts grid and ring take more"))
            }
            Layout::Free if self.places_mm.is_empty() => {
                Err(StageError::user("there is no place for an LED")
                    .param("/places_mm")
                    .hint("layout = \"free\" needs places_mm = [[x, y], …]"))
            }
            Layout::Best if self.centre_mm.is_some() || self.rotation_deg != 0.0 => {
                let param = if self.centre_mm.is_some() { "/centre_mm" } else { "/rotation_deg" };
                Err(StageError::user("the best places are found, not moved or turned")
                    .param(param)
                    .hint("leave it out, or choose another layout"))
            }
            _ => Ok(()),
        }
    }
}
