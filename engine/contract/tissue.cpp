#include "engine/contract/tissue.h"

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

}  // namespace typodont
