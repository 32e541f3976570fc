//! `light.track_range_mm`: from how far away a camera sees enough markers.
//!
//! A view is a direction above the base's horizon, drawn at random and known to nobody who placed the markers. A camera in
//! that direction sees a marker if it stands within the emission cone, nothing of the body is in between (rays of
//! `fibar-ruler`), and no further from the marker than its reach. The range is the largest distance from the middle of the body
//! at which a share of the views, [`MOST`] of them, see [`ENOUGH`] markers that are not in one plane.

use fibar_core::artefact::constellation::Constellation;
use fibar_ruler::surface::ClosedSurface;
use glam::{DMat3, DVec3};
use rand::RngExt;
use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};
use rayon::prelude::*;

/// Markers that a pose needs.
pub const ENOUGH: usize = 6;
/// Share of the views that must see them.
pub const MOST: f64 = 0.99;
/// Markers nearer than this to a common plane, root mean square, are in one plane, mm.
const PLANE_MM: f64 = 1.0;
/// Distances are found to this, mm.
const STEP_MM: f64 = 1.0;
/// How far off the surface sights start, mm.
const LIFT_MM: f64 = 0.02;

/// What the cameras are.
#[derive(Clone, Copy, Debug)]
pub struct Views {
    /// How many directions.
    pub count: u32,
    /// Least height above the horizon, rad.
    pub lowest: f64,
    /// Markers show within this angle of their normal, rad.
    pub emission: f64,
    /// Of the directions.
    pub seed: u64,
}

/// The object as cameras meet it.
pub struct Stage<'a> {
    body: &'a ClosedSurface,
    middle: DVec3,
    /// Place and normal of each marker that a fibre lights.
    markers: Vec<(DVec3, DVec3)>,
    directions: Vec<DVec3>,
    cos_emission: f64,
}

impl<'a> Stage<'a> {
    /// The markers in the order of `lit`, which are indices into the constellation.
    pub fn of(
        body: &'a ClosedSurface,
        middle: DVec3,
        constellation: &Constellation,
        lit: &[usize],
        views: Views,
    ) -> Stage<'a> {
        let marker = |&k: &usize| (constellation.markers[k].position, constellation.markers[k].normal);
        Stage {
            body,
            middle,
            markers: lit.iter().map(marker).collect(),
            directions: directions(views),
            cos_emission: libm::cos(views.emission),
        }
    }

    /// The range for these reaches, one per marker, and a share of the views, mm; 0 if no distance will do.
    pub fn range(&self, reach: &[f64], share: f64) -> f64 {
        const COARSE_MM: f64 = 25.0;
        let farthest = reach.iter().copied().fold(0.0, f64::max) + self.size();
        let steps = (farthest / COARSE_MM).ceil() as u32;
        let will_do = |distance: f64| self.will_do(reach, distance, share);
        let coarse = (1..=steps).rev().map(|k| f64::from(k) * COARSE_MM).find(|d| will_do(*d));
        let Some(mut low) = coarse else { return 0.0 };
        let mut high = low + COARSE_MM;
        while high - low > STEP_MM {
            let middle = 0.5 * (low + high);
            *if will_do(middle) { &mut low } else { &mut high } = middle;
        }
        low
    }

    /// Whether enough views see enough; gives up once too many do not.
    fn will_do(&self, reach: &[f64], distance: f64, share: f64) -> bool {
        const PORTION: usize = 250;
        let allowed = (1.0 - share) * self.directions.len() as f64 + 1e-9;
        let mut blind = 0;
        self.directions.chunks(PORTION).all(|portion| {
            blind += portion.par_iter().filter(|d| !self.sees_enough(**d, reach, distance)).count();
            blind as f64 <= allowed
        })
    }

    /// Share of the views that see enough markers from a distance.
    pub fn share(&self, reach: &[f64], distance: f64) -> f64 {
        let good = self.directions.par_iter().filter(|d| self.sees_enough(**d, reach, distance)).count();
        good as f64 / self.directions.len() as f64
    }

    /// Largest distance of a marker from the middle, mm.
    fn size(&self) -> f64 {
        self.markers.iter().map(|(place, _)| place.distance(self.middle)).fold(0.0, f64::max)
    }

    fn sees_enough(&self, direction: DVec3, reach: &[f64], distance: f64) -> bool {
        let eye = self.middle + direction * distance;
        let near = |k: &usize| {
            let (place, normal) = self.markers[*k];
            let arm = eye - place;
            arm.length() <= reach[*k] && arm.dot(normal) > self.cos_emission * arm.length()
        };
        let candidates: Vec<usize> = (0..self.markers.len()).filter(near).collect();
        if candidates.len() < ENOUGH {
            return false;
        }
        let clear = |k: &usize| {
            let (place, normal) = self.markers[*k];
            !self.body.bvh().blocks(place + normal * LIFT_MM, eye)
        };
        let seen: Vec<DVec3> = candidates.into_iter().filter(clear).map(|k| self.markers[k].0).collect();
        seen.len() >= ENOUGH && thickness(&seen) > PLANE_MM
    }
}

/// Even over the sphere above the lowest height.
fn directions(views: Views) -> Vec<DVec3> {
    let mut chance = ChaCha8Rng::seed_from_u64(views.seed);
    let lowest = libm::sin(views.lowest);
    let mut direction = || {
        let height: f64 = chance.random_range(lowest..1.0);
        let (sine, cosine) = libm::sincos(chance.random_range(0.0..std::f64::consts::TAU));
        let out = (1.0 - height * height).max(0.0).sqrt();
        DVec3::new(out * cosine, out * sine, height)
    };
    (0..views.count).map(|_| direction()).collect()
}

/// Root mean square distance of points from the plane nearest to them, mm: the root of the scatter's least eigenvalue, by
/// inverse iteration on the scatter made regular.
fn thickness(points: &[DVec3]) -> f64 {
    let count = points.len() as f64;
    let mean = points.iter().sum::<DVec3>() / count;
    let outer = |p: &DVec3| {
        let arm = *p - mean;
        DMat3::from_cols(arm * arm.x, arm * arm.y, arm * arm.z)
    };
    let scatter = points.iter().map(outer).fold(DMat3::ZERO, |a, b| a + b) * (1.0 / count);
    let trace = scatter.x_axis.x + scatter.y_axis.y + scatter.z_axis.z;
    if trace == 0.0 {
        return 0.0;
    }
    let inverse = (scatter + DMat3::IDENTITY * (1e-9 * trace)).inverse();
    let mut normal = DVec3::new(0.48, 0.64, 0.6);
    for _ in 0..60 {
        normal = (inverse * normal).normalize_or(DVec3::Z);
    }
    normal.dot(scatter * normal).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use fibar_core::artefact::constellation::Marker;
    use fibar_core::artefact::mesh::TriangleMesh;
    use fibar_core::{MarkerId, PatternId};

    const SEED: u64 = 4;

    /// An octahedron of radius 40 mm about a point 40 mm above the origin.
    fn body() -> ClosedSurface {
        let vertices: Vec<DVec3> = [DVec3::X, DVec3::Y, -DVec3::X, -DVec3::Y, DVec3::Z, -DVec3::Z]
            .map(|v| v * 40.0 + DVec3::Z * 40.0)
            .into();
        let upper = (0..4).map(|k| [k, (k + 1) % 4, 4]);
        let lower = (0..4).map(|k| [(k + 1) % 4, k, 5]);
        ClosedSurface::of(&TriangleMesh { vertices, triangles: upper.chain(lower).collect() })
    }

    /// Twelve markers on every upper face, `faces` of them.
    fn markers(faces: u32) -> Constellation {
        let marker = |id: u32| {
            let (face, k) = (id / 12, id % 12);
            let corner = |j: u32| {
                let angle = f64::from((face + j) % 4) * std::f64::consts::FRAC_PI_2;
                DVec3::new(libm::cos(angle), libm::sin(angle), 0.0) * 40.0
            };
            let (u, v) = (0.1 + 0.05 * f64::from(k), 0.1 + 0.03 * f64::from(k * 7 % 12));
            let place = corner(0) * u + corner(1) * v + DVec3::Z * (40.0 * (1.0 - u - v) + 40.0);
            let normal = (corner(0) + corner(1) + DVec3::Z * 40.0).normalize();
            Marker { id: MarkerId(id), position: place, normal, pattern: PatternId(1), neighbours: vec![] }
        };
        Constellation::new(350.0, vec![], (0..12 * faces).map(marker).collect())
    }

    /// From above, all four faces show: the range is the reach less the height.
    #[track_caller]
    fn check(
        faces: u32,
        lowest_deg: f64,
        emission_deg: f64,
        reach: f64,
        range: std::ops::RangeInclusive<f64>,
    ) {
        let (body, constellation) = (body(), markers(faces));
        let views = Views {
            count: 500,
            lowest: lowest_deg.to_radians(),
            emission: emission_deg.to_radians(),
            seed: SEED,
        };
        let lit: Vec<usize> = (0..constellation.markers.len()).collect();
        let stage = Stage::of(&body, DVec3::Z * 40.0, &constellation, &lit, views);
        let found = stage.range(&vec![reach; lit.len()], MOST);
        assert!(range.contains(&found), "{faces} faces, {lowest_deg}°, {emission_deg}°: {found} mm");
    }

    #[test]
    fn the_range_is_where_enough_markers_end() {
        check(4, 80.0, 80.0, 500.0, 500.0..=540.0);
        check(4, 80.0, 20.0, 500.0, 0.0..=0.0); // faces lean 54.7° off the view
        check(1, 80.0, 80.0, 500.0, 0.0..=0.0); // one face is one plane
        check(4, 0.0, 89.0, 500.0, 480.0..=520.0);
        check(2, 0.0, 89.0, 500.0, 0.0..=0.0); // nothing shows from behind
        check(4, 80.0, 80.0, 5.0, 0.0..=45.0);
    }

    #[test]
    fn thickness_is_the_distance_from_the_plane() {
        let flat = [[0.0, 0.0], [5.0, 1.0], [-3.0, 8.0], [2.0, -6.0]].map(|[x, y]| DVec3::new(x, y, 0.3 * x));
        assert!(thickness(&flat) < 1e-3);
        let thick: Vec<DVec3> = flat.iter().flat_map(|p| [*p + DVec3::Z, *p - DVec3::Z]).collect();
        let tilt = 1.0 / (1.0f64 + 0.09).sqrt();
        assert!((thickness(&thick) - tilt).abs() < 0.02, "{}", thickness(&thick));
    }
}
