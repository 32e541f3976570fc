//! How much light each LED could bring to each site, as `bound-light` found, and how much of it is left when fibres share an LED.

use fibar_core::artefact::bounds::Bounds;
use fibar_core::artefact::sites::Sites;
use fibar_core::artefact::sockets::Sockets;
use fibar_plugin::StageError;

/// Light of an LED in units of what a single fibre in its middle takes: with more fibres than that each has less. Mouths side by side
/// under a dome of 5 mm, as the optics of `verify-light` have it.
const LED_LIGHT: f64 = 5.3;

/// From how far away a camera could see each site by each code, each fibre alone.
#[derive(Clone, Debug)]
pub struct Light {
    /// By site, then by code from 1; mm.
    reach_mm: Vec<Vec<f64>>,
    /// From how far away a marker should be seen, mm.
    goal_mm: f64,
}

impl Light {
    /// The bounds of all sites, which must be those that the bounds were made for.
    pub fn new(bounds: &Bounds, sockets: &Sockets, sites: &Sites, goal_mm: f64) -> Result<Light, StageError> {
        let mut by_code = vec![0; sockets.sockets.len()];
        for socket in &sockets.sockets {
            let place = bounds.leds.iter().position(|led| *led == socket.led);
            let strange =
                || StageError::input(format!("the bounds know nothing of LED {}", socket.led)).hint(HINT);
            by_code[socket.pattern.0 as usize - 1] = place.ok_or_else(strange)?;
        }
        let reach = |site: &fibar_core::artefact::sites::Site| {
            let strange = || {
                StageError::input("the bounds know nothing of a site")
                    .hint(HINT)
                    .place_mm(site.position.to_array())
            };
            let target = bounds.target_at(site.position).ok_or_else(strange)?;
            Ok(by_code.iter().map(|&led| target.best_mm[led]).collect())
        };
        let reach_mm = sites.sites.iter().map(reach).collect::<Result<_, StageError>>()?;
        Ok(Light { reach_mm, goal_mm })
    }

    /// The same for some of the sites.
    pub fn of(&self, sites: &[usize]) -> Light {
        Light { reach_mm: sites.iter().map(|&k| self.reach_mm[k].clone()).collect(), goal_mm: self.goal_mm }
    }

    /// How far a site falls short of the goal with a code that `crowd` markers share: 0 if it does not, 1 in the dark; squared, so
    /// that a dark marker counts more than two dim ones.
    pub fn shortage(&self, site: usize, code: u8, crowd: f64) -> f64 {
        let reach = self.reach_mm[site][usize::from(code) - 1] * (LED_LIGHT / crowd).min(1.0).sqrt();
        let short = (1.0 - reach / self.goal_mm).max(0.0);
        short * short
    }
}

const HINT: &str = "put bound-light between place-visibility, socket-led and this stage";

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::sites;
    use fibar_core::artefact::bounds::Target;
    use fibar_core::artefact::sockets::{Hole, Socket};
    use fibar_core::light::LightLaw;
    use fibar_core::{LedId, PatternId};
    use glam::DVec3;

    fn base() -> Sockets {
        let socket = |(led, pattern): (u32, u32)| Socket {
            led: LedId(led),
            pattern: PatternId(pattern),
            position: DVec3::X * f64::from(led),
            axis: DVec3::Z,
        };
        let hole = Hole { diameter_mm: 5.2, depth_mm: 8.6 };
        Sockets::new(hole, [(0, 2), (1, 1)].map(socket).to_vec())
    }

    fn bounds(sites: &Sites) -> Bounds {
        let target = |s: &fibar_core::artefact::sites::Site| Target {
            position: s.position,
            normal: s.normal,
            certified_mm: vec![900.0, 500.0],
            best_mm: vec![800.0, 400.0],
        };
        Bounds {
            format: "fibar.bounds/1".into(),
            law: LightLaw::TONE_2020,
            min_bend_radius_mm: 12.0,
            wall_mm: 0.0,
            arrival_tilt_deg: 0.0,
            leds: vec![LedId(0), LedId(1)],
            targets: sites.sites.iter().map(target).collect(),
        }
    }

    #[test]
    fn light_goes_by_the_led_that_blinks_the_code() {
        let sites = sites(2);
        let light = Light::new(&bounds(&sites), &base(), &sites, 1000.0).unwrap();
        let check = |code: u8, crowd: f64, expected: f64| {
            let found = light.shortage(3, code, crowd);
            assert!((found - expected).abs() < 1e-12, "{code} {crowd}: {found}");
        };
        check(1, 1.0, 0.36);
        check(2, 5.0, 0.04);
        check(2, 4.0 * LED_LIGHT, 0.36);
        assert_eq!(light.of(&[4]).shortage(0, 1, 1.0), light.shortage(4, 1, 1.0));
    }

    #[test]
    fn strange_bounds_are_refused() {
        let sites = sites(2);
        let check = |bounds: &Bounds, says: &str| {
            let error = Light::new(bounds, &base(), &sites, 1000.0).unwrap_err().to_string();
            assert!(error.contains(says), "{error:?} does not say {says:?}");
        };
        let good = bounds(&sites);
        check(&Bounds { leds: vec![LedId(0), LedId(5)], ..good.clone() }, "nothing of LED 1");
        check(&Bounds { targets: good.targets[1..].to_vec(), ..good }, "nothing of a site");
    }
}
