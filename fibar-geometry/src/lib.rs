//! Pure geometry kernels: meshes, NURBS curves, distance, rays, sampling, optics.
