//! The paper's recognition: a blob's name from its own pattern and its neighbours' (Tone 2020, "Marker ID recognition"), and
//! the correction of names by the pose that most of them agree on ("Pose estimation of projection object from markers").
//!
//! A sequence starts at twelve o'clock of the image, on the object as in the table, so the camera must be held upright.

use crate::camera::Camera;
use crate::consensus::{ConsensusOptions, Estimate, find_consensus};
use crate::model::{Blob, Model};
use crate::refinement::Correspondence;
use fibar_core::adjacency::clockwise_neighbours;
use fibar_core::id::PatternId;
use fibar_core::recognition::{Entry, look_up};
use glam::DVec2;

/// Each blob's marker by the lookup table; `None` where no marker has its pattern.
pub fn name_by_lookup(model: &Model, blobs: &[Blob]) -> Vec<Option<usize>> {
    let (lines, owners) = table(model);
    let sequences = neighbour_patterns(blobs);
    let name = |(blob, neighbours): (&Blob, &Vec<PatternId>)| {
        look_up(Entry { pattern: blob.pattern, neighbours }, &lines).map(|line| owners[line])
    };
    blobs.iter().zip(&sequences).map(name).collect()
}

/// Names corrected by the pose that most of them agree on; the names as they are where no four agree.
pub fn correct_by_pose(
    model: &Model,
    camera: &Camera,
    blobs: &[Blob],
    names: &[Option<usize>],
    options: &ConsensusOptions,
) -> (Vec<Option<usize>>, Option<Estimate>) {
    let named = blobs.iter().zip(names).filter_map(|(blob, name)| name.map(|marker| (blob.at, marker)));
    let seen: Vec<Correspondence> = named
        .map(|(pixel, marker)| Correspondence { point: model.markers()[marker].position, pixel })
        .collect();
    let estimate = find_consensus(camera, &seen, options);
    let corrected = estimate.as_ref().map(|found| model.name(camera, &found.pose, blobs, options.gate_px));
    (corrected.unwrap_or_else(|| names.to_vec()), estimate)
}

/// For every blob, its Delaunay neighbours' patterns, clockwise from twelve o'clock.
pub fn neighbour_patterns(blobs: &[Blob]) -> Vec<Vec<PatternId>> {
    let places: Vec<DVec2> = blobs.iter().map(|b| b.at).collect();
    let patterns = |neighbours: Vec<usize>| neighbours.into_iter().map(|k| blobs[k].pattern).collect();
    clockwise_neighbours(&places).into_iter().map(patterns).collect()
}

/// The lines of the lookup table, and whose each is.
fn table(model: &Model) -> (Vec<Entry<'_>>, Vec<usize>) {
    let lines = model.markers().iter().enumerate().flat_map(|(owner, marker)| {
        marker.neighbours.iter().map(move |neighbours| (Entry { pattern: marker.pattern, neighbours }, owner))
    });
    lines.unzip()
}
