//! The paper's choice of candidates: places whose suitability is greatest around (Tone 2020, "Marker placement").

use crate::params::{Order, Params};
use crate::surface::Neighbourhood;
use fibar_geometry::sampling::SurfaceSample;
use rand::seq::SliceRandom;

/// Indices of the candidates, most suitable first. `grain` is the side of the square that a sample stands for, mm.
///
/// All samples with `s > 0` are listed. They are visited in random order (the paper's) or best first; one that is still
/// listed strikes out every listed place within the spacing whose `s` is smaller. Of exactly equal places the first counts
/// as better: the paper does not say, and would keep both however close they are.
pub fn select_candidates(
    samples: &[SurfaceSample],
    suitability: &[f64],
    grain: f64,
    params: &Params,
    rng: &mut impl rand::Rng,
) -> Vec<usize> {
    let best_first = |a: &usize, b: &usize| suitability[*b].total_cmp(&suitability[*a]).then(a.cmp(b));
    let mut listed: Vec<bool> = suitability.iter().map(|&s| s > 0.0).collect();
    let mut order: Vec<usize> = (0..samples.len()).filter(|&k| listed[k]).collect();
    match params.order {
        Order::Random => order.shuffle(rng),
        Order::BestFirst => order.sort_by(best_first),
    }
    let mut neighbourhood = Neighbourhood::new(samples, grain, params.spacing_mm, params.spacing_along);
    for &here in &order {
        if listed[here] {
            for other in neighbourhood.around(here) {
                listed[other] &= best_first(&here, &other).is_gt();
            }
        }
    }
    order.retain(|&k| listed[k]);
    order.sort_by(best_first);
    order
}
