// The error and the time of filters and sound of a drill.
#include "audio/ar/filter.h"
#include "audio/ar/levinson.h"
#include "audio/ar/noise.h"
#include "audio/ar/spectrum.h"
#include "audio/ar_fit.h"
#include "audio/drill_synth.h"
#include "engine/app/assets.h"
#include "engine/base/units.h"
#include "tests/bench/bench.h"

namespace typodont::bench {

namespace {

using namespace audio;

constexpr std::size_t kSamples = 16384;

const FitReport& fit(bool lines) {
  static std::map<bool, FitReport> fits;
  if (!fits.contains(lines)) {
    FitOptions options;
    options.lines = lines;
    if (!lines) options.order = smoke() ? "100" : "600";
    fits.emplace(lines, fit_recording(assets_folder() / "sounds/micromotor_steady.wav", options));
  }
  return fits.at(lines);
}

template <class F>
double ns_per_sample(F&& work) {
  return measure(smoke() ? 2 : 9, work).median / kSamples;
}

template <class T>
double relative_rms(const std::vector<T>& y, const std::vector<double>& truth) {
  double error = 0, power = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    error += std::pow(static_cast<double>(y[i]) - truth[i], 2);
    power += truth[i] * truth[i];
  }
  return std::sqrt(error / power);
}

/// A model of this order: its spectrum against that of the recording, and the block filter against a simple loop.
void filter(benchmark::State& state, int order) {
  const FitReport& best = fit(false);
  const ArModel model = truncated(best.model, static_cast<std::size_t>(order));
  const std::size_t points = 2 * best.frequencies.size();
  const auto seen = expected_welch(sampled_power(model.reflection, model.gain, 32769), points, model.rate);
  std::vector<double> recorded, modelled;
  for (std::size_t i = 0; i < best.frequencies.size(); ++i) {
    if (best.frequencies[i] < 60 || best.frequencies[i] > best.up_to) continue;
    recorded.push_back(std::pow(10, best.recording_dB[i] / 10));
    modelled.push_back(seen[i + 1]);
  }
  std::vector<float> noise(kSamples), out(kSamples);
  GaussianNoise(1).fill(noise.data(), static_cast<int>(kSamples));
  const std::vector<double> wide(noise.begin(), noise.end());
  std::vector<double> truth(kSamples);
  DirectFilter<double>(model).process(wide.data(), truth.data(), static_cast<int>(kSamples));
  BlockFilter<float> block(model);
  const auto run = [&] {
    for (std::size_t i = 0; i < kSamples; i += BlockFilter<float>::kBlock)
      block.process(noise.data() + i, out.data() + i);
  };
  run();
  const double error = relative_rms(out, truth), ours = ns_per_sample(run);
  DirectFilter<float> direct(model);
  const double loop = ns_per_sample([&] { direct.process(noise.data(), out.data(), static_cast<int>(kSamples)); });
  const double distance = log_spectral_distance(recorded, modelled);
  set_time(state, ours);
  state.counters["simple_loop_ns"] = loop;
  state.counters["filter_error_rel"] = error;
  state.counters["spectrum_error_dB"] = distance;
  require(error < 1e-4, "float and double differ inaudibly");
  if (order != 300) return;
  require_time(loop > 2 * ours, "the block filter of order 300 is twice as fast as a simple loop");
  require(distance < 1, "at order 300, the model is within 1 dB of the recording");
}

/// The complete sound with its spectral lines. `speed`: fraction of the free speed.
void voice(benchmark::State& state, double speed, double area) {
  SoundModels models;
  models.idle = fit(true).model;
  models.free_speed = 300 * kKrpm;
  DrillSynth synth(models, models.idle.rate, 1);
  SoundState sound;
  sound.spindle = speed * models.free_speed;
  sound.contact_area = area;
  sound.force = area > 0 ? 1.5 : 0;
  sound.tissue = Tissue::kEnamel;
  synth.push(sound);
  std::vector<float> out(kSamples);
  const double ns = ns_per_sample([&] { synth.render(out); });
  set_time(state, ns);
  state.counters["core_percent"] = 100 * ns * 1e-9 * models.idle.rate;
  require_time(ns * 1e-9 * models.idle.rate < 0.01, "the sound needs at most 1 % of a core");
}

}  // namespace

void add_cases() {
  for (const int order : smoke() ? std::vector{100} : std::vector{4, 16, 50, 100, 200, 300, 400, 600})
    add(fmt::format("filter, a sample/order {}", order), [=](benchmark::State& state) { filter(state, order); });
  add("drill, a sample/off", [](benchmark::State& state) { voice(state, 0, 0); });
  add("drill, a sample/idle", [](benchmark::State& state) { voice(state, 1, 0); });
  add("drill, a sample/working in enamel", [](benchmark::State& state) { voice(state, 0.8, 0.8e-6); });
}

}  // namespace typodont::bench
