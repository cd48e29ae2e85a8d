#include "engine/app/hands/demo_hand.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "engine/base/error.h"
#include "engine/base/units.h"
#include "engine/base/voxels.h"

namespace typodont {

namespace {

using namespace literals;

constexpr double kTravelSpeed = 18e-3;  // m/s, speed of the tool outside the tissue
constexpr double kExploreSpeed = 4e-3;  // m/s, speed over the surface while exploring
// Depth of the hand below the surface, m. The coupling converts it to a force.
constexpr double kExplorePress = 0.5e-3;
// Distance explored on each side of the lesion's middle, m.
constexpr double kExplored = 3.0e-3;

/// Middle of the caries in its highest layer of voxels.
dvec3 top_of_caries(const haptics::TissueVolume& tissue) {
  glm::ivec3 lo, hi;
  tissue.bounds(lo, hi);
  const glm::ivec3 size = glm::max(hi - lo + 1, glm::ivec3(0));
  std::vector<float> distance(voxel_count(size));
  std::vector<Tissue> labels(distance.size());
  tissue.copy(lo, size, distance.data(), labels.data());
  for (int z = size.z - 1; z >= 0; --z) {
    dvec3 sum(0);
    int count = 0;
    for (int x = 0; x < size.x; ++x) {
      for (int y = 0; y < size.y; ++y) {
        const std::size_t i = voxel_index({x, y, z}, size);
        if (labels[i] != Tissue::kCaries || distance[i] > 0) continue;
        sum += tissue.frame().to_world(dvec3(lo + glm::ivec3(x, y, z)));
        ++count;
      }
    }
    if (count > 0) return sum / static_cast<double>(count);
  }
  throw Error("tissue", "", "no caries", "a lesion to remove");
}

/// Height of the surface at (x, y), m; NaN if there is no tissue.
double surface_height(const haptics::TissueVolume& tissue, double x, double y) {
  glm::ivec3 lo, hi;
  tissue.bounds(lo, hi);
  const glm::ivec3 at(glm::round(tissue.frame().to_voxels({x, y, 0})));
  const int count = hi.z - lo.z + 1;
  std::vector<float> column(static_cast<std::size_t>(count));
  tissue.copy({at.x, at.y, lo.z}, {1, 1, count}, column.data(), nullptr);
  for (int z = count - 1; z >= 0; --z) {
    if (column[static_cast<std::size_t>(z)] < 0) return tissue.frame().to_world({0, 0, lo.z + z}).z;
  }
  return std::nan("");
}

class Writer {
 public:
  explicit Writer(const dquat& R_WT) : R_(R_WT) {}
  void start(const dvec3& p) { rows_.push_back({0, {p, R_}, 0, dvec3(0)}); }
  void move(const dvec3& p, double speed, double pedal) {
    const double dt = std::max(0.02, glm::length(p - rows_.back().X_WT.p) / speed);
    rows_.push_back({rows_.back().t + dt, {p, R_}, pedal, dvec3(0)});
  }
  void wait(double seconds, double pedal) {
    rows_.push_back({rows_.back().t + seconds, rows_.back().X_WT, pedal, dvec3(0)});
  }
  std::vector<haptics::HandPath::Row> take() { return std::move(rows_); }

 private:
  dquat R_;
  std::vector<haptics::HandPath::Row> rows_;
};

}  // namespace

DemoHand::DemoHand(const Scene& scene, haptics::Carver& carver, double rate)
    : rate_(rate), expert_(scene, carver, rate) {
  const haptics::TissueVolume& tissue = carver.volume();
  const dvec3 top = top_of_caries(tissue);
  const double r = scene.servo.tool.radius();
  above_ = top + dvec3(0, 0, 4.0_mm);

  Writer hand(dquat(1, 0, 0, 0));
  hand.start(above_ + dvec3(2.0_mm, 1.0_mm, 2.0_mm));
  hand.wait(0.4, 0);
  for (const dvec3& across : {dvec3(1, 0, 0), dvec3(0, 1, 0)}) {
    bool down = false;
    for (double s = -kExplored; s <= kExplored; s += 0.25_mm) {
      const dvec3 p = top + s * across;
      const double z = surface_height(tissue, p.x, p.y);
      if (std::isnan(z)) continue;
      const dvec3 target(p.x, p.y, z + r - kExplorePress);
      if (!down) hand.move(target + dvec3(0, 0, 2.0_mm), kTravelSpeed, 0);
      hand.move(target, down ? kExploreSpeed : kTravelSpeed / 2, 0);
      down = true;
    }
    hand.move(above_, kTravelSpeed, 0);
  }
  hand.move(expert_.from().p, kTravelSpeed, 0);
  scripted_ = haptics::make_scripted_hand({hand.take()}, rate, /*paced=*/false);
}

bool DemoHand::read(haptics::HandSample& sample) noexcept {
  if (!next(sample)) return false;
  sample.t = from_seconds(static_cast<double>(ticks_++) / rate_);
  last_ = sample.X_WT;
  return true;
}

bool DemoHand::next(haptics::HandSample& sample) {
  if (phase_ == Phase::kExplore) {
    if (scripted_->read(sample)) return true;
    phase_ = Phase::kDrill;
  }
  if (phase_ == Phase::kDrill) {
    if (expert_.read(sample)) return true;
    phase_ = Phase::kAway;
    Writer away(last_.R);
    away.start(last_.p);
    away.move(above_ + dvec3(5.0_mm, 4.0_mm, 5.0_mm), kTravelSpeed, 0);
    away.wait(0.8, 0);
    scripted_ = haptics::make_scripted_hand({away.take()}, rate_, /*paced=*/false);
  }
  return scripted_->read(sample);
}

}  // namespace typodont
