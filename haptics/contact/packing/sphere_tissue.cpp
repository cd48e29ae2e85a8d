#include "haptics/contact/packing/sphere_tissue.h"

#include <algorithm>
#include <cmath>

namespace typodont::haptics::packing {

namespace {

/// A cut goes on where it comes from within 60° of the side that it came from before.
constexpr double kSameSide = 0.5;
/// Share of its base's radius below which a sphere is removed: no contact with it could be felt.
constexpr double kLeast = 1e-3;
constexpr double kTouching = 1e-13;  // m, an overlap that rounding leaves between spheres that touch

double ball_volume(double r) {
  return 4.0 / 3.0 * kPi * r * r * r;
}

}  // namespace

SphereTissue::SphereTissue(const SpherePacking& packing, Removal removal)
    : removal_(removal), tissue_(packing.tissue), tree_(packing.center, packing.radius) {
  spheres_.reserve(packing.size());
  for (std::size_t i = 0; i < packing.size(); ++i) {
    spheres_.push_back({packing.center[i], packing.radius[i], ball_volume(packing.radius[i]), {}, 0, 0});
  }
  const PerTissue filled = packing.sphere_volume();
  for (std::size_t t = 0; t < kTissueCount; ++t) share_[t] = filled[t] > 0 ? packing.solid_volume[t] / filled[t] : 0;
}

/// m³ that a bare sphere still counts for.
double SphereTissue::counted(const CutSphere& s) const noexcept {
  if (!(s.radius() > kLeast * s.base_radius)) return 0;
  if (!(s.overlap > 0)) return s.base_volume;
  const double base = ball_volume(s.base_radius);
  if (removal_ == Removal::kAsPrinted) return s.base_volume * ball_volume(s.radius()) / base;
  return s.base_volume * (1 - lens_volume(s.tool, s.base_radius, s.tool + s.base_radius - s.overlap) / base);
}

double SphereTissue::volume(int i) const noexcept {
  return counted(sphere(i)) * share_[static_cast<std::size_t>(tissue(i))];
}

PerTissue SphereTissue::volumes() const noexcept {
  PerTissue sum{};
  for (std::size_t i = 0; i < spheres_.size(); ++i) {
    sum[static_cast<std::size_t>(tissue_[i])] += volume(static_cast<int>(i));
  }
  return sum;
}

std::size_t SphereTissue::cut(const dvec3& a, const dvec3& b, double r, std::span<int> changed,
                              std::span<CutSphere> before, PerTissue& removed) noexcept {
  const std::size_t found = std::min(tree_.near_segment(a, b, r, changed), changed.size());
  std::size_t kept = 0;
  for (std::size_t k = 0; k < found; ++k) {
    const int i = changed[k];
    CutSphere s = sphere(i);
    const CutSphere was = s;
    const double volume_before = volume(i);
    dvec3 away;
    const auto overlap_of = [&](const dvec3& center, double radius) {
      const dvec3 off = center - nearest_on(a, b, center);
      const double distance = glm::length(off);
      away = distance > 0 ? off / distance : dvec3(0, 0, 1);
      return r + radius - distance;
    };
    double overlap = overlap_of(s.base, s.base_radius);
    if (s.overlap > 0 && (glm::dot(away, s.away) < kSameSide || r != s.tool || !(overlap > s.overlap))) {
      // Another cut: the sphere as it is now is what it begins with.
      s = {s.center(), s.radius(), counted(s), {}, 0, 0};
      overlap = overlap_of(s.base, s.base_radius);
    }
    if (!(overlap > kTouching)) continue;
    s.overlap = std::min(overlap, 2 * s.base_radius);
    s.away = away;
    s.tool = r;
    set(i, s);
    removed[static_cast<std::size_t>(tissue(i))] += volume_before - volume(i);
    if (kept < before.size()) before[kept] = was;
    changed[kept++] = i;
  }
  return kept;
}

void SphereTissue::set(int i, const CutSphere& s) noexcept {
  spheres_[static_cast<std::size_t>(i)] = s;
  tree_.set(i, s.center(), s.radius() > kLeast * s.base_radius ? s.radius() : 0);
}

}  // namespace typodont::haptics::packing
