#include "haptics/import/corrections.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>

#include "engine/base/error.h"
#include "engine/base/nearest.h"
#include "engine/base/units.h"
#include "engine/base/voxels.h"
#include "haptics/dense_tissue.h"
#include "haptics/import/blocks.h"
#include "haptics/import/import.h"
#include "haptics/import/import_scan.h"

namespace typodont::haptics {

namespace {

using importing::Grid;
using importing::Mask;

/// Tissue of a kind at a sample. Its grey value decides between enamel and dentin, or cortical and cancellous bone.
Tissue tissue_of(const Imported& imported, LabelKind kind, std::size_t at) {
  const double grey = imported.grey.empty() ? imported.report.kinds.cortical : static_cast<double>(imported.grey[at]);
  switch (kind) {
    case LabelKind::kBone:
      return grey >= imported.report.kinds.cortical ? Tissue::kCorticalBone : Tissue::kCancellousBone;
    case LabelKind::kTooth:
      return grey >= imported.report.kinds.enamel ? Tissue::kEnamel : Tissue::kDentin;
    case LabelKind::kMetal:
      return Tissue::kAmalgam;
    case LabelKind::kCanal:
      return Tissue::kPulp;
    case LabelKind::kNothing:
      break;
  }
  return Tissue::kAir;
}

void set_label(Imported& imported, LabelKind kind, std::size_t at) {
  DenseTissue& t = imported.tissue;
  t.tissue[at] = tissue_of(imported, kind, at);
  if (t.hardness.empty()) return;
  t.hardness[at] = kOwnHardness;
  if (!imported.report.jaw || kind != LabelKind::kBone || imported.grey.empty()) return;
  const KindGreys& k = imported.report.kinds;
  const double own = t.tissue[at] == Tissue::kCorticalBone ? k.own_cortical : k.own_cancellous;
  t.hardness[at] = hardness_byte((static_cast<double>(imported.grey[at]) - k.soft) / (own - k.soft));
}

BoxContent copy_of(const DenseTissue& t, const VoxelBox& box) {
  BoxContent content{box, {}, {}, {}};
  for (int x = box.lo.x; x <= box.hi.x; ++x) {
    for (int y = box.lo.y; y <= box.hi.y; ++y) {
      const auto from = static_cast<std::ptrdiff_t>(t.at(x, y, box.lo.z)), to = from + box.hi.z - box.lo.z + 1;
      const auto copy = [&](const auto& all, auto& part) {
        part.insert(part.end(), all.begin() + from, all.begin() + to);
      };
      copy(t.distance, content.distance);
      copy(t.tissue, content.tissue);
      if (!t.hardness.empty()) copy(t.hardness, content.hardness);
    }
  }
  return content;
}

VoxelBox box_around(const DenseTissue& t, const dvec3& lo, const dvec3& hi, double reach) {
  const VoxelBox box{glm::ivec3(glm::floor(t.frame.to_voxels(lo - reach))),
                     glm::ivec3(glm::ceil(t.frame.to_voxels(hi + reach)))};
  return common(box, {glm::ivec3(0), t.size - 1});
}

template <class Work>
void for_each_in(const VoxelBox& box, Work work) {
  for_each_voxel_between(box.lo, box.hi, [&](int x, int y, int z) { work(glm::ivec3(x, y, z)); });
}

/// Removes the tissue inside `solid` (function: signed distance, m). Samples near the new surface keep their labels.
void remove(DenseTissue& t, const VoxelBox& box, const std::function<double(const glm::ivec3&)>& solid) {
  for_each_in(box, [&](const glm::ivec3& p) {
    const std::size_t at = t.at(p.x, p.y, p.z);
    const double d = std::clamp(-solid(p), static_cast<double>(t.distance[at]), t.band);
    t.distance[at] = static_cast<float>(d);
    if (d > importing::kLabelReach * t.frame.voxel) t.tissue[at] = Tissue::kAir;
  });
}

BoxContent paint(Imported& imported, const LabelStroke& stroke) {
  DenseTissue& t = imported.tissue;
  if (stroke.path.empty()) return {};
  dvec3 lo(stroke.path.front()), hi(lo);
  for (const dvec3& p : stroke.path) lo = glm::min(lo, p), hi = glm::max(hi, p);
  const bool only_labels = stroke.only_tissue && stroke.kind != LabelKind::kNothing;
  const VoxelBox box = box_around(t, lo, hi, stroke.radius + (only_labels ? 0 : t.band));
  if (box.empty()) return {};
  BoxContent before = copy_of(t, box);
  const auto capsule = [&](const glm::ivec3& p) {
    return distance_to_path(stroke.path, t.frame.to_world(dvec3(p))) - stroke.radius;
  };
  if (stroke.kind == LabelKind::kNothing) {
    remove(t, box, capsule);
  } else if (only_labels) {
    for_each_in(box, [&](const glm::ivec3& p) {
      const std::size_t at = t.at(p.x, p.y, p.z);
      if (t.tissue[at] != Tissue::kAir && capsule(p) <= 0) set_label(imported, stroke.kind, at);
    });
  } else {
    // Distance from a wall of the box within which no tissue is added, voxels, because tissue cannot have a surface
    // there.
    constexpr double kWall = 3;
    for_each_in(box, [&](const glm::ivec3& p) {
      const std::size_t at = t.at(p.x, p.y, p.z);
      const glm::ivec3 from_wall = glm::min(p, t.size - 1 - p);
      const double wall = (kWall - std::min({from_wall.x, from_wall.y, from_wall.z})) * t.frame.voxel;
      const double added = std::max(capsule(p), wall), before_d = static_cast<double>(t.distance[at]);
      if (added <= 0 || (added < before_d && added <= importing::kLabelReach * t.frame.voxel))
        set_label(imported, stroke.kind, at);
      t.distance[at] = static_cast<float>(std::clamp(std::min(before_d, added), -t.band, t.band));
    });
  }
  return before;
}

BoxContent grow(Imported& imported, const LabelSeed& seed) {
  DenseTissue& t = imported.tissue;
  const VoxelBox room = box_around(t, seed.point, seed.point, seed.reach);
  const glm::ivec3 start(glm::round(t.frame.to_voxels(seed.point)));
  const auto at = [&](const glm::ivec3& p) { return t.at(p.x, p.y, p.z); };
  const auto in_room = [&](const glm::ivec3& p) {
    return glm::all(glm::greaterThanEqual(p, room.lo)) && glm::all(glm::lessThanEqual(p, room.hi)) &&
           glm::length(t.frame.to_world(dvec3(p)) - seed.point) <= seed.reach;
  };
  if (room.empty() || !in_room(start) || !(t.distance[at(start)] < 0)) return {};
  // Mean grey value of a sample and its neighbours, to reduce noise.
  const auto grey = [&](const glm::ivec3& p) {
    if (imported.grey.empty()) return 0.0;
    double sum = static_cast<double>(imported.grey[at(p)]), count = 1;
    for (const glm::ivec3& f : kFaceSteps) {
      const glm::ivec3 q = glm::clamp(p + f, glm::ivec3(0), t.size - 1);
      sum += static_cast<double>(imported.grey[at(q)]), count += 1;
    }
    return sum / count;
  };
  const double middle = grey(start);
  const double limit = seed.tolerance * (imported.report.soft_grey - imported.report.outside_grey);
  const glm::ivec3 size = room.hi - room.lo + 1;
  Mask part(size, 0);
  std::deque<glm::ivec3> open{start};
  part[start - room.lo] = 1;
  std::array<bool, kTissueCount> replaced{};
  while (!open.empty()) {
    const glm::ivec3 p = open.front();
    open.pop_front();
    replaced[static_cast<std::size_t>(t.tissue[at(p)])] = true;
    for (const glm::ivec3& f : kFaceSteps) {
      const glm::ivec3 q = p + f;
      if (!in_room(q) || part[q - room.lo] || !(t.distance[at(q)] < 0)) continue;
      // Without grey values (mesh), samples with the label of the seed are similar.
      const bool similar =
          imported.grey.empty() ? t.tissue[at(q)] == t.tissue[at(start)] : std::abs(grey(q) - middle) <= limit;
      if (!similar) continue;
      part[q - room.lo] = 1;
      open.push_back(q);
    }
  }
  // Adds one layer of samples around the part, because its border is blurred. Only labels that occur in the part are
  // included; this can add samples just outside the surface.
  const Mask core = part;
  for_each_in(room, [&](const glm::ivec3& p) {
    if (core[p - room.lo] || !in_room(p) || !replaced[static_cast<std::size_t>(t.tissue[at(p)])]) return;
    const bool beside = std::ranges::any_of(kFaceSteps, [&](const glm::ivec3& f) {
      const glm::ivec3 q = p + f - room.lo;
      return core.holds(q) && core[q];
    });
    if (beside) part[p - room.lo] = 1;
  });
  if (seed.kind != LabelKind::kNothing) {
    BoxContent before = copy_of(t, room);
    for_each_in(room, [&](const glm::ivec3& p) {
      if (part[p - room.lo]) set_label(imported, seed.kind, at(p));
    });
    return before;
  }
  // The removed region extends half a voxel beyond its samples. Its border is smoothed, because samples form steps.
  const VoxelBox box = box_around(t, seed.point, seed.point, seed.reach + t.band);
  BoxContent before = copy_of(t, box);
  Mask inside(box.hi - box.lo + 1, 0), outside(inside.size, 1);
  for_each_in(room, [&](const glm::ivec3& p) {
    if (!part[p - room.lo]) return;
    inside[p - box.lo] = 1;
    outside[p - box.lo] = 0;
  });
  const Grid<float> to_part = distance_squared_to(inside), to_rest = distance_squared_to(outside);
  Grid<float> solid(inside.size);
  for (std::size_t i = 0; i < solid.v.size(); ++i)
    solid.v[i] = inside.v[i] ? 0.5F - std::sqrt(to_rest.v[i]) : std::sqrt(to_part.v[i]) - 0.5F;
  constexpr double kSmooth = 0.8;  // voxels, standard deviation of the Gaussian that smooths the distance to the part
  solid = gaussian(solid, kSmooth);
  remove(t, box, [&](const glm::ivec3& p) { return static_cast<double>(solid[p - box.lo]) * t.frame.voxel; });
  return before;
}

}  // namespace

BoxContent correct(Imported& imported, const Correction& correction) {
  const double size = std::visit(
      [](const auto& c) {
        if constexpr (requires { c.radius; })
          return c.radius;
        else
          return c.reach;
      },
      correction);
  if (!(size >= 0.5 * imported.tissue.frame.voxel))
    throw Error("correction", "", fmt::format("{:g} mm", size / kMillimetre),
                fmt::format("at least half a voxel of {:g} mm", imported.tissue.frame.voxel / kMillimetre));
  if (const auto* stroke = std::get_if<LabelStroke>(&correction)) return paint(imported, *stroke);
  return grow(imported, std::get<LabelSeed>(correction));
}

void exchange(Imported& imported, BoxContent& content) {
  DenseTissue& t = imported.tissue;
  std::size_t from = 0;
  const VoxelBox& box = content.box;
  if (box.empty()) return;
  const auto count = static_cast<std::size_t>(box.hi.z - box.lo.z + 1);
  for (int x = box.lo.x; x <= box.hi.x; ++x) {
    for (int y = box.lo.y; y <= box.hi.y; ++y, from += count) {
      const std::size_t at = t.at(x, y, box.lo.z);
      const auto swap_row = [&](auto& all, auto& part) {
        std::swap_ranges(part.begin() + static_cast<std::ptrdiff_t>(from),
                         part.begin() + static_cast<std::ptrdiff_t>(from + count),
                         all.begin() + static_cast<std::ptrdiff_t>(at));
      };
      swap_row(t.distance, content.distance);
      swap_row(t.tissue, content.tissue);
      if (!t.hardness.empty()) swap_row(t.hardness, content.hardness);
    }
  }
}

PerTissue volumes_in(const BoxContent& content, double voxel) {
  PerTissue volume{};
  for (std::size_t i = 0; i < content.distance.size(); ++i) {
    // Fraction of the voxel inside the tissue, as if the surface were a plane at the distance of the voxel's centre.
    const double fraction = std::clamp(0.5 - static_cast<double>(content.distance[i]) / voxel, 0.0, 1.0);
    volume[static_cast<std::size_t>(content.tissue[i])] += fraction * voxel * voxel * voxel;
  }
  return volume;
}

PerTissue volumes_in(const DenseTissue& tissue, const VoxelBox& box) {
  return box.empty() ? PerTissue{} : volumes_in(copy_of(tissue, box), tissue.frame.voxel);
}

}  // namespace typodont::haptics
