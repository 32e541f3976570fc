//! Who surrounds whom in the images: rings of Delaunay neighbours, with all markers lit and with some missing.

use fibar_core::adjacency::clockwise_neighbours;
use fibar_core::artefact::sites::{Sites, View};
use fibar_core::images::{Image, Images};
use glam::DVec2;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeMap;

/// Images of each view with markers missing at random, beside the one with all of them.
const DRAWS: usize = 3;
/// Rings that are kept for each marker, those that most images show.
const KEPT: usize = 4;

/// The rings of every marker.
pub struct Rings(Vec<Vec<Ring>>);

/// Neighbours of a marker, clockwise, from no particular one on.
#[derive(Clone, Debug, PartialEq)]
pub struct Ring {
    /// Markers by index.
    pub members: Vec<usize>,
    /// Share of this marker's kept images that show it; all shares of a marker add up to 1.
    pub share: f64,
}

/// The chosen sites and what each view sees of them, renumbered in the order of `markers`, which rises.
pub fn sites_of(sites: &Sites, markers: &[usize]) -> Sites {
    let renumber = |k: &u32| markers.binary_search(&(*k as usize)).ok().map(|m| m as u32);
    let view =
        |v: &View| View { position: v.position, visible: v.visible.iter().filter_map(renumber).collect() };
    let kept = markers.iter().map(|&k| sites.sites[k]).collect();
    Sites::new(sites.centre, kept, sites.views.iter().map(view).collect())
}

impl Rings {
    /// Collects the rings of all images. Every marker of `images` is seen by some view.
    pub fn collect(images: &Images, missing_share: f64, seed: u64) -> Rings {
        let mut counts = vec![BTreeMap::<Vec<usize>, usize>::new(); images.sites.len()];
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        for image in &images.views {
            for draw in 0..=DRAWS {
                let share = if draw == 0 { 0.0 } else { missing_share };
                let lit: Vec<usize> =
                    (0..image.sites.len()).filter(|_| rng.random::<f64>() >= share).collect();
                for (marker, ring) in neighbours(image, &lit) {
                    *counts[marker].entry(turned_to_least(ring)).or_default() += 1;
                }
            }
        }
        Rings(counts.into_iter().map(most_frequent).collect())
    }

    /// How many markers there are.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// The rings of a marker, the most frequent first.
    pub fn of(&self, marker: usize) -> &[Ring] {
        &self.0[marker]
    }

    /// For every marker, those in one of whose rings it is, rising.
    pub fn seen_from(&self) -> Vec<Vec<usize>> {
        let mut seen_from = vec![Vec::new(); self.0.len()];
        for (marker, rings) in self.0.iter().enumerate() {
            let members = rings.iter().flat_map(|ring| &ring.members);
            members.for_each(|&member| seen_from[member].push(marker));
        }
        seen_from.iter_mut().for_each(|s| s.dedup());
        seen_from
    }
}

/// Each lit marker of an image and its neighbours, clockwise from twelve o'clock.
pub fn neighbours(image: &Image, lit: &[usize]) -> Vec<(usize, Vec<usize>)> {
    let points: Vec<DVec2> = lit.iter().map(|&k| image.points[k]).collect();
    let marker = |k: usize| image.sites[lit[k]] as usize;
    let rings = clockwise_neighbours(&points).into_iter().enumerate();
    rings.map(|(k, ring)| (marker(k), ring.into_iter().map(marker).collect())).collect()
}

/// The ring begun with its least member: the same for every roll of the camera.
fn turned_to_least(mut ring: Vec<usize>) -> Vec<usize> {
    let least = (0..ring.len()).min_by_key(|&k| ring[k]).unwrap_or(0);
    ring.rotate_left(least);
    ring
}

fn most_frequent(counts: BTreeMap<Vec<usize>, usize>) -> Vec<Ring> {
    let mut counted: Vec<(Vec<usize>, usize)> = counts.into_iter().collect();
    counted.sort_by(|a, b| b.1.cmp(&a.1).then_with(|| a.0.cmp(&b.0)));
    counted.truncate(KEPT);
    let total: usize = counted.iter().map(|(_, count)| count).sum();
    let ring = |(members, count): (Vec<usize>, usize)| Ring { members, share: count as f64 / total as f64 };
    counted.into_iter().map(ring).collect()
}
