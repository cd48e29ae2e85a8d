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

/// Passes patches (copies of the field around the tool) to the servo as LockStep does, with two patches.
struct LockStepPassing {
  explicit LockStepPassing(Carver&) {}
  void pass(Scene& scene) {
    if (!scene.carver.snapshot_due(scene.last)) return;
    scene.steps.take_snapshot(scene.carver.snapshot_center(scene.last));
    scene.steps.adopt_snapshot();
  }
};
/// Passes patches (copies of the field around the tool) to the servo as in a session, with four patches.
struct SessionPassing {
  explicit SessionPassing(Carver& carver) : exchange(carver) {}
  void pass(Scene& scene) {
    exchange.keep_up(scene.carver, scene.last.patch);
    if (scene.carver.snapshot_due(scene.last)) exchange.offer(scene.carver, scene.carver.snapshot_center(scene.last));
    if (Snapshot* const fresh = exchange.take(scene.servo.snapshot(), scene.last.cuts, scene.t))
      scene.servo.adopt(*fresh);
  }
  PatchExchange exchange;
};

/// Returns the mean time of a tick of the whole program, ns: servo, carver (owner of the tissue) and transfer of
/// patches (copies of the field around the tool). All of them run on one thread, so the CPU time of this thread is the
/// time of the whole program. The clock is not read within a tick, because this may take as long as half of a tick.
template <class Passing>
double measure_program(const ProcessCase& c, const DenseTissue& dense, const ServoSettings& settings, int ticks) {
  double least = std::numeric_limits<double>::infinity();
  for (int run = 0; run < kRuns; ++run) {
    Scene scene(dense, settings);
    Passing passing(scene.carver);
    const auto hand = c.hand();
    Nanos start = 0;
    for (int i = 0; i < kApproach + ticks; ++i) {
      if (i == kApproach) start = thread_cpu_time();
      const Pose X_WT = hand(i, scene.last, settings.tick);
      scene.t += from_seconds(settings.tick);
      if (i == 0) scene.last.X_WT = scene.last.X_WG = X_WT;
      passing.pass(scene);
      if (scene.servo.tick({scene.t, X_WT, c.pedal}, scene.last, scene.cut)) scene.carver.apply(scene.cut);
    }
    least = std::min(least, static_cast<double>(thread_cpu_time() - start) / ticks);
  }
  return least;
}

/// Returns the CPU time of the servo in each tick, ns.
std::vector<double> measure_servo(const ProcessCase& c, const DenseTissue& dense, const ServoSettings& settings,
                                  int ticks) {
  return least_of([&] {
    Scene scene(dense, settings);
    const auto hand = c.hand();
    std::vector<double> servo;
    for (int i = 0; i < kApproach + ticks; ++i) {
      const Pose X_WT = hand(i, scene.last, settings.tick);
      scene.t += from_seconds(settings.tick);
      scene.steps.tick({scene.t, X_WT, c.pedal}, scene.last, scene.cut);
      if (i >= kApproach) servo.push_back(static_cast<double>(scene.last.cpu_time));
    }
    return servo;
  });
}

}  // namespace

void process_rows(const BenchOptions& options, std::vector<BenchRow>& rows) {
  for (const double voxel_mm : options.voxels_mm) {
    for (const ProcessCase& c : cases()) {
      const DenseTissue dense = tissue(c.solids, voxel_mm);
      ServoSettings settings;
      settings.tool = c.tool;
      settings.method = options.method;
      settings.spindle.free_speed = 300 * kKrpm;
      const double session = measure_program<SessionPassing>(c, dense, settings, options.ticks);
      const double lock_step = measure_program<LockStepPassing>(c, dense, settings, options.ticks);
      const std::vector<double> servo = measure_servo(c, dense, settings, options.ticks);
      const std::string knob = fmt::format("voxel {:g} mm", voxel_mm), of = ", " + c.name;
      const double mean = std::accumulate(servo.begin(), servo.end(), 0.0) / options.ticks;
      const double median = quantile(servo, 0.5);
      rows.push_back({"process time, servo alone" + of, knob, BenchRow::kNone, "", mean, "tick"});
      rows.push_back({"process time, servo, carver and hand-over" + of, knob, BenchRow::kNone, "", lock_step, "tick",
                      "the servo alone", lock_step / mean});
      rows.push_back({"process time, patches passed as in a session" + of, knob, BenchRow::kNone, "", session, "tick",
                      "the servo alone", session / mean});
      for (const double fraction : {0.5, 0.99, 0.999}) {
        const double ns = quantile(servo, fraction);
        rows.push_back({fmt::format("servo's tick, {:g} %{}", 100 * fraction, of), knob, BenchRow::kNone, "", ns,
                        "tick", "its median", ns / median});
      }
      histogram_rows("servo's tick, histogram" + of, knob, servo, rows);
    }
  }
}

}  // namespace typodont::haptics::bench
