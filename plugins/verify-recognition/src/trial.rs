//! One view put to the recognisers, with more and more markers missing.

use crate::params::Params;
use crate::scene::{Scene, Sighting};
use crate::views::{Chance, Viewpoint};
use fibar_track::consensus::{ConsensusOptions, Estimate};
use fibar_track::lookup::{correct_by_pose, name_by_lookup};
use fibar_track::model::Model;
use fibar_track::pose::Pose;
use fibar_track::recogniser::{RecogniserOptions, Recognition, recognise};

/// Shares of the visible markers that are missing, in percent.
pub const MISSING_PERCENT: [u32; 4] = [0, 10, 30, 50];

/// A view and what became of it.
#[derive(Clone, Debug)]
pub struct ViewReport {
    /// Where the camera stood.
    pub viewpoint: Viewpoint,
    /// Markers in sight.
    pub sightings: Vec<Sighting>,
    /// How many of them blink the m-sequence.
    pub m_sequences: usize,
    /// How far they are from lying in one plane, mm.
    pub thickness_mm: f64,
    /// One trial per share missing.
    pub trials: Vec<Trial>,
}

/// How many blobs were named rightly, and whether the pose was right.
#[derive(Clone, Debug, Default)]
pub struct Trial {
    /// Visible markers that are not missing.
    pub blobs: usize,
    /// Named rightly by the paper's lookup, camera upright.
    pub paper: usize,
    /// The same at the view's roll.
    pub paper_rolled: usize,
    /// Named rightly after the lookup's names were corrected by their pose, camera upright.
    pub corrected: usize,
    /// Named rightly by our recogniser, at the view's roll.
    pub ours: usize,
    /// Named wrongly although the recogniser was certain.
    pub falsely_certain: usize,
    /// The recogniser was certain.
    pub certain: bool,
    /// Each blob's name by our recogniser, in order of the sightings that are not missing.
    pub names: Vec<Option<usize>>,
    /// Our recogniser's pose against the true one.
    pub pose: Option<PoseError>,
}

/// A pose beside the truth, and the errors that its covariance predicts.
#[derive(Clone, Copy, Debug)]
pub struct PoseError {
    /// Within the limits of the parameters.
    pub right: bool,
    /// Angle between the orientations, rad.
    pub turn_rad: f64,
    /// Distance between the places of the body's middle, mm.
    pub shift_mm: f64,
    /// Standard deviation predicted of the angle, rad.
    pub sigma_turn_rad: f64,
    /// Standard deviation predicted of the distance from the camera, mm.
    pub sigma_along_mm: f64,
    /// Standard deviation predicted across the sight, mm per direction.
    pub sigma_across_mm: f64,
}

/// The object as the recognisers know it, and as it is.
pub struct Bench<'a> {
    /// The truth.
    pub scene: Scene<'a>,
    /// What the recognisers know.
    pub model: &'a Model,
    /// Views and camera.
    pub params: &'a Params,
    /// For views and samples.
    pub seed: u64,
}

impl Bench<'_> {
    /// Makes view number `number` and tries it.
    pub fn try_view(&self, number: u64) -> ViewReport {
        let mut chance = Chance::new(self.seed, number);
        let viewpoint = Viewpoint::random(&mut chance, self.scene.middle, self.params);
        let sightings = self.scene.look(&viewpoint, self.params, &mut chance);
        let with_missing = |percent: u32| {
            let left: Vec<Sighting> =
                sightings.iter().copied().filter(|s| s.luck >= f64::from(percent) / 100.0).collect();
            self.try_image(&viewpoint, &left, number)
        };
        ViewReport {
            viewpoint,
            m_sequences: self.scene.m_sequences(&sightings),
            thickness_mm: self.scene.thickness_mm(&sightings),
            trials: MISSING_PERCENT.into_iter().map(with_missing).collect(),
            sightings,
        }
    }

    fn try_image(&self, viewpoint: &Viewpoint, left: &[Sighting], number: u64) -> Trial {
        let camera = self.params.camera();
        let image = |pose: &Pose| self.scene.blobs(&camera, pose, left, self.params.noise_px);
        let (pose, upright) = (viewpoint.pose(), viewpoint.upright_pose());
        let (blobs, upright_blobs) = (image(&pose), image(&upright));
        let names = name_by_lookup(self.model, &upright_blobs);
        let options = ConsensusOptions { seed: number, ..ConsensusOptions::default() };
        let (corrected, _) = correct_by_pose(self.model, &camera, &upright_blobs, &names, &options);
        let found = recognise(self.model, &camera, &blobs, &RecogniserOptions::default());
        let ours = count_right(&found.names, left);
        let certain = found.false_alarms < RecogniserOptions::default().max_false_alarms;
        let named = found.names.iter().flatten().count();
        Trial {
            blobs: left.len(),
            paper: count_right(&names, left),
            paper_rolled: count_right(&name_by_lookup(self.model, &blobs), left),
            corrected: count_right(&corrected, left),
            ours,
            falsely_certain: if certain { named - ours } else { 0 },
            certain,
            pose: self.pose_error(&found, &pose),
            names: found.names,
        }
    }

    fn pose_error(&self, found: &Recognition, truth: &Pose) -> Option<PoseError> {
        let Estimate { pose, uncertainty, .. } = found.estimate.as_ref()?;
        let middle = truth.apply(self.scene.middle);
        let (turn_rad, shift_mm) = (pose.angle_to(truth), pose.apply(self.scene.middle).distance(middle));
        let noise = self.params.noise_px;
        Some(PoseError {
            right: turn_rad <= self.params.pose_turn_deg.to_radians()
                && shift_mm <= self.params.pose_shift_share * middle.length(),
            turn_rad,
            shift_mm,
            sigma_turn_rad: uncertainty.turn_rad() * noise,
            sigma_along_mm: uncertainty.along_sight_mm() * noise,
            sigma_across_mm: uncertainty.across_sight_mm() * noise,
        })
    }
}

fn count_right(names: &[Option<usize>], left: &[Sighting]) -> usize {
    names.iter().zip(left).filter(|(name, s)| **name == Some(s.marker)).count()
}
