//! The fibres of each LED as three nested tubes.

use fibar_core::artefact::routes::{Fibre, Routes};
use fibar_core::artefact::sockets::Sockets;
use fibar_core::id::{LedId, PatternId};
use fibar_geometry::curve::Curve;
use fibar_plugin::StageError;
use fibar_solid::{Axis, AxisOptions, Solid, SolidError};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Continuation past the marker, mm: through the skin, so that the skin's inner side cuts the fibre.
const BEYOND_MARKER_MM: f64 = 1.0;
/// Continuation into the socket, mm at most, so that the socket's end cuts the fibre.
const INTO_SOCKET_MM: f64 = 0.5;
/// Added to every wall, mm: more than rounding to the export grid takes away.
const WALL_MARGIN_MM: f64 = 1e-4;

/// Cavities between the parts of a tight bend that are filled, mm³: a cube of 0.1 mm.
const SPECK_MM3: f64 = 1e-3;

/// All fibres of one LED, united layer by layer. Each layer holds the ones before it.
pub struct LedTubes {
    /// The LED.
    pub led: LedId,
    /// What it blinks.
    pub pattern: PatternId,
    /// Cores.
    pub core: Solid,
    /// Cores with cladding.
    pub cladding: Solid,
    /// Whole fibres.
    pub black: Solid,
    /// Joints of the axes that no mitre fits.
    pub elbows: usize,
}

/// Sweeps all fibres; the LEDs come in order of their pattern.
pub fn sweep_all(routes: &Routes, sockets: &Sockets, chord_error: f64) -> Result<Vec<LedTubes>, StageError> {
    let mut groups: BTreeMap<(PatternId, LedId), Vec<&Fibre>> = BTreeMap::new();
    for fibre in &routes.fibres {
        groups.entry((fibre.pattern, fibre.led)).or_default().push(fibre);
    }
    let depth = sockets.hole.depth_mm;
    groups
        .into_par_iter()
        .map(|((pattern, led), fibres)| sweep_led(led, pattern, &fibres, chord_error, depth))
        .collect()
}

fn sweep_led(
    led: LedId,
    pattern: PatternId,
    fibres: &[&Fibre],
    chord_error: f64,
    depth: f64,
) -> Result<LedTubes, StageError> {
    let axes: Vec<Axis> = fibres.iter().map(|f| axis(f, chord_error, depth)).collect::<Result<_, _>>()?;
    let elbows = axes.iter().map(Axis::elbows).sum();
    let layers: Vec<Solid> = (0..3)
        .into_par_iter()
        .map(|layer| unite(&axes, fibres, layer))
        .collect::<Result<_, SolidError>>()
        .map_err(|error| StageError::internal(format!("the fibres of LED {led}: {error}")))?;
    let [core, cladding, black] = layers.try_into().expect("three layers were made");
    Ok(LedTubes { led, pattern, core, cladding, black, elbows })
}

fn axis(fibre: &Fibre, chord_error: f64, depth: f64) -> Result<Axis, StageError> {
    let blame = |error: String| StageError::input(format!("fibre {}: {error}", fibre.id));
    let curve = Curve::of_fibre(fibre).map_err(|error| blame(error.to_string()))?;
    let options = AxisOptions {
        outer_radius: fibre.radii_mm.black,
        chord_error,
        extend_start: INTO_SOCKET_MM.min(depth),
        extend_end: BEYOND_MARKER_MM,
    };
    Axis::new(&curve, options).map_err(|error| blame(error.to_string()).place_mm(fibre.points[0].to_array()))
}

/// One layer of all fibres.
fn unite(axes: &[Axis], fibres: &[&Fibre], layer: usize) -> Result<Solid, SolidError> {
    let mut parts = Vec::new();
    for (axis, fibre) in axes.iter().zip(fibres) {
        parts.extend(axis.tube(apothems(axis, fibre)[layer])?);
    }
    Solid::union(&parts)?.without_specks(SPECK_MM3)
}

/// Apothems of core, cladding and black, mm: the core has its nominal area, the walls at least their nominal thickness.
fn apothems(axis: &Axis, fibre: &Fibre) -> [f64; 3] {
    let radii = fibre.radii_mm;
    let core = axis.apothem_of_equal_area(radii.core);
    let cladding = axis.apothem_around(core, radii.cladding - radii.core + WALL_MARGIN_MM);
    let black = axis.apothem_around(cladding, radii.black - radii.cladding + WALL_MARGIN_MM);
    [core, cladding, black]
}
