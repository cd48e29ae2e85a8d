#include "haptics/import/local_grey.h"

#include <cmath>

#include "engine/base/voxels.h"

namespace typodont::haptics::importing {

std::optional<LocalGrey> reference_grey(const Grid<float>& grey, const SparseMask& tissue, std::size_t enough,
                                        double least, double blur) {
  const std::shared_ptr<const BlockSet>& set = tissue.set;
  const SparseMask others = where(set, true, true, [&](std::size_t i) { return !tissue.v[i]; });
  const Sparse<float> away = distance_squared_to(others, 4);
  const auto sharp = [&](const glm::ivec3& p) {
    const auto here = static_cast<double>(grey[p]);
    if (blur == 0) return here;
    double rise = 0;
    for (const glm::ivec3& f : kFaceSteps) rise += static_cast<double>(grey[p + f]) - here;
    // Distance of the sample from the border, in units of `blur`. The border is 0.5 voxel from the next sample outside.
    const double z = std::clamp((std::sqrt(static_cast<double>(away[p])) - 0.5) / blur, 0.5, 6.0);
    const double density = std::exp(-0.5 * z * z) / std::sqrt(2 * M_PI);
    return here - blur * blur * rise * 0.5 * std::erfc(z / std::sqrt(2.0)) / (z * density);
  };
  // If too few samples are far from the border, samples nearer to it are used.
  for (const double far : {3.0, 2.5, 2.0, 1.5, 1.4}) {
    if (far < least) break;
    const auto counts = [&](const glm::ivec3&, std::size_t i) { return away.v[i] >= static_cast<float>(far * far); };
    double sum = 0;
    std::size_t count = 0;
    for (std::size_t i = 0; i < away.v.size(); ++i) {
      const glm::ivec3 p = set->place(i);
      if (tissue.v[i] && set->holds(p) && counts(p, i)) sum += sharp(p), ++count;
    }
    if (count >= enough) return LocalGrey(sharp, *set, sum / static_cast<double>(count), counts);
  }
  return std::nullopt;
}

}  // namespace typodont::haptics::importing
