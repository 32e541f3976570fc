//! Which surfaces each wall lies between.
//!
//! - Cladding of an LED: from its core's surface to that surface of the cladding which is not the core's.
//! - Black of an LED: from the cladding's surface, likewise without the core's, to that surface of the black which is not
//!   the cladding's.
//! - Skin: from the object's surface to anything that is not skin.
//!
//! So a wall cut thin by another fibre, by a hole or by the skin counts as thin, and a core laid bare has no wall. Fibres of
//! one LED that merge need no exception: what is inside of both is not a surface. Cladding and black stop at the ends of
//! the fibres, so near those they are not measured; the skin is measured everywhere.

use crate::part::{Object, Part};
use crate::wall::{Wall, thinnest};
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_core::material::Role;
use fibar_ruler::bvh::Bvh;
use fibar_ruler::contact::Triangle;

/// The thinnest walls of one role, one per solid that has any, thinnest first.
pub struct RoleWalls {
    /// The role.
    pub role: Role,
    /// Name of the solid, and its thinnest wall.
    pub walls: Vec<(String, Wall)>,
}

/// A triangle with every corner and its middle this near to a surface lies on it, mm.
const ON_SURFACE_MM: f64 = 2e-4;
/// Triangles are cut down to this before those near a fibre's end are left out, mm.
const PIECE_MM: f64 = 0.75;

/// Measures all roles that have walls.
pub fn measure(object: &Object, end_zone_mm: f64) -> Vec<RoleWalls> {
    let cladding = walls_around(object, Role::Core, Role::Cladding, end_zone_mm);
    let black = walls_around(object, Role::Cladding, Role::Black, end_zone_mm);
    vec![cladding, black, skin(object)]
}

/// Walls of `outer` around `inner`, LED by LED.
fn walls_around(object: &Object, inner: Role, outer: Role, end_zone_mm: f64) -> RoleWalls {
    let of_led = |role: Role, part: &Part| object.of_role(role).find(|other| other.led == part.led);
    let wall = |part: &Part| {
        let core = of_led(Role::Core, part).map(|core| Bvh::of(&triangles(&core.mesh)));
        let mut inside = triangles(&of_led(inner, part)?.mesh);
        if inner != Role::Core {
            inside = off_surface(inside, core.as_ref());
        }
        let outside = off_surface(triangles(&part.mesh), Some(&Bvh::of(&inside)));
        let pieces = inside.iter().flat_map(|t| cut(*t));
        let away =
            pieces.filter(|piece| object.fibre_ends.iter().all(|end| !is_near(piece, *end, end_zone_mm)));
        Some((part.name.clone(), thinnest(&away.collect::<Vec<_>>(), &Bvh::of(&outside))?))
    };
    sorted(outer, object.of_role(outer).filter_map(wall).collect())
}

/// From the object's surface to anything but skin. The skin is one solid, so its wall is named by what comes nearest.
fn skin(object: &Object) -> RoleWalls {
    let surface = Bvh::of(&triangles(&object.body));
    let others = object.parts.iter().filter(|part| part.role != Role::Skin);
    let wall =
        |part: &Part| Some((format!("skin over {}", part.name), thinnest(&triangles(&part.mesh), &surface)?));
    sorted(Role::Skin, others.filter_map(wall).collect())
}

/// The least distances between the outer surfaces of fibres of two LEDs, one per pair, nearest first; pairs further apart than a
/// wall is looked for are left out.
pub fn bridges(object: &Object) -> Vec<(String, Wall)> {
    let outer: Vec<&Part> = object.of_role(Role::Black).collect();
    let trees: Vec<Bvh> = outer.iter().map(|part| Bvh::of(&triangles(&part.mesh))).collect();
    let bridge = |(k, j): (usize, usize)| {
        let name = format!("{} and {}", outer[j].name, outer[k].name);
        Some((name, thinnest(&triangles(&outer[k].mesh), &trees[j])?))
    };
    let pairs = (0..outer.len()).flat_map(|k| (0..k).map(move |j| (k, j)));
    sorted(Role::Black, pairs.filter_map(bridge).collect()).walls
}

fn sorted(role: Role, mut walls: Vec<(String, Wall)>) -> RoleWalls {
    walls.sort_by(|a, b| a.1.thickness.total_cmp(&b.1.thickness).then_with(|| a.0.cmp(&b.0)));
    RoleWalls { role, walls }
}

fn triangles(mesh: &TriangleMesh) -> Vec<Triangle> {
    (0..mesh.triangles.len()).map(|t| mesh.corners(t)).collect()
}

/// Those that do not lie on a surface.
fn off_surface(triangles: Vec<Triangle>, surface: Option<&Bvh>) -> Vec<Triangle> {
    let Some(surface) = surface else { return triangles };
    let touches = |point| surface.nearest(&point, ON_SURFACE_MM).is_some();
    let lies_on = |&[a, b, c]: &Triangle| [(a + b + c) / 3.0, a, b, c].into_iter().all(touches);
    triangles.into_iter().filter(|t| !lies_on(t)).collect()
}

fn is_near(piece: &Triangle, point: glam::DVec3, distance: f64) -> bool {
    fibar_ruler::contact::nearest_on_triangle(point, piece).0.distance_squared(point) < distance * distance
}

/// A triangle in pieces with no edge longer than [`PIECE_MM`], by halving the longest.
fn cut(triangle: Triangle) -> Vec<Triangle> {
    let (mut waiting, mut pieces) = (vec![triangle], Vec::new());
    while let Some([a, b, c]) = waiting.pop() {
        let lengths = [a.distance_squared(b), b.distance_squared(c), c.distance_squared(a)];
        let [a, b, c] = match lengths {
            [ab, bc, ca] if bc >= ab && bc >= ca => [b, c, a],
            [ab, bc, ca] if ca >= ab && ca >= bc => [c, a, b],
            _ => [a, b, c],
        };
        if a.distance_squared(b) <= PIECE_MM * PIECE_MM {
            pieces.push([a, b, c]);
        } else {
            let middle = a.midpoint(b);
            waiting.extend([[a, middle, c], [middle, b, c]]);
        }
    }
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::part::tests::object;
    use crate::topology::tests::{cuboid, inside_out, together};
    use glam::DVec3;

    /// Boxes about the origin, each filling up what the one before left.
    fn shells(sizes: &[DVec3]) -> Vec<TriangleMesh> {
        let boxes: Vec<TriangleMesh> = sizes.iter().map(|half| cuboid(-*half, *half)).collect();
        let hollow = |pair: &[TriangleMesh]| together(&[pair[1].clone(), inside_out(pair[0].clone())]);
        boxes[..1].iter().cloned().chain(boxes.windows(2).map(hollow)).collect()
    }

    #[track_caller]
    fn check(cladding: DVec3, black: DVec3, body: DVec3, [in_cladding, in_black, in_skin]: [f64; 3]) {
        let parts =
            shells(&[DVec3::splat(2.0), DVec3::splat(2.0) + cladding, DVec3::splat(2.0) + cladding + black]);
        let whole = DVec3::splat(2.0) + cladding + black + body;
        let walls = measure(&object(cuboid(-whole, whole), &parts), 3.0);
        for (role, expected) in walls.iter().zip([in_cladding, in_black, in_skin]) {
            let (name, wall) = &role.walls[0];
            assert!((wall.thickness - expected).abs() < 1e-9, "{name}: {wall:?} instead of {expected}");
        }
    }

    #[test]
    fn walls_of_boxes_in_boxes() {
        let thick = DVec3::splat(0.7);
        check(thick, thick, thick, [0.7, 0.7, 0.7]);
        check(DVec3::new(0.5, 0.9, 0.8), thick, thick, [0.5, 0.7, 0.7]);
        check(thick, DVec3::new(0.9, 0.9, 0.3), DVec3::new(2.0, 0.4, 2.0), [0.7, 0.3, 0.4]);
    }

    #[test]
    fn bridges_span_the_gap_between_fibres() {
        let at = |x: f64| cuboid(DVec3::new(x, -1.0, -1.0), DVec3::new(x + 2.0, 1.0, 1.0));
        let black = |(k, x): (u32, f64)| Part {
            name: format!("black-led{k}"),
            role: Role::Black,
            led: Some(fibar_core::LedId(k)),
            mesh: at(x),
            merged_vertices: 0,
        };
        let mut object = object(at(-9.0), &[]);
        object.parts = [(0, 0.0), (1, 2.3), (2, 5.0), (3, 90.0)].map(black).into();
        let found = bridges(&object);
        let names: Vec<&str> = found.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(
            names,
            ["black-led0 and black-led1", "black-led1 and black-led2", "black-led0 and black-led2"]
        );
        let gaps: Vec<f64> = found.iter().map(|(_, bridge)| bridge.thickness).collect();
        assert!(gaps.iter().zip([0.3, 0.7, 3.0]).all(|(f, e)| (f - e).abs() < 1e-9), "{gaps:?}");
        assert!((found[0].1.place.x - 2.15).abs() < 1e-9);
    }

    #[test]
    fn a_bare_core_has_no_wall() {
        let core = cuboid(DVec3::splat(-2.0), DVec3::splat(2.0));
        // Covers all but the side towards +x.
        let around = [DVec3::new(-2.5, -2.5, -2.5), DVec3::new(2.0, 2.5, 2.5)];
        let cladding = together(&[cuboid(around[0], around[1]), inside_out(core.clone())]);
        let body = cuboid(DVec3::splat(-9.0), DVec3::splat(9.0));
        let walls = measure(&object(body, &[core, cladding]), 3.0);
        assert_eq!(walls[0].walls[0].1.thickness, 0.0);
    }

    #[test]
    fn near_the_ends_nothing_is_measured() {
        let parts = shells(&[DVec3::new(1.0, 1.0, 9.0), DVec3::new(1.5, 1.5, 9.1)]);
        let mut object = object(cuboid(DVec3::splat(-20.0), DVec3::splat(20.0)), &parts);
        assert!((measure(&object, 3.0)[0].walls[0].1.thickness - 0.1).abs() < 1e-9);
        object.fibre_ends = vec![DVec3::Z * 9.0, DVec3::Z * -9.0];
        assert!((measure(&object, 3.0)[0].walls[0].1.thickness - 0.5).abs() < 1e-9);
    }

    #[test]
    fn pieces_are_small_and_cover_the_triangle() {
        let whole = [DVec3::ZERO, DVec3::X * 9.0, DVec3::Y * 0.4];
        let area = |t: &Triangle| (t[1] - t[0]).cross(t[2] - t[0]).length() / 2.0;
        let pieces = cut(whole);
        assert!((pieces.iter().map(area).sum::<f64>() - area(&whole)).abs() < 1e-12);
        let longest = pieces.iter().flat_map(|[a, b, c]| [a.distance(*b), b.distance(*c), c.distance(*a)]);
        assert!(longest.fold(0.0, f64::max) <= PIECE_MM);
    }
}
