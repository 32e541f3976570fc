//! The fibres of each LED as three nested tubes.

use fibar_core::artefact::routes::{Fibre, Routes};
use fibar_core::artefact::sockets::Sockets;
use fibar_core::id::{LedId, PatternId};
use fibar_geometry::curve::Curve;
use fibar_plugin::StageError;
use fibar_solid::{Axis, AxisOptions, Layer, Solid, SolidError};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Continuation past the marker, mm: through the skin, so that the skin's inner side cuts the fibre.
const BEYOND_MARKER_MM: f64 = 1.0;
/// Continuation into the socket, mm at most, so that the socket's end cuts the fibre.
const INTO_SOCKET_MM: f64 = 0.5;
/// How far an inner layer stands out of the one around it at both ends, mm, so that the outer one's end cuts both.
const OVERHANG_MM: f64 = 0.1;
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
        parts.extend(axis.tube(nested(axis, fibre)[layer])?);
    }
    Solid::union(&parts)?.without_specks(SPECK_MM3)
}

/// Core, cladding and black: the core has its nominal area, the walls at least their nominal thickness.
fn nested(axis: &Axis, fibre: &Fibre) -> [Layer; 3] {
    let radii = fibre.radii_mm;
    let core = axis.apothem_of_equal_area(radii.core);
    let cladding = axis.apothem_around(core, radii.cladding - radii.core + WALL_MARGIN_MM);
    let black = axis.apothem_around(cladding, radii.black - radii.cladding + WALL_MARGIN_MM);
    let layer = |apothem, deeper: f64| Layer { apothem, overhang: deeper * OVERHANG_MM };
    [layer(core, 2.0), layer(cladding, 1.0), layer(black, 0.0)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use fibar_core::artefact::sockets::{Hole, Socket};
    use fibar_core::id::MarkerId;
    use fibar_core::material::LayerRadii;
    use fibar_geometry::curve::clamped_uniform_knots;
    use fibar_solid::Grid;
    use glam::DVec3;

    /// From beside an LED at the origin up and away.
    fn fibre(id: u32, start: [f64; 3], end: [f64; 3]) -> Fibre {
        let (start, end) = (DVec3::from(start), DVec3::from(end));
        let points = vec![start, start + DVec3::Z * 2.5, start.lerp(end, 0.6), end];
        Fibre {
            id,
            marker: MarkerId(id),
            led: LedId(0),
            pattern: PatternId(1),
            degree: 3,
            knots: clamped_uniform_knots(3, 4),
            points,
            weights: vec![1.0; 4],
            radii_mm: LayerRadii::TONE_2020,
        }
    }

    /// Where all layers of a fibre end in one plane, rounding left membranes of no thickness, and simplifying a solid
    /// with membranes moved whole facets: cladding and black overlapped by 1.2 mm³ in a bunny.
    #[test]
    fn layers_that_end_together_leave_no_membranes() {
        let tip = Socket { led: LedId(0), pattern: PatternId(1), position: DVec3::ZERO, axis: DVec3::Z };
        let sockets = Sockets::new(Hole { diameter_mm: 5.2, depth_mm: 8.0 }, vec![tip]);
        let fibres = vec![
            fibre(1, [1.625, 0.0, 0.0], [9.0, 7.0, 30.0]),
            fibre(2, [-1.1, 1.1, 0.0], [-12.0, 5.0, 24.0]),
            fibre(3, [-0.8, -1.4, 0.0], [2.0, -11.0, 27.0]),
        ];
        let grid = Grid::exact_in_f32(40.0);
        for chord_error in [0.05, 0.02, 0.01] {
            let led = &sweep_all(&Routes::new(fibres.clone()), &sockets, chord_error).unwrap()[0];
            for (inner, outer) in [(&led.core, &led.cladding), (&led.cladding, &led.black)] {
                let wall = outer.subtract([inner]).unwrap();
                assert_eq!(wall.components().unwrap().len(), 1, "chord error {chord_error}");
                let snapped = grid.snap_solid(&wall).unwrap();
                let overlap = snapped.intersect(inner).unwrap().volume();
                assert!(overlap < grid.step() * inner.surface_area(), "{overlap} mm³ at {chord_error}");
            }
        }
    }
}
