//! The simulated images: where each viewpoint sees the sites.
//!
//! A viewpoint is a pinhole camera that looks at the centre of the sphere of viewpoints, upright: +Z of the object points
//! up in the image, at the poles +Y. Image coordinates: x right, y down, focal length 1.

use crate::artefact::sites::{Site, Sites, View};
use glam::{DVec2, DVec3};

/// All images, over the sites that at least one of them shows.
pub struct Images {
    /// The sites, renumbered.
    pub sites: Vec<Site>,
    /// For every view, what it shows.
    pub views: Vec<Image>,
    /// For every site, the views that show it, rising.
    pub views_of: Vec<Vec<u32>>,
}

/// What one view shows.
pub struct Image {
    /// The sites, rising.
    pub sites: Vec<u32>,
    /// Their places in the image.
    pub points: Vec<DVec2>,
}

impl Images {
    /// Projects the visible sites of every view.
    pub fn new(sites: &Sites) -> Images {
        let mut seen = vec![false; sites.sites.len()];
        sites.views.iter().flat_map(|v| &v.visible).for_each(|&k| seen[k as usize] = true);
        let numbers: Vec<u32> =
            seen.iter().scan(0, |next, &s| Some(std::mem::replace(next, *next + u32::from(s)))).collect();
        let image = |view: &View| {
            let camera = Camera::looking_at(sites.centre, view.position);
            let point = |&k: &u32| camera.project(sites.sites[k as usize].position);
            Image {
                sites: view.visible.iter().map(|&k| numbers[k as usize]).collect(),
                points: view.visible.iter().map(point).collect(),
            }
        };
        let views: Vec<Image> = sites.views.iter().map(image).collect();
        let kept: Vec<Site> =
            std::iter::zip(&sites.sites, &seen).filter(|(_, s)| **s).map(|(site, _)| *site).collect();
        let mut views_of = vec![Vec::new(); kept.len()];
        for (v, view) in (0..).zip(&views) {
            view.sites.iter().for_each(|&k| views_of[k as usize].push(v));
        }
        Images { sites: kept, views, views_of }
    }
}

/// A pinhole: position and the directions of the image's axes in the object's frame.
struct Camera {
    position: DVec3,
    right: DVec3,
    down: DVec3,
    forward: DVec3,
}

impl Camera {
    fn looking_at(centre: DVec3, position: DVec3) -> Camera {
        /// Sine of the angle to the pole within which +Y takes over as up: far below the distance of two viewpoints.
        const POLE: f64 = 1e-6;
        let forward = (centre - position).normalize_or(DVec3::NEG_Z);
        let across = forward.cross(DVec3::Z);
        let across = if across.length() > POLE { across } else { forward.cross(DVec3::Y) };
        let right = across.normalize();
        Camera { position, right, down: forward.cross(right), forward }
    }

    fn project(&self, point: DVec3) -> DVec2 {
        let arm = point - self.position;
        DVec2::new(arm.dot(self.right), arm.dot(self.down)) / arm.dot(self.forward)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_are_upright() {
        let check = |position: [f64; 3], point: [f64; 3], expected: [f64; 2]| {
            let camera = Camera::looking_at(DVec3::ZERO, position.into());
            let found = camera.project(point.into());
            assert!(found.distance(expected.into()) < 1e-12, "{position:?}: {found}");
        };
        check([0.0, -4.0, 0.0], [1.0, 0.0, 2.0], [0.25, -0.5]);
        check([0.0, -4.0, 0.0], [1.0, -2.0, 2.0], [0.5, -1.0]);
        check([0.0, 4.0, 0.0], [1.0, 0.0, 2.0], [-0.25, -0.5]);
        check([4.0, 0.0, 0.0], [0.0, 1.0, 2.0], [0.25, -0.5]);
        check([0.0, 0.0, 4.0], [1.0, 2.0, 0.0], [0.25, -0.5]);
        check([0.0, 0.0, -4.0], [1.0, 2.0, 0.0], [-0.25, -0.5]);
    }

    #[test]
    fn unseen_sites_drop_out() {
        let site = |x: f64| Site { position: DVec3::X * x, normal: DVec3::Z, suitability_rad: 1.0 };
        let view = |visible: &[u32]| View { position: DVec3::Z * 9.0, visible: visible.to_vec() };
        let sites = Sites::new(
            DVec3::ZERO,
            vec![site(0.0), site(1.0), site(2.0), site(3.0)],
            vec![view(&[1, 3]), view(&[3])],
        );
        let images = Images::new(&sites);
        assert_eq!(images.sites.iter().map(|s| s.position.x).collect::<Vec<_>>(), [1.0, 3.0]);
        assert_eq!(images.views[0].sites, [0, 1]);
        assert_eq!(images.views_of, [vec![0], vec![0, 1]]);
    }
}
