#include "audio/voice/work_level.h"

#include <cmath>
#include <complex>
#include <vector>

#include "audio/ar/levinson.h"
#include "audio/voice/derive.h"
#include "audio/voice/mapping.h"
#include "engine/base/units.h"

namespace typodont::audio {

namespace {

// Number of frequencies from 0 to half the sampling rate: 2^13 + 1.
constexpr std::size_t kPoints = 8193;
// Sampling rate of a usual sound device, Hz.
constexpr double kRate = 48000;
constexpr double kMaxBright = 30;  // largest gain of the frequencies above kBrightFrom

/// Mean power of the whole sound, and of its frequencies above kBrightFrom, full scale².
struct Power {
  double all = 0, high = 0;
  void add(double frequency, double power) {
    all += power;
    if (frequency > kBrightFrom) high += power;
  }
};

/// Power response |1 + gain (1 - L)|², L: low-pass filter. The synthesizer adds gain × the signal above kBrightFrom.
double brightened(double frequency, double gain) {
  const double pole = 1 - std::exp(-2 * kPi * kBrightFrom / kRate);
  const std::complex<double> z = std::polar(1.0, -2 * kPi * frequency / kRate);
  return std::norm(1.0 + gain * (1.0 - pole / (1.0 - (1 - pole) * z)));
}

/// Adds the power of a model's noise. `speed`: relative to the recording; `gain`: factor of the power; `bright`: gain
/// of high frequencies.
void add_noise(Power& power, const ArModel& model, double speed, double gain, double bright) {
  const auto density = sampled_power(model.reflection, model.gain, kPoints);
  for (std::size_t i = 0; i < kPoints; ++i) {
    const double f = static_cast<double>(i) / (kPoints - 1) * model.rate / 2 * speed;
    power.add(f, gain * density[i] / kPoints * brightened(f, bright));
  }
}
void add_lines(Power& power, const ArModel& model, double speed, double gain, double bright) {
  for (const ModelLine& line : model.lines) {
    const double f = line.frequency * speed, varies = line.amplitude_noise.deviation();
    power.add(f, gain * line.amplitude * line.amplitude / 2 * (1 + varies * varies) * brightened(f, bright));
  }
}
void add_tones(Power& power, const SoundModels& models, double speed) {
  for (const RotorTone& tone : models.tones) {
    const double amplitude = tone.amplitude * speed;
    power.add(tone.multiple * speed * models.free_speed / (2 * kPi), amplitude * amplitude / 2);
  }
}

}  // namespace

bool calibrate(SoundModels& models, const WorkLevel& measured) {
  const auto tissue = static_cast<std::size_t>(measured.tissue);
  const double speed = measured.spindle / models.free_speed;
  const double angle = 0.5 * kPi * load_of(measured.contact_area, measured.force, measured.removal_rate);
  const double idle_gain = std::pow(std::cos(angle) * std::pow(speed, kIdleExponent), 2);
  const double work_gain = std::pow(std::sin(angle) * loudness_of(measured.contact_area) * speed, 2);
  const ArModel work = models.working[tissue] ? *models.working[tissue] : derived_working_models(models.idle)[tissue];

  Power idle;
  add_noise(idle, models.idle, 1, 1, 0);
  add_lines(idle, models.idle, 1, 1, 0);
  add_tones(idle, models, 1);
  const double wanted_all = idle.all * std::pow(10, measured.level_dB / 10);
  const double wanted_high = idle.high * std::pow(10, measured.high_dB / 10);

  // Bisection of the gain of high frequencies. For each tried value, `gain` is set so that the level is as measured.
  double gain = 0;
  const auto excess = [&](double brightness) {
    const double bright = brightness * brightness_of(measured.force, measured.removal_rate);
    Power fixed, scaled;
    add_noise(fixed, models.idle, speed, idle_gain, 0);
    add_lines(fixed, models.idle, speed, idle_gain, bright);
    add_tones(fixed, models, speed);
    add_noise(scaled, work, speed, work_gain, bright);
    add_lines(scaled, work, speed, work_gain, bright);
    gain = (wanted_all - fixed.all) / scaled.all;
    return fixed.high + gain * scaled.high - wanted_high;
  };
  double low = 0, high = kMaxBright;
  if (excess(low) > 0 || excess(high) < 0) return false;
  for (int i = 0; i < 50; ++i) {
    const double middle = 0.5 * (low + high);
    (excess(middle) < 0 ? low : high) = middle;
  }
  if (!(gain > 0)) return false;
  models.working_gain = std::sqrt(gain);
  models.brightness = low;
  return true;
}

}  // namespace typodont::audio
