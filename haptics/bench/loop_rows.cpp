#include <fmt/format.h>
#include <pthread.h>
#include <sched.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <thread>

#include "haptics/bench/rows.h"
#include "haptics/bench/timing.h"

namespace typodont::haptics::bench {

void free_air_row(const BenchOptions& options, std::vector<BenchRow>& rows) {
  ServoSettings settings;
  settings.tool = head(HeadShape::kSphere, 1.2e-3, 1.2e-3);
  settings.method = options.method;
  Scene scene(tissue(kBlock, 0.1), settings);
  const dvec3 above(0, 0, kBlockTop + 2e-3);
  scene.tick({above}, 0);
  constexpr int kBatch = 256;
  // The samples of the hand are computed here, so that the time for this is not measured. In a session, the device
  // delivers them.
  std::vector<HandSample> way;
  for (int k = 0; k < kBatch; ++k) way.push_back({0, {above + dvec3(1e-6 * k, 0, 0)}, 0});
  const double ns = batch_ns(std::max(options.ticks / 100, 5), kBatch, [&](int k) {
    HandSample& hand = way[static_cast<std::size_t>(k)];
    hand.t = scene.t += 1000000;
    scene.servo.tick(hand, scene.last, scene.cut);
  });
  rows.push_back({"free air, median", "round 1.2 mm", BenchRow::kNone, "", ns, "tick"});
}

/// Counts missed deadlines while another thread keeps a second core busy. If `drilling` is false, the count shows how
/// many deadlines are missed because of the machine and not because of the servo. Like the servo of a session, the loop
/// first sleeps and then spins, and has real-time priority if the system grants it.
static void deadline_rows(const BenchOptions& options, bool drilling, std::vector<BenchRow>& rows) {
  constexpr Nanos kPeriod = 100'000, kSpin = 40'000;
  ServoSettings settings;
  settings.tool = head(HeadShape::kSphere, 1.2e-3, 1.2e-3);
  settings.method = options.method;
  settings.spindle.free_speed = 300e3 / 60 * 2 * kPi;
  settings.tick = 1e-9 * kPeriod;
  Scene scene(tissue(kBlock, 0.1), settings);
  DrillingHand hand(settings.tool);
  scene.tick(hand.next(dvec3(0), settings.tick), 1);

  std::atomic<bool> stop{false};
  std::vector<double> late, busy_ticks;
  int missed = 0, ticks = 0;
  bool in_front = false;
  std::thread renderer([&] {
    std::vector<float> picture(1 << 20);
    for (float shade = 0; !stop.load(std::memory_order_relaxed); shade += 1) {
      for (float& pixel : picture) pixel = std::sqrt(pixel * 0.5f + shade);
    }
  });
  std::thread servo([&] {
    const sched_param priority{80};
    in_front = pthread_setschedparam(pthread_self(), SCHED_FIFO, &priority) == 0;
    const int wanted = 10 * options.ticks;
    Nanos next = now() + kPeriod;
    while (ticks < wanted) {
      if (const Nanos rest = next - now() - kSpin; rest > 0)
        std::this_thread::sleep_for(std::chrono::nanoseconds(rest));
      while (now() < next) {
      }
      scene.t += kPeriod;
      const Nanos start = thread_cpu_time();
      if (drilling) scene.servo.tick({scene.t, hand.next(scene.last.f_T_W, settings.tick), 1}, scene.last, scene.cut);
      busy_ticks.push_back(static_cast<double>(thread_cpu_time() - start));
      const Nanos end = now();
      late.push_back(static_cast<double>(end - next));
      ++ticks;
      next += kPeriod;
      for (; next < end; next += kPeriod) ++missed, ++ticks;  // counts a skipped tick as a missed deadline
    }
  });
  servo.join();
  stop = true;
  renderer.join();
  const std::string knob = fmt::format("round 1.2 mm, voxel 0.1 mm, {}", in_front ? "SCHED_FIFO" : "ordinary priority");
  const double fraction = static_cast<double>(missed) / ticks;
  if (!drilling) {
    rows.push_back({"floor: 10 kHz beside a busy core, empty loop", knob, fraction, "of the deadlines missed",
                    quantile(late, 0.5), "tick"});
    return;
  }
  rows.push_back({"drilling at 10 kHz beside a busy core, the tick", knob, fraction, "of the deadlines missed",
                  quantile(busy_ticks, 0.5), "tick"});
  rows.push_back({"drilling at 10 kHz beside a busy core, done after", knob, fraction, "of the deadlines missed",
                  quantile(late, 0.5), "tick"});
}

void deadline_rows(const BenchOptions& options, std::vector<BenchRow>& rows) {
  deadline_rows(options, false, rows);
  deadline_rows(options, true, rows);
}

}  // namespace typodont::haptics::bench
