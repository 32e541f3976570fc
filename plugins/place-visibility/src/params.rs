//! The parameters of the stage.

use fibar_geometry::viewsphere::Polyhedron;
use glam::DVec3;

/// How candidates are found. What Tone 2020 leaves open is explained in `docs/place-visibility.md`.
#[derive(Clone, Debug, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Points of the surface that are rated, each standing for the same area.
    #[schemars(range(min = 100, max = 2_000_000))]
    pub samples: u32,
    /// Solid whose cut triangles give the viewpoints; `pentakis-dodecahedron` at frequency 4 is our reading of the paper's
    /// "4-frequency dodecahedral geodesic sphere".
    pub sphere: Sphere,
    /// Parts that each edge of the solid is cut into.
    #[schemars(range(min = 1, max = 16))]
    pub frequency: u32,
    /// From the centre of the body's bounding box to the viewpoints.
    #[schemars(range(min = 1.0, max = 100_000.0), extend("unit" = "mm"))]
    pub view_distance_mm: f64,
    /// Viewpoints lower than this above the horizon are left out; all of them by default, as in the paper.
    #[schemars(range(min = -90.0, max = 90.0), extend("unit" = "deg"))]
    pub lowest_view_deg: f64,
    /// Distance under which the better of two places strikes out the other.
    #[schemars(range(min = 0.5, max = 1000.0), extend("unit" = "mm"))]
    pub spacing_mm: f64,
    /// How that distance is measured.
    pub spacing_along: Along,
    /// In which order places strike out others.
    pub order: Order,
    /// A marker is seen by a viewpoint only within this angle of its normal: printed fibres are dark from shallow angles.
    #[schemars(range(min = 1.0, max = 90.0), extend("unit" = "deg"))]
    pub emission_limit_deg: f64,
    /// Edges sharper than this stay sharp in the normals.
    #[schemars(range(min = 0.0, max = 180.0), extend("unit" = "deg"))]
    pub crease_deg: f64,
    /// Least height of a marker above the tips of the LEDs.
    #[schemars(range(min = 0.0, max = 1000.0), extend("unit" = "mm"))]
    pub rise_mm: f64,
    /// Least thickness of the body under a marker, along the inward normal.
    #[schemars(range(min = 0.0, max = 1000.0), extend("unit" = "mm"))]
    pub thickness_mm: f64,
    /// Straight piece that ends a fibre under a marker; around its inner end there must be room for the fibre.
    #[schemars(range(min = 0.0, max = 100.0), extend("unit" = "mm"))]
    pub end_mm: f64,
    /// Outer diameter of a fibre.
    #[schemars(range(min = 0.1, max = 100.0), extend("unit" = "mm"))]
    pub fibre_diameter_mm: f64,
    /// Skin under the surface, which fibres do not enter.
    #[schemars(range(min = 0.0, max = 10.0), extend("unit" = "mm"))]
    pub skin_mm: f64,
    /// Further room between a fibre's outer surface and the skin.
    #[schemars(range(min = 0.0, max = 100.0), extend("unit" = "mm"))]
    pub wall_mm: f64,
    /// Boxes without markers.
    pub keep_out: Vec<Region>,
    /// Parts of the source without markers, by label or by colour (`#rrggbb`): a face that a modeller painted, say.
    pub keep_out_parts: Vec<String>,
    /// How far off the surface rays start, so that they do not meet the very triangle they leave.
    #[schemars(range(min = 0.0001, max = 1.0), extend("unit" = "mm"))]
    pub lift_mm: f64,
}

/// Solid whose cut triangles give the viewpoints.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize, serde::Serialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Sphere {
    /// 30 f² + 2 viewpoints at frequency f.
    PentakisDodecahedron,
    /// 10 f² + 2 viewpoints.
    Icosahedron,
    /// 20 f² viewpoints.
    Goldberg,
}

/// How the distance between two places is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize, serde::Serialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Along {
    /// Shortest way on the surface.
    Surface,
    /// Straight through.
    Straight,
}

/// In which order places strike out others.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize, serde::Serialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Order {
    /// At random, as in the paper: gaps up to about twice the spacing remain.
    Random,
    /// The most suitable first: what is struck out is within the spacing of a place that is kept.
    BestFirst,
}

/// A box along the axes of the body's frame.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize, serde::Serialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Region {
    /// Least coordinates, mm.
    pub low_mm: [f64; 3],
    /// Greatest coordinates, mm.
    pub high_mm: [f64; 3],
}

impl Default for Params {
    fn default() -> Params {
        Params {
            samples: 20_000,
            sphere: Sphere::PentakisDodecahedron,
            frequency: 4,
            view_distance_mm: 1000.0,
            lowest_view_deg: -90.0,
            spacing_mm: 12.5,
            spacing_along: Along::Surface,
            order: Order::Random,
            emission_limit_deg: 60.0,
            crease_deg: 40.0,
            rise_mm: 8.0,
            thickness_mm: 8.0,
            end_mm: 2.5,
            fibre_diameter_mm: 3.75,
            skin_mm: 0.4,
            wall_mm: 0.0,
            keep_out: Vec::new(),
            keep_out_parts: Vec::new(),
            lift_mm: 0.01,
        }
    }
}

impl Region {
    /// Whether a point lies in the box, border included.
    pub fn contains(&self, point: DVec3) -> bool {
        let (low, high) = (DVec3::from(self.low_mm), DVec3::from(self.high_mm));
        point.cmpge(low).all() && point.cmple(high).all()
    }
}

impl From<Sphere> for Polyhedron {
    fn from(sphere: Sphere) -> Polyhedron {
        match sphere {
            Sphere::PentakisDodecahedron => Polyhedron::PentakisDodecahedron,
            Sphere::Icosahedron => Polyhedron::Icosahedron,
            Sphere::Goldberg => Polyhedron::Goldberg,
        }
    }
}
