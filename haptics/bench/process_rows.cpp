// Measures the CPU time of a tick, both for the servo alone and for the whole process, which includes the carver (owner
// of the tissue) and the transfer of patches (copies of the field) to the servo.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <string>
#include <vector>

#include "engine/base/units.h"
#include "haptics/bench/rows.h"
#include "haptics/bench/timing.h"
#include "haptics/patch_exchange.h"

namespace typodont::haptics::bench {

namespace {

// number of ticks before the measurement begins; by then the tool has contact and the force has risen
constexpr int kApproach = 200;

/// A case of the benchmark: a hand with a tool. `hand()` returns a function of (i, last, dt), which returns the tool's
/// pose in tick i. `last` contains the data of tick i − 1.
struct ProcessCase {
  std::string name;
  Tool tool;
  double pedal;
  std::string_view solids;
  std::function<std::function<Pose(int, const ServoTick&, double)>()> hand;
};

/// Returns the tool's pose for a hand that slides around a ball at 30 mm/s and a depth of 0.4 mm. Its path is a great
/// circle that is oblique to the voxel axes.
Pose slide(int tick, const Tool& tool, double dt) {
  constexpr double kSpeed = 0.03;  // m/s, speed of the hand
  const double radius = kBallRadius + tool.radius(), angle = kSpeed * dt * tick / radius + 0.3;
  const dvec3 u = glm::normalize(dvec3(1, 0.3, 0.2)), v = glm::normalize(glm::cross(u, dvec3(0.2, -0.1, 1)));
  return {(radius - 4e-4) * (std::cos(angle) * u + std::sin(angle) * v)};
}

ProcessCase drilling(std::string name, const Tool& tool) {
  return {std::move(name), tool, 1, kBlock, [tool] {
            return [hand = DrillingHand(tool)](int, const ServoTick& last, double dt) mutable {
              return hand.next(last.f_T_W, dt);
            };
          }};
}

std::vector<ProcessCase> cases() {
  const Tool round = head(HeadShape::kSphere, 1.2e-3, 1.2e-3);
  ProcessCase sliding{"sliding at 30 mm/s, round 1.2 mm", round, 0, kBall,
                      [round] { return [round](int i, const ServoTick&, double dt) { return slide(i, round, dt); }; }};
  return {std::move(sliding), drilling("drilling, round 1.2 mm", round),
          drilling("drilling, round 4 mm", head(HeadShape::kSphere, 4e-3, 4e-3)),
          drilling("drilling, flame 1.2 x 4 mm", head(HeadShape::kFlame, 1.2e-3, 4e-3))};
}

/// Returns the mean CPU time of a tick, ns. Patches (copies of the field around the tool) are passed as in a session
/// (PatchExchange, four patches), and not in the simpler way of LockStep (two patches). Unlike measure(), this function
/// does not read the clock within a tick.
double measure_session(const ProcessCase& c, const DenseTissue& dense, const ServoSettings& settings, int ticks) {
  double least = std::numeric_limits<double>::infinity();
  for (int run = 0; run < kRuns; ++run) {
    Scene scene(dense, settings);
    Carver& carver = scene.carver;
    PatchExchange exchange(carver);
    const auto hand = c.hand();
    Nanos start = 0;
    for (int i = 0; i < kApproach + ticks; ++i) {
      if (i == kApproach) start = thread_cpu_time();
      const Pose X_WT = hand(i, scene.last, settings.tick);
      scene.t += from_seconds(settings.tick);
      if (i == 0) scene.last.X_WT = scene.last.X_WG = X_WT;
      exchange.keep_up(carver, scene.last.patch);
      if (carver.snapshot_due(scene.last)) exchange.offer(carver, carver.snapshot_center(scene.last));
      if (Snapshot* const fresh = exchange.take(scene.servo.snapshot(), scene.last.cuts, scene.t))
        scene.servo.adopt(*fresh);
      if (scene.servo.tick({scene.t, X_WT, c.pedal}, scene.last, scene.cut)) carver.apply(scene.cut);
    }
    least = std::min(least, static_cast<double>(thread_cpu_time() - start) / ticks);
  }
  return least;
}

/// CPU time of a run. Servo, carver (owner of the tissue) and transfer of patches (copies of the field) run on one
/// thread, so the CPU time of this thread is the time of the whole program.
struct ProcessTime {
  // ns, mean time of a tick of the whole program: servo, carver (owner of the tissue) and transfer of patches (copies
  // of the field)
  double all = std::numeric_limits<double>::infinity();
  double session = 0;  // ns, as `all`, but the patches are passed to the servo as in a session (measure_session())
  std::vector<double> servo;  // ns, time of the servo in each tick
};
ProcessTime measure(const ProcessCase& c, const DenseTissue& dense, const BenchOptions& options) {
  ServoSettings settings;
  settings.tool = c.tool;
  settings.method = options.method;
  settings.spindle.free_speed = 300 * kKrpm;
  // ns. LockStep reads the clock twice in each tick. These readings belong to the measurement and not to the program.
  const double readings = 2 * clock_ns();
  ProcessTime time;
  time.session = measure_session(c, dense, settings, options.ticks);
  time.servo = least_of([&] {
    Scene scene(dense, settings);
    const auto hand = c.hand();
    std::vector<double> servo;
    Nanos start = 0;
    for (int i = 0; i < kApproach + options.ticks; ++i) {
      if (i == kApproach) start = thread_cpu_time();
      const Pose X_WT = hand(i, scene.last, settings.tick);
      scene.t += from_seconds(settings.tick);
      scene.steps.tick({scene.t, X_WT, c.pedal}, scene.last, scene.cut);
      if (i >= kApproach) servo.push_back(static_cast<double>(scene.last.cpu_time));
    }
    time.all = std::min(time.all, static_cast<double>(thread_cpu_time() - start) / options.ticks - readings);
    return servo;
  });
  return time;
}

}  // namespace

void process_rows(const BenchOptions& options, std::vector<BenchRow>& rows) {
  for (const double voxel_mm : options.voxels_mm) {
    for (const ProcessCase& c : cases()) {
      const ProcessTime time = measure(c, tissue(c.solids, voxel_mm), options);
      const std::string knob = fmt::format("voxel {:g} mm", voxel_mm), of = ", " + c.name;
      const double mean = std::accumulate(time.servo.begin(), time.servo.end(), 0.0) / options.ticks;
      const double median = quantile(time.servo, 0.5);
      rows.push_back({"process time, servo alone" + of, knob, BenchRow::kNone, "", mean, "tick"});
      rows.push_back({"process time, servo, carver and hand-over" + of, knob, BenchRow::kNone, "", time.all, "tick",
                      "the servo alone", time.all / mean});
      rows.push_back({"process time, patches passed as in a session" + of, knob, BenchRow::kNone, "", time.session,
                      "tick", "the servo alone", time.session / mean});
      for (const double fraction : {0.5, 0.99, 0.999}) {
        const double ns = quantile(time.servo, fraction);
        rows.push_back({fmt::format("servo's tick, {:g} %{}", 100 * fraction, of), knob, BenchRow::kNone, "", ns,
                        "tick", "its median", ns / median});
      }
      histogram_rows("servo's tick, histogram" + of, knob, time.servo, rows);
    }
  }
}

}  // namespace typodont::haptics::bench
