//! Compartments beside the LEDs, for a board or a battery, opened at the face that takes the LEDs.
//!
//! A cavity with its wall around and above it must lie inside the body, and leave a wall to every LED's hole and every other
//! cavity, or the stage says where it does not.

use crate::base::Base;
use crate::face::Face;
use crate::outline::Outline;
use crate::params::Params;
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_core::artefact::sockets::{Cavity, Section};
use fibar_plugin::StageError;
use glam::DVec2;

/// A compartment as a recipe asks for it.
#[derive(Clone, Debug, PartialEq, serde::Deserialize, serde::Serialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CavityParams {
    /// What it is for; errors, verdicts and `sockets.json` call it so.
    pub name: String,
    /// Its middle on the base in the body's x and y; on another face along its own u and v.
    #[schemars(extend("unit" = "mm"))]
    pub centre_mm: [f64; 2],
    /// Width and length of what goes in, for a box; along x and y unless turned.
    #[schemars(extend("unit" = "mm"))]
    pub size_mm: Option<[f64; 2]>,
    /// Diameter of what goes in, for a cylinder.
    #[schemars(range(min = 0.5, max = 500.0), extend("unit" = "mm"))]
    pub diameter_mm: Option<f64>,
    /// Height of what goes in.
    #[schemars(range(min = 0.5, max = 500.0), extend("unit" = "mm"))]
    pub depth_mm: f64,
    /// Turns a box counter-clockwise seen from inside.
    #[serde(default)]
    #[schemars(range(min = -360.0, max = 360.0), extend("unit" = "deg"))]
    pub rotation_deg: f64,
    /// Room left around what goes in, and above it.
    #[serde(default = "play")]
    #[schemars(range(min = 0.0, max = 10.0), extend("unit" = "mm"))]
    pub play_mm: f64,
}

fn play() -> f64 {
    0.2
}

/// Where a cavity lies on its face.
struct Footprint {
    section: Section,
    centre: DVec2,
    /// Unit vector along the width.
    across: DVec2,
    depth: f64,
}

/// The cavities, held against the body, the LEDs' places and each other.
pub fn cavities(
    laid: &TriangleMesh,
    face: &Face,
    leds: &[DVec2],
    params: &Params,
) -> Result<Vec<Cavity>, StageError> {
    let footprints: Vec<Footprint> =
        (0..params.cavities.len()).map(|k| Footprint::of(k, params)).collect::<Result<_, _>>()?;
    for (k, footprint) in footprints.iter().enumerate() {
        let base = Base::new(laid, params.flatness_mm, footprint.depth + params.wall_mm);
        let checks = [
            footprint.thin_in_body(&base, params),
            footprint.thin_to_led(leds, params),
            footprint.thin_to_others(&footprints[..k], params),
        ];
        if let Some(thin) = checks.into_iter().flatten().next() {
            return Err(thin.error(k, face, params));
        }
    }
    Ok(footprints.iter().zip(&params.cavities).map(|(f, asked)| f.cavity(&asked.name, face)).collect())
}

/// A wall that is less than asked.
struct Thin {
    wall: f64,
    to: String,
    at: DVec2,
    hint: &'static str,
}

impl Thin {
    fn error(self, k: usize, face: &Face, params: &Params) -> StageError {
        let (name, asked) = (&params.cavities[k].name, params.wall_mm);
        let message = format!(
            "the cavity \"{name}\" leaves {:.2} mm {}, {asked} mm of wall are asked",
            self.wall.max(0.0),
            self.to
        );
        let error = StageError::user(message).param(format!("/cavities/{k}")).hint(self.hint);
        error.place_mm(face.place(self.at, 0.0).to_array())
    }
}

impl Footprint {
    fn of(k: usize, params: &Params) -> Result<Footprint, StageError> {
        let asked = &params.cavities[k];
        let grown = |size: f64| size + 2.0 * asked.play_mm;
        let section = match (asked.size_mm, asked.diameter_mm) {
            (Some([width, length]), None) if width > 0.0 && length > 0.0 => {
                Ok(Section::Rectangle { width_mm: grown(width), length_mm: grown(length) })
            }
            (None, Some(diameter)) => Ok(Section::Circle { diameter_mm: grown(diameter) }),
            (Some(_), None) => Err("needs a positive width and length"),
            (Some(_), Some(_)) => Err("is a box and a cylinder at once"),
            (None, None) => Err("has no size"),
        };
        let twice = params.cavities[..k].iter().any(|other| other.name == asked.name);
        let section = if twice || asked.name.is_empty() { Err("needs a name of its own") } else { section };
        let (sine, cosine) = libm::sincos(asked.rotation_deg.to_radians());
        let refuse = |reason| {
            StageError::user(format!("the cavity \"{}\" {reason}", asked.name))
                .param(format!("/cavities/{k}"))
                .hint("size_mm = [width, length] makes a box, diameter_mm a cylinder")
        };
        Ok(Footprint {
            section: section.map_err(refuse)?,
            centre: asked.centre_mm.into(),
            across: DVec2::new(cosine, sine),
            depth: asked.depth_mm + asked.play_mm,
        })
    }

    /// Corners of the box; of a cylinder its centre.
    fn core(&self) -> Vec<DVec2> {
        match self.section {
            Section::Circle { .. } => vec![self.centre],
            Section::Rectangle { width_mm, length_mm } => {
                let (u, v) = (self.across * width_mm / 2.0, self.across.perp() * length_mm / 2.0);
                [-u - v, u - v, u + v, v - u].map(|corner| self.centre + corner).to_vec()
            }
        }
    }

    /// What a cylinder has around its centre.
    fn radius(&self) -> f64 {
        match self.section {
            Section::Circle { diameter_mm } => diameter_mm / 2.0,
            Section::Rectangle { .. } => 0.0,
        }
    }

    fn outline(&self) -> Outline {
        Outline::of(self.core())
    }

    /// Whether too little of the body is left beside it or above.
    fn thin_in_body(&self, base: &Base, params: &Params) -> Option<Thin> {
        let wall = (base.room_of(&self.outline()) - self.radius()).max(0.0);
        let to = format!("of the body beside or above it, up to {:.2} mm", self.depth + params.wall_mm);
        let hint = "move it, make it smaller or less deep, or scale the body up";
        (wall < params.wall_mm).then_some(Thin { wall, to, at: self.centre, hint })
    }

    /// Whether too little is left to the hole that comes nearest.
    fn thin_to_led(&self, leds: &[DVec2], params: &Params) -> Option<Thin> {
        let outline = self.outline();
        let wall = |led: &DVec2| outline.distance(*led) - self.radius() - params.hole_diameter_mm / 2.0;
        let (led, wall) = leds.iter().map(wall).enumerate().min_by(|a, b| a.1.total_cmp(&b.1))?;
        let hint = "move it or the LEDs, or make it smaller";
        let to = format!("to the hole of LED {led}");
        (wall < params.wall_mm).then_some(Thin { wall, to, at: leds[led], hint })
    }

    /// Whether too little is left to a cavity before it.
    fn thin_to_others(&self, before: &[Footprint], params: &Params) -> Option<Thin> {
        let wall = |other: &Footprint| {
            self.outline().distance_between(&other.outline()) - self.radius() - other.radius()
        };
        let walls = before.iter().map(wall).enumerate();
        let (other, wall) = walls.min_by(|a, b| a.1.total_cmp(&b.1))?;
        let to = format!("to \"{}\"", params.cavities[other].name);
        let at = self.centre.midpoint(before[other].centre);
        (wall < params.wall_mm).then_some(Thin { wall, to, at, hint: "move one of them" })
    }

    fn cavity(&self, name: &str, face: &Face) -> Cavity {
        Cavity {
            name: name.to_string(),
            position: face.place(self.centre, self.depth),
            axis: face.inwards(),
            across: face.place(self.across, 0.0) - face.place(DVec2::ZERO, 0.0),
            section: self.section,
            depth_mm: self.depth,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::frustum;
    use glam::DVec3;

    fn asked(name: &str, centre_mm: [f64; 2], size_mm: [f64; 2]) -> CavityParams {
        let name = name.to_string();
        let (diameter_mm, depth_mm) = (None, 6.0);
        CavityParams {
            name,
            centre_mm,
            size_mm: Some(size_mm),
            diameter_mm,
            depth_mm,
            rotation_deg: 0.0,
            play_mm: 0.2,
        }
    }

    fn round(name: &str, centre_mm: [f64; 2], diameter_mm: f64) -> CavityParams {
        CavityParams { size_mm: None, diameter_mm: Some(diameter_mm), ..asked(name, centre_mm, [1.0; 2]) }
    }

    /// In a block of 80 × 80 × 40 mm with one LED in the middle.
    fn place(cavities: Vec<CavityParams>) -> Result<Vec<Cavity>, StageError> {
        let params = Params { cavities, ..Params::default() };
        super::cavities(&frustum(40.0, 40.0, 40.0), &Face::BASE, &[DVec2::ZERO], &params)
    }

    #[test]
    fn boxes_and_cylinders_stand_on_the_base() {
        let turned = CavityParams { rotation_deg: 90.0, ..asked("board", [20.0, 0.0], [20.0, 30.0]) };
        let found = place(vec![turned, round("cell", [-20.0, 5.0], 20.0)]).unwrap();
        let [board, cell] = found.as_slice() else { panic!("{found:?}") };
        assert_eq!(board.section, Section::Rectangle { width_mm: 20.4, length_mm: 30.4 });
        assert!(board.across.distance(DVec3::Y) < 1e-12 && board.axis == DVec3::Z);
        assert!(cell.position.distance(DVec3::new(-20.0, 5.0, 6.2)) < 1e-12);
        assert_eq!((cell.section, cell.depth_mm), (Section::Circle { diameter_mm: 20.4 }, 6.2));
    }

    #[test]
    fn what_leaves_no_wall_is_named_with_its_place() {
        let check = |cavities: Vec<CavityParams>, says: &str, at: Option<[f64; 3]>| {
            let error = place(cavities).unwrap_err();
            assert!(error.to_string().contains(says), "{error} does not say {says:?}");
            if let Some(at) = at {
                assert_eq!(error.clone().place_mm(at), error);
            }
        };
        let board = || asked("board", [20.0, 0.0], [20.0, 30.0]);
        check(
            vec![asked("board", [29.0, 0.0], [20.0, 30.0])],
            "leaves 0.80 mm of the body",
            Some([29.0, 0.0, 0.0]),
        );
        check(vec![round("cell", [90.0, 0.0], 20.0)], "leaves 0.00 mm of the body", None);
        check(vec![round("cell", [29.0, 0.0], 20.0)], "leaves 0.80 mm of the body", None);
        check(vec![CavityParams { depth_mm: 39.0, ..board() }], "leaves 0.00 mm of the body", None);
        check(vec![asked("board", [12.0, 0.0], [20.0, 30.0])], "to the hole of LED 0", Some([0.0, 0.0, 0.0]));
        check(vec![round("cell", [1.0, 0.0], 9.0)], "to the hole of LED 0", None);
        check(vec![board(), round("cell", [20.0, 25.0], 18.0)], "leaves 0.60 mm to \"board\"", None);
        check(vec![board(), asked("lid", [22.0, 0.0], [2.0, 2.0])], "leaves 0.00 mm to \"board\"", None);
        check(vec![board(), board()], "a name of its own", None);
        check(vec![CavityParams { diameter_mm: Some(3.0), ..board() }], "a box and a cylinder at once", None);
        check(vec![CavityParams { size_mm: None, ..board() }], "has no size", None);
        check(vec![asked("board", [20.0, 0.0], [0.0, 30.0])], "positive width", None);
    }
}
