#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <vector>

#include "engine/base/clock.h"
#include "engine/base/measure.h"
#include "engine/base/units.h"
#include "haptics/coupling/velocity_estimator.h"
#include "haptics/device_bench.h"
#include "haptics/devices/safe_device.h"
#include "haptics/devices/woodenhaptics.h"
#include "haptics/lockstep.h"
#include "haptics/solid.h"

namespace typodont::haptics {

namespace {

/// A simulated board of the second generation that answers at once. It simulates a small oscillation of the arm, and
/// sends one report per period of simulated time.
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

/// Times in ns from each sample to the written force. Every time is stored, because the bins of a histogram would be
/// too coarse.
using Times = std::vector<double>;

Times bare_loop(int ticks) {
  MemoryBoard board(1000);
  Times times;
  times.reserve(static_cast<std::size_t>(ticks));
  std::uint8_t report[64], command[15] = {};
  for (int i = 0; i < ticks; ++i) {
    board.read(report, 1);
    const Nanos woke = now();
    board.write(command);
    times.push_back(static_cast<double>(now() - woke));
  }
  return times;
}

/// Runs the loop of an arm. If `contact` is true, the servo computes contact with a block below the arm's tip;
/// otherwise the force is constant.
Times arm_loop(const Arm& arm, double rate, int ticks, bool contact) {
  auto link = std::make_unique<MemoryBoard>(rate);
  Link& clock = *link;
  DeviceInfo identity;
  identity.rate = rate;
  auto device = make_arm_device(std::move(link), ArmProtocol::kHidV2, arm, std::move(identity));
  auto options = SafeDevice::options_for(device->info());
  options.clock = [&clock] { return clock.now(); };
  options.watchdog_thread = false;
  const double device_step = device->info().position_step;
  SafeDevice hand(std::move(device), options);
  HandSample sample;
  hand.read(sample);

  // The block is placed so that the whole path of the tip lies slightly below its top face.
  const dvec3 tip = sample.X_WT.p;
  const DenseTissue block =
      read_solids(Json::parse(fmt::format(R"({{"voxel_mm": 0.2, "solids": [{{"tissue": "enamel", "solid": {{"box": {{
          "center_mm": [{}, {}, {}], "size_mm": [12, 12, 8]}}}}}}]}})",
                                          tip.x / kMillimetre, tip.y / kMillimetre, tip.z / kMillimetre - 4.5),
                              "bench"));
  ServoSettings settings;
  settings.tool.diameter = settings.tool.length = 2e-3;
  settings.tool.cuts = false;
  settings.tick = 1 / rate;
  for (Material& m : settings.materials) m = {1000, 30e9, 0.2, 0.15, 2950, dvec3(0.9)};
  settings.position_step = device_step;
  LockStep steps(TissueVolume(block), settings);
  steps.take_snapshot(tip);
  steps.adopt_snapshot();

  Times times;
  times.reserve(static_cast<std::size_t>(ticks));
  ServoTick tick;
  Cut cut;
  for (int i = 0; i < ticks; ++i) {
    hand.read(sample);
    const Nanos woke = now();  // time at which the sample arrived
    dvec3 f = hand.armed() ? dvec3(0.1, 0.2, 0.3) : dvec3(0);
    if (contact) {
      steps.servo().tick(sample, tick, cut);
      f = tick.f_T_W;
    }
    hand.write(f, dvec3(0));
    times.push_back(static_cast<double>(now() - woke));
  }
  return times;
}

/// Root mean square error of the estimated velocity on a path, in m/s. The estimate is compared with the true velocity
/// at two times: at the present time, and at a time that is earlier by the estimator's stated lag.
struct VelocityError {
  double now = 0, at_lag = 0, lag = 0, difference = 0;
};
template <class Path>
VelocityError velocity_error(double rate, double step, double noise, Path&& path) {
  VelocityEstimator estimator(noise);
  VelocityError e;
  double last = 0;
  int n = 0;
  for (int i = 0; i < static_cast<int>(4 * rate); ++i) {
    const double t = i / rate;
    const double x = step * std::round(path(t) / step);
    const auto v_true = [&](double at) { return (path(at + 1e-6) - path(at - 1e-6)) / 2e-6; };
    const VelocityEstimate estimate = estimator.add(from_seconds(t), {x, 0, 0});
    if (t > 0.5) {
      e.now += std::pow(estimate.v.x - v_true(t), 2);
      e.at_lag += std::pow(estimate.v.x - v_true(t - estimate.lag), 2);
      e.difference += std::pow((x - last) * rate - v_true(t - 0.5 / rate), 2);
      e.lag += estimate.lag;
      ++n;
    }
    last = x;
  }
  e.now = std::sqrt(e.now / n), e.at_lag = std::sqrt(e.at_lag / n), e.difference = std::sqrt(e.difference / n);
  e.lag /= n;
  return e;
}

}  // namespace

std::vector<BenchRow> bench_devices(const DeviceBenchOptions& options) {
  std::vector<BenchRow> rows;
  const Times bare = bare_loop(options.ticks);
  const double floor = quantile(bare, 0.5), floor_slow = quantile(bare, 0.999);
  const auto add = [&](const std::string& name, const std::string& knob, const Times& times, bool self = false) {
    const auto row = [&](const char* which, double time, double to) {
      rows.push_back({.name = name + ", " + which,
                      .knob = knob,
                      .time_ns = time,
                      .per = "tick",
                      .baseline = self ? "" : "no work",
                      .ratio = self ? BenchRow::kNone : time / to});
    };
    row("median", quantile(times, 0.5), floor);
    row("99.9 %", quantile(times, 0.999), floor_slow);
  };
  add("sample to force: empty loop", "", bare, true);
  for (const char* preset : {"woody", "polhem_v3"}) {
    const Arm arm = read_arm(options.assets / "devices" / (std::string(preset) + ".json"));
    add("sample to force: limits and currents", preset, arm_loop(arm, 1000, options.ticks, false));
  }
  const Arm woody = read_arm(options.assets / "devices/woody.json");
  for (const double rate : {1000.0, 4000.0, 10000.0}) {
    add("sample to force: contact, limits and currents", fmt::format("{:g} kHz", rate / 1e3),
        arm_loop(woody, rate, options.ticks, true));
  }

  // m, step of the encoder; the estimator uses it as the position noise
  constexpr double kStep = 0.055e-3;
  struct Motion {
    const char* name;
    double (*path)(double);
  };
  constexpr Motion kMotions[] = {
      {"at rest on the edge of a count", [](double t) { return kStep / 2 + 1e-9 * std::sin(700 * t); }},
      {"3 mm/s", [](double t) { return 3e-3 * t; }},
      {"50 mm/s", [](double t) { return 50e-3 * t; }},
      {"swing, 4 Hz, 200 mm/s", [](double t) { return 0.2 / (8 * kPi) * std::sin(8 * kPi * t); }}};
  for (const Motion& motion : kMotions) {
    for (const double rate : {1000.0, 4000.0}) {
      const VelocityError e = velocity_error(rate, kStep, kStep, motion.path);
      const std::string knob = fmt::format("{:g} kHz, 0.055 mm", rate / 1e3);
      const auto row = [&](const char* what, double value, const char* unit) {
        rows.push_back({.name = fmt::format("velocity, {}: {}", motion.name, what),
                        .knob = knob,
                        .error = value,
                        .error_unit = unit});
      };
      row("estimate", e.now * 1e3, "mm/s rms");
      row("estimate, at its stated lag", e.at_lag * 1e3, "mm/s rms");
      row("its lag", e.lag * 1e3, "ms mean");
      row("difference of two samples", e.difference * 1e3, "mm/s rms");
    }
  }
  return rows;
}

}  // namespace typodont::haptics
