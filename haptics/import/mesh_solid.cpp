#include "haptics/import/mesh_solid.h"

#include <fmt/format.h>

#include <cmath>
#include <vector>

#include "engine/base/error.h"
#include "haptics/import/mesh.h"
#include "haptics/import/triangle_tree.h"

namespace typodont::haptics {

namespace {

class MeshSolid : public Solid {
 public:
  explicit MeshSolid(importing::TriangleTree tree) : tree_(std::move(tree)) {}

  double distance(const dvec3& p) const override {
    const double d = std::sqrt(tree_.distance_squared(p));
    return tree_.winding(p) > 0 ? -d : d;
  }
  void distances(std::span<const dvec3> p, std::span<double> distances) const override {
    if (p.empty()) return;
    distances[0] = distance(p[0]);
    for (std::size_t i = 1; i < p.size(); ++i) {
      // The ball around the last point contains no surface. Within this ball the sign does not change, and the surface
      // is at most `step` + `before` away.
      const double step = glm::length(p[i] - p[i - 1]), before = std::abs(distances[i - 1]);
      const double d = std::sqrt(tree_.distance_squared(p[i], (step + before) * kRounding));
      const bool inside = step * kRounding < before ? distances[i - 1] < 0 : tree_.winding(p[i]) > 0;
      distances[i] = inside ? -d : d;
    }
  }
  void bounds(dvec3& lo, dvec3& hi) const override { lo = tree_.lo(), hi = tree_.hi(); }

 private:
  static constexpr double kRounding = 1 + 1e-9;  // larger than the relative error of a computed distance
  importing::TriangleTree tree_;
};

}  // namespace

std::unique_ptr<Solid> read_mesh_solid(const std::filesystem::path& file, double unit) {
  importing::MeshRepairs repairs;
  const importing::Mesh mesh = importing::read_mesh(file, unit, repairs);
  // Throws, because the user would not learn of closed holes here; `typodont import` reports repairs.
  if (repairs.holes > 0) {
    throw Error(file.string(), "", fmt::format("{} holes with {} edges in all", repairs.holes, repairs.hole_edges),
                "a closed surface; typodont import closes small holes");
  }
  std::vector<importing::Triangle> triangles;
  for (std::size_t t = 0; t < mesh.corners.size(); ++t) triangles.push_back(mesh.triangle(t));
  return std::make_unique<MeshSolid>(importing::TriangleTree(std::move(triangles)));
}

}  // namespace typodont::haptics
