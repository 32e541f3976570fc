//! What the refinement minimises: `Σ_f (1 − E_cam) + k3·E_fib + k4·E_surf + k5·E_reg` (Tone 2020, "Route optimization").

use crate::bundle::Bundle;
use crate::foreign::Foreign;
use crate::interior::Interior;
use crate::params::Params;
use crate::wall::Wall;
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_core::light::LightLaw;
use fibar_geometry::optics::discrete::e_cam_with_gradient;
use glam::DVec3;
use rayon::prelude::*;

/// Slack of the neighbour lists; changes the time only.
const SLACK_MM: f64 = 1.5;

/// The objective of one body.
pub struct Objective<'a> {
    wall: Wall<'a>,
    light: LightLaw,
    params: &'a Params,
    /// Where the exponential of E_fib falls to the cut-off, mm.
    reach: f64,
}

/// The terms, not yet weighted, summed over the fibres.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Terms {
    /// `Σ (1 − E_cam)`.
    pub cam: f64,
    /// `Σ E_fib`; every pair of control points counts twice, once from either fibre.
    pub fib: f64,
    /// `Σ E_surf`.
    pub surf: f64,
    /// `Σ E_reg`, mm.
    pub reg: f64,
}

impl<'a> Objective<'a> {
    /// Prepares the wall's field.
    pub fn of(body: &TriangleMesh, interior: &'a Interior, params: &'a Params) -> Objective<'a> {
        let reach = -libm::log(params.cut_off) / params.k6;
        Objective { wall: Wall::of(body, interior, params), light: params.light(), params, reach }
    }

    /// Lists of neighbours for [`evaluate`](Self::evaluate), to be refreshed whenever the bundle has moved.
    pub fn foreign(&self, bundle: &Bundle) -> Foreign {
        Foreign::of(bundle, self.reach, SLACK_MM)
    }

    /// The terms, and the gradient of their weighted sum by every control point, per mm.
    pub fn evaluate(&self, bundle: &Bundle, foreign: &Foreign, gradient: &mut [DVec3]) -> Terms {
        let of_fibre = |(fibre, gradient): (usize, &mut [DVec3])| {
            gradient.fill(DVec3::ZERO);
            self.evaluate_fibre(bundle, foreign, fibre, gradient)
        };
        let fibres = gradient.par_chunks_mut(bundle.count).enumerate();
        let terms: Vec<Terms> = fibres.map(of_fibre).collect();
        terms.into_iter().fold(Terms::default(), Terms::plus)
    }

    /// The weighted sum.
    pub fn weigh(&self, terms: &Terms) -> f64 {
        let Params { k3, k4, k5, .. } = *self.params;
        terms.cam + k3 * terms.fib + k4 * terms.surf + k5 * terms.reg
    }

    fn evaluate_fibre(
        &self,
        bundle: &Bundle,
        foreign: &Foreign,
        fibre: usize,
        gradient: &mut [DVec3],
    ) -> Terms {
        let first = fibre * bundle.count;
        let points = &bundle.points[first..][..bundle.count];
        let fib = gradient.iter_mut().enumerate().fold(0.0, |total, (k, slope)| {
            let here = first + k;
            total + self.e_fib(&bundle.points, here, foreign.near(here), slope)
        });
        Terms {
            cam: 1.0 - e_cam_with_gradient(&self.light, points, -1.0, gradient),
            fib,
            surf: self.e_surf(points, gradient),
            reg: self.e_reg(points, gradient),
        }
    }

    /// A control point's share of E_fib; the slope holds the other fibres' share of the same pairs, too.
    fn e_fib(&self, points: &[DVec3], here: usize, others: &[u32], slope: &mut DVec3) -> f64 {
        let (decay, square) = (self.params.k6, self.reach * self.reach);
        let twice = 2.0 * self.params.k3 * decay;
        others.iter().fold(0.0, |total, &other| {
            let arm = points[here] - points[other as usize];
            let distance = arm.length_squared();
            if distance >= square {
                return total;
            }
            let distance = distance.sqrt();
            let value = libm::exp(-decay * distance);
            *slope -= twice * value / distance.max(1e-9) * arm;
            total + value
        })
    }

    fn e_surf(&self, points: &[DVec3], gradient: &mut [DVec3]) -> f64 {
        points.iter().zip(gradient).fold(0.0, |total, (point, slope)| {
            let (sum, by_place) = self.wall.sum_with_gradient(*point);
            *slope += self.params.k4 * by_place;
            total + sum
        })
    }

    fn e_reg(&self, points: &[DVec3], gradient: &mut [DVec3]) -> f64 {
        let mut total = 0.0;
        let counted = if self.params.even_out_ends { 0..points.len() - 2 } else { 1..points.len() - 3 };
        for k in counted {
            let legs = [points[k + 1] - points[k], points[k + 2] - points[k + 1]];
            let (value, slope) = unevenness(legs[0].length() - legs[1].length(), self.params.even_within_mm);
            let [u, v] = legs.map(|leg| self.params.k5 * slope * leg.normalize_or_zero());
            gradient[k] -= u;
            gradient[k + 1] += u + v;
            gradient[k + 2] -= v;
            total += value;
        }
        total
    }
}

/// `|x|` and its derivative, the crease rounded off within `width` (Huber 1964); at most `width / 2` below `|x|`.
fn unevenness(x: f64, width: f64) -> (f64, f64) {
    if x.abs() < width {
        (0.5 * x * x / width, x / width)
    } else {
        (x.abs() - 0.5 * width, if x == 0.0 { 0.0 } else { x.signum() })
    }
}

impl Terms {
    fn plus(self, other: Terms) -> Terms {
        Terms {
            cam: self.cam + other.cam,
            fib: self.fib + other.fib,
            surf: self.surf + other.surf,
            reg: self.reg + other.reg,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ends::Ends;
    use crate::interior::tests::cuboid;
    use fibar_core::{LedId, MarkerId, PatternId};

    /// Three wavy fibres of two patterns that come close to each other and to the wall.
    fn bundle() -> Bundle {
        let ends = |pattern, marker| Ends {
            pattern: PatternId(pattern),
            led: LedId(pattern - 1),
            marker: MarkerId(marker),
            start: [DVec3::ZERO; 2],
            finish: [DVec3::ZERO; 2],
        };
        let at = |fibre: f64, k: f64| {
            DVec3::new(3.0 * fibre + 2.0 * (0.9 * k).sin(), 3.0 * (0.7 * k + fibre).cos(), 2.2 * k - 9.0)
        };
        let points = (0..27).map(|n| at(f64::from(n / 9), f64::from(n % 9))).collect();
        Bundle { ends: vec![ends(1, 1), ends(1, 2), ends(2, 3)], points, count: 9 }
    }

    fn check(params: Params) {
        let body = cuboid(DVec3::new(11.0, 7.0, 11.0));
        let interior = Interior::of(&body, &params).unwrap();
        let objective = Objective::of(&body, &interior, &params);
        let bundle = bundle();
        let mut gradient = vec![DVec3::ZERO; bundle.points.len()];
        objective.evaluate(&bundle, &objective.foreign(&bundle), &mut gradient);
        let value = |points: Vec<DVec3>| {
            let moved = Bundle { points, ..bundle.clone() };
            let foreign = objective.foreign(&moved);
            objective.weigh(&objective.evaluate(&moved, &foreign, &mut vec![DVec3::ZERO; 27]))
        };
        for (k, axis) in (0..27).flat_map(|k| DVec3::AXES.map(|axis| (k, axis))) {
            let at = |step: f64| {
                let mut points = bundle.points.clone();
                points[k] += step * axis;
                value(points)
            };
            let difference = (at(1e-5) - at(-1e-5)) / 2e-5;
            let error = (gradient[k].dot(axis) - difference).abs();
            assert!(
                error < 1e-5 * (1.0 + difference.abs()),
                "{k}, {axis}: {} is not {difference}",
                gradient[k]
            );
        }
    }

    #[test]
    fn every_gradient_is_that_of_finite_differences() {
        let none = Params { k3: 0.0, k4: 0.0, k5: 0.0, cut_off: 1e-12, grid_mm: 3.0, ..Params::default() };
        check(none.clone());
        check(Params { k3: 1.5, ..none.clone() });
        check(Params { k4: 0.5, ..none.clone() });
        check(Params { k5: 1.0, ..none.clone() });
        check(Params { k5: 1.0, even_within_mm: 0.0, ..none });
        check(Params { cut_off: 1e-12, grid_mm: 3.0, ..Params::default() });
    }

    #[test]
    fn e_fib_is_the_plain_double_sum_of_the_paper() {
        let params = Params { cut_off: 1e-12, grid_mm: 3.0, ..Params::default() };
        let body = cuboid(DVec3::splat(20.0));
        let interior = Interior::of(&body, &params).unwrap();
        let objective = Objective::of(&body, &interior, &params);
        let bundle = bundle();
        let terms = objective.evaluate(&bundle, &objective.foreign(&bundle), &mut vec![DVec3::ZERO; 27]);
        let pairs = (0..27)
            .flat_map(|a| (0..27).map(move |b| (a, b)))
            .filter(|&(a, b)| bundle.pattern(a) != bundle.pattern(b));
        let plain: f64 = pairs.map(|(a, b)| (-1.5 * bundle.points[a].distance(bundle.points[b])).exp()).sum();
        assert!((terms.fib - plain).abs() < 1e-9, "{} is not {plain}", terms.fib);
    }
}
