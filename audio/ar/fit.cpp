#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <optional>

#include "audio/ar/estimate.h"
#include "audio/ar/filter.h"
#include "audio/ar/levinson.h"
#include "audio/ar/lines.h"
#include "audio/ar/noise.h"
#include "audio/ar/parts.h"
#include "audio/ar/resample.h"
#include "audio/ar/rotor.h"
#include "audio/ar/spectrum.h"
#include "audio/ar/speed.h"
#include "audio/ar_fit.h"
#include "audio/sound_file.h"
#include "engine/base/error.h"
#include "engine/base/quantile.h"
#include "engine/base/units.h"

namespace typodont::audio {

namespace {

// Lowest compared frequency, Hz; the analysis window cannot resolve lower frequencies.
constexpr double kLowestCompared = 60;
// Peak amplitude below which a recording is silent: -60 dB re full scale.
constexpr double kSilence = 1e-3;
// Frames at both ends of a recording are silence if they are quieter than its loud frames by more than this, dB.
constexpr double kQuietBelowLoud = 40;
// In a steady interval, the level differs from the loud part's median level by at most this, dB.
constexpr double kSteadyWithin = 3;
constexpr std::size_t kSamplesPerOrder = 10;
// If the range of the spindle's speed divided by its mean is above this, changes of speed are removed before the fit.
constexpr double kConstantSpeed = 0.002;
// Largest allowed fraction of a recording that is not fitted but compared with the model (FitOptions::hold_out).
constexpr double kMaxHeldOut = 0.9;
// Length of the Welch window, s. Its resolution is about that of a model of order 300 at 48 kHz.
constexpr double kWelchWindow = 1024.0 / 48000;

void refuse_what_is_not_finite(const std::filesystem::path& file, const Recording& recording) {
  for (std::size_t c = 0; c < recording.channels.size(); ++c) {
    for (std::size_t i = 0; i < recording.length(); ++i) {
      const double v = recording.channels[c][i];
      if (std::isfinite(v)) continue;
      throw Error(file.string(),
                  fmt::format("sample {} of channel {} ({:.4f} s)", i, c, static_cast<double>(i) / recording.rate),
                  std::isnan(v) ? "NaN" : "infinity", "a finite sample");
    }
  }
}

/// Throws Error for clipping: many samples have the largest or smallest value, some of them adjacent.
void refuse_clipping(const std::filesystem::path& file, std::span<const double> x) {
  const auto [low, high] = std::minmax_element(x.begin(), x.end());
  std::size_t extreme = 0, neighbours = 0;
  bool before = false;
  for (const double v : x) {
    const bool at_extreme = (*high > 0 && v >= 0.9995 * *high) || (*low < 0 && v <= 0.9995 * *low);
    extreme += at_extreme;
    neighbours += at_extreme && before;
    before = at_extreme;
  }
  const double fraction = static_cast<double>(extreme) / static_cast<double>(x.size());
  if (extreme >= 10 && neighbours >= 3 && fraction > 1e-4) {
    throw Error(file.string(), "",
                fmt::format("clipping: {} samples ({:.2f} %) at the extremes {:.3f} and {:.3f}", extreme,
                            100 * fraction, *low, *high),
                "a recording that stays below its full scale");
  }
}

/// Throws Error if one spectral line contains nearly all power.
void refuse_one_tone(const std::filesystem::path& file, std::span<const double> x, double rate) {
  constexpr std::size_t kPoints = 8192;
  const auto power = welch(x, kPoints, rate);
  const auto peak = static_cast<std::size_t>(std::max_element(power.begin(), power.end()) - power.begin());
  double total = 0, line = 0;
  for (std::size_t i = 0; i < power.size(); ++i) {
    total += power[i];
    // Sums the power of the spectral line: its main lobe and first side lobes.
    if (i + 4 >= peak && i <= peak + 4) line += power[i];
  }
  if (line > 0.999 * total) {
    throw Error(file.string(), "",
                fmt::format("one tone at {:.0f} Hz with {:.2f} % of the power",
                            static_cast<double>(peak) * rate / kPoints, 100 * line / total),
                "a sound with noise in it");
  }
}

/// Index of the first audible sample, and the index after the last one.
std::pair<std::size_t, std::size_t> audible(std::span<const double> x, double rate) {
  const auto frame = static_cast<std::size_t>(0.02 * rate);
  const auto levels = frame_levels(x, frame);
  if (levels.size() < 3) return {0, x.size()};
  const double floor = lower_quantile(levels, 0.95) - kQuietBelowLoud;
  const auto sounds = [&](double level) { return level > floor; };
  const auto first = std::find_if(levels.begin(), levels.end(), sounds) - levels.begin();
  const auto last = std::find_if(levels.rbegin(), levels.rend(), sounds).base() - levels.begin();
  const bool to_end = last == static_cast<std::ptrdiff_t>(levels.size());
  return {static_cast<std::size_t>(first) * frame, to_end ? x.size() : static_cast<std::size_t>(last) * frame};
}

/// Longest interval whose level is within kSteadyWithin of the loud frames' median level.
std::pair<std::size_t, std::size_t> steady(std::span<const double> x, double rate) {
  const auto frame = static_cast<std::size_t>(0.05 * rate);
  const auto levels = frame_levels(x, frame);
  if (levels.size() < 3) return {0, x.size()};
  std::vector<double> loud;
  const double limit = lower_quantile(levels, 0.9) - 6;
  std::copy_if(levels.begin(), levels.end(), std::back_inserter(loud), [&](double v) { return v >= limit; });
  const double level = lower_quantile(loud, 0.5);
  std::size_t best_from = 0, best_length = 0, run = 0;
  for (std::size_t i = 0; i < levels.size(); ++i) {
    run = std::abs(levels[i] - level) <= kSteadyWithin ? run + 1 : 0;
    if (run > best_length) {
      best_length = run;
      best_from = i + 1 - run;
    }
  }
  return {best_from * frame, (best_from + best_length) * frame};
}

/// Returns the mains frequency (50 or 60 Hz) if its power is 20 dB above the median at nearby frequencies, otherwise 0.
double detected_hum(std::span<const double> x, double rate) {
  const auto points = static_cast<std::size_t>(2 * std::floor(std::min(static_cast<double>(x.size()), 4 * rate) / 2));
  // In recordings shorter than 0.5 s, 50 Hz cannot be distinguished from 60 Hz.
  if (static_cast<double>(points) < 0.5 * rate) return 0;
  const auto power = welch(x, points, rate);
  const double bin = rate / static_cast<double>(points);
  for (const double mains : {50.0, 60.0}) {
    double line = 0;
    std::vector<double> around;
    for (std::size_t i = 1; i < power.size() && static_cast<double>(i) * bin < mains + 25; ++i) {
      const double away = std::abs(static_cast<double>(i) * bin - mains);
      if (away <= 1.5 + bin) line = std::max(line, power[i]);
      if (away > 4 + 2 * bin && away < 25) around.push_back(power[i]);
    }
    if (!around.empty() && line > 100 * lower_quantile(around, 0.5)) return mains;
  }
  return 0;
}

/// Removes the mains frequency and four harmonics with notch filters, applied forward and backward, so that no phase
/// shift remains.
void remove_hum(std::vector<double>& x, double mains, double rate) {
  for (int harmonic = 1; harmonic <= 5; ++harmonic) {
    const double w = 2 * kPi * mains * harmonic / rate;
    if (w > 0.9 * kPi) break;
    // Notch 4 Hz wide: zeros on the unit circle, poles slightly inside.
    const double r = 1 - kPi * 4 / rate, c = -2 * std::cos(w);
    const double gain = (1 + c * r + r * r) / (2 + c);  // factor that makes the gain 1 at 0 Hz
    for (int pass = 0; pass < 2; ++pass) {
      double x1 = 0, x2 = 0, y1 = 0, y2 = 0;
      for (double& v : x) {
        const double y = gain * (v + c * x1 + x2) - c * r * y1 - r * r * y2;
        x2 = x1;
        x1 = v;
        y2 = y1;
        y1 = y;
        v = y;
      }
      std::reverse(x.begin(), x.end());
    }
  }
}

/// If the band above the audible one is empty (40 dB below the weakest audible frequency), returns the standard
/// deviation of the white noise that fills it; otherwise 0. Without this noise, the model would use poles for the band.
double fill_of_empty_band(std::span<const double> x, double rate) {
  const auto points = static_cast<std::size_t>(2 * std::lround(kWelchWindow * rate / 2));
  const auto power = welch(x, points, rate);
  const double audible = std::min(20000.0, 0.42 * rate);
  double weakest = 1e300, emptiest = 1e300;
  for (std::size_t i = 2; i + 1 < power.size(); ++i) {
    const double f = static_cast<double>(i) * rate / static_cast<double>(points);
    double& least = f <= audible ? weakest : emptiest;
    least = std::min(least, power[i]);
  }
  const double fill = 0.1 * weakest;
  return emptiest < 1e-4 * weakest ? std::sqrt(fill * rate / 2) : 0.0;
}

Window window_named(const std::string& name) {
  if (name == "none") return Window::kNone;
  if (name == "hann") return Window::kHann;
  if (name == "hamming") return Window::kHamming;
  if (name == "blackman") return Window::kBlackman;
  throw Error("--window", "", "\"" + name + "\"", "none, hann, hamming or blackman");
}

/// Returns the order that the user chose; 0: a criterion chooses it.
std::size_t order_asked(const FitOptions& options) {
  if (options.order == "aic" || options.order == "bic") return 0;
  int order = 0;
  const char* end = options.order.data() + options.order.size();
  const auto result = std::from_chars(options.order.data(), end, order);
  if (result.ec != std::errc() || result.ptr != end || order < 1 || order > 5000) {
    throw Error("--order", "", "\"" + options.order + "\"", "1 to 5000, aic or bic");
  }
  return static_cast<std::size_t>(order);
}

/// Compares the held-out part with the model. `model`: the model's expected spectrum at the frequencies of `report`.
HeldOut compared(std::span<const double> unseen, double rate, const FitReport& report,
                 const std::vector<double>& model) {
  HeldOut held;
  held.to = report.to;
  held.from = report.to - static_cast<double>(unseen.size()) / rate;
  const auto points = static_cast<std::size_t>(2 * std::lround(kWelchWindow * rate / 2));
  const auto power = welch(unseen, points, rate);
  std::vector<double> measured;
  for (std::size_t i = 0; i < report.frequencies.size(); ++i)
    if (report.frequencies[i] >= kLowestCompared && report.frequencies[i] <= report.up_to)
      measured.push_back(power[i + 1]);
  held.distance_dB = log_spectral_distance(measured, model);
  held.chance_dB = chance_distance(unseen.size(), points);
  for (const ModelLine& line : report.model.lines)
    held.line_variation.push_back(follow_line(unseen, rate, line.frequency).variation());
  return held;
}

/// Lists parts of a recording for a message: "run-up 0.60 to 0.85 s, idle 0.85 to 2.40 s".
std::string named(const std::vector<SoundPart>& parts) {
  std::string names;
  for (const SoundPart& part : parts)
    names += fmt::format("{}{} {:.2f} to {:.2f} s", names.empty() ? "" : ", ", name_of(part.part), part.from, part.to);
  return names.empty() ? "none" : names;
}

}  // namespace

FitReport fit_recording(const std::filesystem::path& file, const FitOptions& options) {
  const std::size_t order = order_asked(options);
  const bool by_criterion = order == 0;
  if (by_criterion && (options.max_order < 1 || options.max_order > 5000)) {
    throw Error("--max-order", "", fmt::to_string(options.max_order), "1 to 5000");
  }
  const std::size_t highest = by_criterion ? static_cast<std::size_t>(options.max_order) : order;
  const bool yule = options.method == "yule-walker", covariance = options.method == "modified-covariance";
  if (!yule && !covariance && options.method != "burg") {
    throw Error("--method", "", "\"" + options.method + "\"", "burg, yule-walker or modified-covariance");
  }
  const Window window = window_named(options.window);
  if (covariance && window != Window::kNone) {
    throw Error("--window", "", options.window, "none: modified covariance takes its samples unwindowed");
  }
  if (covariance && by_criterion) {
    throw Error("--order", "", options.order, "a number: modified covariance solves for one order only");
  }
  if (options.hum != "auto" && options.hum != "off" && options.hum != "50" && options.hum != "60") {
    throw Error("--hum", "", "\"" + options.hum + "\"", "auto, off, 50 or 60");
  }
  if (options.rate != 0 && !(options.rate >= 4000 && options.rate <= 400000)) {
    throw Error("--rate", "", fmt::format("{} Hz", options.rate), "4000 to 400000 Hz");
  }

  const std::optional<DrillPart> wanted = drill_part_named(options.part);
  if (!wanted && !options.part.empty()) {
    throw Error("--part", "", "\"" + options.part + "\"", "run-up, idle, load or run-down");
  }

  if (!(options.hold_out >= 0 && options.hold_out <= kMaxHeldOut)) {
    throw Error("--hold-out", "", fmt::to_string(options.hold_out), fmt::format("0 to {}", kMaxHeldOut));
  }

  const Recording recording = read_recording(file);
  FitReport report;
  refuse_what_is_not_finite(file, recording);
  if (options.channel >= static_cast<int>(recording.channels.size())) {
    throw Error(file.string(), "channel", fmt::to_string(options.channel),
                fmt::format("0 to {}", recording.channels.size() - 1));
  }
  const double rate = recording.rate;
  report.duration = static_cast<double>(recording.length()) / rate;

  // Selects the part that the user gave, without silence at its ends; on request, its longest steady interval.
  const double to = options.to > 0 ? options.to : report.duration;
  if (!(options.from >= 0 && options.from < to && to <= report.duration + 1e-6)) {
    throw Error(file.string(), "--from and --to", fmt::format("{} to {} s", options.from, to),
                fmt::format("a part of 0 to {:.3f} s", report.duration));
  }
  std::size_t first = static_cast<std::size_t>(std::lround(options.from * rate));
  std::size_t last = std::min(recording.length(), static_cast<std::size_t>(std::lround(to * rate)));
  std::vector<double> x = recording.mono(options.channel);
  double peak = 0;
  for (std::size_t i = first; i < last; ++i) peak = std::max(peak, std::abs(x[i]));
  const double offset = std::accumulate(x.begin() + static_cast<std::ptrdiff_t>(first),
                                        x.begin() + static_cast<std::ptrdiff_t>(last), 0.0) /
                        static_cast<double>(std::max<std::size_t>(1, last - first));
  double swing = 0;
  for (std::size_t i = first; i < last; ++i) swing = std::max(swing, std::abs(x[i] - offset));
  if (swing < kSilence) {
    throw Error(file.string(), "", fmt::format("silence: peak {:.1f} dB re full scale", in_dB(swing * swing)),
                "a sound above -60 dB");
  }
  for (double& v : x) v -= offset;
  if (std::abs(offset) > 0.01 * peak) report.notes.push_back(fmt::format("constant offset {:.4f} removed", offset));
  const auto narrow = [&](std::pair<std::size_t, std::size_t> range, const char* what) {
    if (range.first == 0 && range.second == last - first) return;
    last = first + range.second;
    first += range.first;
    report.notes.push_back(fmt::format("{}: kept {:.3f} to {:.3f} s", what, static_cast<double>(first) / rate,
                                       static_cast<double>(last) / rate));
  };
  if (options.trim) narrow(audible({x.data() + first, last - first}, rate), "silence trimmed");
  report.parts = parts_of({x.data() + first, last - first}, rate);
  for (SoundPart& part : report.parts) {
    part.from += static_cast<double>(first) / rate;
    part.to += static_cast<double>(first) / rate;
  }
  if (wanted) {
    const SoundPart* longest = nullptr;
    for (const SoundPart& part : report.parts)
      if (part.part == *wanted && (!longest || part.to - part.from > longest->to - longest->from)) longest = &part;
    if (!longest) throw Error(file.string(), "--part", options.part, "one of the recording: " + named(report.parts));
    const double from = longest->from * rate - static_cast<double>(first);
    narrow({static_cast<std::size_t>(std::lround(from)),
            static_cast<std::size_t>(std::lround(longest->to * rate - static_cast<double>(first)))},
           "part of the recording");
  } else if (report.parts.size() > 1 && !options.steady) {
    report.notes.push_back("not steady: " + named(report.parts) + "; --part fits one of them, --steady the most even");
  }
  if (options.steady) narrow(steady({x.data() + first, last - first}, rate), "steady stretch");
  x = std::vector<double>(x.begin() + static_cast<std::ptrdiff_t>(first),
                          x.begin() + static_cast<std::ptrdiff_t>(last));
  report.from = static_cast<double>(first) / rate;
  report.to = static_cast<double>(last) / rate;

  // Checks that this part of the recording can be fitted.
  const double model_rate = options.rate > 0 ? options.rate : rate;
  const double samples_fitted = (1 - options.hold_out) * static_cast<double>(x.size()) * model_rate / rate;
  if (samples_fitted < static_cast<double>(kSamplesPerOrder * highest)) {
    throw Error(file.string(), "",
                fmt::format("{:.0f} samples ({:.3f} s): too short for order {}", samples_fitted,
                            samples_fitted / model_rate, highest),
                fmt::format("at least {} samples, or an order of at most {}", kSamplesPerOrder * highest,
                            std::max(1, static_cast<int>(samples_fitted) / static_cast<int>(kSamplesPerOrder))));
  }
  refuse_one_tone(file, x, rate);
  for (std::size_t c = 0; c < recording.channels.size(); ++c) {
    if (options.channel >= 0 && options.channel != static_cast<int>(c)) continue;
    refuse_clipping(file, {recording.channels[c].data() + first, last - first});
  }

  // Removes hum, changes the sampling rate, and removes changes of the speed.
  report.hum = options.hum == "off" ? 0 : options.hum == "auto" ? detected_hum(x, rate) : std::stod(options.hum);
  if (report.hum > 0) {
    remove_hum(x, report.hum, rate);
    report.notes.push_back(fmt::format("mains hum at {:.0f} Hz and its harmonics removed", report.hum));
  }
  if (model_rate != rate) {
    x = resampled(x, rate, model_rate);
    report.notes.push_back(fmt::format("resampled from {:.0f} to {:.0f} Hz", rate, model_rate));
  }
  const auto fill = [&] {
    const double level = fill_of_empty_band(x, model_rate);
    GaussianNoise noise(1);
    if (level > 0)
      for (double& v : x) v += level * static_cast<double>(noise.next());
    return level;
  };
  if (const double level = fill(); level > 0) {
    report.notes.push_back(
        fmt::format("empty band above what is audible filled with noise at {:.0f} dB", in_dB(level * level)));
  }
  if (options.lines) {
    const SpeedTrack speed = speed_of(x, model_rate);
    for (std::size_t i = 0; i < speed.ratio.size(); ++i)
      report.speed_times.push_back(static_cast<double>(i) * speed.step);
    report.speed_ratio = speed.ratio;
    if (speed.range() > kConstantSpeed) {
      x = at_constant_speed(x, model_rate, speed);
      // Resampling has emptied the highest frequencies again, so they are filled with noise.
      fill();
      report.notes.push_back(
          fmt::format("changes of the spindle's speed removed: {:.1f} %, measured on the line at "
                      "{:.0f} Hz",
                      100 * speed.range(), speed.frequency));
    }
  }
  const auto fitted = static_cast<std::size_t>(std::llround((1 - options.hold_out) * static_cast<double>(x.size())));
  const std::vector<double> unseen(x.begin() + static_cast<std::ptrdiff_t>(fitted), x.end());
  x.resize(fitted);
  report.level_dB = in_dB(mean_power(x));

  // Separates the rotor's spectral lines from the noise.
  const std::vector<double> whole = x;
  ArModel& model = report.model;
  std::vector<TakenLine> taken;
  if (options.lines) taken = take_lines(x, model_rate);
  for (const TakenLine& one : taken) {
    model.lines.push_back(one.line);
    report.line_variation.push_back(one.variation);
  }
  const auto weights = window == Window::kNone ? std::vector<double>() : window_samples(window, x.size());
  Estimate estimate = yule         ? yule_walker(x, highest, weights)
                      : covariance ? modified_covariance(x, highest)
                                   : burg(x, highest, weights);
  report.variance_by_order = estimate.by_order;
  std::size_t chosen = highest;
  if (by_criterion) {
    const Criterion criterion = options.order == "aic" ? Criterion::kAkaike : Criterion::kBayes;
    chosen = std::max<std::size_t>(1, best_order(estimate.by_order, x.size(), criterion));
    estimate.reflection.resize(chosen);
    estimate.variance = estimate.by_order[chosen];
    report.notes.push_back(fmt::format("order {} chosen by {} among 1 to {}", chosen, options.order, highest));
  }
  if (estimate.refactored) {
    report.notes.push_back("the least-squares solution was not stable: replaced by the stable model of its spectrum");
  }
  for (const double k : estimate.reflection) report.max_reflection = std::max(report.max_reflection, std::abs(k));
  if (!(estimate.variance > 1e-11 * mean_power(x)) || !(report.max_reflection < 1)) {
    throw Error(file.string(), "",
                fmt::format("pure tones: the residual is {:.0f} dB below the sound",
                            in_dB(mean_power(x)) - in_dB(estimate.variance)),
                "a sound with noise in it");
  }
  model.reflection = estimate.reflection;
  model.gain = std::sqrt(estimate.variance);
  model.rate = model_rate;
  model.samples = x.size();
  model.method = options.method;
  model.name = options.name.empty() ? file.stem().string() : options.name;
  model.source = options.source.empty() ? file.filename().string() : options.source;
  model.licence = options.licence.empty() ? "not stated" : options.licence;
  model.spindle = options.spindle;
  if (model.spindle == 0) {
    model.spindle = 2 * kPi * estimated_rotor_frequency(whole, model_rate);
    model.spindle_estimated = model.spindle > 0;
  }

  // Compares the model with the smoothed spectrum of the recording.
  const auto points = static_cast<std::size_t>(2 * std::lround(kWelchWindow * model_rate / 2));
  const auto measured = welch(whole, points, model_rate);
  report.up_to = std::min(16000.0, 0.45 * std::min(rate, model_rate));
  std::vector<double> a, b;
  for (std::size_t i = 1; i < measured.size(); ++i) {
    report.frequencies.push_back(static_cast<double>(i) * model_rate / static_cast<double>(points));
    report.recording_dB.push_back(in_dB(measured[i]));
  }
  report.model_dB = spectrum_dB(model, report.frequencies);
  const auto seen = expected_welch(sampled_power(model.reflection, model.gain, 32769), points, model_rate);
  const auto lines = lines_through_window(taken, points, model_rate);
  for (std::size_t i = 0; i < report.model_dB.size(); ++i)
    report.model_dB[i] = in_dB(std::pow(10, report.model_dB[i] / 10) + lines[i + 1]);
  std::vector<double> unsmoothed;
  for (std::size_t i = 0; i < report.frequencies.size(); ++i) {
    if (report.frequencies[i] < kLowestCompared || report.frequencies[i] > report.up_to) continue;
    a.push_back(measured[i + 1]);
    b.push_back(seen[i + 1] + lines[i + 1]);
    unsmoothed.push_back(std::pow(10, report.model_dB[i] / 10));
  }
  report.distance_dB = log_spectral_distance(a, b);
  if (options.hold_out > 0) report.held_out = compared(unseen, model_rate, report, b);
  report.unsmoothed_distance_dB = log_spectral_distance(a, unsmoothed);
  report.itakura_saito = itakura_saito(a, b);
  report.condition = direct_form_condition(model);
  report.form = report.condition <= ArFilter::kFloatLimit    ? "float"
                : report.condition <= ArFilter::kDoubleLimit ? "double"
                                                             : "lattice";
  for (const auto& note : report.notes) model.notes += (model.notes.empty() ? "" : "; ") + note;
  return report;
}

}  // namespace typodont::audio
