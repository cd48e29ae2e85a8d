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
  void bounds(dvec3& lo, dvec3& hi) const override { lo = tree_.lo(), hi = tree_.hi(); }

 private:
  importing::TriangleTree tree_;
};

}  // namespace

std::unique_ptr<Solid> read_mesh_solid(const std::filesystem::path& file, double unit) {
  importing::MeshRepairs repairs;
  const importing::Mesh mesh = importing::read_mesh(file, unit, repairs);
  // A closed hole is an error here, because the user would not learn that the hole was closed. The command `typodont
  // import` reports its repairs, so it can close holes.
  if (repairs.holes > 0) {
    throw Error(file.string(), "", fmt::format("{} holes with {} edges in all", repairs.holes, repairs.hole_edges),
                "a closed surface; typodont import closes small holes");
  }
  std::vector<importing::Triangle> triangles;
  for (const auto& c : mesh.corners) {
    const auto at = [&](std::size_t k) { return mesh.points[static_cast<std::size_t>(c[k])]; };
    triangles.push_back({at(0), at(1), at(2)});
  }
  return std::make_unique<MeshSolid>(importing::TriangleTree(std::move(triangles)));
}

}  // namespace typodont::haptics
