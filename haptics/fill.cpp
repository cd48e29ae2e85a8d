#include "haptics/fill.h"

#include "haptics/solid.h"

namespace typodont::haptics {

Fill::Fill(const Tool& tool, const dvec3& center_W, double radius, const Pose& X_WT, const VoxelFrame& frame)
    : label_(tool.fill),
      within_(tool.fill_within.get()),
      frame_(frame),
      head_(HeadField::with_exit_path(tool, frame.voxel)),
      center_(frame.to_voxels(center_W)),
      radius_(radius / frame.voxel),
      X_VT_{frame.to_voxels(X_WT.p), X_WT.R} {
  const dvec3 reach(radius_ + static_cast<double>(Sweep::kMargin));
  lo_ = glm::ivec3(glm::ceil(center_ - reach));
  hi_ = glm::ivec3(glm::floor(center_ + reach));
}

double Fill::beyond_limit(const dvec3& p) const noexcept {
  return within_->distance(frame_.to_world(p)) / frame_.voxel;
}

double Fill::kept_by_head(const dvec3& p) const noexcept {
  return static_cast<double>(kClear) - head_.distance(glm::conjugate(X_VT_.R) * (p - X_VT_.p));
}

}  // namespace typodont::haptics
