#include "engine/app/hands/scripted_student.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "engine/base/error.h"
#include "engine/base/units.h"

namespace typodont {

namespace {

using namespace literals;

constexpr double kTravelSpeed = 18e-3;    // m/s through the air
constexpr double kExploreSpeed = 4e-3;    // m/s over the surface
constexpr double kDrillSpeed = 4.5e-3;    // m/s along a ring
constexpr double kLayer = 0.4e-3;         // m from ring to ring
constexpr double kPress = 0.5e-3;         // m down: the hand leads the tool by this much, so that it is pressed on
constexpr double kSidePress = 0.95e-3;    // m outward, the same
constexpr double kExplorePress = 0.5e-3;  // m below the surface

struct Layer {
  double z = 0;                  // m
  dvec3 center{0};               // of the caries at this height
  dvec3 along{1, 0, 0};          // unit, its longer axis
  double length = 0, width = 0;  // m, half-axes of the ellipse that holds nineteen twentieths of it
};

/// The caries as slices across z.
std::vector<Layer> slice(const haptics::TissueVolume& tissue) {
  glm::ivec3 lo, hi;
  tissue.bounds(lo, hi);
  const glm::ivec3 size = hi - lo + 1;
  if (size.x <= 0) return {};
  std::vector<float> distance(static_cast<std::size_t>(size.x) * size.y * size.z);
  std::vector<Tissue> labels(distance.size());
  tissue.copy(lo, size, distance.data(), labels.data());
  std::vector<std::vector<dvec3>> slices(static_cast<std::size_t>(size.z));
  for (int x = 0; x < size.x; ++x) {
    for (int y = 0; y < size.y; ++y) {
      for (int z = 0; z < size.z; ++z) {
        const std::size_t i =
            (static_cast<std::size_t>(x) * size.y + static_cast<std::size_t>(y)) * size.z + static_cast<std::size_t>(z);
        if (labels[i] != Tissue::kCaries || distance[i] > 0) continue;
        slices[static_cast<std::size_t>(z)].push_back(tissue.frame().to_world(dvec3(lo + glm::ivec3(x, y, z))));
      }
    }
  }
  std::vector<Layer> layers;
  for (const auto& points : slices) {
    if (points.empty()) continue;
    Layer layer;
    for (const dvec3& p : points) layer.center += p / static_cast<double>(points.size());
    layer.z = layer.center.z;
    // Principal axes in the plane, and how far the points reach along each.
    double xx = 0, xy = 0, yy = 0;
    for (const dvec3& p : points) {
      const dvec3 d = p - layer.center;
      xx += d.x * d.x, xy += d.x * d.y, yy += d.y * d.y;
    }
    const double angle = 0.5 * std::atan2(2 * xy, xx - yy);
    layer.along = {std::cos(angle), std::sin(angle), 0};
    const auto reach = [&](const dvec3& axis) {
      std::vector<double> distances;
      for (const dvec3& p : points) distances.push_back(std::abs(glm::dot(p - layer.center, axis)));
      std::sort(distances.begin(), distances.end());
      return distances[distances.size() * 19 / 20];
    };
    layer.length = reach(layer.along);
    layer.width = reach({-layer.along.y, layer.along.x, 0});
    layers.push_back(layer);
  }
  return layers;
}

Layer layer_at(const std::vector<Layer>& layers, double z) {
  return *std::min_element(layers.begin(), layers.end(),
                           [&](const Layer& a, const Layer& b) { return std::abs(a.z - z) < std::abs(b.z - z); });
}

/// Height of the surface at (x, y), m; NaN beside the tissue.
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
  double now() const { return rows_.back().t; }
  std::vector<haptics::HandPath::Row> take() { return std::move(rows_); }

 private:
  dquat R_;
  std::vector<haptics::HandPath::Row> rows_;
};

}  // namespace

StudentPlan plan_caries_removal(const haptics::TissueVolume& tissue, const haptics::Tool& tool) {
  const std::vector<Layer> layers = slice(tissue);
  if (layers.empty()) throw Error("tissue", "", "no caries", "a lesion to remove");
  const double r = tool.radius();
  const Layer &top = layers.back(), &bottom = layers.front();

  StudentPlan plan;
  plan.hand.mass = 0.15;
  plan.hand.damping = 12;
  plan.hand.stiffness = dvec3(2500);
  plan.hand.tremor_amplitude = 0.01;

  // The handpiece leans away from the eyes, so that the bur can be seen.
  Writer hand(glm::angleAxis(-0.42, dvec3(1, 0, 0)) * glm::angleAxis(0.18, dvec3(0, 1, 0)));
  const dvec3 above = top.center + dvec3(0, 0, 4.0_mm);
  hand.start(above + dvec3(2.0_mm, 1.0_mm, 2.0_mm));
  hand.wait(0.4, 0);

  // Explore: drawn across the lesion in both directions, the drill at rest.
  for (const dvec3& across : {dvec3(1, 0, 0), dvec3(0, 1, 0)}) {
    bool down = false;
    for (double s = -3.0_mm; s <= 3.0_mm; s += 0.25_mm) {
      const dvec3 p = top.center + s * across;
      const double z = surface_height(tissue, p.x, p.y);
      if (std::isnan(z)) continue;
      const dvec3 target(p.x, p.y, z + r - kExplorePress);
      if (!down) hand.move(target + dvec3(0, 0, 2.0_mm), kTravelSpeed, 0);
      hand.move(target, down ? kExploreSpeed : kTravelSpeed / 2, 0);
      down = true;
    }
    hand.move(above, kTravelSpeed, 0);
  }
  plan.explore_end = hand.now();
  hand.wait(1.0, 1);  // the drill runs up

  // Remove: rings from the top down, each as wide as the caries there.
  const dvec3 first(top.center.x, top.center.y, top.z + r + 0.4_mm);
  hand.move(first, kTravelSpeed, 1);
  for (double z = top.z + r; z > bottom.z + r - kLayer; z -= kLayer) {
    const Layer layer = layer_at(layers, std::max(z, bottom.z));
    const double length = std::max(0.0, layer.length - r + kSidePress),
                 width = std::max(0.0, layer.width - r + kSidePress);
    const dvec3 across(-layer.along.y, layer.along.x, 0);
    const int steps = std::max(12, static_cast<int>(std::ceil(2 * kPi * length / 0.15_mm)));
    for (int i = 0; i <= steps; ++i) {
      const double a = 2 * kPi * i / steps;
      const dvec3 p = layer.center + length * std::cos(a) * layer.along + width * std::sin(a) * across;
      hand.move({p.x, p.y, z - kPress}, kDrillSpeed, 1);
    }
    if (width > r) hand.move({layer.center.x, layer.center.y, z - kPress}, kDrillSpeed, 1);
  }
  hand.move(above, kTravelSpeed / 2, 1);
  plan.drill_end = hand.now();
  hand.move(above + dvec3(5.0_mm, 4.0_mm, 5.0_mm), kTravelSpeed, 0);
  hand.wait(0.8, 0);
  plan.path.rows = hand.take();
  return plan;
}

}  // namespace typodont
