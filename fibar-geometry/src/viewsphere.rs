//! Geodesic spheres of viewpoints.
