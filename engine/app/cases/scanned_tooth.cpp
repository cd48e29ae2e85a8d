#include "engine/app/cases/scanned_tooth.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "engine/app/assets.h"
#include "engine/app/scene.h"
#include "engine/base/error.h"
#include "engine/base/quantile.h"
#include "engine/base/voxels.h"
#include "engine/session/place.h"

namespace typodont {

namespace {

constexpr double kSlice = 0.2e-3;     // m, height of the slices in which widths are measured
constexpr double kLowest = 0.02;      // fraction of a side's enamel below its edge: voxels with a wrong label
constexpr double kSideCosine = 0.97;  // a side is within 14° of its direction

/// Extent of points, m.
struct Extent {
  dvec3 low{1}, high{-1};
  void add(const dvec3& p) { low = glm::min(low, p), high = glm::max(high, p); }
  dvec3 middle() const { return 0.5 * (low + high); }
  dvec3 size() const { return glm::max(high - low, dvec3(0)); }
};

/// Calls visit(p, tissue) for each sample inside the tooth; p: its position in the axes R, m.
template <class Visit>
void each_inside(const DenseCopy& copy, const glm::dmat3& R, Visit visit) {
  for_each_voxel(copy.field.size, [&](int x, int y, int z) {
    if (const std::size_t i = copy.field.at(x, y, z); copy.field.distance[i] < 0)
      visit(glm::transpose(R) * copy.frame.to_world(dvec3(x, y, z)), copy.tissue[i]);
  });
}

/// Height of the enamel's edge on the mesial, distal, buccal and lingual side. Empty if a side has no enamel.
std::optional<std::array<double, 4>> enamel_edges(const DenseCopy& copy, const glm::dmat3& R, const dvec3& middle) {
  std::array<std::vector<double>, 4> heights;
  each_inside(copy, R, [&](const dvec3& p, Tissue tissue) {
    if (tissue != Tissue::kEnamel) return;
    const glm::dvec2 out = glm::dvec2(p - middle) / (glm::length(glm::dvec2(p - middle)) + 1e-9);
    const std::array along{out.x, -out.x, out.y, -out.y};
    for (std::size_t side = 0; side < 4; ++side)
      if (along[side] > kSideCosine) heights[side].push_back(p.z);
  });
  std::array<double, 4> edges{};
  for (std::size_t side = 0; side < 4; ++side) {
    if (heights[side].empty()) return std::nullopt;
    edges[side] = quantile(heights[side], kLowest);
  }
  return edges;
}

}  // namespace

ScannedTooth::ScannedTooth(const haptics::TissueVolume& volume, const DenseCopy& copy, const glm::dmat3& R_WT,
                           const dvec3& p_WT)
    : field_(volume), frame_(copy.frame), pulp_(label_distance(copy, {Tissue::kPulp})), R_WT_(R_WT), p_WT_(p_WT) {}

double ScannedTooth::pulp_distance(const dvec3& p) const {
  return pulp_.sample(frame_.to_voxels(to_W(p))) * frame_.voxel;
}

Tissue ScannedTooth::tissue(const dvec3& p) const {
  const Tissue inside = field_.tissue(to_W(p)),
               found = inside == Tissue::kAir ? field_.tissue_at_surface(to_W(p)) : inside;
  return found == Tissue::kAir ? Tissue::kDentin : found;
}

CaseTooth scanned_tooth(const std::string& type, const std::filesystem::path& file) {
  const Scene scene = read_scene(find_scene(file.string()));
  const auto sides = session::tooth_sides(Json::parse(scene.text, scene.file.string()));
  if (!sides)
    throw Error(scene.file.string(), "tooth", "no such key", "the mesial and the buccal side of the scanned tooth");
  const haptics::TissueVolume volume = load_untouched(scene);
  const DenseCopy copy = dense_copy(volume);
  const glm::dmat3 R{sides->mesial_W, sides->buccal_W, glm::cross(sides->mesial_W, sides->buccal_W)};
  Extent enamel, pulp, whole;
  each_inside(copy, R, [&](const dvec3& p, Tissue tissue) {
    whole.add(p);
    if (tissue == Tissue::kEnamel) enamel.add(p);
    if (tissue == Tissue::kPulp) pulp.add(p);
  });
  if (enamel.size().z <= 0 || pulp.size().z <= 0)
    throw Error(scene.file.string(), "tissue", "no tooth with enamel and pulp", "a labelled scan of a tooth");
  if (enamel.middle().z < whole.middle().z)
    throw Error(scene.file.string(), "tooth", "mesial × buccal points to the root",
                "a tooth of the lower left or upper right side, or the mirror image of the scan");
  const auto edges = enamel_edges(copy, R, enamel.middle());
  if (!edges)
    throw Error(scene.file.string(), "tissue", "a side of the crown without enamel", "a labelled scan of a tooth");
  const std::array<double, 4>& edge = *edges;
  const dvec3 origin(enamel.middle().x, enamel.middle().y, 0.5 * (edge[2] + edge[3]));

  CaseTooth tooth;
  tooth.type = type;
  tooth.name = tooth_name(type) + ", scanned";
  tooth.cej_mesial = edge[0] - origin.z;
  tooth.cej_distal = edge[1] - origin.z;
  Extent crown, neck, all;
  std::map<long, std::array<double, 2>> width;  // m, by slice: largest distance to mesial and to distal
  const auto slice = [](double z) { return std::lround(z / kSlice); };
  each_inside(copy, R, [&](const dvec3& at, Tissue) {
    const dvec3 p = at - origin;
    all.add(p);
    if (std::abs(p.z) < kSlice) neck.add(p);
    if (p.z < 0) return;
    crown.add(p);
    auto& of = width[slice(p.z)];
    of = {std::max(of[0], p.x), std::max(of[1], -p.x)};
  });
  tooth.md = crown.size().x;
  tooth.bl = crown.size().y;
  tooth.crown = all.high.z;
  tooth.root = -all.low.z;
  const auto widest = std::ranges::max_element(width, {}, [](const auto& of) { return of.second[0] + of.second[1]; });
  // Only sizes: the surface is that of the scan.
  tooth.form.widest = 2.0 * glm::dvec2(glm::max(-all.low, all.high));
  tooth.form.neck = glm::dvec2(neck.size());
  tooth.form.height = tooth.crown;
  tooth.form.root = tooth.root;
  tooth.form.proximal = static_cast<double>(widest->first) * kSlice;
  tooth.scan = std::make_shared<const ScannedTooth>(volume, copy, R, R * origin);
  return tooth;
}

}  // namespace typodont
