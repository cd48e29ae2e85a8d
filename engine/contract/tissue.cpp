#include "engine/contract/tissue.h"

#include <algorithm>

namespace typodont {

static constexpr std::array<std::string_view, kTissueCount> kNames = {
    "air", "enamel", "dentin", "caries", "pulp", "cortical_bone", "cancellous_bone", "gingiva", "amalgam", "composite",
};

std::string_view name_of(Tissue tissue) noexcept {
  const auto i = static_cast<std::size_t>(tissue);
  return i < kNames.size() ? kNames[i] : "unknown";
}

std::optional<Tissue> tissue_named(std::string_view name) noexcept {
  for (int i = 0; i < kTissueCount; ++i) {
    if (kNames[static_cast<std::size_t>(i)] == name) return static_cast<Tissue>(i);
  }
  return std::nullopt;
}

VoxelColor voxel_color(const dvec3& srgb) noexcept {
  const glm::ivec3 level(glm::round(glm::clamp(srgb, 0.0, 1.0) * dvec3(31, 63, 31)));
  return static_cast<VoxelColor>(std::max(level.x << 11 | level.y << 5 | level.z, 1));
}

dvec3 srgb_of(VoxelColor color) noexcept {
  return {(color >> 11) / 31.0, (color >> 5 & 63) / 63.0, (color & 31) / 31.0};
}

}  // namespace typodont
