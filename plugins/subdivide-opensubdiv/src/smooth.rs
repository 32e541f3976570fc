//! A mesh made smooth, and what that did to it.

use crate::angles::sharp;
use crate::control::ControlMesh;
use crate::fitting::fit;
use crate::refinement::{Refinement, Rules};
use crate::{Keep, Params, Rims, Scheme, TriangleWeights};
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_core::artefact::parts::Parts;
use fibar_plugin::StageError;
use glam::DVec3;
use opensubdiv_petite::far;

/// The outcome.
#[derive(Debug, PartialEq)]
pub struct Smooth {
    /// Vertices shared; children of a triangle one after the other.
    pub mesh: TriangleMesh,
    /// The parts of `mesh`.
    pub parts: Parts,
    /// What became of the mesh before.
    pub fate: Fate,
}

/// What subdivision changed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fate {
    /// Edges that stay sharp.
    pub creases: usize,
    /// Vertices of creases and rims that stay where they are.
    pub corners: usize,
    /// Edges of one triangle.
    pub rim_edges: usize,
    /// Vertices that stay short of the limit surface.
    pub unlimited: usize,
    /// Volume inside, by the divergence theorem, mm³.
    pub volume_before_mm3: f64,
    /// The same of the smooth mesh.
    pub volume_after_mm3: f64,
    /// Largest distance of a refined vertex from where on the mesh it was, mm.
    pub displacement_mm: f64,
    /// Largest distance of a vertex of the mesh from where it is in the smooth one, mm.
    pub kept_within_mm: f64,
    /// By how much the sides of the box have grown, mm; negative where the shape shrank.
    pub growth_mm: DVec3,
}

/// Subdivides a mesh.
pub fn smooth(mesh: &TriangleMesh, parts: Option<Parts>, params: &Params) -> Result<Smooth, StageError> {
    check_size(mesh.triangles.len() as u64, params)?;
    let control = ControlMesh::new(mesh, parts)?;
    let places = &control.mesh.vertices;
    let sharp = sharp(&control.mesh, params.crease_deg.to_radians(), params.corner_deg.to_radians());
    let refinement = Refinement::new(&control.mesh, &sharp, rules(params))?;
    let positions = match params.keep {
        Keep::Nothing => refinement.positions(places),
        Keep::Size => grown(refinement.positions(places), places),
        Keep::Vertices => refinement.positions(&fit(&refinement, places)),
    };
    let refined = TriangleMesh { triangles: refinement.triangles(&positions), vertices: positions };
    let fate = Fate {
        creases: sharp.creases.len(),
        corners: sharp.corners.len(),
        rim_edges: control.rim_edges(),
        unlimited: refinement.unlimited,
        volume_before_mm3: volume(&control.mesh),
        volume_after_mm3: volume(&refined),
        displacement_mm: farthest(&refinement.flat_positions(places), refined.vertices.iter().copied()),
        kept_within_mm: farthest(places, refinement.of_control(&refined.vertices)),
        growth_mm: size(&refined.vertices) - size(places),
    };
    let parts = control.parts_of(&refined, params.children() as usize, 1 << params.levels);
    Ok(Smooth { mesh: refined, parts, fate })
}

/// Before any memory is taken.
fn check_size(triangles: u64, params: &Params) -> Result<(), StageError> {
    let wanted = |levels: u32| triangles.saturating_mul(Params { levels, ..params.clone() }.children());
    if wanted(params.levels) <= params.max_triangles {
        return Ok(());
    }
    let most = params.max_triangles;
    let message = format!(
        "{triangles} triangles become {} at levels = {}, more than max_triangles = {most}",
        wanted(params.levels),
        params.levels
    );
    let fitting = (1..params.levels).rev().find(|&levels| wanted(levels) <= most);
    let hint = match fitting {
        Some(levels) => format!("levels = {levels} makes {}; or raise max_triangles", wanted(levels)),
        None => "simplify the mesh before, or raise max_triangles".into(),
    };
    Err(StageError::user(message).param("/levels").hint(hint))
}

fn rules(params: &Params) -> Rules {
    Rules {
        scheme: match params.scheme {
            Scheme::Loop => far::Scheme::Loop,
            Scheme::CatmullClark => far::Scheme::CatmullClark,
        },
        levels: params.levels as usize,
        rims: match params.rims {
            Rims::Smooth => far::BoundaryInterpolation::EdgeOnly,
            Rims::Corners => far::BoundaryInterpolation::EdgeAndCorner,
        },
        triangles: match params.triangles {
            TriangleWeights::Plain => far::TriangleSubdivision::CatmullClark,
            TriangleWeights::Even => far::TriangleSubdivision::Smooth,
        },
        to_limit: params.limit,
    }
}

fn farthest(from: &[DVec3], to: impl Iterator<Item = DVec3>) -> f64 {
    from.iter().zip(to).map(|(from, to)| from.distance(to)).fold(0.0, f64::max)
}

fn volume(mesh: &TriangleMesh) -> f64 {
    mesh.volume_of(0..mesh.triangles.len())
}

/// The points scaled evenly, about the middle of the box of `like`, until they touch that box from inside.
fn grown(mut points: Vec<DVec3>, like: &[DVec3]) -> Vec<DVec3> {
    let (Some((low, high)), Some((from, to))) = (bounds(like), bounds(&points)) else { return points };
    let ratios = (high - low) / (to - from);
    let factor =
        ratios.to_array().into_iter().filter(|ratio| ratio.is_finite()).fold(f64::INFINITY, f64::min);
    if factor.is_finite() && factor > 0.0 {
        let (middle, was) = ((low + high) * 0.5, (from + to) * 0.5);
        points.iter_mut().for_each(|point| *point = middle + (*point - was) * factor);
    }
    points
}

fn size(points: &[DVec3]) -> DVec3 {
    bounds(points).map_or(DVec3::ZERO, |(low, high)| high - low)
}

fn bounds(points: &[DVec3]) -> Option<(DVec3, DVec3)> {
    let first = *points.first()?;
    Some(points.iter().fold((first, first), |(low, high), point| (low.min(*point), high.max(*point))))
}
