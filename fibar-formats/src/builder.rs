//! A mesh while it is read: every vertex and triangle passes through here, and so do the limits.

use crate::Limits;
use crate::error::{Place, ReadError};
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_core::artefact::places::Places;
use glam::DVec3;

/// A mesh that grows within limits.
pub struct MeshBuilder {
    mesh: TriangleMesh,
    /// Corners of loose triangles, where equal ones are to be shared.
    shared: Option<SharedCorners>,
    most_triangles: u64,
}

impl MeshBuilder {
    /// Nothing yet.
    pub fn new(limits: &Limits) -> MeshBuilder {
        // Corners are numbered by 32 bits.
        let most_triangles = limits.triangles.min(u64::from(u32::MAX) / 3);
        let shared = limits.shares_corners.then(SharedCorners::default);
        MeshBuilder { mesh: TriangleMesh::default(), shared, most_triangles }
    }

    /// Vertices so far.
    pub fn vertex_count(&self) -> usize {
        self.mesh.vertices.len()
    }

    /// Triangles so far.
    pub fn triangle_count(&self) -> usize {
        self.mesh.triangles.len()
    }

    /// Refuses a count of triangles that a file announces, before any of them is read.
    pub fn announce_triangles(&self, count: u64, place: Place) -> Result<(), ReadError> {
        if count <= self.most_triangles.saturating_sub(self.mesh.triangles.len() as u64) {
            return Ok(());
        }
        let message = format!("{count} triangles exceed the limit of {}", self.most_triangles);
        Err(ReadError::new(place, message).try_this("simplify the mesh, or raise `max_triangles`"))
    }

    /// Appends a vertex.
    pub fn push_vertex(&mut self, vertex: DVec3, place: Place) -> Result<(), ReadError> {
        if !vertex.is_finite() {
            return Err(ReadError::new(place, "a corner is not finite"));
        }
        // A sound mesh has fewer vertices than triangles; loose triangles have three each.
        if self.mesh.vertices.len() as u64 >= 3 * self.most_triangles {
            return self.announce_triangles(self.most_triangles + 1, place);
        }
        self.mesh.vertices.push(vertex);
        Ok(())
    }

    /// Appends a triangle of corners that exist.
    pub fn push_triangle(&mut self, corners: [u32; 3], place: Place) -> Result<(), ReadError> {
        if self.mesh.triangles.len() as u64 >= self.most_triangles {
            return self.announce_triangles(self.most_triangles + 1, place);
        }
        self.check_corners(corners.map(i64::from).as_slice(), place)?;
        self.mesh.triangles.push(corners);
        Ok(())
    }

    /// Appends a triangle whose corners know no others. A format has loose triangles only, or none.
    pub fn push_loose(&mut self, corners: [DVec3; 3], place: Place) -> Result<(), ReadError> {
        if self.shared.is_some() {
            return self.push_sharing(corners, place);
        }
        let first = self.mesh.vertices.len() as u32;
        corners.iter().try_for_each(|&corner| self.push_vertex(corner, place))?;
        self.push_triangle([first, first + 1, first + 2], place)
    }

    fn push_sharing(&mut self, corners: [DVec3; 3], place: Place) -> Result<(), ReadError> {
        if !corners.iter().all(|corner| corner.is_finite()) {
            return Err(ReadError::new(place, "a corner is not finite"));
        }
        if self.mesh.triangles.len() as u64 >= self.most_triangles {
            return self.announce_triangles(self.most_triangles + 1, place);
        }
        if let Some(shared) = &mut self.shared {
            shared.push(corners, &mut self.mesh.triangles);
        }
        Ok(())
    }

    /// Appends the fan of a polygon about its first corner; right for convex ones, closed for all.
    pub fn push_polygon(&mut self, corners: &[i64], place: Place) -> Result<(), ReadError> {
        if corners.len() < 3 {
            return Err(ReadError::new(place, format!("a face needs 3 corners, has {}", corners.len())));
        }
        self.check_corners(corners, place)?;
        let corner = |k: usize| corners[k] as u32;
        (1..corners.len() - 1)
            .try_for_each(|k| self.push_triangle([corner(0), corner(k), corner(k + 1)], place))
    }

    fn check_corners(&self, corners: &[i64], place: Place) -> Result<(), ReadError> {
        let count = self.mesh.vertices.len() as u64;
        match corners.iter().find(|&&corner| corner < 0 || corner as u64 >= count) {
            Some(stray) => {
                Err(ReadError::new(place, format!("vertex {stray} does not exist, there are {count}")))
            }
            None => Ok(()),
        }
    }

    /// The mesh.
    pub fn finish(mut self) -> TriangleMesh {
        if let Some(shared) = self.shared.filter(|_| self.mesh.vertices.is_empty()) {
            self.mesh.vertices = shared.finish(&mut self.mesh.triangles);
        }
        self.mesh
    }
}

/// Gives loose triangles corners in common, several triangles at once.
#[derive(Default)]
struct SharedCorners {
    places: Places,
    /// Corners of the last triangles, which have no numbers yet.
    waiting: Vec<DVec3>,
    numbers: Vec<u32>,
}

impl SharedCorners {
    fn push(&mut self, corners: [DVec3; 3], triangles: &mut Vec<[u32; 3]>) {
        const AT_ONCE: usize = 192;
        triangles.push([0; 3]);
        self.waiting.extend(corners);
        if self.waiting.len() >= AT_ONCE {
            self.number(triangles);
        }
    }

    fn number(&mut self, triangles: &mut [[u32; 3]]) {
        self.numbers.clear();
        self.places.number(&self.waiting, &mut self.numbers);
        let last = triangles.len() - self.waiting.len() / 3;
        for (triangle, numbers) in triangles[last..].iter_mut().zip(self.numbers.as_chunks().0) {
            *triangle = *numbers;
        }
        self.waiting.clear();
    }

    fn finish(mut self, triangles: &mut [[u32; 3]]) -> Vec<DVec3> {
        self.number(triangles);
        self.places.into_places()
    }
}
