//! The solids as files, on the grid that every export keeps.

use crate::partition::{Part, Partition};
use fibar_core::artefact::Document;
use fibar_core::artefact::solids::{INDEX_FILE, Solid as SolidEntry, Solids};
use fibar_plugin::{Job, StageError};
use fibar_solid::Grid;
use rayon::prelude::*;
use std::path::Path;

/// Writes the tree of solids.
pub fn write(partition: Partition, skin_mm: f64, grid: Grid, job: &mut Job) -> Result<(), StageError> {
    let folder = job.create_tree("solids", "solids")?;
    let files = files(&partition.parts);
    let written = partition.parts.par_iter().zip(files);
    let written: Vec<(SolidEntry, usize)> =
        written.map(|(part, file)| write_part(part, file, grid, &folder)).collect::<Result<_, _>>()?;
    job.metric("sweep.triangles", written.iter().map(|(_, triangles)| *triangles as f64).sum(), "1");
    job.metric("sweep.solids", written.len() as f64, "1");
    let entries = written.into_iter().map(|(entry, _)| entry).collect();
    std::fs::write(folder.join(INDEX_FILE), Solids::new(skin_mm, entries).to_json())?;
    Ok(())
}

/// `core-led0.ply`, `skin.ply`; `skin-2.ply` for the skin of the second part: names of parts may be no file names.
fn files(parts: &[Part]) -> Vec<String> {
    let stem = |part: &Part| match part.owner {
        Some((led, _)) => format!("{}-led{led}", part.role.name()),
        None => part.role.name().to_string(),
    };
    let name =
        |(k, part): (usize, &Part)| match parts[..k].iter().filter(|other| stem(other) == stem(part)).count()
        {
            0 => format!("{}.ply", stem(part)),
            before => format!("{}-{}.ply", stem(part), before + 1),
        };
    parts.iter().enumerate().map(name).collect()
}

/// Writes one solid; returns its entry and number of triangles.
fn write_part(
    part: &Part,
    file: String,
    grid: Grid,
    folder: &Path,
) -> Result<(SolidEntry, usize), StageError> {
    let mut entry = SolidEntry {
        role: part.role,
        led: part.owner.map(|(led, _)| led),
        pattern: part.owner.map(|(_, pattern)| pattern),
        part: part.label.as_ref().and_then(|label| label.name.clone()),
        colour: part.label.as_ref().and_then(|label| label.colour),
        file,
        volume_mm3: 0.0,
    };
    let name = entry.name();
    let failed = |error| StageError::internal(format!("{name}: {error}"));
    let snapped = grid.snap_solid(&part.solid).map_err(failed)?;
    entry.volume_mm3 = snapped.volume();
    let mesh = snapped.to_mesh().map_err(failed)?;
    std::fs::write(folder.join(&entry.file), mesh.to_ply())?;
    Ok((entry, mesh.triangles.len()))
}
