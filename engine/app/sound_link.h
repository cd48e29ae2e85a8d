// Converts ticks to sound: contains a scene's synthesizer and the output for its samples. Application thread.
#pragma once

#include <atomic>
#include <filesystem>
#include <limits>
#include <memory>
#include <string>

#include "audio/audio_output.h"
#include "audio/drill_synth.h"
#include "audio/tick_voice.h"
#include "engine/app/scene.h"
#include "engine/base/ring.h"
#include "engine/contract/contact.h"

namespace typodont {

class SoundLink {
 public:
  /// `address`: see docs/interface.md. The voice is the one in assets/sounds/ with the name of the scene's motor; for
  /// an ideal motor the speed selects the voice. `live`: the sound stops if ticks stop. Throws Error or RunFailure.
  SoundLink(const std::string& address, const Scene& scene, bool live);
  ~SoundLink();
  SoundLink(const SoundLink&) = delete;
  SoundLink& operator=(const SoundLink&) = delete;

  /// Servo thread (or the only thread of a deterministic run). Wait-free.
  void push(const ServoTick& tick) noexcept;
  /// Application thread: call at least ten times per second once the session's clock runs. `t`: present time on that
  /// clock; for a file, the time of the latest pushed tick. The sound begins with the first call, so that a tick at t
  /// is heard in the sample at t. A file contains the session from its beginning.
  void advance(Nanos t);
  /// Ends the sound; a file is complete only after this. Throws Error if it cannot be written.
  void stop(Nanos t);
  /// Sets the flow of the suction that is heard from the next block on, m³/s; 0: off. Any thread.
  void suck(double flow) noexcept { suction_flow_.store(flow, std::memory_order_relaxed); }
  bool live() const { return live_; }
  /// Latest measured latency in s from a tick to its sound, including the latency that the device reports. NaN before
  /// the first sound and for files. Any thread.
  double latency() const noexcept { return latency_.load(std::memory_order_relaxed); }
  audio::AudioStats stats() const { return output_->stats(); }
  /// Number of ticks that were lost because the device did not play for a long time. Any thread.
  std::uint64_t unheard() const noexcept { return ticks_.dropped(); }
  /// The voice's file, its hash and the sample rate, for a recording.
  std::string about() const;

 private:
  static void render(void* self, std::span<float> mono, Nanos t_first) noexcept;

  void make_synth(double sample_rate);

  const bool live_;
  bool begun_ = false;
  Nanos zero_ = 0;             // ns on the machine's clock at which the session's time is zero; only for live sound
  double device_latency_ = 0;  // s, latency that the device reports
  std::atomic<double> latency_{std::numeric_limits<double>::quiet_NaN()};
  std::atomic<double> suction_flow_{0};  // m³/s
  audio::SynthOptions options_;
  std::unique_ptr<audio::AudioOutput> output_;
  std::filesystem::path voice_file_;
  audio::SoundModels models_;
  audio::TickVoice voice_;  // the ticks' voice; used only by the audio thread
  std::unique_ptr<audio::DrillSynth> synth_;
  Ring<ServoTick> ticks_{1 << 14};
};

}  // namespace typodont
