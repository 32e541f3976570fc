//! Fibres as tubes of points, and the colours of their loss.

use fibar_core::LedId;
use fibar_core::artefact::routes::Fibre;
use fibar_core::light::LightLaw;
use fibar_geometry::curve::Curve;
use fibar_geometry::optics::{Absorption, costliest_radius};
use fibar_picture::Drawing;
use fibar_picture::colour::{Colour, scale};
use fibar_plugin::StageError;
use glam::DVec3;

/// Distance between neighbouring points of a tube, at most, mm.
const SPACING_MM: f64 = 0.8;

/// Decibels per cm of an absorption of 1 per mm: `10·log10(e)·10`.
const DB_PER_CM: f64 = 43.429_448_190_325_18;

/// One fibre, sampled.
pub struct Tube {
    /// The LED that feeds it.
    pub led: LedId,
    /// Outer radius, mm.
    radius: f64,
    /// Places along its axis, mm, and the curvature there, 1/mm.
    places: Vec<(DVec3, f64)>,
}

impl Tube {
    /// Samples a fibre's axis.
    pub fn of(fibre: &Fibre) -> Result<Tube, StageError> {
        let curve = Curve::of_fibre(fibre)
            .map_err(|error| StageError::input(format!("fibre {}: {error}", fibre.id)))?;
        let at = |u: f64| {
            let jet = curve.jet(u);
            (jet.position, jet.curvature())
        };
        let breaks = curve.breaks();
        let inner = breaks.windows(2).flat_map(|span| {
            let points = (curve.length_between(span[0], span[1]) / SPACING_MM).clamp(1.0, 1e4).ceil();
            let (from, width) = (span[0], (span[1] - span[0]) / points);
            (0..points as u32).map(move |k| from + (f64::from(k) + 0.5) * width)
        });
        let (first, last) = curve.domain();
        let places = std::iter::once(first).chain(inner).chain(std::iter::once(last)).map(at).collect();
        Ok(Tube { led: fibre.led, radius: fibre.radii_mm.black, places })
    }

    /// Draws the fibre, coloured by its curvature.
    pub fn draw(&self, drawing: &mut Drawing, colour: impl Fn(f64) -> Colour) {
        let points: Vec<DVec3> = self.places.iter().map(|(point, _)| *point).collect();
        let colours: Vec<Colour> = self.places.iter().map(|(_, curvature)| colour(*curvature)).collect();
        drawing.tube(&points, self.radius, &colours);
    }
}

/// Colours for absorption, even in its logarithm, from a straight fibre's to that of the costliest bend.
pub struct LossScale {
    absorption: Absorption,
    straight: f64,
    costliest: f64,
}

impl LossScale {
    /// The scale for a law; one without a costliest radius ends at a bend of 10 mm.
    pub fn of(absorption: Absorption, law: LightLaw) -> LossScale {
        let radius = costliest_radius(law).unwrap_or(10.0);
        LossScale { absorption, straight: absorption.per_mm(0.0), costliest: absorption.per_mm(1.0 / radius) }
    }

    /// The colour of a place with this curvature, 1/mm.
    pub fn colour(&self, curvature: f64) -> Colour {
        let finite = if curvature.is_finite() { curvature } else { f64::MAX };
        let above = libm::log(self.absorption.per_mm(finite) / self.straight);
        scale(above / libm::log(self.costliest / self.straight))
    }

    /// What stands at either end of the scale.
    pub fn captions(&self) -> [String; 2] {
        [
            format!("straight, {:.2} dB/cm", self.straight * DB_PER_CM),
            format!("{:.1} dB/cm and more", self.costliest * DB_PER_CM),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fibar_core::material::LayerRadii;
    use fibar_core::{MarkerId, PatternId};

    fn loss_scale() -> LossScale {
        LossScale::of(Absorption::monotone(LightLaw::TONE_2020), LightLaw::TONE_2020)
    }

    #[test]
    fn the_scale_runs_from_straight_to_the_costliest_bend() {
        let colours = loss_scale();
        assert_eq!(colours.colour(0.0), scale(0.0));
        assert_eq!(colours.colour(f64::INFINITY), scale(1.0));
        assert_eq!(colours.colour(1.0), scale(1.0));
        let brightness = |radius: f64| colours.colour(1.0 / radius).iter().sum::<f64>();
        assert!([80.0, 51.0, 30.0, 20.0, 12.0].windows(2).all(|w| brightness(w[0]) < brightness(w[1])));
        assert_eq!(colours.captions(), ["straight, 0.96 dB/cm", "11.9 dB/cm and more"]);
    }

    #[test]
    fn a_tube_runs_from_end_to_end() {
        let points = [0.0, 10.0, 20.0, 40.0].map(|z| DVec3::Z * z).to_vec();
        let fibre = Fibre {
            id: 1,
            marker: MarkerId(1),
            led: LedId(0),
            pattern: PatternId(1),
            degree: 3,
            knots: vec![0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0],
            weights: vec![1.0; 4],
            points,
            radii_mm: LayerRadii::TONE_2020,
        };
        let tube = Tube::of(&fibre).unwrap();
        assert_eq!((tube.places[0].0, tube.places[tube.places.len() - 1].0), (DVec3::ZERO, DVec3::Z * 40.0));
        assert!(tube.places.iter().all(|(_, curvature)| curvature.abs() < 1e-9));
    }
}
