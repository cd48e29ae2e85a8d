// From ticks to sound: the synthesizer of a scene and where its samples go. Application thread.
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
  /// `address` as INTERFACE.md has it. The voice is the one named like the scene's motor in assets/sounds/; of an ideal
  /// motor by its speed. `live`: ticks that stop coming end the sound. Throws Error or RunFailure.
  SoundLink(const std::string& address, const Scene& scene, bool live);
  ~SoundLink();
  SoundLink(const SoundLink&) = delete;
  SoundLink& operator=(const SoundLink&) = delete;

  /// Servo thread (or the one thread of a deterministic run): wait-free.
  void push(const ServoTick& tick) noexcept;
  /// Application thread, at least ten times a second, once the session's clock runs. `t` on it: now; of a file the time
  /// of the newest tick that was pushed. The sound begins with the first call, so that a tick at t is heard in the
  /// sample at t; a file holds the session from its beginning.
  void advance(Nanos t);
  /// The end; a file is complete only after this. Throws Error where it cannot be written.
  void stop(Nanos t);
  bool live() const { return live_; }
  /// s from a tick to its sound, as the ticks' arrival shows it, with what the device says it adds; the newest. NaN
  /// where nothing was heard yet, and for files. Any thread.
  double latency() const noexcept { return latency_.load(std::memory_order_relaxed); }
  audio::AudioStats stats() const { return output_->stats(); }
  /// Ticks that found no room on their way, where the device was away for long. Any thread.
  std::uint64_t unheard() const noexcept { return ticks_.dropped(); }
  /// The voice's file and its hash, and the sample rate: for a recording.
  std::string about() const;

 private:
  static void render(void* self, std::span<float> mono, Nanos t_first) noexcept;

  void make_synth(double sample_rate);

  const bool live_;
  bool begun_ = false;
  Nanos zero_ = 0;             // the clock's time at the session's zero, where live
  double device_latency_ = 0;  // s
  std::atomic<double> latency_{std::numeric_limits<double>::quiet_NaN()};
  audio::SynthOptions options_;
  std::unique_ptr<audio::AudioOutput> output_;
  std::filesystem::path voice_file_;
  audio::SoundModels models_;
  audio::TickVoice voice_;  // audio thread
  std::unique_ptr<audio::DrillSynth> synth_;
  Ring<ServoTick> ticks_{1 << 14};
};

}  // namespace typodont
