//! Which camera sees which site: by rays of this stage's own, from more directions than a lookup table has.
//!
//! Two sets of cameras, both on geodesic spheres around the body. The *survey* counts markers, so it is coarse and stands at the
//! nearest and at the farthest distance. The *watch* is for what must never fail: a site counts there only when the
//! directions all around see it too, from near and far, so that whatever lies between two of them is covered as well.

use crate::params::Params;
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_core::artefact::sites::{Site, Sites};
use fibar_geometry::rays::RayScene;
use fibar_geometry::viewsphere::{Polyhedron, geodesic_directions, geodesic_mesh};
use glam::DVec3;
use rayon::prelude::*;

/// The solid of both sets of cameras.
const GRID: Polyhedron = Polyhedron::PentakisDodecahedron;

/// Cameras by index, and what each site shows to them.
pub struct Sightlines {
    /// Cameras of the survey.
    pub survey: usize,
    /// For every site, the survey's cameras that see it, rising.
    pub surveyed_by: Vec<Vec<u32>>,
    /// Directions of the watch, unit vectors from the body's middle.
    pub watch: Vec<DVec3>,
    /// For every site, the directions of the watch from all around which it is seen, rising.
    pub watched_by: Vec<Vec<u32>>,
}

impl Sightlines {
    /// Casts all rays.
    pub fn cast(body: &TriangleMesh, sites: &Sites, params: &Params) -> Sightlines {
        let gaze = Gaze {
            scene: RayScene::new(body),
            centre: sites.centre,
            distances: [params.nearest_mm, params.farthest_mm],
            cos_limit: libm::cos(params.emission_limit_deg.to_radians()),
            lift: params.lift_mm,
        };
        let lowest = libm::sin(params.lowest_view_deg.to_radians());
        let mut survey = geodesic_directions(GRID, params.survey_frequency);
        survey.retain(|d| d.z >= lowest);
        let watch = Grid::new(params.watch_frequency, lowest);
        let surveyed_by = sites.sites.par_iter().map(|site| gaze.cameras(site, &survey)).collect();
        let watched_by = sites.sites.par_iter().map(|site| watch.surrounded(&gaze, site)).collect();
        Sightlines { survey: survey.len() * 2, surveyed_by, watch: watch.demanded(), watched_by }
    }
}

/// Directions of a geodesic sphere, and who is next to whom.
struct Grid {
    directions: Vec<DVec3>,
    /// How many of them, the first ones, are demanded; the rest only surround them.
    demanded: usize,
    neighbours: Vec<Vec<usize>>,
}

impl Grid {
    /// The directions not lower than `lowest` (as a sine), then those around that are.
    ///
    /// A direction just below the horizon stands for views just above it, so those next to a high one are demanded too.
    fn new(frequency: u32, lowest: f64) -> Grid {
        let mesh = geodesic_mesh(GRID, frequency);
        let mut around = vec![Vec::new(); mesh.vertices.len()];
        for t in &mesh.triangles {
            for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
                around[a as usize].push(b as usize);
            }
        }
        let high: Vec<bool> = mesh.vertices.iter().map(|d| d.z >= lowest).collect();
        let next =
            |set: &[bool]| (0..set.len()).map(|k| set[k] || around[k].iter().any(|&n| set[n])).collect();
        let demanded: Vec<bool> = next(&high);
        let surrounding: Vec<bool> = next(&demanded);
        let mut order: Vec<usize> = (0..high.len()).filter(|&k| surrounding[k]).collect();
        order.sort_by_key(|&k| !demanded[k]);
        let mut place = vec![usize::MAX; high.len()];
        order.iter().enumerate().for_each(|(new, &old)| place[old] = new);
        let count = order.iter().filter(|&&k| demanded[k]).count();
        Grid {
            directions: order.iter().map(|&k| mesh.vertices[k]).collect(),
            demanded: count,
            neighbours: order[..count]
                .iter()
                .map(|&k| around[k].iter().map(|&n| place[n]).collect())
                .collect(),
        }
    }

    fn demanded(&self) -> Vec<DVec3> {
        self.directions[..self.demanded].to_vec()
    }

    /// The demanded directions that see a site, as all those next to them do, from every distance.
    fn surrounded(&self, gaze: &Gaze, site: &Site) -> Vec<u32> {
        let seen: Vec<bool> = self.directions.iter().map(|d| gaze.sees_always(site, *d)).collect();
        let sure = |k: &usize| seen[*k] && self.neighbours[*k].iter().all(|&n| seen[n]);
        (0..self.demanded).filter(sure).map(|k| k as u32).collect()
    }
}

/// How cameras look.
struct Gaze {
    scene: RayScene,
    centre: DVec3,
    distances: [f64; 2],
    cos_limit: f64,
    lift: f64,
}

impl Gaze {
    /// The cameras that see a site: two for each direction, the near one first.
    fn cameras(&self, site: &Site, directions: &[DVec3]) -> Vec<u32> {
        let sees = |camera: &u32| {
            self.sees(site, directions[*camera as usize / 2], self.distances[*camera as usize % 2])
        };
        (0..directions.len() as u32 * 2).filter(sees).collect()
    }

    fn sees_always(&self, site: &Site, direction: DVec3) -> bool {
        self.distances.iter().all(|&distance| self.sees(site, direction, distance))
    }

    /// Whether a camera in a direction from the middle sees a site: within the emission limit, with nothing in between.
    fn sees(&self, site: &Site, direction: DVec3, distance: f64) -> bool {
        let eye = self.centre + direction * distance;
        let arm = eye - site.position;
        arm.dot(site.normal) > self.cos_limit * arm.length()
            && self.scene.is_clear(site.position + site.normal * self.lift, eye)
    }
}
