#include "haptics/volume/csg_baseline.h"

#include <openvdb/openvdb.h>
#include <openvdb/tools/Composite.h>
#include <openvdb/tools/LevelSetSphere.h>

#include <algorithm>

namespace typodont::haptics {

struct CsgBaseline::Impl {
  VoxelFrame frame;
  openvdb::FloatGrid::Ptr grid;  // distances and coordinates in voxels
};

namespace {
// voxels, distance from the surface up to which OpenVDB's level sets store distances by default
constexpr float kBand = 3;
}  // namespace

CsgBaseline::CsgBaseline(const DenseTissue& tissue) : impl_(std::make_unique<Impl>()) {
  openvdb::initialize();
  impl_->frame = tissue.frame;
  impl_->grid = openvdb::FloatGrid::create(kBand);
  impl_->grid->setGridClass(openvdb::GRID_LEVEL_SET);
  auto at = impl_->grid->getAccessor();
  const float to_voxels = static_cast<float>(1 / tissue.frame.voxel);
  for (int x = 0; x < tissue.size.x; ++x) {
    for (int y = 0; y < tissue.size.y; ++y) {
      for (int z = 0; z < tissue.size.z; ++z) {
        const float d = tissue.distance[tissue.at(x, y, z)] * to_voxels;
        if (d < kBand && d > -kBand) at.setValue({x, y, z}, d);
        if (d <= -kBand) at.setValueOff({x, y, z}, -kBand);
      }
    }
  }
  impl_->grid->pruneGrid();
}

CsgBaseline::~CsgBaseline() = default;

void CsgBaseline::cut_ball(const dvec3& center_W, double radius) {
  const dvec3 c = impl_->frame.to_voxels(center_W);
  const auto ball = openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(
      static_cast<float>(radius / impl_->frame.voxel), openvdb::Vec3f(openvdb::Vec3d(c.x, c.y, c.z)), 1.0f, kBand,
      /*threaded=*/false);
  openvdb::tools::csgDifference(*impl_->grid, *ball);
}

double CsgBaseline::volume() const {
  double voxels = 0;
  for (auto it = impl_->grid->cbeginValueAll(); it; ++it) {
    const double fraction = std::clamp(0.5 - static_cast<double>(*it), 0.0, 1.0);
    if (fraction > 0) voxels += fraction * static_cast<double>(it.getVoxelCount());
  }
  return voxels * impl_->frame.voxel * impl_->frame.voxel * impl_->frame.voxel;
}

}  // namespace typodont::haptics
