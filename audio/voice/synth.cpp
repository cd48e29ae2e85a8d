#include <algorithm>
#include <cmath>
#include <vector>

#include "audio/ar/noise.h"
#include "audio/ar/resample.h"
#include "audio/drill_synth.h"
#include "audio/voice/derive.h"
#include "audio/voice/hand_sounds.h"
#include "audio/voice/mapping.h"
#include "audio/voice/rotor_lines.h"
#include "audio/voice/sine.h"
#include "audio/voice/stream.h"
#include "engine/base/units.h"

#ifdef __SSE2__
#include <immintrin.h>
#endif

namespace typodont::audio {

namespace {

// Parameters of the synthesizer. Sources: audio/README.md.
constexpr double kFastestSpeed = 2;  // highest spindle speed, relative to the free speed
constexpr double kAttack = 0.5e-3;   // s, time constant with which all levels change, except those of water and suction
// Time from rest to free speed after a jump of the wanted speed, s; measured.
constexpr double kRunUp = 0.4;
// Time constant of the run-down from free speed, s; measured.
constexpr double kRunDown = 1.25;
// A change of the speed per tick above this fraction of the free speed means "switched on or off", not "loaded".
constexpr double kJump = 0.5;
// Speed below which the drill is silent, relative to the free speed.
constexpr double kAtRest = 0.03;
constexpr float kTouchStrength = 0.02f;  // added to the knock's amplitude when a contact begins; full scale is 1
constexpr float kTapPerNewton = 0.25f;
// If the force rises more slowly than this, no knock is heard, N/s.
constexpr double kSlowRise = 20;
constexpr float kScrapeLevel = 0.12f;  // amplitude of scraping at 1 N and 20 mm/s
constexpr float kScrapeRings = 0.06f;  // strength with which scraping excites the modes of the tissue
// Standard deviation of suction, 4 dB below the idling turbine. Suction has 63 to 75 dB(A) alone, 67 to 80 with a
// handpiece (Dutta et al., J Conserv Dent 16 (2013) 121-125).
constexpr float kSuctionLevel = 0.031f;
// The levels of water and suction change at this fraction of the rate of all other levels.
constexpr float kWaterRate = 0.02f;
// At low speed, each cutting edge makes a decaying burst; the mean power of the bursts is that of the steady sound.
// Bursts are separate up to kApart edges per second, and fused to a steady sound from kFused on.
constexpr double kApart = 60, kFused = 200;
// Until the next cutting edge passes, the amplitude of a burst decays by the factor exp(-kDying).
constexpr double kDying = 6;
constexpr int kChunk = 64;

/// While an object exists, the CPU flushes denormal numbers to zero. So the computing time is constant, and the result
/// does not depend on the caller's setting.
class FlushDenormals {
 public:
#ifdef __SSE2__
  FlushDenormals() noexcept : before_(_mm_getcsr()) {
    _mm_setcsr(before_ | 0x8040u);
  }
  ~FlushDenormals() {
    _mm_setcsr(before_);
  }
#else
  FlushDenormals() noexcept = default;
#endif
  FlushDenormals(const FlushDenormals&) = delete;
  FlushDenormals& operator=(const FlushDenormals&) = delete;

 private:
#ifdef __SSE2__
  unsigned before_;
#endif
};

/// A level that approaches its target exponentially, and finally reaches it exactly.
struct Level {
  float value = 0, target = 0;
  float next(float rate) noexcept {
    const float away = target - value;
    value = std::abs(away) < 1e-5f ? target : value + rate * away;
    return value;
  }
  bool zero() const noexcept { return value == 0 && target == 0; }
};

/// Limiter: linear up to 0.7, then compressed to stay below full scale.
float limited(float x) noexcept {
  const float size = std::abs(x);
  if (size <= 0.7f) return x;
  return std::copysign(0.7f + 0.3f * std::tanh((size - 0.7f) / 0.3f), x);
}

float finite_or_zero(double v, double most) noexcept {
  return std::isfinite(v) ? static_cast<float>(std::clamp(v, 0.0, most)) : 0.0f;
}

/// Returns the mean power of the idling drill.
double idle_power(const SoundModels& models) {
  double power = power_of(models.idle);
  for (const RotorTone& tone : models.tones) power += tone.amplitude * tone.amplitude / 2;
  return power;
}

ArModel lowered(const ArModel& model, bool lower) {
  return lower ? truncated(model, std::max<std::size_t>(1, sufficient_order(model))) : model;
}

}  // namespace

struct DrillSynth::Impl {
  Impl(const SoundModels& models, double sample_rate, std::uint64_t seed, const SynthOptions& synth_options)
      : rate(sample_rate),
        options(synth_options),
        level(static_cast<float>(models.level)),
        working_gain(static_cast<float>(models.working_gain)),
        brightness_gain(static_cast<float>(models.brightness)),
        free_speed(models.free_speed),
        tones(models.tones),
        phases(models.tones.size(), 0.0),
        teeth(models.teeth),
        tooth_peak(std::sqrt(2 * kDying / (1 - std::exp(-2 * kDying)))),
        kernels(kFastestSpeed * fastest_step(models, sample_rate)),
        lines(sample_rate),
        modal(sample_rate),
        scrape(sample_rate, mixed(seed ^ 0x5c4a9e)),
        suction(sample_rate, mixed(seed ^ 0x50c710)),
        spray(sample_rate, mixed(seed ^ 0x59a7)),
        spray_gain(static_cast<float>(std::sqrt(idle_power(models) * (std::pow(10, models.spray_dB / 10) - 1)))),
        attack(static_cast<float>(1 - std::exp(-1 / (kAttack * sample_rate)))),
        bright_pole(static_cast<float>(1 - std::exp(-2 * kPi * kBrightFrom / sample_rate))),
        run_up(1 / (kRunUp * sample_rate)),
        run_down(1 - std::exp(-1 / (kRunDown * sample_rate))),
        pending(kPending) {
    const ArModel idle = lowered(models.idle, options.lower_order);
    const auto derived = derived_working_models(idle);
    streams.reserve(kTissueCount);
    streams.emplace_back(idle, rate, kernels, mixed(seed));
    for (std::size_t t = 1; t < derived.size(); ++t) {
      const auto& recorded = models.working[t];
      streams.emplace_back(recorded ? lowered(*recorded, options.lower_order) : derived[t], rate, kernels,
                           mixed(seed + t));
    }
    // Derived cutting sounds use the spectral lines of the idle sound with other amplitudes; recorded cutting sounds
    // have spectral lines of their own.
    std::uint64_t line_seed = mixed(seed ^ 0x11e5);
    for (std::size_t i = 0; i < idle.lines.size(); ++i) {
      RotorLines::Factors factors{1};
      for (std::size_t t = 1; t < derived.size(); ++t) {
        if (!models.working[t])
          factors[t] = static_cast<float>(derived[t].lines[i].amplitude / idle.lines[i].amplitude);
      }
      lines.add(idle.lines[i], idle.rate, factors, ++line_seed);
    }
    for (std::size_t t = 1; t < derived.size(); ++t) {
      if (!models.working[t]) continue;
      RotorLines::Factors factors{};
      factors[t] = 1;
      for (const ModelLine& line : models.working[t]->lines)
        lines.add(line, models.working[t]->rate, factors, ++line_seed);
    }
  }

  static double fastest_step(const SoundModels& models, double sample_rate) {
    double fastest = models.idle.rate;
    for (const auto& model : models.working) fastest = std::max(fastest, model ? model->rate : 0.0);
    return fastest / sample_rate;
  }

  /// Sample index (with fraction) of a time; exact for months.
  double index_of(Nanos t) const noexcept {
    const Nanos seconds = t / kNanosPerSecond;
    return static_cast<double>(seconds) * rate + static_cast<double>(t - seconds * kNanosPerSecond) * 1e-9 * rate;
  }

  void take(const SoundState& state) noexcept {
    const double spindle = std::isfinite(state.spindle) ? std::abs(state.spindle) : 0.0;
    if (!reference_given && spindle > free_speed) free_speed = spindle;
    double ratio = free_speed > 0 ? std::min(spindle / free_speed, kFastestSpeed) : 0.0;
    if (std::abs(ratio - 1) < 1e-6) ratio = 1;
    if (ratio < kAtRest) ratio = 0;
    const double interval = std::clamp(index_now - last_state, 1.0, 0.005 * rate);
    if (!heard_any) {
      speed = ratio;
      speed_step = 0;
      ramp_left = 0;
    } else if (gliding || std::abs(ratio - speed_target) > kJump) {
      gliding = true;
    } else {
      ramp_left = static_cast<int>(interval);
      speed_step = (ratio - speed) / ramp_left;
    }
    speed_target = ratio;

    const double area = finite_or_zero(state.contact_area, 1), force = finite_or_zero(state.force, 1000);
    const double removal = finite_or_zero(state.removal_rate, 1);
    const bool contact = area > 0 || removal > 0 || force > 0.02;
    const bool by_hand = !state.cutting_tool || ratio == 0;
    const bool named = state.tissue != Tissue::kAir && static_cast<std::size_t>(state.tissue) < kTissueCount;
    const Tissue tissue = named ? state.tissue : Tissue::kDentin;  // if the state names no tissue, dentin is used
    const auto touched = static_cast<std::size_t>(tissue);

    // Cross-fades from idle to cutting sound with constant total power.
    const bool cutting = contact && !by_hand;
    const double load = cutting ? load_of(area, force, removal) : 0.0;
    const auto loudness = static_cast<float>(std::sin(0.5 * kPi * load) * loudness_of(area));
    for (std::size_t t = 1; t < weights.size(); ++t) {
      weights[t].target = t == touched ? working_gain * loudness : 0.0f;
    }
    weights[0].target = state.cutting_tool ? static_cast<float>(std::cos(0.5 * kPi * load)) : 0.0f;
    bright.target = cutting ? brightness_gain * static_cast<float>(brightness_of(force, removal)) : 0.0f;

    // Hand instruments knock when the force rises fast, and scrape when they slide.
    if (by_hand && contact) {
      const double slow = kSlowRise * std::max(0.0, index_now - last_state) / rate;
      const double rise = std::max(0.0, force - (in_contact ? last_force + slow : 0.0));
      const float strength = kTapPerNewton * static_cast<float>(rise) + (in_contact ? 0.0f : kTouchStrength);
      if (strength > 1e-4f) modal.strike(tissue, std::min(strength, 1.0f));
      last_tissue = tissue;
    }
    const float slide = finite_or_zero(state.slip_speed, 1);
    const bool scraping = by_hand && contact && slide > 1e-4f;
    if (scraping) slip = slide;
    scrape_level.target =
        scraping ? kScrapeLevel * std::sqrt(static_cast<float>(force)) * std::min(1.0f, slide / 0.02f) : 0.0f;
    suction_level.target = kSuctionLevel * finite_or_zero(state.suction, 1);
    spray_level.target = spray_gain * finite_or_zero(state.spray, 1);
    in_contact = contact;
    last_force = force;
    if (!heard_any) {  // the first state takes effect at once, without a fade
      for (Level& weight : weights) weight.value = weight.target;
      bright.value = bright.target;
      suction_level.value = suction_level.target;
      spray_level.value = spray_level.target;
    }
    heard_any = true;
    last_state = index_now;
  }

  /// Renders at most kChunk samples, during which the drill gets no new state.
  void chunk(float* out, int count) noexcept {
    double speeds[kChunk];
    float gains[kTissueCount][kChunk], brightness[kChunk], rotor[kChunk];
    float working[kChunk] = {};
    std::fill(out, out + count, 0.0f);

    // Computes the speed of each sample, and whether the drill is audible.
    bool turning = false;
    for (int i = 0; i < count; ++i) {
      if (gliding) {
        const double away = speed_target - speed;
        speed += away > 0 ? std::min(away, run_up) : away * run_down;
        if (std::abs(speed_target - speed) < 0.002 || (speed_target == 0 && speed < kAtRest)) {
          speed = speed_target;
          gliding = false;
          ramp_left = 0;
        }
      } else if (ramp_left > 0) {
        speed = --ramp_left == 0 ? speed_target : speed + speed_step;
      }
      speeds[i] = speed;
      turning = turning || speed > 0;
    }

    bool active[kTissueCount];
    for (std::size_t t = 0; t < weights.size(); ++t) active[t] = turning && !weights[t].zero();
    // Levels change per sample, because the length of chunks depends on the caller's buffers.
    const auto level_at = [&](Level& x, int i) noexcept {
      if (speeds[i] == 0) x.value = x.target;
      return speeds[i] == 0 ? 0.0f : x.next(attack);
    };
    if (!turning) {
      for (Level& weight : weights) weight.value = weight.target;
      bright.value = bright.target;
      low = 0;
    } else {
      for (int i = 0; i < count; ++i) {
        const auto s = static_cast<float>(speeds[i]);
        // speed^kIdleExponent = speed^3.75 (audio/README.md).
        rotor[i] = s * s * s * std::sqrt(s * std::sqrt(s));
        brightness[i] = level_at(bright, i);
      }
      for (std::size_t t = 0; t < weights.size(); ++t) {
        if (!active[t]) continue;
        // The idle amplitude is proportional to speed^3.75 (air, bearings), the cutting amplitude to the speed.
        for (int i = 0; i < count; ++i) {
          gains[t][i] = level_at(weights[t], i) * (t == 0 ? rotor[i] : static_cast<float>(speeds[i]));
        }
        streams[t].add(speeds, gains[t], t == 0 ? out : working, count);
      }
      if (teeth > 0) strike(speeds, working, count);
      // Spectral lines come from the motor, so they continue between bursts.
      if (!lines.empty()) lines.add(speeds, gains, active, working, count);
      for (int i = 0; i < count; ++i) {
        low = speeds[i] == 0 ? 0.0f : low + bright_pole * (working[i] - low);
        out[i] += working[i] + brightness[i] * (working[i] - low);
      }
      for (std::size_t k = 0; k < tones.size(); ++k) {
        // Cycles of the tone per sample at free speed.
        const double turns = free_speed / (2 * kPi) * tones[k].multiple / rate;
        const auto amplitude = static_cast<float>(tones[k].amplitude);
        for (int i = 0; i < count; ++i) {
          phases[k] += turns * speeds[i];
          if (phases[k] >= 1) phases[k] -= std::floor(phases[k]);
          if (turns * speeds[i] < 0.45) out[i] += amplitude * static_cast<float>(speeds[i]) * sine_of_turns(phases[k]);
        }
      }
    }

    // Adds the sound of hand instruments, if one is audible.
    if (!scrape_level.zero() || !modal.silent()) {
      for (int i = 0; i < count; ++i) {
        if (!scrape_level.zero()) {
          const float rubbed = scrape.next(slip, scrape_level.next(attack), last_tissue);
          modal.strike(last_tissue, kScrapeRings * rubbed);
          out[i] += rubbed;
        }
        out[i] += modal.next();
      }
    }
    if (!suction_level.zero()) {
      for (int i = 0; i < count && !suction_level.zero(); ++i) {
        out[i] += suction.next(suction_level.next(kWaterRate * attack));
      }
    }
    for (int i = 0; i < count && !spray_level.zero(); ++i) out[i] += spray.next(spray_level.next(kWaterRate * attack));
    for (int i = 0; i < count; ++i) out[i] = limited(level * out[i]);
  }

  /// Divides the cutting sound into one burst per cutting edge, if the edges are heard separately.
  void strike(const double* speeds, float* working, int count) noexcept {
    for (int i = 0; i < count; ++i) {
      const double frequency = teeth * free_speed / (2 * kPi) * speeds[i];
      tooth_phase += frequency / rate;
      tooth_phase -= std::floor(tooth_phase);
      const double apart = std::clamp((kFused - frequency) / (kFused - kApart), 0.0, 1.0);
      if (apart == 0) continue;
      const double burst = tooth_peak * std::exp(-kDying * tooth_phase);
      working[i] *= static_cast<float>(1 + apart * (burst - 1));
    }
  }

  void render(std::span<float> mono, double first) noexcept {
    const FlushDenormals flush;
    std::size_t done = 0;
    while (done < mono.size()) {
      index_now = first + static_cast<double>(done);
      // Applies the states whose time is this sample or earlier.
      while (count_pending > 0) {
        const double away = index_of(pending[head].t) - index_now;
        if (away >= 0.5) break;
        if (away < -0.5) ++late;
        take(pending[head]);
        head = (head + 1) % kPending;
        --count_pending;
      }
      if (options.hold > 0 && heard_any && index_now - last_state > options.hold * rate &&
          speed_target + in_contact > 0) {
        gliding = true;
        take(SoundState{});
      }
      std::size_t next = std::min(mono.size() - done, static_cast<std::size_t>(kChunk));
      if (count_pending > 0) {
        const double away = index_of(pending[head].t) - index_now;
        next = std::min(next, static_cast<std::size_t>(std::max(1.0, std::floor(away + 0.5))));
      }
      chunk(mono.data() + done, static_cast<int>(next));
      done += next;
    }
    index_next = first + static_cast<double>(mono.size());
  }

  double rate;
  SynthOptions options;
  float level, working_gain, brightness_gain;
  double free_speed;
  bool reference_given = free_speed > 0;
  std::vector<RotorTone> tones;
  std::vector<double> phases;  // phase of each rotor tone; 1 is a full cycle
  const double teeth, tooth_peak;
  double tooth_phase = 0;  // position between two cutting edges, 0..1
  InterpolationKernels kernels;
  // The idle sound, then the cutting sound of each tissue.
  std::vector<ModelStream> streams;
  RotorLines lines;
  ModalBank modal;
  Scrape scrape;
  Suction suction;
  Spray spray;
  const float spray_gain;  // standard deviation of the spray's sound at full flow
  const float attack, bright_pole;
  const double run_up, run_down;

  std::vector<SoundState> pending;  // ring buffer of states whose time has not come yet
  std::size_t head = 0, count_pending = 0;
  std::uint64_t late = 0, dropped = 0;

  // Sample indices since the start: now, begin of the next call, last state.
  double index_now = 0, index_next = 0, last_state = 0;
  bool heard_any = false, gliding = false, in_contact = false;
  // Spindle speed relative to the free speed: current value, value at the end of the ramp, change per sample.
  double speed = 0, speed_target = 0, speed_step = 0;
  int ramp_left = 0;
  // Level of each sound in `streams`.
  std::array<Level, kTissueCount> weights;
  Level bright, scrape_level, suction_level, spray_level;
  float slip = 0, low = 0;
  double last_force = 0;
  Tissue last_tissue = Tissue::kEnamel;
};

DrillSynth::DrillSynth(const SoundModels& models, double sample_rate, std::uint64_t seed, const SynthOptions& options)
    : impl_(std::make_unique<Impl>(models, sample_rate, seed, options)) {}
DrillSynth::~DrillSynth() = default;
DrillSynth::DrillSynth(DrillSynth&&) noexcept = default;
DrillSynth& DrillSynth::operator=(DrillSynth&&) noexcept = default;

void DrillSynth::push(const SoundState& state) noexcept {
  Impl& impl = *impl_;
  if (impl.count_pending == kPending) {
    ++impl.dropped;
    return;
  }
  impl.pending[(impl.head + impl.count_pending) % kPending] = state;
  ++impl.count_pending;
}

void DrillSynth::render(std::span<float> mono) noexcept {
  impl_->render(mono, impl_->index_next);
}
void DrillSynth::render(std::span<float> mono, Nanos t_first) noexcept {
  impl_->render(mono, impl_->index_of(t_first));
}
double DrillSynth::sample_rate() const noexcept {
  return impl_->rate;
}
std::uint64_t DrillSynth::late() const noexcept {
  return impl_->late;
}
std::uint64_t DrillSynth::dropped() const noexcept {
  return impl_->dropped;
}

}  // namespace typodont::audio
