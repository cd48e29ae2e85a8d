#include "haptics/import/cavities.h"

#include <algorithm>

#include "engine/base/quantile.h"
#include "engine/base/voxels.h"

namespace typodont::haptics::importing {

std::vector<bool> Hollows::operator()(const SparseComponents& spaces) const {
  constexpr std::size_t kMin = 30;  // voxels; a dark space with fewer voxels than this is noise
  std::vector<bool> hollow(spaces.voxels.size(), false);
  std::vector<std::vector<float>> greys(spaces.voxels.size());
  for (std::size_t i = 0; i < spaces.label.v.size(); ++i) {
    if (const std::int32_t id = spaces.label.v[i]; id > 0 && smooth_.holds(smooth_.place(i)))
      greys[static_cast<std::size_t>(id)].push_back(smooth_.v[i]);
  }
  for (std::size_t id = 1; id < hollow.size(); ++id) {
    hollow[id] = static_cast<double>(spaces.voxels[id]) > largest_;
    if (!air_ || spaces.voxels[id] < kMin || greys[id].empty()) continue;
    hollow[id] = hollow[id] || nth(greys[id], greys[id].size() / 2) < *air_;
  }
  return hollow;
}

SparseMask find_cavities(const SparseMask& solid, const SparseMask& dense, double widest_mouth, bool tooth,
                         const std::shared_ptr<BlockSet>& set, const Hollows& hollows, SparseMask& hollow) {
  SparseMask outside, cavity(set, 0, 1);
  hollow = SparseMask(set, 0, 0);
  {
    const SparseMask open = where(set, true, true, [&](std::size_t i) { return !solid.v[i]; });
    Reached reached = reached_from_walls(open);
    outside = std::move(reached.samples);
    outside.outside = 1;
    if (!tooth) {
      const SparseMask closed = where(set, true, false, [&](std::size_t i) { return open.v[i] && !outside.v[i]; });
      const SparseComponents spaces = components(closed);
      const std::vector<bool> is_hollow = hollows(spaces);
      for (std::size_t b = 0; b < set->slot.size(); ++b) {
        const std::int32_t id = spaces.blocks[b];
        if (id > 0 && is_hollow[static_cast<std::size_t>(id)]) reached.blocks[b] = 1;
      }
      for_each_sample(*set, [&](std::size_t i) {
        if (!closed.v[i] || !is_hollow[static_cast<std::size_t>(spaces.label.v[i])]) return;
        hollow.v[i] = outside.v[i] = 1;
      });
    }
    for (std::size_t b = 0; b < set->slot.size(); ++b) {
      if (set->slot[b] == BlockSet::kOutside && !reached.blocks[b]) set->slot[b] = BlockSet::kInside;
    }
    for_each_sample(*set, [&](std::size_t i) { cavity.v[i] = open.v[i] && !outside.v[i]; });
  }

  const Sparse<float> clearance = distance_squared_to(solid, static_cast<int>(widest_mouth) + 1);
  // The rim of a wide opening need not be exact, so the radius of a large ball grows in longer steps.
  constexpr double kFine = 8;  // voxels; if the ball's radius is larger, it grows in longer steps
  for (double r = 1; r <= widest_mouth; r += r < kFine ? 0.5 : 0.15 * r) {
    const SparseMask roomy = where(set, true, false, [&](std::size_t i) {
      return !solid.v[i] && !cavity.v[i] && clearance.v[i] > static_cast<float>(r * r);
    });
    SparseMask centres = reached_from_walls(roomy).samples;
    centres.outside = 1;
    const Sparse<float> from_centre = distance_squared_to(centres, static_cast<int>(r + 1) + 1);
    const SparseMask pocket = where(set, false, false, [&](std::size_t i) {
      return outside.v[i] && !hollow.v[i] && !cavity.v[i] && from_centre.v[i] > static_cast<float>((r + 1) * (r + 1));
    });
    const SparseComponents parts = components(pocket);
    // A pocket with air (maxillary sinus) is not a cavity of the bone.
    const std::vector<bool> holds_air = tooth ? std::vector<bool>(parts.voxels.size(), false) : hollows(parts);
    std::vector<Contacts> faces(parts.voxels.size());
    for (std::size_t i = 0; i < pocket.v.size(); ++i) {
      const auto id = static_cast<std::size_t>(parts.label.v[i]);
      if (id == 0) continue;
      const glm::ivec3 p = pocket.place(i);
      for (const glm::ivec3& f : kFaceSteps) {
        const glm::ivec3 q = p + f;
        if (!pocket.holds(q) || (outside[q] && !pocket[q] && !cavity[q])) {
          ++faces[id].mouth;
        } else if (cavity[q]) {
          ++faces[id].cavity;
        } else if (solid[q]) {
          ++faces[id].wall;
          faces[id].dense += dense[q];
        }
      }
    }
    for (std::size_t i = 0; i < pocket.v.size(); ++i) {
      const auto id = static_cast<std::size_t>(parts.label.v[i]);
      if (id == 0) continue;
      const Contacts& f = faces[id];
      const bool narrow =
          parts.voxels[id] >= 30 && static_cast<double>(f.mouth) < 0.04 * static_cast<double>(f.mouth + f.wall);
      // True: the pocket is only the opening of a cavity that was found with a smaller ball.
      const bool plug = 2 * f.cavity > f.mouth;
      if ((narrow || plug) && !holds_air[id] && !(tooth && 2 * f.dense > f.wall + f.cavity)) cavity.v[i] = 1;
    }
  }
  return cavity;
}

}  // namespace typodont::haptics::importing
