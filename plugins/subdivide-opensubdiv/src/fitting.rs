//! A control mesh whose refined vertices lie where those of the given mesh are.
//!
//! Subdivision shrinks: a vertex moves towards its neighbours. Moving each control vertex out by what its image is off, again and
//! again, c ← c + (p − S c), makes the images return to p (Maillot & Stam 2001): S has eigenvalues in (0, 1].

use crate::refinement::Refinement;
use glam::DVec3;

/// Near enough, mm: a tenth of what a printer places.
const CLOSE_MM: f64 = 1e-3;
const MOST_STEPS: usize = 200;

/// Control vertices whose images are `targets`, to `CLOSE_MM` where the steps suffice.
pub fn fit(refinement: &Refinement, targets: &[DVec3]) -> Vec<DVec3> {
    let mut control = targets.to_vec();
    for _ in 0..MOST_STEPS {
        let positions = refinement.positions(&control);
        let errors: Vec<DVec3> =
            targets.iter().zip(refinement.of_control(&positions)).map(|(target, is)| *target - is).collect();
        if errors.iter().all(|error| error.length() < CLOSE_MM) {
            break;
        }
        control.iter_mut().zip(errors).for_each(|(place, error)| *place += error);
    }
    control
}
