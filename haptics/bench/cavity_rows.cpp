#include "haptics/bench/cavity_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <span>
#include <string>
#include <utility>

#include "engine/base/measure.h"
#include "engine/base/units.h"
#include "haptics/bench/scene.h"
#include "haptics/bench/timing.h"
#include "haptics/contact_method.h"
#include "haptics/lockstep.h"
#include "haptics/solid.h"

namespace typodont::haptics::bench {

namespace {

struct Bur {
  const char* name;
  HeadShape shape;
  double diameter, length;  // m, diameter and length of the bur's head
};
constexpr Bur kBurs[] = {{"round 1.2 mm", HeadShape::kSphere, 1.2e-3, 1.2e-3},
                         {"pear 1.0 x 2 mm", HeadShape::kPear, 1.0e-3, 2e-3},
                         {"round end 1.0 x 4 mm", HeadShape::kRoundEndCylinder, 1.0e-3, 4e-3},
                         {"flame 1.0 x 4 mm", HeadShape::kFlame, 1.0e-3, 4e-3},
                         {"cylinder 1.0 x 4 mm", HeadShape::kCylinder, 1.0e-3, 4e-3},
                         {"cone 1.2 x 4 mm", HeadShape::kCone, 1.2e-3, 4e-3},
                         {"inverted cone 1.0 x 1.0 mm", HeadShape::kInvertedCone, 1.0e-3, 1.0e-3}};
constexpr std::size_t kFewBurs = 3;
constexpr double kDeep = 1.5e-3;   // m, depth below the surface to which the bur sinks
constexpr double kSpeed = 2e-6;    // m per tick, speed of the bur
constexpr double kWiden = 0.7e-3;  // m, radius to which the bur's circular path grows
// m; a bur on its circular path has a constant angular speed; at this radius, its speed is kSpeed
constexpr double kCircle = 0.5e-3;
// mm, sides of two square blocks whose surfaces have 53,000 and 1,000,000 vertices
constexpr double kSmallBlock = 12.7, kLargeBlock = 66.8;

/// Returns a block of dentin, 4 mm high, whose top is at z = 0. `side`: mm.
TissueVolume block(double side) {
  return TissueVolume(read_solids(Json::parse(fmt::format(R"({{"voxel_mm": 0.1, "solids": [{{"tissue": "dentin",
                                   "solid": {{"box": {{"center_mm": [0, 0, -2], "size_mm": [{0}, {0}, 4]}}}}}}]}})",
                                                          side),
                                              "bench")));
}

/// One run: a bur sinks into a block and then widens the hole.
struct Widening {
  std::vector<double> times;   // ns, thread CPU time of each tick while the bur widens the hole
  double removed = 0;          // m³, volume that the bur removed in the whole run
  std::uint64_t elements = 0;  // number of vertices of the block's mesh
};

Widening widen(const char* model, const Bur& bur, const TissueVolume& tissue, int ticks) {
  ServoSettings settings;
  settings.tool = head(bur.shape, bur.diameter, bur.length);
  settings.spindle.free_speed = 300 * kKrpm;
  settings.materials.fill({500, 8e9, 0.3, 0.22, 2150, dvec3(0.8)});
  settings.method = contact_method(model, "bench");
  LockStep steps(tissue.clone(), settings);
  Widening run;
  run.elements = steps.carver().body().elements();
  ServoTick tick;
  Cut cut;
  HandSample hand;
  hand.pedal = 1;
  const double half = bur.length / 2;
  const auto go = [&](const dvec3& p) {
    hand.t += 1'000'000;
    hand.X_WT.p = p;
    steps.tick(hand, tick, cut);
    run.times.push_back(static_cast<double>(tick.cpu_time));
  };
  for (double z = 0.05e-3; z > -kDeep; z -= kSpeed) go({0, 0, half + z});
  run.times.clear();
  for (int i = 0; i < ticks; ++i) {
    const double angle = i * kSpeed / kCircle, radius = std::min(i * kSpeed / 10, kWiden);
    go({radius * std::cos(angle), radius * std::sin(angle), half - kDeep});
  }
  run.removed = std::accumulate(tick.removed.begin(), tick.removed.end(), 0.0);
  return run;
}

/// Measures a bur in a block. `place`: words for the names of the rows. One row compares the removed volume with that
/// of the model "offset" with the same hand and motor, because a model that cuts too little would need less time.
void bur_rows(const char* model, const Bur& bur, const TissueVolume& tissue, const std::string& place, int ticks,
              std::vector<BenchRow>& rows) {
  Widening run;
  const std::vector<double> times = least_of([&] {
    run = widen(model, bur, tissue, ticks);
    return run.times;
  });
  const double reference = widen("offset", bur, tissue, ticks).removed;
  const auto row = [&](const char* name) -> BenchRow& {
    BenchRow& r = rows.emplace_back();
    r.name = fmt::format("widen a cavity 1.5 mm deep{}, {}", place, name), r.knob = bur.name;
    return r;
  };
  for (const auto& [name, part] : {std::pair("median", 0.5), std::pair("99.9 %", 0.999)}) {
    BenchRow& r = row(name);
    r.time_ns = quantile(times, part), r.per = "tick";
    r.size = static_cast<double>(run.elements), r.size_unit = "vertices";
  }
  BenchRow& r = row("removed volume");
  r.error = 100 * std::abs(run.removed / reference - 1), r.error_unit = "% difference from `offset`";
}

}  // namespace

void cavity_rows(const char* model, bool all_burs, bool quick, std::vector<BenchRow>& rows) {
  const TissueVolume tissue = block(kSmallBlock);
  for (const Bur& bur : std::span(kBurs).first(all_burs ? std::size(kBurs) : kFewBurs)) {
    bur_rows(model, bur, tissue, "", quick ? 1500 : 6000, rows);
  }
}

void large_cavity_rows(const char* model, std::vector<BenchRow>& rows) {
  const TissueVolume tissue = block(kLargeBlock);
  for (const Bur& bur : kBurs) {
    if (bur.shape != HeadShape::kSphere && bur.shape != HeadShape::kCylinder && bur.shape != HeadShape::kCone) continue;
    bur_rows(model, bur, tissue, ", 1,000,000 vertices", 6000, rows);
  }
}

}  // namespace typodont::haptics::bench
