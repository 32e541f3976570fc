// What Rust may ask of Manifold. Every function returns a value or throws std::exception, which cxx turns into `Err`.
//
// Solids are evaluated before they are handed out: a lazy tree would move the cost, and the errors, to its first reader.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "manifold/manifold.h"
#include "rust/cxx.h"

namespace fibar {

using manifold::Manifold;
using Handle = std::unique_ptr<Manifold>;
using Pile = std::vector<Manifold>;

struct Buffers;
struct Point;
enum class Operation : std::uint8_t;

Handle solid_from_mesh(rust::Slice<const double> vertices, rust::Slice<const std::uint64_t> triangles);
Handle hull_of_points(rust::Slice<const double> points);
Handle copy_of(const Manifold& solid);
Buffers mesh_of(const Manifold& solid);

std::uint8_t status_of(const Manifold& solid);
std::size_t triangle_count(const Manifold& solid);
std::int32_t genus_of(const Manifold& solid);
double volume_of(const Manifold& solid);
double surface_area_of(const Manifold& solid);
double tolerance_of(const Manifold& solid);
Point lower_corner(const Manifold& solid);
Point upper_corner(const Manifold& solid);

std::unique_ptr<Pile> new_pile();
void push(Pile& pile, const Manifold& solid);
Handle combined(const Pile& pile, Operation operation);
std::unique_ptr<Pile> components_of(const Manifold& solid);

Handle translated(const Manifold& solid, Point by);
Handle trimmed(const Manifold& solid, Point normal, double offset);
Handle simplified(const Manifold& solid, double tolerance);
Handle with_tolerance(const Manifold& solid, double tolerance);
Handle eroded(const Manifold& solid, const Manifold& ball);

}  // namespace fibar
