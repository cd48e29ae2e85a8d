// The set-up in which contact and cutting are measured: simple solids, servo and carver (owner of the tissue), a hand.
#pragma once

#include <atomic>
#include <functional>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "engine/base/clock.h"
#include "haptics/lockstep.h"
#include "haptics/solid.h"
#include "haptics/surface_patch.h"

namespace typodont::haptics::bench {

/// Makes tissue from `solids`, which is JSON text as in a scene file.
DenseTissue tissue(std::string_view solids, double voxel_mm);

inline constexpr std::string_view kBall = R"([{"tissue": "enamel", "solid": {"sphere": {"radius_mm": 4}}}])";
inline constexpr std::string_view kBlock = R"([{"tissue": "dentin", "solid": {"box": {"size_mm": [6, 6, 4]}}}])";
inline constexpr double kBallRadius = 4e-3, kBlockTop = 2e-3;  // m, radius of the ball and height of the block's top

Tool head(HeadShape shape, double diameter, double length);

double degrees_between(const dvec3& a, const dvec3& b);

/// A thread that copies patches (the field around the tool) in place of the carver's thread. As in a session, it runs
/// on another core if there is one, so its memory accesses do not displace the servo's code and data from the caches.
class OtherThread {
 public:
  OtherThread();
  ~OtherThread();
  OtherThread(const OtherThread&) = delete;
  OtherThread& operator=(const OtherThread&) = delete;

  /// Runs `work` on this object's thread and waits until `work` has finished.
  void run(std::function<void()> work);

 private:
  void hand_over();
  void loop();

  std::atomic<bool> busy_{false};
  std::function<void()> work_;
  std::thread thread_;
};

/// Servo and carver (owner of the tissue), which run in turn. Snapshots of the tissue are taken on another core.
struct Scene {
  LockStep steps;
  const ServoSettings& settings = steps.settings();
  Carver& carver = steps.carver();
  Servo& servo = steps.servo();
  ServoTick last;
  Cut cut;
  Nanos t = 0;
  OtherThread carving;

  Scene(const DenseTissue& dense, const ServoSettings& settings);
  Scene(TissueVolume tissue, const ServoSettings& settings);

  /// Returns the servo's patch (the field around the tool), for contact models that use a distance field.
  const SurfacePatch& patch() const { return dynamic_cast<const SurfacePatch&>(servo.snapshot()); }
  /// Takes a new snapshot if one is due, as at the start of every tick. The first snapshot has its centre at the hand.
  /// Returns true if a snapshot was taken.
  bool renew_patch(const Pose& X_WT);
  /// Computes one tick. Returns the CPU time of this tick in ns.
  double tick(const Pose& X_WT, double pedal);
};

/// Returns the CPU times of `count` ticks of the servo alone, ns. A snapshot is taken in the first tick; the servo uses
/// it in all ticks. hand(i, last tick) returns the position of the tool in m.
template <class Hand>
std::vector<double> servo_times(TissueVolume tissue, const ServoSettings& settings, double pedal, int count,
                                Hand&& hand) {
  LockStep steps(std::move(tissue), settings);
  std::vector<double> times;
  HandSample sample;
  sample.pedal = pedal;
  ServoTick tick;
  Cut cut;
  for (int i = 0; i < count; ++i) {
    sample.t = from_seconds(1e-3 * i);
    sample.X_WT.p = hand(i, tick);
    if (i == 0) {
      steps.take_snapshot(sample.X_WT.p);
      steps.adopt_snapshot();
    }
    const Nanos start = thread_cpu_time();
    const bool cuts = steps.tick_servo(sample, tick, cut);
    times.push_back(static_cast<double>(thread_cpu_time() - start));
    if (cuts) steps.apply_cuts(cut.index);
  }
  return times;
}

/// A simulated hand (0.15 kg, 5 N·s/m) that pushes with 1 N and oscillates sideways.
class DrillingHand {
 public:
  explicit DrillingHand(const Tool& tool) : x_(0, 0, kBlockTop + tool.length / 2 + 2e-5) {}
  Pose next(const dvec3& force, double dt) {
    const double swing = 1e-3 * std::sin(2 * kPi * t_);
    v_ += dt * (dvec3(2000 * (swing - x_.x), -2000 * x_.y, -1) - 5.0 * v_ + force) / 0.15;
    x_ += dt * v_;
    t_ += dt;
    return {x_};
  }

 private:
  dvec3 x_, v_{0};
  double t_ = 0;
};

}  // namespace typodont::haptics::bench
