#include "engine/session/explore.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/base/nearest.h"
#include "engine/base/voxels.h"

namespace typodont::session {

namespace {

constexpr double kReach = 0.75e-3;     // m, radius around the tip that counts as explored
constexpr double kMarkReach = 0.6e-3;  // m, largest distance of a mark from its lesion
constexpr double kStep = 0.2e-3;       // m; the explored surface is updated whenever the tip has moved this far
// Smallest lesion, voxels. Smaller pieces of caries are noise.
constexpr std::size_t kMinLesion = 8;
constexpr double kSiteReach = 2e-3;  // m, largest distance of a reading from its site

/// Calls each(index, squared distance) for voxels within `reach` of p.
template <class Each>
void around(const DenseField& field, const dvec3& p, double reach, Each&& each) {
  const glm::ivec3 lo = glm::max(glm::ivec3(glm::ceil(p - reach)), glm::ivec3(0));
  const glm::ivec3 hi = glm::min(glm::ivec3(glm::floor(p + reach)), field.size - 1);
  for_each_voxel_between(lo, hi, [&](int x, int y, int z) {
    const dvec3 d = dvec3(x, y, z) - p;
    const double square = glm::dot(d, d);
    if (square <= reach * reach) each(field.at(x, y, z), square);
  });
}

}  // namespace

ExploreMeter::ExploreMeter(const VoxelFrame& frame, const DenseField& surface, const std::vector<Tissue>& tissue,
                           const std::vector<bool>& region)
    : frame_(frame),
      surface_(surface),
      lesion_(surface.distance.size(), 0),
      to_explore_(surface.distance.size()),
      explored_(surface.distance.size()) {
  const glm::ivec3 n = surface_.size;
  for (std::size_t i = 0; i < to_explore_.size(); ++i) {
    to_explore_[i] = std::abs(surface_.distance[i]) < 0.7f && (region.empty() || region[i]);
    surface_count_ += to_explore_[i];
  }
  // A lesion: connected caries that reaches the region's surface.
  std::vector<bool> seen(lesion_.size());
  const auto is_caries = [&](std::size_t i) { return tissue[i] == Tissue::kCaries && surface_.distance[i] < 0.5f; };
  for_each_voxel(n, [&](int x, int y, int z) {
    const std::size_t start = surface_.at(x, y, z);
    if (seen[start] || !is_caries(start)) return;
    std::vector<glm::ivec3> piece{{x, y, z}};
    seen[start] = true;
    bool reaches = false;
    for (std::size_t k = 0; k < piece.size(); ++k) {
      const glm::ivec3 at = piece[k];
      reaches = reaches || to_explore_[surface_.at(at.x, at.y, at.z)];
      for (int axis = 0; axis < 3; ++axis) {
        for (const int step : {-1, 1}) {
          glm::ivec3 to = at;
          to[axis] += step;
          if (to[axis] < 0 || to[axis] >= n[axis]) continue;
          const std::size_t i = surface_.at(to.x, to.y, to.z);
          if (seen[i] || !is_caries(i)) continue;
          seen[i] = true;
          piece.push_back(to);
        }
      }
    }
    if (!reaches || piece.size() < kMinLesion) return;
    found_.push_back(false);
    for (const glm::ivec3& at : piece) lesion_[surface_.at(at.x, at.y, at.z)] = static_cast<int>(found_.size());
  });
}

ExploreMeter::ExploreMeter(std::vector<ProbeSite> sites, const dvec3& axis_W, double tip)
    : sites_(std::move(sites)), axis_W_(axis_W), tip_(tip) {
  for (const ProbeSite& site : sites_) readings_.push_back({glm::dot(site.margin_W - site.floor_W, axis_W_)});
}

void ExploreMeter::probe(const ServoTick& tick, bool pressed) {
  const dvec3 tip = tick.X_WG.p - tip_ * axis_W_;
  std::size_t nearest = 0;
  double least = 1e300;
  for (std::size_t i = 0; i < sites_.size(); ++i) {
    const double d = distance_to_segment(sites_[i].margin_W, sites_[i].floor_W, tip);
    if (d < least) least = d, nearest = i;
  }
  const double depth = glm::dot(sites_[nearest].margin_W - tip, axis_W_);
  if (least > kSiteReach || depth < 0) return;
  const double force = std::max(0.0, glm::dot(tick.f_T_W, axis_W_));
  probing_force_ = std::max(probing_force_, force);
  if (pressed) readings_[nearest].reading = depth, readings_[nearest].force = force;
}

void ExploreMeter::add(std::span<const ServoTick> ticks) {
  for (const ServoTick& tick : ticks) {
    const bool down = tick.pedal > 0.5, pressed = down && !pedal_down_;
    pedal_down_ = down;
    const bool contact = tick.depth > 0 || tick.contact_area > 0;
    if (!contact || !is_finite(tick.X_WG.p)) continue;
    if (!sites_.empty()) {
      probe(tick, pressed);
      continue;
    }
    const dvec3 p = frame_.to_voxels(tick.X_WG.p);
    if (glm::length(p - last_) * frame_.voxel > kStep) {
      last_ = p;
      around(surface_, p, kReach / frame_.voxel, [&](std::size_t i, double) {
        if (!to_explore_[i] || explored_[i]) return;
        explored_[i] = true;
        ++explored_count_;
      });
    }
    if (!pressed) continue;
    double nearest = 1e300;
    int which = 0;
    around(surface_, p, kMarkReach / frame_.voxel, [&](std::size_t i, double square) {
      if (lesion_[i] > 0 && square < nearest) nearest = square, which = lesion_[i];
    });
    if (which > 0) {
      found_[static_cast<std::size_t>(which - 1)] = true;
    } else {
      ++false_finds_;
    }
  }
}

ExploreMeasures ExploreMeter::result() const {
  ExploreMeasures m;
  m.lesions = static_cast<int>(found_.size());
  m.found = static_cast<int>(std::count(found_.begin(), found_.end(), true));
  m.false_finds = false_finds_;
  m.explored = surface_count_ > 0 ? static_cast<double>(explored_count_) / static_cast<double>(surface_count_) : 1.0;
  m.sites = readings_;
  m.probing_force = probing_force_;
  return m;
}

int ExploreMeasures::sites_read() const {
  return static_cast<int>(std::ranges::count_if(sites, [](const SiteReading& s) { return s.reading >= 0; }));
}

int ExploreMeasures::sites_within(double tolerance) const {
  return static_cast<int>(std::ranges::count_if(
      sites, [&](const SiteReading& s) { return s.reading >= 0 && std::abs(s.reading - s.depth) <= tolerance; }));
}

}  // namespace typodont::session
