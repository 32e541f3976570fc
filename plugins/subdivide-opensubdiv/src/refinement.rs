//! OpenSubdiv, asked for topology and weights; positions are ours.

use crate::angles::Sharp;
use crate::limit::{self, Ring};
use crate::stencils::Stencils;
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_plugin::StageError;
use glam::DVec3;
use opensubdiv_petite::Index;
use opensubdiv_petite::far::{
    BoundaryInterpolation, Scheme, StencilTable, StencilTableOptions, TopologyDescriptor, TopologyLevel,
    TopologyRefiner, TopologyRefinerOptions, TriangleSubdivision, UniformRefinementOptions,
};

/// What OpenSubdiv takes for infinitely sharp.
const SHARP: f32 = 10.0;

/// How to subdivide.
#[derive(Clone, Copy, Debug)]
pub struct Rules {
    /// Catmull–Clark or Loop.
    pub scheme: Scheme,
    /// How often.
    pub levels: usize,
    /// What rims become.
    pub rims: BoundaryInterpolation,
    /// Catmull–Clark's weights at triangles.
    pub triangles: TriangleSubdivision,
    /// Whether the vertices shall lie on the limit surface.
    pub to_limit: bool,
}

/// A refined mesh as a function of where the vertices of the control mesh are.
pub struct Refinement {
    /// From each level to the next.
    steps: Vec<Stencils>,
    /// From the last level to the limit surface.
    limit: Option<Stencils>,
    /// The same steps without smoothing: what was on a face or an edge stays there.
    flat: Vec<Stencils>,
    /// Faces of the last level, children of a face one after the other.
    faces: Vec<Vec<u32>>,
    /// Vertices of the last level that were vertices of the control mesh, in their order.
    kept: Vec<usize>,
    /// Vertices of the last level that no limit could be given for.
    pub unlimited: usize,
}

impl Refinement {
    /// Refines the topology of a mesh.
    pub fn new(mesh: &TriangleMesh, sharp: &Sharp, rules: Rules) -> Result<Refinement, StageError> {
        let refiner = refine(mesh, sharp, rules)?;
        let mut tables = stencils_by_level(&refiner, rules.levels + usize::from(rules.to_limit))?;
        let levels = (0..=rules.levels).map(|k| refiner.level(k).ok_or_else(|| odd("a level is missing")));
        let levels = levels.collect::<Result<Vec<_>, _>>()?;
        let (last, parents) = levels.split_last().ok_or_else(|| odd("there are no levels"))?;
        let mut kept: Vec<usize> = (0..mesh.vertices.len()).collect();
        let mut flat = Vec::new();
        for (parent, table) in parents.iter().zip(&tables) {
            let children = Children::of(parent, rules.scheme);
            if children.count() != table.len() {
                return Err(odd("vertices are not where their parents say"));
            }
            kept.iter_mut().for_each(|v| *v = children.of_vertex(*v));
            flat.push(unsmoothed(parent, rules.scheme)?);
        }
        let (mut limit, mut unlimited) = (None, 0);
        if rules.to_limit {
            let table = tables.pop().ok_or_else(|| odd("the level beyond the last is missing"))?;
            let (masks, missed) = limit_masks(last, &table, rules.scheme)?;
            (limit, unlimited) = (Some(masks), missed);
        }
        let faces = (0..last.face_count()).map(|f| corners(last, f)).collect::<Result<_, _>>()?;
        Ok(Refinement { steps: tables, limit, flat, faces, kept, unlimited })
    }

    /// Where the refined vertices are, the control mesh's being at `control`.
    pub fn positions(&self, control: &[DVec3]) -> Vec<DVec3> {
        run(self.steps.iter().chain(&self.limit), control)
    }

    /// Where they would be without smoothing.
    pub fn flat_positions(&self, control: &[DVec3]) -> Vec<DVec3> {
        run(self.flat.iter(), control)
    }

    /// Of all refined positions those that the vertices of the control mesh have become.
    pub fn of_control<'a>(&'a self, positions: &'a [DVec3]) -> impl Iterator<Item = DVec3> + 'a {
        self.kept.iter().map(|&v| positions[v])
    }

    /// Triangles over positions; a quad is cut along its shorter diagonal.
    pub fn triangles(&self, positions: &[DVec3]) -> Vec<[u32; 3]> {
        let length = |a: u32, b: u32| positions[a as usize].distance_squared(positions[b as usize]);
        let cut = |face: &Vec<u32>| match face[..] {
            [a, b, c, d] if length(b, d) < length(a, c) => vec![[a, b, d], [b, c, d]],
            [a, b, c, d] => vec![[a, b, c], [a, c, d]],
            [a, b, c] => vec![[a, b, c]],
            _ => Vec::new(),
        };
        self.faces.iter().flat_map(cut).collect()
    }
}

#[cfg(test)]
impl Refinement {
    /// The faces before quads are cut.
    pub fn face_corners(&self) -> impl Iterator<Item = Vec<usize>> + '_ {
        self.faces.iter().map(|face| face.iter().map(|&v| v as usize).collect())
    }
}

fn run<'a>(steps: impl Iterator<Item = &'a Stencils>, control: &[DVec3]) -> Vec<DVec3> {
    steps.fold(control.to_vec(), |points, step| step.apply(&points))
}

fn odd(what: &str) -> StageError {
    StageError::internal(format!("OpenSubdiv: {what}"))
}

fn refine(mesh: &TriangleMesh, sharp: &Sharp, rules: Rules) -> Result<TopologyRefiner, StageError> {
    let (counts, corners) = (vec![3; mesh.triangles.len()], mesh.triangles.as_flattened());
    let creases = sharp.creases.as_flattened();
    let sharpness = vec![SHARP; sharp.creases.len().max(sharp.corners.len())];
    let mut descriptor = TopologyDescriptor::new(mesh.vertices.len(), &counts, corners).map_err(refuse)?;
    descriptor.creases(creases, &sharpness[..sharp.creases.len()]);
    descriptor.corners(&sharp.corners, &sharpness[..sharp.corners.len()]);
    let options = TopologyRefinerOptions {
        scheme: rules.scheme,
        boundary_interpolation: Some(rules.rims),
        triangle_subdivision: rules.triangles,
        ..Default::default()
    };
    let mut refiner = TopologyRefiner::new(descriptor, options).map_err(refuse)?;
    refiner.refine_uniform(UniformRefinementOptions {
        refinement_level: rules.levels + usize::from(rules.to_limit),
        order_vertices_from_faces_first: true,
        full_topology_in_last_level: false,
    });
    Ok(refiner)
}

fn refuse(error: opensubdiv_petite::Error) -> StageError {
    StageError::input(format!("OpenSubdiv does not take this mesh: {error}"))
        .hint("mend it in a modelling program and export again")
}

/// One table for each level above the first, over the vertices of the level below it.
fn stencils_by_level(refiner: &TopologyRefiner, levels: usize) -> Result<Vec<Stencils>, StageError> {
    let options = StencilTableOptions { factorize_intermediate_levels: false, ..Default::default() };
    let table = StencilTable::new(refiner, options).map_err(|error| odd(&error.to_string()))?;
    let (indices, weights) = (table.control_indices(), table.weights());
    let mut sizes = table.sizes().iter().map(|&size| size as usize);
    let mut start = 0;
    let mut level = |k: usize| {
        let count = refiner.level(k).ok_or_else(|| odd("a level is missing"))?.vertex_count();
        let mut stencils = Stencils::default();
        for size in sizes.by_ref().take(count) {
            let range = start..start + size;
            let (indices, weights) = (&indices[range.clone()], &weights[range]);
            stencils.push(indices.iter().zip(weights).map(|(index, &weight)| (index.0, f64::from(weight))));
            start += size;
        }
        if stencils.len() == count { Ok(stencils) } else { Err(odd("stencils are missing")) }
    };
    (1..=levels).map(&mut level).collect()
}

/// Where the children of a level's faces, edges and vertices stand among the vertices of the next.
struct Children {
    faces: usize,
    edges: usize,
    vertices: usize,
}

impl Children {
    fn of(level: &TopologyLevel<'_>, scheme: Scheme) -> Children {
        let faces = if matches!(scheme, Scheme::Loop) { 0 } else { level.face_count() };
        Children { faces, edges: level.edge_count(), vertices: level.vertex_count() }
    }

    fn count(&self) -> usize {
        self.faces + self.edges + self.vertices
    }

    fn of_edge(&self, edge: usize) -> usize {
        self.faces + edge
    }

    fn of_vertex(&self, vertex: usize) -> usize {
        self.faces + self.edges + vertex
    }
}

/// Means of the corners of faces and of the ends of edges, and the vertices themselves.
fn unsmoothed(level: &TopologyLevel<'_>, scheme: Scheme) -> Result<Stencils, StageError> {
    let children = Children::of(level, scheme);
    let mut stencils = Stencils::default();
    let mut mean = |of: &[u32]| stencils.push(of.iter().map(|&v| (v, 1.0)));
    for face in 0..children.faces {
        mean(&corners(level, face)?);
    }
    for edge in 0..children.edges {
        mean(&ends(level, edge)?);
    }
    (0..children.vertices).for_each(|v| mean(&[v as u32]));
    Ok(stencils)
}

/// A row for each vertex of a level, and how many of them have no limit because their ring meets itself.
fn limit_masks(
    level: &TopologyLevel<'_>,
    next: &Stencils,
    scheme: Scheme,
) -> Result<(Stencils, usize), StageError> {
    let (mut masks, mut missed) = (Stencils::default(), 0);
    for v in 0..level.vertex_count() {
        let ring = ring(level, v, scheme)?;
        let mask = limit::mask(&ring, next).unwrap_or_else(|| {
            missed += 1;
            vec![(v as u32, 1.0)]
        });
        masks.push(mask.into_iter());
    }
    Ok((masks, missed))
}

/// A vertex with those around it, each with the vertex of the next level that takes its place there.
fn ring(level: &TopologyLevel<'_>, v: usize, scheme: Scheme) -> Result<Ring, StageError> {
    let (children, me) = (Children::of(level, scheme), v as u32);
    let mut ring = Ring { vertices: vec![me], children: vec![children.of_vertex(v)] };
    for edge in level.vertex_edges(Index::from(v)).unwrap_or_default() {
        let other = ends(level, edge.0 as usize)?.into_iter().find(|&end| end != me);
        ring.vertices.push(other.ok_or_else(|| odd("an edge has one end twice"))?);
        ring.children.push(children.of_edge(edge.0 as usize));
    }
    if children.faces > 0 {
        for face in level.vertex_faces(Index::from(v)).unwrap_or_default() {
            let corners = corners(level, face.0 as usize)?;
            let at =
                corners.iter().position(|&corner| corner == me).ok_or_else(|| odd("a face lost a corner"))?;
            ring.vertices.push(corners[(at + 2) % corners.len()]);
            ring.children.push(face.0 as usize);
        }
    }
    Ok(ring)
}

fn corners(level: &TopologyLevel<'_>, face: usize) -> Result<Vec<u32>, StageError> {
    let corners = level.face_vertices(Index::from(face)).ok_or_else(|| odd("a face has no corners"))?;
    Ok(corners.iter().map(|index| index.0).collect())
}

fn ends(level: &TopologyLevel<'_>, edge: usize) -> Result<Vec<u32>, StageError> {
    let ends = level.edge_vertices(Index::from(edge)).ok_or_else(|| odd("an edge has no ends"))?;
    Ok(ends.iter().map(|index| index.0).collect())
}
