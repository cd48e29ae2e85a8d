#include "haptics/volume/penalty_baseline.h"

#include <openvdb/openvdb.h>
#include <openvdb/tools/Interpolation.h>

#include <algorithm>
#include <cmath>

namespace typodont::haptics {

struct PenaltyBaseline::Impl {
  VoxelFrame frame;
  openvdb::FloatGrid::Ptr grid;  // distances and coordinates in voxels
  std::unique_ptr<openvdb::FloatGrid::ConstAccessor> accessor;
};

PenaltyBaseline::PenaltyBaseline(const DenseTissue& tissue) : impl_(std::make_unique<Impl>()) {
  openvdb::initialize();
  impl_->frame = tissue.frame;
  float greatest = 0;
  for (const float d : tissue.distance) greatest = std::max(greatest, std::abs(d));
  const float to_voxels = static_cast<float>(1 / tissue.frame.voxel);
  impl_->grid = openvdb::FloatGrid::create(greatest * to_voxels);
  auto at = impl_->grid->getAccessor();
  for (int x = 0; x < tissue.size.x; ++x) {
    for (int y = 0; y < tissue.size.y; ++y) {
      for (int z = 0; z < tissue.size.z; ++z) {
        at.setValue({x, y, z}, tissue.distance[tissue.at(x, y, z)] * to_voxels);
      }
    }
  }
  impl_->accessor = std::make_unique<openvdb::FloatGrid::ConstAccessor>(impl_->grid->getConstAccessor());
}

PenaltyBaseline::~PenaltyBaseline() = default;

dvec3 PenaltyBaseline::push(const dvec3& center_W, double radius) {
  const dvec3 c = impl_->frame.to_voxels(center_W);
  const auto distance = [&](double x, double y, double z) {
    return static_cast<double>(openvdb::tools::QuadraticSampler::sample(*impl_->accessor, openvdb::Vec3R(x, y, z)));
  };
  constexpr double kStep = 0.5;  // voxels, step of the central differences
  const dvec3 gradient{distance(c.x + kStep, c.y, c.z) - distance(c.x - kStep, c.y, c.z),
                       distance(c.x, c.y + kStep, c.z) - distance(c.x, c.y - kStep, c.z),
                       distance(c.x, c.y, c.z + kStep) - distance(c.x, c.y, c.z - kStep)};
  const double voxel = impl_->frame.voxel, depth = radius - distance(c.x, c.y, c.z) * voxel;
  const double slope = glm::length(gradient);
  return depth > 0 && slope > 0 ? center_W + depth / slope * gradient : center_W;
}

}  // namespace typodont::haptics
