// Measures ticks with soft tissue: a hand that presses and slides, a bur that cuts, and a layer at rest.
#include <cmath>
#include <memory>

#include "engine/base/units.h"
#include "haptics/bench/rows.h"
#include "haptics/bench/timing.h"
#include "haptics/soft_tissue.h"

namespace typodont::haptics::bench {

namespace {

/// Makes a flat layer with a width of 12 mm and its surface at z = 0.
std::shared_ptr<const SoftSurface> layer() {
  return std::make_shared<const SoftSurface>(SoftLaw{}, dvec3(-6e-3, -6e-3, -1e-3), dvec3(6e-3, 6e-3, 1e-3),
                                             [](const dvec3& p) { return p.z; });
}

/// Returns the CPU time of the soft layer alone in each tick, ns. The tool presses 0.6 mm deep and slides on a
/// circle.
std::vector<double> press(const Tool& tool, const Pose& tilted, double cutting, int ticks) {
  const std::vector<Tool> tools{tool};
  const auto surface = layer();
  return least_of([&] {
    SoftTissue soft(surface, tools, 1000);
    std::vector<double> times;
    for (int i = 0; i < ticks; ++i) {
      const double way = 2e-6 * i, depth = std::min(1e-6 * i, 0.6e-3);  // m; the tool slides at 2 mm/s
      const Pose X_WG{tilted.p + dvec3(1e-3 * std::cos(way / 1e-3), 1e-3 * std::sin(way / 1e-3), -depth), tilted.R};
      const Nanos start = thread_cpu_time();
      soft.tick({i * Nanos(1'000'000), 1e-3, X_WG, 0, cutting});
      times.push_back(static_cast<double>(thread_cpu_time() - start));
    }
    // Discards the first quarter of the ticks, because the tool must first sink into the layer.
    times.erase(times.begin(), times.begin() + ticks / 4);
    return times;
  });
}

}  // namespace

void soft_rows(const BenchOptions& options, std::vector<BenchRow>& rows) {
  const int ticks = std::max(options.ticks, 1000);
  const auto add = [&](const std::string& knob, const std::vector<double>& times) {
    for (const auto& [name, part] : {std::pair("median", 0.5), std::pair("99.9 %", 0.999)}) {
      rows.push_back({std::string("soft tissue, ") + name, knob, BenchRow::kNone, "", quantile(times, part), "tick"});
    }
  };
  const Tool ball = head(HeadShape::kSphere, 1.2e-3, 1.2e-3);
  add("round 1.2 mm presses", press(ball, {{0, 0, 0.6e-3}}, 0, ticks));
  add("round 1.2 mm cuts", press(ball, {{0, 0, 0.6e-3}}, 3, ticks));
  const Tool lying = head(HeadShape::kCylinder, 1.6e-3, 8e-3);
  add("cylinder 1.6 × 8 mm lies", press(lying, {{0, 0, 0.8e-3}, rotation_between({0, 0, 1}, {1, 0, 0})}, 0, ticks));

  const std::vector<Tool> tools{ball};
  SoftTissue soft(layer(), tools, 1000);
  constexpr int kBatch = 1024;
  bool awake = false;
  const double ns = batch_ns(std::max(ticks / 100, 5), kBatch, [&](int k) {
    // the tool moves at 1 mm/s, the typical speed of a hand that tries to hold it still
    awake |= !soft.at_rest({dvec3(1e-6 * k, 0, 6e-3)}, 0);
  });
  rows.push_back({"soft tissue, asleep", "tool 6 mm away", BenchRow::kNone, "", awake ? BenchRow::kNone : ns, "tick"});
}

}  // namespace typodont::haptics::bench
