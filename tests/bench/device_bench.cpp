// From a device's sample to the written force, and the error of the velocity estimate. The link is simulated in memory.
#include <cstdlib>
#include <memory>

#include "engine/app/assets.h"
#include "haptics/coupling/velocity_estimator.h"
#include "haptics/devices/safe_device.h"
#include "haptics/devices/woodenhaptics.h"
#include "haptics/lockstep.h"
#include "tests/bench/haptic_scene.h"

namespace typodont::bench {

namespace {

using namespace haptics;

/// A board that answers at once. It simulates a small oscillation of the arm, with one report per simulated period.
class MemoryBoard : public Link {
 public:
  explicit MemoryBoard(double rate) : period_(from_seconds(1 / rate)) {}
  int read(std::span<std::uint8_t> buffer, Nanos timeout) noexcept override {
    if (timeout == 0) return 0;
    t_ += period_;
    const auto counts = static_cast<std::uint8_t>(std::abs(t_ / 1'000'000 % 200 - 100) / 4);
    for (std::size_t i = 0; i < 14; ++i) buffer[i] = i < 12 && i % 2 == 0 ? counts : 0;
    return 14;
  }
  bool write(std::span<const std::uint8_t> bytes) noexcept override {
    sum_ += bytes[1];
    return true;
  }
  Nanos now() noexcept override { return t_; }

 private:
  Nanos period_, t_ = 0;
  unsigned sum_ = 0;
};

/// The loop of an arm. `contact`: the tip presses on a block; otherwise the force is constant.
void arm_loop(benchmark::State& state, const char* preset, double rate, bool contact) {
  const Arm arm = read_arm(assets_folder() / "devices" / (std::string(preset) + ".json"));
  auto link = std::make_unique<MemoryBoard>(rate);
  Link& clock = *link;
  DeviceInfo identity;
  identity.rate = rate;
  auto device = make_arm_device(std::move(link), ArmProtocol::kHidV2, arm, std::move(identity));
  auto options = SafeDevice::options_for(device->info());
  options.clock = [&clock] { return clock.now(); };
  options.watchdog_thread = false;
  ServoSettings settings;
  settings.tool = round_head(2e-3);
  settings.tool.cuts = false;
  settings.tick = 1 / rate;
  settings.materials = even_materials();
  settings.position_step = device->info().position_step;
  SafeDevice hand(std::move(device), options);
  HandSample sample;
  hand.read(sample);
  const dvec3 tip = 1e3 * sample.X_WT.p;  // mm; the whole path of the tip lies below the top of the block
  LockStep steps(
      TissueVolume(tissue(fmt::format(R"([{{"tissue": "enamel", "solid": {{"box": {{"center_mm": [{}, {}, {}],
                                                      "size_mm": [12, 12, 8]}}}}}}])",
                                      tip.x, tip.y, tip.z - 4.5),
                          0.2)),
      settings);
  steps.take_snapshot(sample.X_WT.p);
  steps.adopt_snapshot();
  std::vector<double> times;
  ServoTick tick;
  Cut cut;
  for (int i = 0; i < (smoke() ? 1000 : 50'000); ++i) {
    hand.read(sample);
    const Nanos woke = now();
    dvec3 f = hand.armed() ? dvec3(0.1, 0.2, 0.3) : dvec3(0);
    if (contact) {
      steps.servo().tick(sample, tick, cut);
      f = tick.f_T_W;
    }
    hand.write(f, dvec3(0));
    times.push_back(static_cast<double>(now() - woke));
  }
  set_times(state, times);
  require_time(quantile(times, 0.5) < 50e3, "an arm's tick takes less than 50 µs");
}

/// Root mean square error of the velocity of a path, mm/s, at an encoder step of 0.055 mm: the estimate, compared with
/// the truth at its stated lag, and the difference of two samples.
void velocity(benchmark::State& state, double rate, double (*path)(double)) {
  constexpr double kStep = 0.055e-3;
  VelocityEstimator estimator(kStep);
  double estimated = 0, difference = 0, lag = 0, last = 0;
  int n = 0;
  for (int i = 0; i < static_cast<int>(4 * rate); ++i) {
    const double t = i / rate, x = kStep * std::round(path(t) / kStep);
    const auto v_true = [&](double at) { return (path(at + 1e-6) - path(at - 1e-6)) / 2e-6; };
    const VelocityEstimate estimate = estimator.add(from_seconds(t), {x, 0, 0});
    if (t > 0.5) {
      estimated += std::pow(estimate.v.x - v_true(t - estimate.lag), 2);
      difference += std::pow((x - last) * rate - v_true(t - 0.5 / rate), 2);
      lag += estimate.lag, ++n;
    }
    last = x;
  }
  estimated = 1e3 * std::sqrt(estimated / n), difference = 1e3 * std::sqrt(difference / n);
  state.counters["error_mm_per_s"] = estimated;
  state.counters["difference_error_mm_per_s"] = difference;
  state.counters["lag_ms"] = 1e3 * lag / n;
  require(estimated < 0.5 * difference + 0.1, "the estimated velocity has half the error of a difference");
}

}  // namespace

void add_cases() {
  for (const char* const preset : {"woody", "polhem_v3"})
    add(fmt::format("sample to force, no contact/{}", preset),
        [=](benchmark::State& state) { arm_loop(state, preset, 1000, false); });
  for (const double rate : {1000.0, 4000.0, 10000.0})
    add(fmt::format("sample to force, contact/{:g} kHz", rate / 1e3),
        [=](benchmark::State& state) { arm_loop(state, "woody", rate, true); });
  const std::pair<const char*, double (*)(double)> motions[] = {
      {"at rest", [](double t) { return 0.055e-3 / 2 + 1e-9 * std::sin(700 * t); }},
      {"3 mm per s", [](double t) { return 3e-3 * t; }},
      {"50 mm per s", [](double t) { return 50e-3 * t; }},
      {"swing at 4 Hz", [](double t) { return 0.2 / (8 * kPi) * std::sin(8 * kPi * t); }}};
  for (const auto& [name, path] : motions)
    for (const double rate : {1000.0, 4000.0})
      add(fmt::format("velocity/{}/{:g} kHz", name, rate / 1e3),
          [=, path = path](benchmark::State& state) { velocity(state, rate, path); });
}

}  // namespace typodont::bench
