// The bridge's bodies: conversions and one call of Manifold each.
#include "fibar-solid/cpp/bridge.h"

#include <stdexcept>

#include "fibar-solid/src/bridge.rs.h"

namespace fibar {
namespace {

manifold::vec3 vec3_of(Point p) { return {p.x, p.y, p.z}; }

Point point_of(manifold::vec3 v) { return {v.x, v.y, v.z}; }

// Forces the evaluation here, where an exception still becomes an error. The result counts as an original: the marks of
// the meshes it was made of come from one counter for all threads, and their order would show in the order of triangles.
Handle evaluated(Manifold&& solid) { return std::make_unique<Manifold>(solid.AsOriginal()); }

}  // namespace

Handle solid_from_mesh(rust::Slice<const double> vertices, rust::Slice<const std::uint64_t> triangles) {
  manifold::MeshGL64 mesh;
  mesh.numProp = 3;
  mesh.vertProperties.assign(vertices.begin(), vertices.end());
  mesh.triVerts.assign(triangles.begin(), triangles.end());
  return evaluated(Manifold(mesh));
}

Handle hull_of_points(rust::Slice<const double> points) {
  std::vector<manifold::vec3> list;
  list.reserve(points.size() / 3);
  for (std::size_t k = 0; k + 2 < points.size(); k += 3) {
    list.emplace_back(points[k], points[k + 1], points[k + 2]);
  }
  return evaluated(Manifold::Hull(list));
}

Handle copy_of(const Manifold& solid) { return std::make_unique<Manifold>(solid); }

Buffers mesh_of(const Manifold& solid) {
  const manifold::MeshGL64 mesh = solid.GetMeshGL64();
  Buffers buffers;
  const std::size_t stride = mesh.numProp;
  buffers.vertices.reserve(mesh.NumVert() * 3);
  for (std::size_t vertex = 0; vertex < mesh.NumVert(); ++vertex) {
    for (std::size_t k = 0; k < 3; ++k) buffers.vertices.push_back(mesh.vertProperties[vertex * stride + k]);
  }
  // Solids without properties have one vertex per place, so that there is nothing to merge.
  if (!mesh.mergeFromVert.empty()) throw std::logic_error("a solid's vertices were split");
  for (const std::uint64_t vertex : mesh.triVerts) buffers.triangles.push_back(static_cast<std::uint32_t>(vertex));
  return buffers;
}

std::uint8_t status_of(const Manifold& solid) { return static_cast<std::uint8_t>(solid.Status()); }
std::size_t triangle_count(const Manifold& solid) { return solid.NumTri(); }
std::int32_t genus_of(const Manifold& solid) { return solid.Genus(); }
double volume_of(const Manifold& solid) { return solid.Volume(); }
double surface_area_of(const Manifold& solid) { return solid.SurfaceArea(); }
double tolerance_of(const Manifold& solid) { return solid.GetTolerance(); }
Point lower_corner(const Manifold& solid) { return point_of(solid.BoundingBox().min); }
Point upper_corner(const Manifold& solid) { return point_of(solid.BoundingBox().max); }

std::unique_ptr<Pile> new_pile() { return std::make_unique<Pile>(); }
void push(Pile& pile, const Manifold& solid) { pile.push_back(solid); }

Handle combined(const Pile& pile, Operation operation) {
  switch (operation) {
    case Operation::Union:
      return evaluated(Manifold::BatchBoolean(pile, manifold::OpType::Add));
    case Operation::Intersection:
      return evaluated(Manifold::BatchBoolean(pile, manifold::OpType::Intersect));
    case Operation::Difference:
      return evaluated(Manifold::BatchBoolean(pile, manifold::OpType::Subtract));
  }
  throw std::invalid_argument("unknown boolean operation");
}

std::unique_ptr<Pile> components_of(const Manifold& solid) { return std::make_unique<Pile>(solid.Decompose()); }

Handle translated(const Manifold& solid, Point by) { return evaluated(solid.Translate(vec3_of(by))); }

Handle trimmed(const Manifold& solid, Point normal, double offset) {
  return evaluated(solid.TrimByPlane(vec3_of(normal), offset));
}

Handle simplified(const Manifold& solid, double tolerance) { return evaluated(solid.Simplify(tolerance)); }

Handle with_tolerance(const Manifold& solid, double tolerance) { return evaluated(solid.SetTolerance(tolerance)); }

Handle eroded(const Manifold& solid, const Manifold& ball) { return evaluated(solid.MinkowskiDifference(ball)); }

}  // namespace fibar
