//! The paper's method written down plainly, to hold the fast one against: every sum over everything, no neighbour lists, no
//! threads, gradients by differences. Only the body's distance and the wall's field are shared; `wall.rs` tests those.

use crate::bundle::Bundle;
use crate::ends::Ends;
use crate::initial;
use crate::interior::Interior;
use crate::interior::tests::cuboid;
use crate::objective::Objective;
use crate::params::Params;
use crate::refine;
use crate::wall::Wall;
use fibar_core::{LedId, MarkerId, PatternId};
use glam::{DMat3, DVec3};

const HALF: DVec3 = DVec3::new(20.0, 20.0, 14.0);

type Chains = Vec<Vec<DVec3>>;

fn params() -> Params {
    Params {
        rounds: 4,
        moves: 120,
        iterations: 30,
        learning_rate_mm: 0.02,
        grid_mm: 2.0,
        ..Params::default()
    }
}

/// Four fibres of two patterns that cross.
fn ends() -> Vec<Ends> {
    let fibre = |pattern, x: f64, marker, at: DVec3, normal: DVec3| Ends {
        pattern: PatternId(pattern),
        led: LedId(pattern - 1),
        marker: MarkerId(marker),
        start: [-9.0, -6.5].map(|z| DVec3::new(x, 0.0, z)),
        finish: [at - 2.5 * normal, at],
    };
    vec![
        fibre(1, -4.0, 1, DVec3::new(20.0, 1.0, 3.0), DVec3::X),
        fibre(1, -4.0, 2, DVec3::new(8.0, 3.0, 14.0), DVec3::Z),
        fibre(2, 4.0, 3, DVec3::new(-20.0, -1.0, 3.0), -DVec3::X),
        fibre(2, 4.0, 4, DVec3::new(-8.0, -2.0, 14.0), DVec3::Z),
    ]
}

/// Points of other patterns than fibre `f`'s.
fn foreign(chains: &Chains, ends: &[Ends], f: usize) -> Vec<DVec3> {
    let others = chains.iter().zip(ends).filter(|(_, e)| e.pattern != ends[f].pattern);
    others.flat_map(|(chain, _)| chain.clone()).collect()
}

/// Insert midpoints, move all points at once, again.
fn initial_route(ends: &[Ends], interior: &Interior, params: &Params) -> Chains {
    let mut chains: Chains = ends.iter().map(|e| e.control_points().to_vec()).collect();
    for _ in 0..params.rounds {
        for chain in &mut chains {
            let mut finer = vec![chain[0], chain[1]];
            for k in 1..chain.len() - 2 {
                finer.push((chain[k] + chain[k + 1]) / 2.0);
                finer.push(chain[k + 1]);
            }
            finer.push(chain[chain.len() - 1]);
            *chain = finer;
        }
        for _ in 0..params.moves {
            let before = chains.clone();
            for (f, chain) in chains.iter_mut().enumerate() {
                let foreign = foreign(&before, ends, f);
                for k in 2..chain.len() - 2 {
                    let step = step(&before[f], k, &foreign, interior, params);
                    chain[k] = interior.keep_inside(before[f][k] + step);
                }
            }
        }
    }
    chains
}

/// `l + r + f + s` as in the comments of the paper's LaTeX source.
fn step(x: &[DVec3], k: usize, foreign: &[DVec3], interior: &Interior, params: &Params) -> DVec3 {
    let n = x.len();
    let section = (x[n - 2] - x[1]).length() / (n as f64 - 3.0);
    let (mut l, mut r, mut f) = (DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
    for j in [k - 1, k + 1] {
        let leg = x[j] - x[k];
        l += (leg.length() - section) * leg / leg.length();
        if let Some(centre) = circle(x[j - 1], x[j], x[j + 1]) {
            r += section * section * (x[k] - centre) / (x[k] - centre).length_squared();
        }
    }
    for other in foreign {
        if (x[k] - *other).length() < params.fibre_threshold_mm {
            f += (x[k] - *other) / (x[k] - *other).length();
        }
    }
    let (depth, inwards) = interior.depth(x[k]);
    let s = if depth < params.surface_threshold_mm { inwards } else { DVec3::ZERO };
    let sum =
        params.length_gain * l + params.bend_gain * r + params.fibre_step_mm * f + params.surface_step_mm * s;
    sum * (params.longest_move_mm / sum.length()).min(1.0)
}

/// Centre of the circle through three points: as far from each, and in their plane.
fn circle(a: DVec3, b: DVec3, c: DVec3) -> Option<DVec3> {
    let normal = (b - a).cross(c - a);
    if normal.length() < 1e-12 * (b - a).length() * (c - a).length() {
        return None;
    }
    let rows = DMat3::from_cols(b - a, c - a, normal.normalize()).transpose();
    let right = DVec3::new(
        (b.length_squared() - a.length_squared()) / 2.0,
        (c.length_squared() - a.length_squared()) / 2.0,
        normal.normalize().dot(a),
    );
    Some(rows.inverse() * right)
}

/// The whole objective.
fn objective(chains: &Chains, ends: &[Ends], wall: &Wall, params: &Params) -> f64 {
    let of_fibre = |f: usize| {
        let (x, law) = (&chains[f], params.light());
        let mut e_cam = 1.0;
        let (mut e_reg, mut e_fib, mut e_surf) = (0.0, 0.0, 0.0);
        for k in 1..x.len() - 1 {
            let legs = [(x[k] - x[k - 1]).length(), (x[k + 1] - x[k]).length()];
            let radius = circle(x[k - 1], x[k], x[k + 1]).map_or(f64::INFINITY, |c| (x[k] - c).length());
            let a = law.c1_per_mm + law.c2_per_mm * (-law.c3_per_mm * radius).exp();
            e_cam *= (-0.5 * (legs[0] + legs[1]) / 2.0 * a).exp();
            if k >= 2 && k + 2 < x.len() {
                let (uneven, width) = ((legs[0] - legs[1]).abs(), params.even_within_mm);
                e_reg += if uneven < width { uneven * uneven / (2.0 * width) } else { uneven - width / 2.0 };
            }
        }
        for point in x {
            e_surf += wall.sum_with_gradient(*point).0;
            e_fib += foreign(chains, ends, f)
                .iter()
                .map(|y| (-params.k6 * (*point - *y).length()).exp())
                .sum::<f64>();
        }
        (1.0 - e_cam) + params.k3 * e_fib + params.k4 * e_surf + params.k5 * e_reg
    };
    (0..chains.len()).map(of_fibre).sum()
}

/// Adam on the objective, its gradient by central differences; the best routes seen.
fn refined(start: Chains, ends: &[Ends], interior: &Interior, wall: &Wall, params: &Params) -> Chains {
    const STEP: f64 = 1e-5;
    let mut x = start.clone();
    let (mut best, mut least) = (start, f64::INFINITY);
    let zeros: Chains = x.iter().map(|chain| vec![DVec3::ZERO; chain.len()]).collect();
    let (mut m, mut v) = (zeros.clone(), zeros);
    for t in 0..=params.iterations {
        let value = objective(&x, ends, wall, params);
        if value < least {
            (best, least) = (x.clone(), value);
        }
        let here = x.clone();
        for (f, k) in (0..here.len()).flat_map(|f| (2..here[f].len() - 2).map(move |k| (f, k))) {
            for axis in 0..3 {
                let at = |step: f64| {
                    let mut moved = here.clone();
                    moved[f][k][axis] += step;
                    objective(&moved, ends, wall, params)
                };
                let slope = (at(STEP) - at(-STEP)) / (2.0 * STEP);
                m[f][k][axis] = 0.9 * m[f][k][axis] + 0.1 * slope;
                v[f][k][axis] = 0.999 * v[f][k][axis] + 0.001 * slope * slope;
                let mean = m[f][k][axis] / (1.0 - 0.9f64.powi(t as i32 + 1));
                let square = v[f][k][axis] / (1.0 - 0.999f64.powi(t as i32 + 1));
                x[f][k][axis] -= params.learning_rate_mm * mean / (square.sqrt() + 1e-8);
            }
            x[f][k] = interior.keep_inside(x[f][k]);
        }
    }
    best
}

fn furthest(chains: &Chains, bundle: &Bundle) -> f64 {
    chains.iter().flatten().zip(&bundle.points).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max)
}

#[test]
fn the_initial_route_is_the_plain_one() {
    let params = params();
    let interior = Interior::of(&cuboid(HALF), &params).unwrap();
    let fast = initial::route(ends(), &interior, &params, &mut |_| Ok(())).unwrap();
    let plain = initial_route(&ends(), &interior, &params);
    assert!(furthest(&plain, &fast) < 1e-7, "{} mm apart", furthest(&plain, &fast));
    let straight = initial_route(&ends(), &interior, &Params { moves: 0, ..params });
    assert!(furthest(&straight, &fast) > 1.0, "nothing moved");
}

#[test]
fn the_refined_route_is_the_plain_one() {
    let params = Params { rounds: 3, cut_off: 1e-12, least_gain: 0.0, ..params() };
    let body = cuboid(HALF);
    let interior = Interior::of(&body, &params).unwrap();
    let start = initial::route(ends(), &interior, &params, &mut |_| Ok(())).unwrap();
    let chains: Chains = start.chains().map(<[DVec3]>::to_vec).collect();
    let objective = Objective::of(&body, &interior, &params);
    let fast = refine::improve(start, &objective, &interior, &params, &mut |_| Ok(())).unwrap().best;
    let wall = Wall::of(&body, &interior, &params);
    let plain = refined(chains.clone(), &ends(), &interior, &wall, &params);
    assert!(furthest(&chains, &fast) > 0.1, "nothing moved");
    assert!(furthest(&plain, &fast) < 1e-4, "{} mm apart", furthest(&plain, &fast));
}
