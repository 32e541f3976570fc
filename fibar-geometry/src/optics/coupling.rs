//! How the fibres of one LED share its light: κ, the power a fibre carries as a multiple of what the calibration's did.
//!
//! The law of light was measured with one fibre per LED, its core centred on the tip. An object feeds several from each, so
//! a marker is seen from `d_cam·√κ`. Notation, in this file: ρ off the LED's axis in the plane of its tip, `n(x)` the number
//! of cores over a point.
//!
//! ```text
//! beam    E(ρ) = cos^(m+3) θ,  θ = atan(ρ/D) for ρ ≤ dome and sin θ ≤ aperture, else 0
//!         m = ln ½ / ln cos θ½,  D = dome / tan θ½     a source behind the dome whose rim lies at half intensity
//! mouth   κ = ∫ E/n over the core's disc / ∫ E over a centred disc
//! trunk   cores that overlap at the same distance from the LED are one section: its light is the sum of theirs, at most one
//!         calibrated core's per core area (brightness does not rise), and its members take ∫ 1/n over their discs of it
//! ```
//!
//! So fibres that leave one point together get 1/n each, two branches of a trunk half each whatever they carry, and mouths side
//! by side each their own part of the beam. Not modelled: leaks between cores that run close without overlapping, and
//! crossings of fibres of one LED at different distances from it, where light mostly goes straight on.

use crate::curve::Curve;
use fibar_core::light::LedBeam;
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// Distance between the places along fibres at which their cores are compared, mm.
pub const STATION_MM: f64 = 0.25;

/// Points per disc in area sums; shares are good to about 1 %.
const NODES: usize = 200;

/// The beam in the plane of the LED's tip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beam {
    /// From the plane back to the virtual source, mm.
    source_mm: f64,
    /// Power of the cosine: `m + 3`.
    order: f64,
    /// Nothing enters a core further than this off the axis, mm.
    reach_mm: f64,
}

impl Beam {
    /// The beam of an LED, as cores with its numerical aperture see it.
    pub fn of(led: LedBeam) -> Beam {
        let half = led.half_angle_deg.to_radians();
        let source_mm = led.dome_radius_mm / libm::tan(half);
        let order = 3.0 + libm::log(0.5) / libm::log(libm::cos(half));
        let widest = libm::asin(led.numerical_aperture.clamp(0.0, 1.0));
        let guided = if widest < PI / 2.0 { source_mm * libm::tan(widest) } else { f64::INFINITY };
        Beam { source_mm, order, reach_mm: led.dome_radius_mm.min(guided) }
    }

    /// Irradiance a core can use at a place off the axis, 1 on it.
    pub fn irradiance(&self, place: DVec2) -> f64 {
        if place.length_squared() > self.reach_mm * self.reach_mm {
            return 0.0;
        }
        let tangent_squared = place.length_squared() / (self.source_mm * self.source_mm);
        libm::pow(1.0 + tangent_squared, -0.5 * self.order)
    }
}

/// The mouths of one LED's fibres: κ of each, were they never to meet again.
///
/// `mouths` are the axes' places in the plane of the tip, mm off the LED's axis.
pub fn mouth_couplings(beam: &Beam, core_radius: f64, mouths: &[DVec2]) -> Vec<f64> {
    let disc = Disc::of(core_radius);
    let alone = disc.sum(|node| beam.irradiance(node));
    let share = |k: usize| {
        disc.sum(|node| {
            let place = mouths[k] + node;
            beam.irradiance(place) / disc.count_over(place, mouths)
        }) / alone
    };
    (0..mouths.len()).map(share).collect()
}

/// κ of every fibre of one LED, mouths and trunks together.
///
/// `axes` holds each fibre's axis at every [`STATION_MM`] of its length ([`stations`]), `position` and `axis` are the socket's.
pub fn couplings(
    beam: &Beam,
    core_radius: f64,
    position: DVec3,
    axis: DVec3,
    axes: &[Vec<DVec3>],
) -> Vec<f64> {
    let (across, up) = axis.any_orthonormal_pair();
    let flat = |p: &DVec3| DVec2::new((*p - position).dot(across), (*p - position).dot(up));
    let mouths: Vec<DVec2> = axes.iter().filter_map(|axis| axis.first()).map(flat).collect();
    let mut powers = mouth_couplings(beam, core_radius, &mouths);
    let longest = axes.iter().map(Vec::len).max().unwrap_or(0);
    for station in 1..longest {
        for section in sections(axes, station, 2.0 * core_radius) {
            share_out(&section, axes, station, core_radius, &mut powers);
        }
    }
    powers
}

/// Places on a curve every [`STATION_MM`] from its start, mm; at least the start.
pub fn stations(curve: &Curve) -> Vec<DVec3> {
    const PARTS: u32 = 64;
    let mut places = vec![curve.point(curve.domain().0)];
    let (mut here, mut walked) = (places[0], 0.0);
    for span in curve.breaks().windows(2) {
        for k in 1..=PARTS {
            let next = curve.point(span[0] + (span[1] - span[0]) * f64::from(k) / f64::from(PARTS));
            let leg = here.distance(next);
            while places.len() as f64 * STATION_MM <= walked + leg && leg > 0.0 {
                let share = (places.len() as f64 * STATION_MM - walked) / leg;
                places.push(here.lerp(next, share));
            }
            (here, walked) = (next, walked + leg);
        }
    }
    places
}

/// Groups of two and more fibres whose cores overlap at a station, directly or by others between them.
fn sections(axes: &[Vec<DVec3>], station: usize, reach: f64) -> Vec<Vec<usize>> {
    let mut left: Vec<usize> = (0..axes.len()).filter(|&k| station < axes[k].len()).collect();
    let mut sections = Vec::new();
    while let Some(first) = left.pop() {
        let mut section = vec![first];
        let mut seen = 0;
        while seen < section.len() {
            let centre = axes[section[seen]][station];
            let near = |k: &mut usize| axes[*k][station].distance_squared(centre) < reach * reach;
            section.extend(left.extract_if(.., near));
            seen += 1;
        }
        if section.len() > 1 {
            section.sort_unstable();
            sections.push(section);
        }
    }
    sections
}

/// Mixes the light of one section and deals it to the members by area.
fn share_out(section: &[usize], axes: &[Vec<DVec3>], station: usize, core_radius: f64, powers: &mut [f64]) {
    let places = flatten(section, axes, station);
    let disc = Disc::of(core_radius);
    let area = |k: usize| disc.sum(|node| 1.0 / disc.count_over(places[k] + node, &places)) / NODES as f64;
    let areas: Vec<f64> = (0..places.len()).map(area).collect();
    let whole = areas.iter().fold(0.0, |sum, a| sum + a);
    let light = section.iter().fold(0.0, |sum, &k| sum + powers[k]).min(whole);
    for (&k, area) in section.iter().zip(&areas) {
        powers[k] = light * area / whole;
    }
}

/// The members' centres seen along their common direction, mm.
fn flatten(section: &[usize], axes: &[Vec<DVec3>], station: usize) -> Vec<DVec2> {
    let forward =
        section.iter().map(|&k| axes[k][station] - axes[k][station - 1]).fold(DVec3::ZERO, |a, b| a + b);
    let (across, up) = forward.try_normalize().unwrap_or(DVec3::Z).any_orthonormal_pair();
    let origin = axes[section[0]][station];
    let flat = |&k: &usize| {
        let arm = axes[k][station] - origin;
        DVec2::new(arm.dot(across), arm.dot(up))
    };
    section.iter().map(flat).collect()
}

/// A core's cross-section as points of equal area.
struct Disc {
    nodes: Vec<DVec2>,
    radius: f64,
}

impl Disc {
    /// Vogel's sunflower: evenly spread for any number of points.
    fn of(radius: f64) -> Disc {
        const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;
        let node = |k: usize| {
            let out = radius * ((k as f64 + 0.5) / NODES as f64).sqrt();
            let (sine, cosine) = libm::sincos(GOLDEN_ANGLE * k as f64);
            DVec2::new(cosine, sine) * out
        };
        Disc { nodes: (0..NODES).map(node).collect(), radius }
    }

    fn sum(&self, f: impl Fn(DVec2) -> f64) -> f64 {
        self.nodes.iter().fold(0.0, |sum, node| sum + f(*node))
    }

    /// How many discs lie over a place of one of them.
    fn count_over(&self, place: DVec2, centres: &[DVec2]) -> f64 {
        let reach = self.radius * self.radius * (1.0 + 1e-9);
        centres.iter().filter(|c| c.distance_squared(place) <= reach).count().max(1) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORE: f64 = 0.875;

    fn beam() -> Beam {
        Beam::of(LedBeam::TONE_2020)
    }

    /// κ of straight or broken axes from a socket at the origin, looking up.
    #[track_caller]
    fn check(axes: &[&[[f64; 3]]], expected: &[f64]) {
        let axis = |points: &&[[f64; 3]]| {
            let points: Vec<DVec3> = points.iter().map(|p| DVec3::from_array(*p)).collect();
            stations(&Curve::clamped_uniform(1, &points).unwrap())
        };
        let axes: Vec<Vec<DVec3>> = axes.iter().map(axis).collect();
        let found = couplings(&beam(), CORE, DVec3::ZERO, DVec3::Z, &axes);
        let near = found.iter().zip(expected).all(|(f, e)| (f - e).abs() < 0.02);
        assert!(near && found.len() == expected.len(), "{found:?} should be {expected:?}");
    }

    #[test]
    fn the_beam_has_half_its_intensity_at_the_rim_and_nothing_beside_the_dome() {
        let at = |x: f64| beam().irradiance(DVec2::X * x);
        assert_eq!((at(0.0), at(2.6)), (1.0, 0.0));
        let half = 7.5f64.to_radians();
        assert!((at(2.5 - 1e-12) - 0.5 * half.cos().powi(3)).abs() < 1e-9, "{}", at(2.5));
        let wide = Beam::of(LedBeam { half_angle_deg: 60.0, ..LedBeam::TONE_2020 });
        assert!(wide.irradiance(DVec2::X * 0.6) == 0.0, "steeper than a core guides");
    }

    #[test]
    fn one_centred_fibre_is_the_calibration() {
        check(&[&[[0.0; 3], [0.0, 0.0, 40.0]]], &[1.0]);
    }

    #[test]
    fn mouths_side_by_side_each_take_their_own_part() {
        let up = |x: f64, y: f64| [[x, y, 0.0], [x, y, 30.0]];
        let (left, right) = (up(-0.9, 0.0), up(0.9, 0.0));
        check(&[&left, &right], &[0.905, 0.905]);
        let far = up(1.625, 0.0);
        check(&[&far], &[0.748]);
    }

    #[test]
    fn fibres_that_leave_together_share_evenly() {
        let fan = |x: f64, y: f64| [[0.0; 3], [0.0, 0.0, 2.5], [x, y, 40.0]];
        let (a, b, c) = (fan(20.0, 0.0), fan(-10.0, 17.3), fan(-10.0, -17.3));
        check(&[&a, &b, &c], &[1.0 / 3.0; 3]);
    }

    #[test]
    fn a_trunk_deals_by_branches() {
        // One leaves at 5 mm; the other two stay together and part at 20 mm.
        let single = [[0.0; 3], [0.0, 0.0, 5.0], [30.0, 0.0, 20.0]];
        let pair = |y: f64| [[0.0; 3], [0.0, 0.0, 5.0], [-20.0, 0.0, 20.0], [-30.0, y, 30.0]];
        check(&[&single, &pair(10.0), &pair(-10.0)], &[0.5, 0.25, 0.25]);
    }

    #[test]
    fn merging_makes_no_brightness() {
        let merging = |x: f64| [[x, 0.0, 0.0], [0.0, 0.0, 10.0], [0.0, 0.0, 20.0], [20.0 * x, 0.0, 40.0]];
        check(&[&merging(-1.0), &merging(1.0)], &[0.5, 0.5]);
    }
}
