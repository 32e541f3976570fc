//! The whole stage on small bodies, and the shapes the unit tests share.

use super::*;
use fibar_core::artefact::sockets::{Hole, Socket};
use fibar_core::{LedId, PatternId};
use fibar_geometry::viewsphere::{Polyhedron, geodesic_mesh};
use params::{Along, Order, Region};

/// A box from the origin, mm.
pub fn box_mesh(size: DVec3) -> TriangleMesh {
    let bit = |k: u32, n: u32| f64::from(k >> n & 1);
    let vertices = (0..8).map(|k| DVec3::new(bit(k, 0), bit(k, 1), bit(k, 2)) * size).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
    TriangleMesh { vertices, triangles }
}

/// A sphere on the plane z = 0, mm.
fn ball(radius: f64, frequency: u32) -> TriangleMesh {
    let mut mesh = geodesic_mesh(Polyhedron::Icosahedron, frequency);
    mesh.vertices.iter_mut().for_each(|v| *v = (*v + DVec3::Z) * radius);
    mesh
}

pub fn samples_of(mesh: &TriangleMesh, count: usize) -> Vec<SurfaceSample> {
    sample_surface(mesh, count, 0.7, &mut ChaCha8Rng::seed_from_u64(3))
}

fn led_at(z: f64) -> Sockets {
    let socket = Socket { led: LedId(0), pattern: PatternId(1), position: DVec3::Z * z, axis: DVec3::Z };
    Sockets::new(Hole { diameter_mm: 5.2, depth_mm: z }, vec![socket])
}

fn params(change: impl Fn(&mut Params)) -> Params {
    let mut params = Params { samples: 3000, frequency: 2, spacing_mm: 16.0, ..Params::default() };
    change(&mut params);
    params
}

fn run(body: &TriangleMesh, params: &Params) -> Result<Sites, StageError> {
    let parts = ForbiddenParts::find(&[], None, body)?;
    place(body, &led_at(8.6), parts, params, 1, &mut |_, _| Ok(())).map(|placed| placed.sites)
}

#[test]
fn a_ball_is_seen_alike_from_all_sides() {
    let all = params(|p| p.rise_mm = 0.0);
    let sites = run(&ball(40.0, 12), &all).unwrap();
    assert_eq!(Sites::from_json(&sites.to_json()), Ok(sites.clone()));
    // On a sphere of radius R seen from distance D, a viewpoint sees the cap up to acos(R / D) from its own direction.
    let (radius, distance, n) = (40.0, 1000.0, 4000);
    let edge = libm::acos(radius / distance);
    let ring = |k: usize| {
        let polar = (k as f64 + 0.5) / n as f64 * edge;
        let incidence = std::f64::consts::PI
            - libm::atan2(distance * libm::sin(polar), distance * libm::cos(polar) - radius);
        incidence * libm::sin(polar) / 2.0 * edge / n as f64
    };
    let expected = 122.0 * (0..n).map(ring).sum::<f64>();
    for site in &sites.sites {
        assert!(
            (site.suitability_rad / expected - 1.0).abs() < 0.05,
            "{} ≠ {expected}",
            site.suitability_rad
        );
    }
}

#[test]
fn candidates_keep_their_distance_and_cover_the_surface() {
    let least = [
        (Along::Surface, Order::Random, 20),
        (Along::Straight, Order::Random, 20),
        (Along::Surface, Order::BestFirst, 35),
        (Along::Straight, Order::BestFirst, 35),
    ];
    for (along, order, least) in least {
        let params = params(|p| (p.spacing_along, p.order) = (along, order));
        let sites = run(&ball(40.0, 12), &params).unwrap().sites;
        let gap = |a: &Site, b: &Site| a.position.distance(b.position);
        for (k, site) in sites.iter().enumerate() {
            let nearest = sites[..k].iter().map(|other| gap(site, other)).fold(f64::INFINITY, f64::min);
            assert!(nearest > 15.0, "{along:?}: {nearest}");
            assert!(site.position.z >= 16.6);
        }
        // 15 934 mm² of the ball are high enough; discs 16 mm apart could not be more than 72 on it.
        assert!((least..72).contains(&sites.len()), "{along:?} {order:?}: {}", sites.len());
    }
}

#[test]
fn coarse_and_fine_meshes_agree() {
    let summary = |frequency| {
        let sites = run(&ball(40.0, frequency), &params(|p| (p.samples, p.order) = (8000, Order::BestFirst)))
            .unwrap()
            .sites;
        let total: f64 = sites.iter().map(|s| s.suitability_rad).sum();
        (sites.len() as f64, total / sites.len() as f64)
    };
    let ((coarse, s_coarse), (fine, s_fine)) = (summary(8), summary(40));
    assert!((coarse / fine - 1.0).abs() < 0.05, "{coarse} {fine}");
    assert!((s_coarse / s_fine - 1.0).abs() < 0.05, "{s_coarse} {s_fine}");
}

#[test]
fn the_bunny_is_the_same_coarse_and_fine() {
    let coarse = bunny();
    let fine = halve_edges(&halve_edges(&coarse));
    let summary = |body: &TriangleMesh| {
        let sites = run(body, &params(|p| (p.samples, p.order) = (10_000, Order::BestFirst))).unwrap().sites;
        let total: f64 = sites.iter().map(|s| s.suitability_rad).sum();
        (sites.len() as f64, total / sites.len() as f64)
    };
    let ((count, s), (fine_count, fine_s)) = (summary(&coarse), summary(&fine));
    assert_eq!(fine.triangles.len(), 16 * coarse.triangles.len());
    assert!((count / fine_count - 1.0).abs() < 0.05, "{count} {fine_count}");
    assert!((s / fine_s - 1.0).abs() < 0.05, "{s} {fine_s}");
}

/// The recipe's bunny on its belly, mm.
fn bunny() -> TriangleMesh {
    let text = include_str!("../../../recipes/objects/stanford-bunny.obj");
    let mut mesh = TriangleMesh::default();
    for line in text.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let [x, y, z] = std::array::from_fn(|_| words.next().unwrap().parse::<f64>().unwrap());
                mesh.vertices.push(DVec3::new(x, -z, y));
            }
            Some("f") => {
                let corner = |w: &str| w.split('/').next().unwrap().parse::<u32>().unwrap() - 1;
                mesh.triangles.push(std::array::from_fn(|_| corner(words.next().unwrap())));
            }
            _ => (),
        }
    }
    let (low, high) = mesh.bounds().unwrap();
    let scale = 148.0 / (high.z - low.z);
    mesh.vertices.iter_mut().for_each(|v| *v = (*v - low.with_x(0.0).with_y(0.0)) * scale);
    mesh
}

/// The same surface with four triangles for each one.
fn halve_edges(mesh: &TriangleMesh) -> TriangleMesh {
    let mut fine = TriangleMesh { vertices: mesh.vertices.clone(), triangles: Vec::new() };
    let mut middles = std::collections::BTreeMap::new();
    for &[a, b, c] in &mesh.triangles {
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                fine.vertices.push((mesh.vertices[a as usize] + mesh.vertices[b as usize]) / 2.0);
                fine.vertices.len() as u32 - 1
            })
        };
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        fine.triangles.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
    }
    fine
}

#[test]
fn views_agree_with_the_formula_of_a_convex_body() {
    let sites = run(&ball(40.0, 12), &params(|p| p.emission_limit_deg = 50.0)).unwrap();
    assert_eq!(sites.views.len(), 122);
    for view in &sites.views {
        for (k, site) in (0..).zip(&sites.sites) {
            let angle = (view.position - site.position).angle_between(site.normal).to_degrees();
            if (angle - 50.0).abs() > 1e-6 {
                assert_eq!(view.visible.contains(&k), angle < 50.0, "{angle}");
            }
        }
    }
}

#[test]
fn no_marker_where_no_fibre_can_arrive() {
    let check = |body: TriangleMesh, params: Params, allowed: fn(DVec3) -> bool| {
        let sites = run(&body, &params).unwrap().sites;
        let strangers: Vec<DVec3> = sites.iter().map(|s| s.position).filter(|p| !allowed(*p)).collect();
        assert_eq!(strangers, []);
    };
    let tall = || box_mesh(DVec3::new(60.0, 60.0, 80.0));
    check(tall(), params(|_| ()), |p| p.z >= 16.6);
    check(tall(), params(|p| p.rise_mm = 30.0), |p| p.z >= 38.6);
    let region = Region { low_mm: [-1.0, -1.0, 0.0], high_mm: [61.0, 61.0, 70.0] };
    check(tall(), params(|p| p.keep_out = vec![region]), |p| p.z > 70.0);
    // A plate 6 mm thin keeps only its rim, where the inward normal runs along it.
    check(box_mesh(DVec3::new(90.0, 6.0, 90.0)), params(|p| p.spacing_mm = 9.0), |p| {
        p.y > 0.001 && p.y < 5.999
    });
    // Its rim has no room left for a fibre's end 4.4 mm thin.
    let error = run(&box_mesh(DVec3::new(90.0, 4.4, 90.0)), &params(|_| ())).unwrap_err();
    assert!(error.to_string().contains("a fibre can arrive nowhere"), "{error}");
}

#[test]
fn errors_say_what_is_wrong() {
    let check = |body: TriangleMesh, params: Params, says: &str| {
        let error = run(&body, &params).unwrap_err().to_string();
        assert!(error.contains(says), "{error:?} does not say {says:?}");
    };
    check(ball(40.0, 6), params(|p| p.spacing_mm = 500.0), "only 1 candidate places are 500 mm apart");
    check(ball(40.0, 6), params(|p| p.view_distance_mm = 50.0), "would lie inside it");
    check(ball(40.0, 6), params(|p| p.rise_mm = 500.0), "100 % of it lies lower than 508.6 mm");
    check(TriangleMesh::default(), params(|_| ()), "the body is empty");
    let mut inside_out = ball(40.0, 6);
    inside_out.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    check(inside_out, params(|p| p.thickness_mm = 0.0), "visible from any viewpoint");
}

#[test]
fn same_bytes_for_any_thread_count() {
    let bytes = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| run(&ball(40.0, 6), &params(|_| ())).unwrap().to_json())
    };
    assert_eq!(bytes(1), bytes(3));
}
