//! `recognition-views.csv`: every view in a line, for those who want to look closer.

use crate::tally::Tally;
use crate::trial::{MISSING_PERCENT, ViewReport};
use std::fmt::Write as _;

/// The table, a heading first. Places and errors in mm, angles in degrees; what there is no pose for stays empty.
pub fn list(tally: &Tally) -> String {
    let mut text = heading();
    for (number, report) in tally.reports.iter().enumerate() {
        write_line(&mut text, number, report).expect("a String takes all text");
    }
    text
}

fn heading() -> String {
    let of = |percent: u32| {
        let columns = ["blobs", "right", "certain", "pose_right", "error_turn_deg", "error_shift_mm"];
        let predicted = ["sigma_turn_deg", "sigma_along_mm", "sigma_across_mm"];
        columns.into_iter().chain(predicted).fold(String::new(), |text, c| format!("{text},{c}_{percent:02}"))
    };
    let trials: String = MISSING_PERCENT.into_iter().map(of).collect();
    format!("view,eye_x_mm,eye_y_mm,eye_z_mm,roll_deg,visible,m_sequences,thickness_mm{trials}\n")
}

fn write_line(text: &mut String, number: usize, report: &ViewReport) -> std::fmt::Result {
    let (eye, roll) = (report.viewpoint.eye, report.viewpoint.roll_rad.to_degrees());
    write!(text, "{number},{:.2},{:.2},{:.2},{roll:.2}", eye.x, eye.y, eye.z)?;
    write!(text, ",{},{},{:.3}", report.sightings.len(), report.m_sequences, report.thickness_mm)?;
    for trial in &report.trials {
        write!(text, ",{},{},{}", trial.blobs, trial.ours, u8::from(trial.certain))?;
        match &trial.pose {
            None => text.push_str(",0,,,,,"),
            Some(pose) => {
                let turns = [pose.turn_rad, pose.sigma_turn_rad].map(f64::to_degrees);
                write!(text, ",{},{:.4},{:.3}", u8::from(pose.right), turns[0], pose.shift_mm)?;
                write!(text, ",{:.4},{:.3},{:.3}", turns[1], pose.sigma_along_mm, pose.sigma_across_mm)?;
            }
        }
    }
    text.push('\n');
    Ok(())
}
