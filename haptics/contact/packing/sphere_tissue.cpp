#include "haptics/contact/packing/sphere_tissue.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/base/dispatch.h"
#include "engine/base/nearest.h"
#include "haptics/contact/packing/sphere_lanes.h"

namespace typodont::haptics::packing {

namespace {

/// cos 60°: if the angle between the directions of two cuts of a sphere is smaller, the second continues the first
constexpr double kSameSide = 0.5;
// After a cut, bounding boxes in the tree are only enlarged. Once in this number of cuts, they are computed exactly.
constexpr std::size_t kExactEvery = 16;
constexpr double kRounding = 1e-15;  // m, rounding error of a sphere's displacement
constexpr double kTouching = 1e-13;  // m; a smaller overlap of spheres counts as rounding error

double ball_volume(double r) {
  return 4.0 / 3.0 * kPi * r * r * r;
}

}  // namespace

SphereTissue::SphereTissue(const SpherePacking& packing, Removal removal, std::span<const double> cell)
    : removal_(removal),
      tree_(packing.center, packing.radius),
      spheres_(tree_.places()),
      tissue_(tree_.places()),
      hardness_(tree_.places(), 1.0f) {
  const PerTissue filled = packing.sphere_volume();
  for (std::size_t i = 0; i < packing.size(); ++i) {
    const auto t = static_cast<std::size_t>(packing.tissue[i]);
    const double volume = cell.empty() ? ball_volume(packing.radius[i]) * packing.solid_volume[t] / filled[t] : cell[i];
    const auto place = static_cast<std::size_t>(tree_.place_of(static_cast<int>(i)));
    spheres_[place] = {packing.center[i], packing.radius[i], volume, {}, 0, 0, packing.radius[i], volume};
    tissue_[place] = packing.tissue[i];
  }
}

void SphereTissue::set_material(int i, Tissue tissue, double hardness) noexcept {
  const auto place = static_cast<std::size_t>(tree_.place_of(i));
  tissue_[place] = tissue;
  hardness_[place] = static_cast<float>(hardness);
  graded_ = graded_ || hardness != 1;
}

/// Volume that a cut leaves of a sphere, with its share of the gaps between spheres, m³.
double SphereTissue::left_of(const CutSphere& s, double curve) const noexcept {
  if (gone(s)) return 0;
  const double base = ball_volume(s.whole_radius);
  if (removal_ == Removal::kAsPrinted) return s.whole_volume * ball_volume(s.radius()) / base;
  const double deep = 2 * (s.whole_radius - s.base_radius) + s.overlap;
  return s.whole_volume * (1 - lens_volume(curve, s.whole_radius, curve + s.whole_radius - deep) / base);
}

/// Computes the state of `s` after a cut by a ball of radius `r` from a to b. Returns false if the ball does not
/// overlap what earlier cuts have left of the sphere.
bool SphereTissue::after_cut(CutSphere& s, const dvec3& a, const dvec3& b, double r, double curve) const noexcept {
  dvec3 away;
  const auto overlap_of = [&](const dvec3& center, double radius) {
    const dvec3 off = center - nearest_on_segment(a, b, center);
    const double distance = glm::length(off);
    away = distance > 0 ? off / distance : dvec3(0, 0, 1);
    return r + radius - distance;
  };
  double overlap = overlap_of(s.base, s.base_radius);
  if (s.overlap > 0 && (glm::dot(away, s.away) < kSameSide || r != s.tool || !(overlap > s.overlap))) {
    // The cut does not continue the last one: the current state becomes the base from which overlaps are measured.
    s = {s.center(), s.radius(), s.volume, {}, 0, 0, s.whole_radius, s.whole_volume};
    overlap = overlap_of(s.base, s.base_radius);
  }
  if (!(overlap > kTouching)) return false;
  s.overlap = std::min(overlap, 2 * s.base_radius);
  s.away = away;
  s.tool = r;
  s.volume = std::min(s.volume, left_of(s, curve));
  return true;
}

std::size_t SphereTissue::cut_near(std::size_t found, const dvec3& a, const dvec3& b, double r, double curve,
                                   std::span<Place> changed, std::span<CutSphere> before, Removed& removed) noexcept {
  std::size_t kept = 0;
  std::optional<Place> unmended;  // tissue sphere whose bounding boxes must still be updated
  for (std::size_t k = 0; k < found; ++k) {
    const Place place = changed[k];
    CutSphere s = sphere(place);
    const CutSphere was = s;
    if (!after_cut(s, a, b, r, curve)) continue;
    count(place, was.volume - s.volume, removed);
    if (unmended && !tree_.share_leaf(*unmended, place)) tree_.mend_above(*unmended);
    put(place, s);
    unmended = place;
    if (kept < before.size()) before[kept] = was;
    changed[kept++] = place;
  }
  if (unmended) tree_.mend_above(*unmended);
  return kept;
}

/// Data of eight tissue spheres for SIMD: their states before and after a cut by one ball.
struct SphereTissue::Lanes {
  static constexpr std::size_t kLeafSize = SphereTree::kLeafSize;
  double base[3][kLeafSize], base_radius[kLeafSize], volume[kLeafSize], whole_radius[kLeafSize],
      whole_volume[kLeafSize], away[3][kLeafSize], overlap[kLeafSize], tool[kLeafSize];
  double new_away[3][kLeafSize], new_overlap[kLeafSize], new_volume[kLeafSize], protrudes[kLeafSize];
  unsigned changes;  // bit mask: spheres that changed and have valid results
  unsigned others;   // bit mask: spheres that after_cut() must compute

  void put(std::size_t k, const CutSphere& s) {
    base[0][k] = s.base.x, base[1][k] = s.base.y, base[2][k] = s.base.z;
    base_radius[k] = s.base_radius, volume[k] = s.volume;
    whole_radius[k] = s.whole_radius, whole_volume[k] = s.whole_volume;
    away[0][k] = s.away.x, away[1][k] = s.away.y, away[2][k] = s.away.z;
    overlap[k] = s.overlap, tool[k] = s.tool;
  }
  /// Copies to `s` the state of sphere `k` after a cut by a ball of radius `r`.
  void take(std::size_t k, double r, CutSphere& s) const {
    s.base.x = base[0][k], s.base.y = base[1][k], s.base.z = base[2][k];
    s.base_radius = base_radius[k], s.volume = new_volume[k];
    s.whole_radius = whole_radius[k], s.whole_volume = whole_volume[k];
    s.away.x = new_away[0][k], s.away.y = new_away[1][k], s.away.z = new_away[2][k];
    s.overlap = new_overlap[k], s.tool = r;
  }
};

namespace {

/// SphereTissue::left_of() for eight spheres, with bit-identical results. Not for Removal::kAsPrinted.
TYPODONT_INLINE void left_lanes(const D8& base_radius, const D8& overlap, const D8& curve, const D8& whole_radius,
                                const D8& whole_volume, D8& left) {
  const D8 rest = base_radius - 0.5 * overlap, radius = rest > D8{} ? rest : D8{};
  const D8 deep = 2.0 * (whole_radius - base_radius) + overlap;
  D8 base, lens;
  ball_volumes(whole_radius, base);
  lens_volumes(curve, whole_radius, curve + whole_radius - deep, lens);
  const D8 part = whole_volume * (1.0 - lens / base);
  left = radius > SphereTissue::kMin * base_radius ? part : D8{};
}

/// SphereTissue::after_cut() for eight spheres, with bit-identical results. s.others: the
/// spheres whose new cut does not continue their previous cut.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
void cut_lanes(SphereTissue::Lanes& s, const dvec3& a, const dvec3& b, double r, double curve) {
  D8 x, y, z, base_radius, volume, whole_radius, whole_volume, away_x, away_y, away_z, overlap, tool;
  read_lanes(x, s.base[0]), read_lanes(y, s.base[1]), read_lanes(z, s.base[2]);
  read_lanes(away_x, s.away[0]), read_lanes(away_y, s.away[1]), read_lanes(away_z, s.away[2]);
  read_lanes(base_radius, s.base_radius), read_lanes(volume, s.volume);
  read_lanes(whole_radius, s.whole_radius), read_lanes(whole_volume, s.whole_volume);
  read_lanes(overlap, s.overlap), read_lanes(tool, s.tool);
  const D8 zero{};
  D8 off_x, off_y, off_z;
  offsets_from_segment(x, y, z, a, b, off_x, off_y, off_z);
  D8 distance = off_x * off_x + off_y * off_y + off_z * off_z;
  take_root(distance);
  const L8 apart = distance > zero;
  const D8 to_x = apart ? off_x / distance : zero, to_y = apart ? off_y / distance : zero,
           to_z = apart ? off_z / distance : zero + 1.0;
  const D8 deep = r + base_radius - distance, twice = 2.0 * base_radius, deepest = twice < deep ? twice : deep;
  const L8 fresh = overlap <= zero, continued = (to_x * away_x + to_y * away_y + to_z * away_z >= zero + kSameSide) &
                                                (tool == zero + r) & (deep > overlap);
  D8 left;
  left_lanes(base_radius, deepest, zero + curve, whole_radius, whole_volume, left);
  // Half of an overlap moves the sphere, the other half reduces its radius, so the sphere leaves its old surface.
  const D8 half = 0.5 * overlap, new_half = 0.5 * deepest, rest = base_radius - half, new_rest = base_radius - new_half,
           moved_x = new_half * to_x - half * away_x, moved_y = new_half * to_y - half * away_y,
           moved_z = new_half * to_z - half * away_z;
  D8 moved = moved_x * moved_x + moved_y * moved_y + moved_z * moved_z;
  take_root(moved);
  write_lanes(s.protrudes, moved + (new_rest > zero ? new_rest : zero) - (rest > zero ? rest : zero) + kRounding);
  s.changes = bits_of((fresh | continued) & (deep > zero + kTouching));
  s.others = bits_of(~(fresh | continued));
  write_lanes(s.new_away[0], to_x), write_lanes(s.new_away[1], to_y), write_lanes(s.new_away[2], to_z);
  write_lanes(s.new_overlap, deepest);
  write_lanes(s.new_volume, left < volume ? left : volume);
}

}  // namespace

double TriedCut::add(const SphereTissue& tissue, std::span<const Place> near, const dvec3& a, const dvec3& b, double r,
                     double curve, const PerTissue& weight) noexcept {
  double sum = 0;
  const std::size_t first = count_;
  const auto state = [&](Place place) -> const CutSphere& {
    const auto k = static_cast<std::size_t>(place);
    return several_ && tried_in_[k] == number_ ? state_[k] : tissue.sphere(place);
  };
  SphereTissue::Lanes lanes{};
  for (std::size_t begin = 0; begin < near.size(); begin += SphereTissue::Lanes::kLeafSize) {
    const std::span<const Place> some =
        near.subspan(begin, std::min(near.size() - begin, SphereTissue::Lanes::kLeafSize));
    for (std::size_t k = 0; k < some.size(); ++k) lanes.put(k, state(some[k]));
    cut_lanes(lanes, a, b, r, curve);
    if (tissue.removal_ == Removal::kAsPrinted) lanes.changes = 0, lanes.others = ~0u;
    for (std::size_t k = 0; k < some.size(); ++k) {
      const Place place = some[k];
      // The step is kept (++count_) only if the sphere changes. If steps_ is full, its last element is overwritten.
      Step& step = steps_[std::min(count_, kMaxSteps)];
      step.place = place, step.first = count_ == first;
      if (lanes.others >> k & 1) {
        const CutSphere& before = state(place);
        step.after = before;
        if (!tissue.after_cut(step.after, a, b, r, curve)) continue;
        step.taken = before.volume - step.after.volume;
        step.protrudes = glm::distance(step.after.center(), before.center()) + step.after.radius() - before.radius();
      } else {
        if (!(lanes.changes >> k & 1)) continue;
        lanes.take(k, r, step.after);
        step.taken = lanes.volume[k] - lanes.new_volume[k];
        step.protrudes = lanes.protrudes[k];
      }
      sum += step.taken * tissue.hardness(place) * weight[static_cast<std::size_t>(tissue.tissue(place))];
      ++count_;
      if (!several_) continue;
      state_[static_cast<std::size_t>(place)] = step.after;
      tried_in_[static_cast<std::size_t>(place)] = number_;
    }
  }
  return sum;
}

void SphereTissue::set(int i, const CutSphere& s) noexcept {
  put(tree_.place_of(i), s);
  tree_.mend_above(tree_.place_of(i));
}

/// Updates the tree's bounding boxes around a sphere that make() changed. Usually only enlarges the boxes, which is
/// faster than computing them exactly.
void SphereTissue::renew_boxes(Place place) noexcept {
  if ((made_ + static_cast<std::size_t>(place) / SphereTree::kLeafSize) % kExactEvery == 0) {
    tree_.mend_above(place);
  } else {
    tree_.widen_above(place);
  }
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
          const double fraction =
              std::clamp(0.5 - static_cast<double>(distance[static_cast<std::size_t>(k)]), 0.0, 1.0);
          if (!(fraction > 0)) continue;
          const glm::ivec3 v(x0 + k / (kBlock * kBlock), y0 + k / kBlock % kBlock, z0 + k % kBlock);
          if (const int i = tree.nearest(tissue.frame().to_world(dvec3(v))); i >= 0) {
            cell[static_cast<std::size_t>(i)] += fraction * h * h * h;
          }
        }
      }
    }
  }
  // Each cell gets at least the volume of its sphere, because a small sphere may be nearest to no voxel centre.
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
