//! The bridge to Manifold as cxx sees it. Only `solid.rs` uses it; bodies are in `cpp/bridge.cpp`.

#[cxx::bridge(namespace = "fibar")]
pub(crate) mod ffi {
    /// A mesh, flat: three coordinates a vertex, three indices a triangle.
    struct Buffers {
        vertices: Vec<f64>,
        triangles: Vec<u32>,
    }

    /// A place or direction, mm.
    struct Point {
        x: f64,
        y: f64,
        z: f64,
    }

    /// A boolean over a list; a difference takes the rest from the first.
    enum Operation {
        Union,
        Intersection,
        Difference,
    }

    unsafe extern "C++" {
        include!("fibar-solid/cpp/bridge.h");

        #[namespace = "manifold"]
        type Manifold;

        fn solid_from_mesh(vertices: &[f64], triangles: &[u64]) -> Result<UniquePtr<Manifold>>;
        fn hull_of_points(points: &[f64]) -> Result<UniquePtr<Manifold>>;
        fn copy_of(solid: &Manifold) -> UniquePtr<Manifold>;
        fn mesh_of(solid: &Manifold) -> Result<Buffers>;

        fn status_of(solid: &Manifold) -> Result<u8>;
        fn triangle_count(solid: &Manifold) -> usize;
        fn genus_of(solid: &Manifold) -> i32;
        fn volume_of(solid: &Manifold) -> f64;
        fn surface_area_of(solid: &Manifold) -> f64;
        fn tolerance_of(solid: &Manifold) -> f64;
        fn lower_corner(solid: &Manifold) -> Point;
        fn upper_corner(solid: &Manifold) -> Point;

        fn new_pile() -> UniquePtr<CxxVector<Manifold>>;
        fn push(pile: Pin<&mut CxxVector<Manifold>>, solid: &Manifold);
        fn combined(pile: &CxxVector<Manifold>, operation: Operation) -> Result<UniquePtr<Manifold>>;
        fn components_of(solid: &Manifold) -> Result<UniquePtr<CxxVector<Manifold>>>;

        fn translated(solid: &Manifold, by: Point) -> Result<UniquePtr<Manifold>>;
        fn trimmed(solid: &Manifold, normal: Point, offset: f64) -> Result<UniquePtr<Manifold>>;
        fn simplified(solid: &Manifold, tolerance: f64) -> Result<UniquePtr<Manifold>>;
        fn with_tolerance(solid: &Manifold, tolerance: f64) -> Result<UniquePtr<Manifold>>;
        fn eroded(solid: &Manifold, ball: &Manifold) -> Result<UniquePtr<Manifold>>;
    }
}

impl From<glam::DVec3> for ffi::Point {
    fn from(v: glam::DVec3) -> Self {
        ffi::Point { x: v.x, y: v.y, z: v.z }
    }
}

impl From<ffi::Point> for glam::DVec3 {
    fn from(p: ffi::Point) -> Self {
        glam::DVec3::new(p.x, p.y, p.z)
    }
}
