#include "haptics/mesh_baseline.h"

#include <openvdb/openvdb.h>
#include <openvdb/tools/SignedFloodFill.h>
#include <openvdb/tools/VolumeToMesh.h>
#include <tbb/global_control.h>

#include "engine/base/measure.h"

namespace typodont::haptics {

using openvdb::FloatGrid;

struct MeshBaseline::Impl {
  FloatGrid::Ptr grid;
  FloatGrid::Accessor out;

  static FloatGrid::Ptr level_set() {
    openvdb::initialize();
    auto grid = FloatGrid::create(static_cast<float>(kBand));
    grid->setGridClass(openvdb::GRID_LEVEL_SET);
    return grid;
  }
  Impl() : grid(level_set()), out(grid->getAccessor()) {}
};

MeshBaseline::MeshBaseline() : impl_(std::make_unique<Impl>()) {}
MeshBaseline::~MeshBaseline() = default;

void MeshBaseline::set(const glm::ivec3& i, float distance) {
  impl_->out.setValue({i.x, i.y, i.z}, distance);
}
void MeshBaseline::finish() {
  openvdb::tools::signedFloodFill(impl_->grid->tree());
}

double MeshBaseline::extract(int repeats, Mesh& mesh) const {
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  std::vector<openvdb::Vec3s> points;
  std::vector<openvdb::Vec3I> triangles;
  std::vector<openvdb::Vec4I> quads;
  const double ns =
      measure(repeats, [&] { openvdb::tools::volumeToMesh(*impl_->grid, points, triangles, quads, 0.0, 0.0); }).median;
  mesh = {};
  for (const auto& p : points) mesh.points.push_back({p.x(), p.y(), p.z()});
  for (const auto& t : triangles) mesh.triangles.push_back({t[0], t[1], t[2]});
  for (const auto& q : quads) {
    mesh.triangles.push_back({q[0], q[1], q[2]});
    mesh.triangles.push_back({q[0], q[2], q[3]});
  }
  return ns;
}

}  // namespace typodont::haptics
