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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pose::Pose;
    use crate::synthetic::{Random, object};
    use fibar_core::artefact::constellation::Constellation;
    use glam::DVec3;
    use std::f64::consts::FRAC_PI_2;

    const CAMERA: Camera =
        Camera { focal_px: 1100.0, centre_px: DVec2::new(360.0, 270.0), size_px: DVec2::new(720.0, 540.0) };

    fn see(model: &Model, pose: &Pose) -> (Vec<Blob>, Vec<Option<usize>>) {
        let places = (0..model.markers().len()).map(|k| (k, model.project(&CAMERA, pose, k)));
        let seen = places
            .filter_map(|(k, at)| at.map(|at| (Blob { at, pattern: model.markers()[k].pattern }, Some(k))));
        seen.unzip()
    }

    /// An object whose table was made from the very view that it is tried on.
    fn object_learned_from(pose: &Pose) -> Constellation {
        let mut constellation = object(&mut Random::new(16), 70);
        let model = Model::new(&constellation, 1.0);
        let (blobs, owners) = see(&model, pose);
        for (sequence, owner) in neighbour_patterns(&blobs).into_iter().zip(owners) {
            constellation.markers[owner.expect("seen")].neighbours = vec![sequence];
        }
        constellation
    }

    #[test]
    fn the_view_of_the_table_is_named_and_a_rolled_one_mended_by_pose() {
        let (eye, target) = (DVec3::new(500.0, 300.0, 400.0), DVec3::ZERO);
        let model = Model::new(&object_learned_from(&Pose::looking(eye, target, 0.0)), 1.0);
        let check = |roll: f64, least_named: f64, least_mended: f64| {
            let (blobs, owners) = see(&model, &Pose::looking(eye, target, roll));
            let names = name_by_lookup(&model, &blobs);
            let (mended, _) = correct_by_pose(&model, &CAMERA, &blobs, &names, &ConsensusOptions::default());
            let rate = |names: &[Option<usize>]| {
                names.iter().zip(&owners).filter(|(a, b)| a == b).count() as f64 / owners.len() as f64
            };
            assert!(rate(&names) >= least_named, "roll {roll}: {} named", rate(&names));
            assert!(rate(&mended) >= least_mended, "roll {roll}: {} mended", rate(&mended));
        };
        check(0.0, 1.0, 1.0);
        check(0.2, 0.6, 1.0);
        check(FRAC_PI_2, 0.2, 0.0);
    }

    #[test]
    fn too_few_blobs_keep_their_names() {
        let model = Model::new(&object_learned_from(&Pose::looking(DVec3::X * 600.0, DVec3::ZERO, 0.0)), 1.0);
        let options = ConsensusOptions::default();
        let check = |blobs: &[Blob], names: &[Option<usize>]| {
            let (corrected, estimate) = correct_by_pose(&model, &CAMERA, blobs, names, &options);
            assert_eq!(corrected, names);
            assert!(estimate.is_none());
        };
        let blob = Blob { at: DVec2::ONE, pattern: PatternId(1) };
        check(&[], &[]);
        check(&[blob; 3], &[Some(1), Some(2), None]);
        assert_eq!(name_by_lookup(&model, &[Blob { pattern: PatternId(9), ..blob }]), [None]);
    }
}
