#include "audio/bench.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstring>
#include <functional>

#include "audio/ar/filter.h"
#include "audio/ar/levinson.h"
#include "audio/ar/noise.h"
#include "audio/ar/simd.h"
#include "audio/ar/spectrum.h"
#include "audio/ar_fit.h"
#include "audio/drill_synth.h"
#include "engine/base/clock.h"
#include "engine/base/units.h"

#ifdef TYPODONT_LIQUID
#include <liquid/liquid.h>
#endif

namespace typodont::audio {

namespace {

/// Lower bound of any direct form: its multiply-adds without feedback.
TYPODONT_CLONES void multiply_add_floor(const float* a, int order, const float* x, float* y, int count) {
  for (int n = 0; n < count; n += 64) {
    Float16 even[4] = {}, odd[4] = {};
    for (int i = 1; i < order; i += 2) {
      for (int v = 0; v < 4; ++v) {
        even[v] -= a[i] * *reinterpret_cast<const Float16Unaligned*>(x + n - i + 16 * v);
        odd[v] -= a[i + 1] * *reinterpret_cast<const Float16Unaligned*>(x + n - i - 1 + 16 * v);
      }
    }
    for (int v = 0; v < 4; ++v) *reinterpret_cast<Float16Unaligned*>(y + n + 16 * v) = even[v] + odd[v];
  }
}

double median_ns(const BenchOptions& options, const std::function<void()>& work) {
  std::vector<double> times;
  for (int r = 0; r < options.repeats; ++r) {
    const Nanos before = thread_cpu_time();
    work();
    times.push_back(static_cast<double>(thread_cpu_time() - before) / options.samples);
  }
  std::nth_element(times.begin(), times.begin() + options.repeats / 2, times.end());
  return times[static_cast<std::size_t>(options.repeats / 2)];
}

template <class T>
double relative_rms(const std::vector<T>& y, const std::vector<double>& truth) {
  double error = 0, power = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const double d = static_cast<double>(y[i]) - truth[i];
    error += d * d;
    power += truth[i] * truth[i];
  }
  return std::sqrt(error / power);
}

template <class T>
void run_blocks(BlockFilter<T>& filter, const std::vector<T>& noise, std::vector<T>& out) {
  for (std::size_t i = 0; i + BlockFilter<T>::kBlock <= noise.size(); i += BlockFilter<T>::kBlock) {
    filter.process(noise.data() + i, out.data() + i);
  }
}

}  // namespace

std::vector<BenchRow> audio_bench(const BenchOptions& options) {
  std::vector<BenchRow> rows;
  const auto count = static_cast<std::size_t>(options.samples / 64 * 64);
  std::vector<float> noise(count), out(count);
  GaussianNoise(1).fill(noise.data(), static_cast<int>(count));
  const std::vector<double> wide(noise.begin(), noise.end());
  std::vector<double> truth(count), wide_out(count);

  FitOptions fit;
  fit.order = std::to_string(*std::max_element(options.orders.begin(), options.orders.end()));
  // the rows measure how well noise fits
  fit.lines = false;
  const FitReport best = fit_recording(options.recording, fit);
  for (const int order : options.orders) {
    const ArModel model = truncated(best.model, static_cast<std::size_t>(order));
    const std::string knob = "order " + std::to_string(order);

    const std::size_t points = 2 * best.frequencies.size();  // samples in a segment of the recording's Welch spectrum
    const auto seen = expected_welch(sampled_power(model.reflection, model.gain, 32769), points, model.rate);
    std::vector<double> recorded, modelled;
    for (std::size_t i = 0; i < best.frequencies.size(); ++i) {
      if (best.frequencies[i] < 60 || best.frequencies[i] > best.up_to) continue;
      recorded.push_back(std::pow(10, best.recording_dB[i] / 10));
      modelled.push_back(seen[i + 1]);
    }

    DirectFilter<double>(model).process(wide.data(), truth.data(), static_cast<int>(count));
    std::vector<float> history(count + 1024, 0.01f), a(static_cast<std::size_t>(order) + 4, 1e-3f);
    const double floor = median_ns(options, [&] {
      multiply_add_floor(a.data(), order, history.data() + 1024, out.data(), static_cast<int>(count));
    });
    rows.push_back({"floor multiply-add float", knob, BenchRow::kNone, "", floor, "sample"});

    // Error with a new filter, time with the same one afterwards.
    BlockFilter<float> single(model);
    run_blocks(single, noise, out);
    const double single_error = relative_rms(out, truth);
    const double single_ns = median_ns(options, [&] { run_blocks(single, noise, out); });
    rows.push_back(
        {"filter block float", knob, single_error, "relative rms", single_ns, "sample", "floor", single_ns / floor});
    rows.push_back({"model", knob, log_spectral_distance(recorded, modelled), "dB log-spectral", single_ns, "sample",
                    "floor", single_ns / floor});
    rows.push_back({"model", knob, itakura_saito(recorded, modelled), "Itakura-Saito", single_ns, "sample", "floor",
                    single_ns / floor});

    BlockFilter<double> twice(model);
    run_blocks(twice, wide, wide_out);
    const double double_error = relative_rms(wide_out, truth);
    const double double_ns = median_ns(options, [&] { run_blocks(twice, wide, wide_out); });
    rows.push_back(
        {"filter block double", knob, double_error, "relative rms", double_ns, "sample", "floor", double_ns / floor});

    DirectFilter<float> direct(model);
    direct.process(noise.data(), out.data(), static_cast<int>(count));
    const double direct_error = relative_rms(out, truth);
    const double direct_ns =
        median_ns(options, [&] { direct.process(noise.data(), out.data(), static_cast<int>(count)); });
    rows.push_back({"filter direct float", knob, direct_error, "relative rms", direct_ns, "sample", "block float",
                    direct_ns / single_ns});

    LatticeFilter lattice(model);
    for (std::size_t i = 0; i < count; ++i) wide_out[i] = lattice.next(wide[i]);
    const double lattice_error = relative_rms(wide_out, truth);
    const double lattice_ns = median_ns(options, [&] {
      for (std::size_t i = 0; i < count; ++i) wide_out[i] = lattice.next(wide[i]);
    });
    rows.push_back({"filter lattice double", knob, lattice_error, "relative rms", lattice_ns, "sample", "block float",
                    lattice_ns / single_ns});

#ifdef TYPODONT_LIQUID
    std::vector<float> numerator(static_cast<std::size_t>(order) + 1, 0.0f), denominator(1, 1.0f);
    numerator[0] = static_cast<float>(model.gain);
    for (const double v : step_up(model.reflection)) denominator.push_back(static_cast<float>(v));
    const auto length = static_cast<unsigned>(denominator.size());
    iirfilt_rrrf packaged = iirfilt_rrrf_create(numerator.data(), length, denominator.data(), length);
    const auto run_packaged = [&] {
      for (std::size_t i = 0; i < count; ++i) iirfilt_rrrf_execute(packaged, noise[i], &out[i]);
    };
    run_packaged();
    const double packaged_error = relative_rms(out, truth);
    const double packaged_ns = median_ns(options, run_packaged);
    iirfilt_rrrf_destroy(packaged);
    rows.push_back({"filter liquid-dsp float", knob, packaged_error, "relative rms", packaged_ns, "sample",
                    "block float", packaged_ns / single_ns});
#endif
  }

  GaussianNoise generator(1);
  const double noise_ns = median_ns(options, [&] { generator.fill(out.data(), static_cast<int>(count)); });
  rows.push_back({"noise", "gaussian", BenchRow::kNone, "", noise_ns, "sample"});

  // The whole voice: time per sample, fraction of a core.
  SoundModels models;
  models.idle = fit_recording(options.recording, {}).model;
  models.free_speed = 300 * kKrpm;
  const auto voice = [&](const std::string& knob, double speed, double area) {
    DrillSynth synth(models, models.idle.rate, 1);
    SoundState state;
    state.spindle = speed * models.free_speed;
    state.contact_area = area;
    state.force = area > 0 ? 1.5 : 0;
    state.tissue = Tissue::kEnamel;
    synth.push(state);
    const double ns = median_ns(options, [&] { synth.render(out); });
    const double real_time = 1e9 / models.idle.rate;
    rows.push_back({"synth", knob, BenchRow::kNone, "", ns, "sample", "one core", ns / real_time});
  };
  voice("off", 0, 0);
  voice("idle at free speed", 1, 0);
  voice("idle slowed", 0.8, 0);
  voice("working in enamel", 0.8, 0.8e-6);
  return rows;
}

}  // namespace typodont::audio
