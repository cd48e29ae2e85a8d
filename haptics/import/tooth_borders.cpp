#include "haptics/import/tooth_borders.h"

#include <algorithm>
#include <cmath>

#include "engine/base/voxels.h"
#include "haptics/import/partial_volume.h"

namespace typodont::haptics::importing {

namespace {

// Curvature of the surface per voxel, positive if convex. Limited, because at edges it has no finite value.
double curvature_at(const Sparse<float>& distance, const glm::ivec3& p) {
  constexpr double kMost = 0.5;
  const glm::ivec3 hi = distance.set->size - 1;
  double sum = 0;
  for (const glm::ivec3& f : kFaceSteps)
    sum += static_cast<double>(distance[glm::clamp(p + f, glm::ivec3(0), hi)]) - static_cast<double>(distance[p]);
  return std::clamp(0.5 * sum, -kMost, kMost);
}

}  // namespace

void match_tooth_volumes(const Grid<float>& grey, Segmentation& s, const SparseMask& enamel, const SparseMask& pulp,
                         const Levels& levels, const std::optional<LocalGrey>& enamel_grey, double pulp_grey,
                         const LocalGrey& outside) {
  // Voxels. Blur changes grey values up to kBlurred from a border of tissues, and up to kOutside outside the surface.
  constexpr float kBlurred = 2.5F;
  constexpr double kOutside = 3;
  constexpr double kMin = -0.25, kMost = 1.25;  // limits of a voxel's estimated tissue fraction, because it is noisy
  const std::shared_ptr<const BlockSet>& set = s.dense.set;
  const Sparse<float>& d = s.surface.distance;
  const double blur = std::max(kMinBlur, s.blur);
  const SparseMask body = where(set, false, false, [&](std::size_t, const glm::ivec3& p) { return d[p] <= 0; });
  const SparseMask dentin =
      where(set, false, true, [&](std::size_t i) { return body.v[i] && !enamel.v[i] && !pulp.v[i]; });
  constexpr std::size_t kEnoughDentin = 200, kEnoughPulp = 5;
  const std::optional<LocalGrey> dentin_grey = reference_grey(grey, dentin, kEnoughDentin, 2, blur),
                                 own_pulp_grey = reference_grey(grey, pulp, kEnoughPulp, 1.4, 0);
  const Sparse<float> to_enamel = distance_squared_to(enamel, 4), to_pulp = distance_squared_to(pulp, 4),
                      to_dentin = distance_squared_to(dentin, 4);
  // Corrects the border of one tissue. `usual`: contrast of this tissue to dentin in the whole scan.
  const auto match = [&](Sparse<float>& field, const SparseMask& tissue, const Sparse<float>& to_tissue,
                         const Sparse<float>& to_other, double usual, auto own_grey) {
    constexpr float kReach = kBlurred * kBlurred;
    constexpr double kMinContrast = 0.3;  // smallest local contrast, as a fraction of `usual`
    const SparseMask others = where(set, true, true, [&](std::size_t i) { return !tissue.v[i]; });
    const Sparse<float> into = distance_squared_to(others, 4);
    Sparse<float> fraction(set, 0, 0);
    SparseMask border(set, 0, 0);
    for_each_sample(*set, [&](const glm::ivec3& p, std::size_t i) {
      const double at = d[p];
      if (to_tissue.v[i] > kReach || to_other.v[i] < to_tissue.v[i] || at > kOutside) return;
      border.v[i] = body.v[i] && to_dentin.v[i] <= kReach;
      if (into.v[i] > kReach) {
        fraction.v[i] = 1;
        return;
      }
      // of_dentin: grey value of dentin here. displaced: blur makes a convex surface appear displaced inwards.
      const double of_dentin = dentin_grey ? dentin_grey->at(p) : levels.soft;
      const double displaced = at + blur * blur * curvature_at(d, p);
      const double without = glm::mix(of_dentin, outside.at(p), 0.5 * std::erfc(-displaced / (std::sqrt(2.0) * blur)));
      const double contrast = usual * std::max(kMinContrast, (own_grey(p) - of_dentin) / usual);
      const double found = (static_cast<double>(grey[p]) - without) / contrast;
      fraction.v[i] = static_cast<float>(std::clamp(found, kMin, kMost));
    });
    match_volume(field, fraction, border, body, blur);
  };
  if (enamel_grey && levels.top() > levels.soft)
    match(s.dense, enamel, to_enamel, to_pulp, levels.top() - levels.soft,
          [&](const glm::ivec3& p) { return enamel_grey->at(p); });
  if (pulp_grey < levels.soft)
    match(s.cavity, pulp, to_pulp, to_enamel, pulp_grey - levels.soft,
          [&](const glm::ivec3& p) { return own_pulp_grey ? own_pulp_grey->at(p) : pulp_grey; });
}

}  // namespace typodont::haptics::importing
