//! The LED's beam in the plane of its tip, as a core sees it.
//!
//! The beam is that of a point source behind the dome, placed so that its cone of half intensity leaves by the dome's rim. A
//! place ρ off the axis is seen by it at θ, `tan θ = (ρ/dome)·tan θ½`; intensity falls as `cos^m θ` with `cos^m θ½ = ½`, and
//! irradiance by `cos³ θ` more, for distance and slant. Beside the dome there is no light; steeper than its aperture a core
//! guides none.

use fibar_core::light::LedBeam;

/// The irradiance as a function of the distance from the axis.
#[derive(Clone, Copy, Debug)]
pub struct Beam {
    tan_per_mm: f64,
    half_log_cos: f64,
    /// No light further off the axis than this, mm.
    pub reach_mm: f64,
}

impl Beam {
    /// As the LED's profile says.
    pub fn of(led: &LedBeam) -> Beam {
        let half = led.half_angle_deg.to_radians();
        let tan_per_mm = libm::tan(half) / led.dome_radius_mm;
        let aperture = led.numerical_aperture;
        let steepest =
            if aperture < 1.0 { aperture / (1.0 - aperture * aperture).sqrt() } else { f64::INFINITY };
        Beam {
            tan_per_mm,
            half_log_cos: libm::log(libm::cos(half)),
            reach_mm: led.dome_radius_mm.min(steepest / tan_per_mm),
        }
    }

    /// Irradiance a distance off the axis, 1 on it.
    pub fn at(&self, off_axis_mm: f64) -> f64 {
        if off_axis_mm > self.reach_mm {
            return 0.0;
        }
        let cosine = libm::cos(libm::atan(off_axis_mm * self.tan_per_mm));
        let halvings = libm::log(cosine) / self.half_log_cos;
        libm::exp2(-halvings) * cosine * cosine * cosine
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_the_intensity_leaves_by_the_rim() {
        let beam = Beam::of(&LedBeam::TONE_2020);
        let cosine = libm::cos(7.5f64.to_radians());
        assert_eq!((beam.at(0.0), beam.at(2.51)), (1.0, 0.0));
        assert!((beam.at(2.5) - 0.5 * cosine * cosine * cosine).abs() < 1e-12);
    }

    #[test]
    fn a_wide_led_is_cut_by_the_aperture() {
        let beam = Beam::of(&LedBeam { half_angle_deg: 60.0, ..LedBeam::TONE_2020 });
        assert!((beam.reach_mm - 0.523).abs() < 1e-3, "{}", beam.reach_mm);
    }
}
