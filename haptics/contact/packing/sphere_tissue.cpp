#include "haptics/contact/packing/sphere_tissue.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace typodont::haptics::packing {

namespace {

/// Lower limit of the cosine of the angle between the directions of two cuts of a sphere. If the angle is less than
/// 60°, the second cut continues the first one.
constexpr double kSameSide = 0.5;
/// Smallest radius of a cut sphere, as a fraction of its radius before the cut. A smaller sphere is removed, because
/// its contact could not be felt.
constexpr double kLeast = 1e-3;
constexpr double kTouching = 1e-13;  // m, overlap that rounding can cause between touching spheres

double ball_volume(double r) {
  return 4.0 / 3.0 * kPi * r * r * r;
}

}  // namespace

SphereTissue::SphereTissue(const SpherePacking& packing, Removal removal, std::span<const double> cell)
    : removal_(removal),
      tissue_(packing.tissue),
      hardness_(packing.size(), 1.0f),
      tree_(packing.center, packing.radius) {
  const PerTissue filled = packing.sphere_volume();
  spheres_.reserve(packing.size());
  for (std::size_t i = 0; i < packing.size(); ++i) {
    const auto t = static_cast<std::size_t>(packing.tissue[i]);
    const double volume = cell.empty() ? ball_volume(packing.radius[i]) * packing.solid_volume[t] / filled[t] : cell[i];
    spheres_.push_back({packing.center[i], packing.radius[i], volume, {}, 0, 0});
  }
}

void SphereTissue::set_material(int i, Tissue tissue, double hardness) noexcept {
  tissue_[static_cast<std::size_t>(i)] = tissue;
  hardness_[static_cast<std::size_t>(i)] = static_cast<float>(hardness);
  graded_ = graded_ || hardness != 1;
}

bool SphereTissue::gone(const CutSphere& s) const noexcept {
  return !(s.radius() > kLeast * s.base_radius);
}

/// Returns the volume in m³ that a sphere represents, including its part of the gaps.
double SphereTissue::counted(const CutSphere& s) const noexcept {
  if (gone(s)) return 0;
  if (!(s.overlap > 0)) return s.base_volume;
  const double base = ball_volume(s.base_radius);
  if (removal_ == Removal::kAsPrinted) return s.base_volume * ball_volume(s.radius()) / base;
  return s.base_volume * (1 - lens_volume(s.tool, s.base_radius, s.tool + s.base_radius - s.overlap) / base);
}

PerTissue SphereTissue::volumes() const noexcept {
  PerTissue sum{};
  for (std::size_t i = 0; i < spheres_.size(); ++i) {
    sum[static_cast<std::size_t>(tissue_[i])] += volume(static_cast<int>(i));
  }
  return sum;
}

/// Cuts the sphere `s` with a ball of radius `r` that moves from a to b. Returns false if the ball does not overlap `s`
/// more deeply than before; the sphere then stays unchanged.
bool SphereTissue::after_cut(CutSphere& s, const dvec3& a, const dvec3& b, double r) const noexcept {
  dvec3 away;
  const auto overlap_of = [&](const dvec3& center, double radius) {
    const dvec3 off = center - nearest_on(a, b, center);
    const double distance = glm::length(off);
    away = distance > 0 ? off / distance : dvec3(0, 0, 1);
    return r + radius - distance;
  };
  double overlap = overlap_of(s.base, s.base_radius);
  if (s.overlap > 0 && (glm::dot(away, s.away) < kSameSide || r != s.tool || !(overlap > s.overlap))) {
    // A new cut starts: the present state of the sphere becomes the base of this cut, from which the ball removes
    // tissue.
    s = {s.center(), s.radius(), counted(s), {}, 0, 0};
    overlap = overlap_of(s.base, s.base_radius);
  }
  if (!(overlap > kTouching)) return false;
  s.overlap = std::min(overlap, 2 * s.base_radius);
  s.away = away;
  s.tool = r;
  return true;
}

std::size_t SphereTissue::cut(const dvec3& a, const dvec3& b, double r, std::span<int> changed,
                              std::span<CutSphere> before, Removed& removed) noexcept {
  const std::size_t found = std::min(tree_.near_segment(a, b, r, changed), changed.size());
  return cut_near(found, a, b, r, changed, before, removed);
}

std::size_t SphereTissue::cut_near(std::size_t found, const dvec3& a, const dvec3& b, double r, std::span<int> changed,
                                   std::span<CutSphere> before, Removed& removed) noexcept {
  std::size_t kept = 0;
  // index of a sphere in the leaf of the tree whose boxes are not updated yet; -1: there is no such leaf
  int unmended = -1;
  for (std::size_t k = 0; k < found; ++k) {
    const int i = changed[k];
    CutSphere s = sphere(i);
    const CutSphere was = s;
    if (!after_cut(s, a, b, r)) continue;
    count(i, counted(was) - counted(s), removed);
    if (unmended >= 0 && !tree_.share_leaf(unmended, i)) tree_.mend_above(unmended);
    put(unmended = i, s);
    if (kept < before.size()) before[kept] = was;
    changed[kept++] = i;
  }
  if (unmended >= 0) tree_.mend_above(unmended);
  return kept;
}

void SphereTissue::take(int i, const CutSphere& after, Removed& removed) noexcept {
  count(i, volume(i) - counted(after), removed);
  set(i, after);
}

void SphereTissue::count(int i, double taken, Removed& removed) const noexcept {
  const auto t = static_cast<std::size_t>(tissue(i));
  removed.volume[t] += taken;
  removed.hardened[t] += taken * hardness(i);
}

double SphereTissue::cost(std::span<const int> near, const dvec3& a, const dvec3& b, double r,
                          const PerTissue& weight) const noexcept {
  double sum = 0;
  for (const int i : near) {
    CutSphere s = sphere(i);
    const double before = counted(s);
    if (!after_cut(s, a, b, r)) continue;
    sum += (before - counted(s)) * hardness(i) * weight[static_cast<std::size_t>(tissue(i))];
  }
  return sum;
}

double TriedCut::add(const SphereTissue& tissue, std::span<const int> near, const dvec3& a, const dvec3& b, double r,
                     const PerTissue& weight) noexcept {
  double sum = 0;
  bool first = true;
  for (const int i : near) {
    const auto k = static_cast<std::size_t>(i);
    const CutSphere& before = tried_in_[k] == number_ ? state_[k] : tissue.sphere(i);
    CutSphere s = before;
    if (!tissue.after_cut(s, a, b, r)) continue;
    const double taken = tissue.counted(before) - tissue.counted(s);
    sum += taken * tissue.hardness(i) * weight[static_cast<std::size_t>(tissue.tissue(i))];
    if (steps_.size() < kMostSteps) {
      steps_.push_back({i, first, taken, s});
      first = false;
    } else {
      complete_ = false;
    }
    state_[k] = s;
    tried_in_[k] = number_;
  }
  return sum;
}

void SphereTissue::set(int i, const CutSphere& s) noexcept {
  put(i, s);
  tree_.mend_above(i);
}

/// Sets a sphere without updating the tree's boxes above it.
void SphereTissue::put(int i, const CutSphere& s) noexcept {
  spheres_[static_cast<std::size_t>(i)] = s;
  tree_.put(i, s.center(), gone(s) ? 0 : s.radius());
}

std::vector<double> cell_volumes(const SpherePacking& packing, const SphereTree& tree, const TissueVolume& tissue) {
  std::vector<double> cell(packing.size(), 0.0);
  glm::ivec3 lo, hi;
  tissue.bounds(lo, hi);
  constexpr int kBlock = 8;
  const double h = tissue.frame().voxel;
  std::array<float, kBlock * kBlock * kBlock> distance;
  for (int x0 = lo.x; x0 <= hi.x; x0 += kBlock) {
    for (int y0 = lo.y; y0 <= hi.y; y0 += kBlock) {
      for (int z0 = lo.z; z0 <= hi.z; z0 += kBlock) {
        tissue.copy({x0, y0, z0}, glm::ivec3(kBlock), distance.data(), nullptr);
        for (int k = 0; k < kBlock * kBlock * kBlock; ++k) {
          const double share = std::clamp(0.5 - static_cast<double>(distance[static_cast<std::size_t>(k)]), 0.0, 1.0);
          if (!(share > 0)) continue;
          const glm::ivec3 v(x0 + k / (kBlock * kBlock), y0 + k / kBlock % kBlock, z0 + k % kBlock);
          if (const int i = tree.nearest(tissue.frame().to_world(dvec3(v))); i >= 0) {
            cell[static_cast<std::size_t>(i)] += share * h * h * h;
          }
        }
      }
    }
  }
  // No voxel may be assigned to a sphere that is smaller than a voxel, so each sphere represents at least its own
  // volume. Then all volumes are scaled such that their sum is the volume of the tissue.
  PerTissue sum{};
  for (std::size_t i = 0; i < cell.size(); ++i) {
    cell[i] = std::max(cell[i], ball_volume(packing.radius[i]));
    sum[static_cast<std::size_t>(packing.tissue[i])] += cell[i];
  }
  for (std::size_t i = 0; i < cell.size(); ++i) {
    const auto t = static_cast<std::size_t>(packing.tissue[i]);
    cell[i] *= packing.solid_volume[t] / sum[t];
  }
  return cell;
}

}  // namespace typodont::haptics::packing
