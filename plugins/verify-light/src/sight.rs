//! One fibre's reach: by its own curve, by the light it shares, and against the bounds of its pair.

use crate::attenuation::Attenuation;
use crate::law::MonotoneLaw;
use fibar_core::artefact::bounds::Bounds;
use fibar_core::artefact::routes::Fibre;
use fibar_core::artefact::verdict::Place;
use fibar_core::light::CALIBRATED_RADIUS_MM;
use fibar_core::{LedId, MarkerId};
use fibar_ruler::curve::Curve;
use glam::DVec3;

/// One fibre's reach.
#[derive(Clone, Debug, PartialEq)]
pub struct Sight {
    /// Its number.
    pub fibre: u32,
    /// The LED that feeds it.
    pub led: LedId,
    /// The marker that it lights.
    pub marker: MarkerId,
    /// Where it ends, mm.
    pub end: DVec3,
    /// Reach by the monotone law, were it its LED's only fibre, mm.
    pub d_cam_mm: f64,
    /// Reach by the law as printed, mm.
    pub printed_d_cam_mm: f64,
    /// κ: its share of the LED's light, a centred core's being 1.
    pub coupling: f64,
    /// The bounds of its pair, where known.
    pub pair: Option<Pair>,
    /// What it loses on the way.
    pub attenuation: Attenuation,
}

/// What a fibre between the same LED and marker could reach, alone in the object, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    /// More than this none can.
    pub certified_mm: f64,
    /// The best one known; 0 if none is.
    pub best_mm: f64,
}

/// How far from a target a fibre may end and still be its fibre, mm.
const SAME_PLACE_MM: f64 = 1e-3;

impl Sight {
    /// Looks at one fibre as its LED's only one.
    pub fn of(fibre: &Fibre, curve: &Curve, law: &MonotoneLaw) -> Sight {
        let attenuation = Attenuation::along(curve, law);
        Sight {
            fibre: fibre.id,
            led: fibre.led,
            marker: fibre.marker,
            end: curve.end(),
            d_cam_mm: law.detection_distance(attenuation.monotone.value),
            printed_d_cam_mm: law.detection_distance(attenuation.printed),
            coupling: 1.0,
            pair: None,
            attenuation,
        }
    }

    /// Takes the bounds of the pair, if they are among those given.
    pub fn compare(&mut self, bounds: &Bounds) {
        let led = bounds.leds.iter().position(|led| *led == self.led);
        let nearest = bounds
            .targets
            .iter()
            .min_by(|a, b| a.position.distance(self.end).total_cmp(&b.position.distance(self.end)));
        let target = nearest.filter(|t| t.position.distance(self.end) <= SAME_PLACE_MM);
        self.pair = led.zip(target).map(|(led, target)| Pair {
            certified_mm: target.certified_mm[led],
            best_mm: target.best_mm[led],
        });
    }

    /// Reach with what the fibres of its LED leave it: `d_cam·√κ`, as d_cam goes with the root of the power (Tone 2020).
    pub fn coupled_d_cam_mm(&self) -> f64 {
        self.d_cam_mm * self.coupling.sqrt()
    }

    /// `d_cam` over that of the best curve known for the pair alone; none where none is known.
    pub fn bound_share(&self) -> Option<f64> {
        self.pair.filter(|p| p.best_mm > 0.0).map(|p| self.d_cam_mm / p.best_mm)
    }

    /// `d_cam` over the certified bound; more than 1 is impossible. A pair that is certified to be hopeless has a bound of a
    /// micrometre here, so that a fibre that brings light all the same shows.
    pub fn certified_share(&self) -> Option<f64> {
        const HOPELESS_MM: f64 = 1e-3;
        let possible = |p: &Pair| p.certified_mm > 0.0 || self.d_cam_mm > 0.0;
        self.pair.filter(possible).map(|p| self.d_cam_mm / p.certified_mm.max(HOPELESS_MM))
    }

    /// The fibre as a place of the verdict.
    pub fn place(&self) -> Place {
        let Attenuation { length_mm, tight_mm, .. } = self.attenuation;
        let pair = self.pair.map_or(String::new(), |p| {
            format!("; alone at best {:.1} mm, at most {:.1} mm", p.best_mm, p.certified_mm)
        });
        let what = format!(
            "fibre {}: LED {} to marker {}, {length_mm:.1} mm long, {tight_mm:.1} mm of it bent below \
             {CALIBRATED_RADIUS_MM} mm; {:.1} mm by the law as printed; {:.1} mm with {:.3} of a lone fibre's light{pair}",
            self.fibre,
            self.led,
            self.marker,
            self.printed_d_cam_mm,
            self.coupled_d_cam_mm(),
            self.coupling,
        );
        Place { position: self.end, value: self.d_cam_mm, what }
    }
}
