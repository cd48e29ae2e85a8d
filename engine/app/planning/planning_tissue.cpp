#include "engine/app/planning/planning_tissue.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "engine/base/units.h"
#include "engine/base/voxels.h"
#include "haptics/dense_tissue.h"

namespace typodont {

namespace {

// Grey values for pictures and mean values, Hounsfield units.
constexpr double kAirGrey = -1000, kSoftGrey = 50, kToothGrey = 3000, kDentinGrey = 1700, kMetalGrey = 10000;
constexpr double kShortestCanal = 8e-3;  // m; a shorter piece of nerve tissue is no canal
constexpr double kSection = 2e-3;        // m, length of a section of a canal
// Smallest number of voxels in a used section of a canal, as a fraction of the median of all sections.
constexpr double kWholeSection = 0.6;
constexpr int kSlab = 16;  // number of samples along x copied at a time

}  // namespace

PlanningTissue::PlanningTissue(const haptics::TissueVolume& volume) : bone_grey_(load_bone_grey()) {
  glm::ivec3 lo, hi;
  volume.bounds(lo, hi);
  int n = 1;
  const auto count = [&] {
    const dvec3 size = dvec3(hi - lo) / static_cast<double>(n) + 1.0;
    return size.x * size.y * size.z;
  };
  while (count() > kMaxSamples) ++n;
  const glm::ivec3 first = glm::ivec3(glm::floor(dvec3(lo) / static_cast<double>(n)));
  size_ = glm::ivec3(glm::ceil(dvec3(hi) / static_cast<double>(n))) - first + 1;
  if (glm::any(glm::lessThanEqual(size_, glm::ivec3(0)))) size_ = glm::ivec3(0);
  frame_ = {volume.frame().to_world(dvec3(first * n)), volume.frame().voxel * n};
  const std::size_t slice = static_cast<std::size_t>(size_.y) * static_cast<std::size_t>(size_.z);
  tissue_.resize(static_cast<std::size_t>(size_.x) * slice);
  hardness_.resize(tissue_.size());
  std::vector<float> distance(kSlab * slice);
  for (int x = 0; x < size_.x; x += kSlab) {
    const int thick = std::min(kSlab, size_.x - x);
    const std::size_t at = static_cast<std::size_t>(x) * slice, length = static_cast<std::size_t>(thick) * slice;
    volume.copy_every(n, first + glm::ivec3(x, 0, 0), {thick, size_.y, size_.z}, distance.data(), tissue_.data() + at,
                      hardness_.data() + at);
    for (std::size_t i = 0; i < length; ++i)
      if (distance[i] >= 0) tissue_[at + i] = Tissue::kAir;
  }
}

std::size_t PlanningTissue::index(const dvec3& p_W) const {
  const glm::ivec3 p = glm::ivec3(glm::round(frame_.to_voxels(p_W)));
  return inside(p) ? index(p) : tissue_.size();
}

Tissue PlanningTissue::at(const dvec3& p_W) const {
  const std::size_t i = index(p_W);
  return i < tissue_.size() ? tissue_[i] : Tissue::kAir;
}

bool PlanningTissue::is_bone(const dvec3& p_W) const {
  return typodont::is_bone(at(p_W));
}
bool PlanningTissue::is_tooth(const dvec3& p_W) const {
  return typodont::is_tooth(at(p_W));
}

double PlanningTissue::grey(const dvec3& p_W) const {
  const std::size_t i = index(p_W);
  if (i >= tissue_.size()) return kAirGrey;
  const double hardness = haptics::hardness_fraction(hardness_[i]);
  switch (tissue_[i]) {
    case Tissue::kAir:
      return kAirGrey;
    case Tissue::kCorticalBone:
      return bone_grey_.cortical * hardness;
    case Tissue::kCancellousBone:
      return bone_grey_.cancellous * hardness;
    case Tissue::kPulp:
    case Tissue::kGingiva:
      return kSoftGrey;
    case Tissue::kAmalgam:
      return kMetalGrey;
    case Tissue::kEnamel:
      return kToothGrey * hardness;
    default:
      return kDentinGrey * hardness;
  }
}

std::vector<std::pair<glm::ivec3, int>> PlanningTissue::distances_within_piece(const glm::ivec3& from) const {
  const Tissue tissue = tissue_[index(from)];
  std::unordered_map<std::size_t, int> seen{{index(from), 0}};
  std::vector<std::pair<glm::ivec3, int>> piece{{from, 0}};
  for (std::size_t i = 0; i < piece.size(); ++i) {
    const auto [p, distance] = piece[i];
    for (const glm::ivec3& step : kFaceSteps) {
      const glm::ivec3 q = p + step;
      if (!inside(q) || tissue_[index(q)] != tissue || !seen.emplace(index(q), distance + 1).second) continue;
      piece.emplace_back(q, distance + 1);
    }
  }
  return piece;
}

std::vector<NerveCanal> PlanningTissue::canals() const {
  std::vector<NerveCanal> canals;
  std::vector<bool> done(tissue_.size());
  for_each_voxel(size_, [&](const glm::ivec3& p) {
    if (tissue_[index(p)] != kNerve || done[index(p)]) return;
    auto piece = distances_within_piece(p);
    std::size_t in_bone = 0, in_tooth = 0;
    for (const auto& [q, distance] : piece) {
      done[index(q)] = true;
      for (const glm::ivec3& step : kFaceSteps) {
        if (!inside(q + step)) continue;
        in_bone += typodont::is_bone(tissue_[index(q + step)]);
        in_tooth += typodont::is_tooth(tissue_[index(q + step)]);
      }
    }
    if (in_bone <= 2 * in_tooth) return;
    // Measures path lengths again, now from one end of the nerve tissue, so that they increase to its other end.
    piece = distances_within_piece(piece.back().first);
    // Steps across voxel faces give a length that is up to √3 too large, so the length is measured along the
    // centres of sections.
    const double per_section = kSection / frame_.voxel;
    const auto sections = static_cast<std::size_t>(piece.back().second / per_section) + 1;
    std::vector<dvec3> sums(sections, dvec3(0));
    std::vector<double> counts(sections, 0);
    for (const auto& [q, distance] : piece) {
      const auto section = static_cast<std::size_t>(distance / per_section);
      sums[section] += frame_.to_world(dvec3(q));
      counts[section] += 1;
    }
    NerveCanal canal;
    double length = 0;
    // The canal's end sections are oblique. Sections with too few voxels are not used.
    std::vector<double> sorted = counts;
    std::ranges::sort(sorted);
    const double whole = kWholeSection * sorted[sections / 2];
    for (std::size_t i = 0; i < sections; ++i) {
      if (counts[i] < whole) continue;
      canal.path_W.push_back(sums[i] / counts[i]);
      if (canal.path_W.size() > 1) length += glm::distance(canal.path_W.back(), canal.path_W.end()[-2]);
    }
    if (length < kShortestCanal) return;
    // The radius follows from the volume between the centres of the end sections, divided by the length.
    double samples = 0;
    for (const double count : counts) samples += count >= whole ? count : 0;
    const auto used = static_cast<double>(canal.path_W.size());
    const double volume = samples * (used - 1) / used * std::pow(frame_.voxel, 3);
    canal.radius = std::sqrt(volume / (kPi * length));
    canals.push_back(std::move(canal));
  });
  return canals;
}

}  // namespace typodont
