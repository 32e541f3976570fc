//! What can go wrong with a solid, in the words of Manifold's status codes.

/// Why an operation gave no solid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SolidError {
    /// A coordinate is infinite or not a number.
    #[error("a vertex is not finite")]
    NonFiniteVertex,
    /// Not every edge has exactly two triangles that run along it in opposite directions.
    #[error("the mesh is not a closed, oriented 2-manifold")]
    NotManifold,
    /// A triangle names a vertex that does not exist.
    #[error("a triangle names a vertex that does not exist")]
    VertexOutOfBounds,
    /// More triangles than 32 bits count.
    #[error("the result has too many triangles")]
    ResultTooLarge,
    /// An argument is out of its range.
    #[error("{0}")]
    Argument(String),
    /// Any other failure inside Manifold.
    #[error("Manifold failed: {0}")]
    Kernel(String),
}

impl SolidError {
    /// The error that a status of Manifold stands for, in the order of `manifold::Manifold::Error`; `None` for success.
    pub(crate) fn from_status(status: u8) -> Option<SolidError> {
        match status {
            0 => None,
            1 => Some(SolidError::NonFiniteVertex),
            2 => Some(SolidError::NotManifold),
            3 => Some(SolidError::VertexOutOfBounds),
            12 => Some(SolidError::ResultTooLarge),
            other => Some(SolidError::Kernel(format!("status {other}"))),
        }
    }
}

impl From<cxx::Exception> for SolidError {
    fn from(exception: cxx::Exception) -> Self {
        SolidError::Kernel(exception.what().to_string())
    }
}
