#include "engine/app/debris_view.h"

#include <algorithm>

namespace typodont {

namespace {

constexpr double kCoarse = 4e-4;      // m: chips bounce off the tooth's shape, not off the new cavity's fine detail
constexpr float kLeastShown = 3e-5f;  // m: smaller ones are drawn this large, and fainter

}  // namespace

DebrisView::DebrisView(const MaterialTable& materials, const haptics::TissueVolume& tissue) : materials_(materials) {
  // Every n-th sample of the volume, so that no interpolation is needed.
  glm::ivec3 lo, hi;
  tissue.bounds(lo, hi);
  if (lo.x > hi.x) return;
  const VoxelFrame& frame = tissue.frame();
  const int every = std::max(1, static_cast<int>(kCoarse / frame.voxel));
  const glm::ivec3 size = hi - lo + 1;
  std::vector<float> fine(static_cast<std::size_t>(size.x) * size.y * size.z);
  tissue.copy(lo, size, fine.data(), nullptr);
  field_.size = (size + every - 1) / every;
  field_.origin = frame.to_world(dvec3(lo));
  field_.spacing = every * frame.voxel;
  distance_.reserve(static_cast<std::size_t>(field_.size.x) * field_.size.y * field_.size.z);
  for (int x = 0; x < size.x; x += every) {
    for (int y = 0; y < size.y; y += every) {
      for (int z = 0; z < size.z; z += every) {
        const std::size_t i =
            (static_cast<std::size_t>(x) * size.y + static_cast<std::size_t>(y)) * size.z + static_cast<std::size_t>(z);
        distance_.push_back(fine[i] * static_cast<float>(frame.voxel));
      }
    }
  }
  field_.distance = distance_.data();
}

std::span<const render::Particle> DebrisView::particles() {
  points_.resize(debris_.alive());
  const std::size_t count = debris_.write_points(points_);
  particles_.clear();
  for (std::size_t i = 0; i < count; ++i) {
    const debris::DebrisPoint& point = points_[i];
    const float share = std::min(1.0f, point.diameter / kLeastShown);
    particles_.push_back({point.p_W, std::max(point.diameter, kLeastShown) / 2,
                          glm::vec3(materials_[static_cast<std::size_t>(point.tissue)].color), share});
  }
  return particles_;
}

}  // namespace typodont
