//! Refinement of the routes by Adam, keeping the best that was seen.

use crate::adam::Adam;
use crate::bundle::{Bundle, FIXED};
use crate::history::{Entry, History};
use crate::interior::Interior;
use crate::objective::{Objective, Terms};
use crate::params::Params;
use fibar_plugin::StageError;
use glam::DVec3;
use rayon::prelude::*;

/// The outcome.
pub struct Refined {
    /// The routes of the least objective seen.
    pub best: Bundle,
    /// The terms on the way.
    pub history: History,
}

/// Takes Adam's steps until the objective has not gained for `patience` iterations, or the iterations are used up. The end
/// pieces stay, and the guard keeps the rest inside.
pub fn improve(
    start: Bundle,
    objective: &Objective,
    interior: &Interior,
    params: &Params,
    report: &mut dyn FnMut(f64) -> Result<(), StageError>,
) -> Result<Refined, StageError> {
    let mut bundle = start.clone();
    let mut best = start;
    let mut history = History::default();
    let mut adam = Adam::of(bundle.points.len());
    let mut gradient = vec![DVec3::ZERO; bundle.points.len()];
    let mut foreign = objective.foreign(&bundle);
    for iteration in 0..=params.iterations {
        foreign.refresh(&bundle);
        let terms = objective.evaluate(&bundle, &foreign, &mut gradient);
        if history.add(entry(&terms, objective, &bundle), params.least_gain) {
            best.points.clone_from(&bundle.points);
        }
        if history.since_gain() >= params.patience as usize {
            break;
        }
        let done = f64::from(iteration) / f64::from(params.iterations.max(1));
        hold_ends(&mut gradient, bundle.count);
        follow(&mut bundle, &adam.step(&gradient, params.learning_rate_mm), interior);
        report(done)?;
    }
    Ok(Refined { best, history })
}

fn entry(terms: &Terms, objective: &Objective, bundle: &Bundle) -> Entry {
    let mean_e_cam = 1.0 - terms.cam / bundle.ends.len() as f64;
    Entry { terms: *terms, objective: objective.weigh(terms), mean_e_cam }
}

fn hold_ends(gradient: &mut [DVec3], count: usize) {
    for chain in gradient.chunks_mut(count) {
        chain[..FIXED].fill(DVec3::ZERO);
        chain[count - FIXED..].fill(DVec3::ZERO);
    }
}

fn follow(bundle: &mut Bundle, steps: &[DVec3], interior: &Interior) {
    let count = bundle.count;
    bundle.points.par_chunks_mut(count).zip(steps.par_chunks(count)).for_each(|(chain, steps)| {
        for k in FIXED..count - FIXED {
            chain[k] = interior.keep_inside(chain[k] + steps[k]);
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ends::Ends;
    use crate::initial;
    use crate::interior::tests::cuboid;
    use fibar_core::{LedId, MarkerId, PatternId};

    const HALF: DVec3 = DVec3::new(30.0, 30.0, 20.0);

    /// Two LEDs below; their fibres cross on the way to markers on the opposite sides and the top.
    fn ends() -> Vec<Ends> {
        let fibre = |pattern, x: f64, marker, at: DVec3, normal: DVec3| Ends {
            pattern: PatternId(pattern),
            led: LedId(pattern - 1),
            marker: MarkerId(marker),
            start: [-12.0, -9.5].map(|z| DVec3::new(x, 0.0, z)),
            finish: [at - 2.5 * normal, at],
        };
        vec![
            fibre(1, -7.0, 1, DVec3::new(30.0, 1.0, 5.0), DVec3::X),
            fibre(1, -7.0, 2, DVec3::new(12.0, 3.0, 20.0), DVec3::Z),
            fibre(2, 7.0, 3, DVec3::new(-30.0, -1.0, 5.0), -DVec3::X),
            fibre(2, 7.0, 4, DVec3::new(-12.0, -3.0, 20.0), DVec3::Z),
        ]
    }

    fn refined(params: &Params) -> (Bundle, Refined) {
        let body = cuboid(HALF);
        let interior = Interior::of(&body, params).unwrap();
        let start = initial::route(ends(), &interior, params, &mut |_| Ok(())).unwrap();
        let objective = Objective::of(&body, &interior, params);
        (start.clone(), improve(start, &objective, &interior, params, &mut |_| Ok(())).unwrap())
    }

    fn params() -> Params {
        Params { moves: 300, iterations: 300, learning_rate_mm: 0.03, grid_mm: 2.0, ..Params::default() }
    }

    #[test]
    fn routes_get_better_keep_their_ends_and_stay_inside() {
        let (start, Refined { best, history }) = refined(&params());
        assert!(history.best().objective < history.first().objective - 0.1);
        assert!(history.best().mean_e_cam > history.first().mean_e_cam);
        assert_eq!(best.count, 35);
        for (bundle, chain, ends) in
            [&start, &best].into_iter().flat_map(|b| b.chains().zip(&b.ends).map(move |(c, e)| (b, c, e)))
        {
            assert_eq!([chain[0], chain[1], chain[33], chain[34]], ends.control_points());
            let inside = chain[..34].iter().all(|p| (HALF - p.abs()).min_element() > 0.9);
            assert!(inside, "{:?} leaves the box: {chain:?}", bundle.ends);
        }
    }

    #[test]
    fn fibres_of_different_patterns_part() {
        let closest = |bundle: &Bundle| {
            let (a, b) = bundle.points.split_at(70);
            a.iter().flat_map(|p| b.iter().map(|q| p.distance(*q))).fold(f64::INFINITY, f64::min)
        };
        let (start, Refined { best, .. }) = refined(&params());
        assert!(closest(&start) > 3.0 && closest(&best) > 3.0, "{} {}", closest(&start), closest(&best));
    }

    #[test]
    fn threads_change_no_bit() {
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| refined(&params()).1)
        };
        let (one, three) = (on(1), on(3));
        assert_eq!(one.best, three.best);
        assert_eq!(one.history.to_csv(), three.history.to_csv());
    }

    #[test]
    fn patience_ends_the_run() {
        let impatient = Params { patience: 5, least_gain: 0.5, ..params() };
        assert_eq!(refined(&impatient).1.history.iterations(), 5);
        assert_eq!(refined(&Params { iterations: 0, ..params() }).1.history.iterations(), 0);
    }
}
