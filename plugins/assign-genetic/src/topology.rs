//! Who is next to whom in every image, for one set of active markers: independent of what they blink.
//!
//! Only a marker that appears or disappears changes this, and only in the images that show it; there, only its neighbours
//! see a difference. Images once triangulated are remembered.

use crate::lists::Lists;
use fibar_core::adjacency::clockwise_neighbours;
use fibar_core::images::Images;
use glam::DVec2;
use std::collections::HashMap;
use std::sync::{Arc, Mutex};

/// Neighbours of the active markers in every view.
#[derive(Clone)]
pub struct Topology {
    active: Vec<bool>,
    views: Vec<Arc<Rings>>,
    seen: Vec<Arc<Sightings>>,
    memory: Arc<Memory>,
}

/// Active markers of one view, rising, and the neighbours of each, clockwise.
#[derive(Default)]
struct Rings {
    sites: Vec<u32>,
    neighbours: Lists,
}

/// Every way in which the views see one marker.
#[derive(Default)]
pub struct Sightings {
    /// The different rings of neighbours, clockwise; the rings themselves in order.
    pub rings: Lists,
    /// For every ring, the views that see it, rising.
    pub views: Lists,
    /// All sites that occur in any of the rings, rising.
    pub around: Vec<u32>,
}

impl Topology {
    /// No marker is active.
    pub fn blank(images: &Images) -> Topology {
        Topology {
            active: vec![false; images.sites.len()],
            views: vec![Arc::default(); images.views.len()],
            seen: vec![Arc::default(); images.sites.len()],
            memory: Arc::new(Memory::new(images.views.len())),
        }
    }

    /// The sightings of a marker; none if it is not active.
    pub fn sightings(&self, site: usize) -> &Arc<Sightings> {
        &self.seen[site]
    }

    /// The topology of another set of active markers: what the difference does not touch is shared.
    pub fn with_active(self: &Arc<Self>, images: &Images, active: &[bool]) -> Arc<Topology> {
        if self.active == active {
            return self.clone();
        }
        let toggled = (0..active.len()).filter(|&k| active[k] != self.active[k]);
        let mut views: Vec<u32> = toggled.flat_map(|k| &images.views_of[k]).copied().collect();
        views.sort_unstable();
        views.dedup();
        let mut next = Topology { active: active.to_vec(), ..Topology::clone(self) };
        let mut touched = vec![false; active.len()];
        for view in views.into_iter().map(|v| v as usize) {
            let rings = self.memory.connect(images, view, active);
            mark_differences(&self.views[view], &rings, &mut touched);
            next.views[view] = rings;
        }
        for site in (0..active.len()).filter(|&k| touched[k]) {
            next.seen[site] = Arc::new(next.collect_sightings(images, site as u32));
        }
        Arc::new(next)
    }

    fn collect_sightings(&self, images: &Images, site: u32) -> Sightings {
        let ring_in = |view: &u32| self.views[*view as usize].ring(site).map(|ring| (ring, *view));
        let mut found: Vec<(&[u32], u32)> =
            images.views_of[site as usize].iter().filter_map(ring_in).collect();
        found.sort_unstable();
        let mut sightings = Sightings::default();
        for same in found.chunk_by(|a, b| a.0 == b.0) {
            sightings.rings.push(same[0].0.iter().copied());
            sightings.views.push(same.iter().map(|(_, view)| *view));
        }
        sightings.around = sightings.rings.items().to_vec();
        sightings.around.sort_unstable();
        sightings.around.dedup();
        sightings
    }
}

impl Rings {
    /// The neighbours of a marker; `None` if the view does not show it.
    fn ring(&self, site: u32) -> Option<&[u32]> {
        let place = self.sites.binary_search(&site).ok()?;
        Some(self.neighbours.get(place))
    }
}

/// Marks the markers whose ring is not the same before and after.
fn mark_differences(before: &Rings, after: &Rings, touched: &mut [bool]) {
    for &site in before.sites.iter().chain(&after.sites) {
        touched[site as usize] |= before.ring(site) != after.ring(site);
    }
}

/// Triangulated images, by view and active markers. Whether something is remembered changes no result.
struct Memory(Vec<Mutex<HashMap<Vec<u32>, Arc<Rings>>>>);

impl Memory {
    /// Images remembered for each view; a kilobyte or so each.
    const CAPACITY: usize = 64;

    fn new(views: usize) -> Memory {
        Memory((0..views).map(|_| Mutex::default()).collect())
    }

    /// Delaunay neighbours of the active markers in one view.
    fn connect(&self, images: &Images, view: usize, active: &[bool]) -> Arc<Rings> {
        let image = &images.views[view];
        let shown = std::iter::zip(&image.sites, &image.points).filter(|(site, _)| active[**site as usize]);
        let (sites, points): (Vec<u32>, Vec<DVec2>) = shown.map(|(site, point)| (*site, *point)).unzip();
        let lock = || self.0[view].lock().expect("no thread panics while it holds the lock");
        if let Some(known) = lock().get(&sites) {
            return known.clone();
        }
        let rings = Arc::new(connect(sites.clone(), &points));
        let mut known = lock();
        if known.len() >= Self::CAPACITY {
            known.clear();
        }
        known.insert(sites, rings.clone());
        rings
    }
}

fn connect(sites: Vec<u32>, points: &[DVec2]) -> Rings {
    let mut neighbours = Lists::default();
    for ring in clockwise_neighbours(points) {
        neighbours.push(ring.into_iter().map(|k| sites[k]));
    }
    Rings { sites, neighbours }
}
