// Converts ticks to sound. Contains a scene's synthesizer and the output for its samples. Application thread.
#pragma once

#include <array>
#include <atomic>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>

#include "audio/audio_output.h"
#include "audio/binaural.h"
#include "audio/drill_synth.h"
#include "audio/tick_voice.h"
#include "engine/app/scene.h"
#include "engine/base/latest.h"
#include "engine/base/ring.h"
#include "engine/contract/contact.h"

namespace typodont {

class SoundLink {
 public:
  /// Opens the sound. `address`: see docs/interface.md. The voice is the file in assets/sounds/ with the name of the
  /// scene's motor; for an ideal motor the speed selects the voice. `live`: the sound stops if ticks stop. `binaural`:
  /// two channels for the listener's ears, from where the tool is; listen() gives the pose of the listener's head.
  /// Throws Error or RunFailure.
  SoundLink(const std::string& address, const Scene& scene, bool live, bool binaural = false);
  ~SoundLink();
  SoundLink(const SoundLink&) = delete;
  SoundLink& operator=(const SoundLink&) = delete;

  /// Passes a tick to the sound. Servo thread (or the only thread of a deterministic run). Wait-free.
  void push(const ServoTick& tick) noexcept;
  /// Passes the pose of the listener's head: the midpoint of the eyes in m, and the unit vector from the left to the
  /// right eye. Called by the thread that knows the pose. Wait-free. Only for binaural sound; without a call the source
  /// is straight ahead.
  void listen(const dvec3& eyes_W, const dvec3& right_W) noexcept;
  bool binaural() const { return ears_.has_value(); }
  /// Passes whether the handpiece's water is switched on (it flows only while the pedal is pressed), and the flow of
  /// the suction in m³/s (0: off). They are heard from the next block on. Any thread.
  void water(bool spray, double suction_flow) noexcept;
  /// Advances the sound to time t. Application thread; call at least ten times per second once the session's clock
  /// runs. `t`: present time on that clock; for a file, the time of the latest pushed tick. The sound begins with the
  /// first call, so that a tick at t is heard in the sample at t. A file contains the session from its beginning.
  void advance(Nanos t);
  /// Ends the sound; a file is complete only after this call. Throws Error if the file cannot be written.
  void stop(Nanos t);
  bool live() const { return live_; }
  /// Latest measured latency from a tick to its sound, s; it includes the latency that the device reports. NaN before
  /// the first sound, and for files. Any thread.
  double latency() const noexcept { return latency_.load(std::memory_order_relaxed); }
  audio::AudioStats stats() const { return output_->stats(); }
  /// Number of ticks that were lost because the device did not play for a long time. Any thread.
  std::uint64_t unheard() const noexcept { return ticks_.dropped(); }
  /// The voice's file, its hash and the sample rate, for a recording.
  std::string about() const;

 private:
  struct Listener {
    dvec3 eyes_W{0}, right_W{1, 0, 0};
  };
  static void render(void* self, std::span<float> samples, Nanos t_first) noexcept;

  void make_synth(double sample_rate);

  const bool live_;
  bool begun_ = false;
  Nanos zero_ = 0;             // ns, time of the session's zero on the machine's clock; only for live sound
  double device_latency_ = 0;  // s, latency that the device reports
  std::atomic<double> latency_{std::numeric_limits<double>::quiet_NaN()};
  audio::SynthOptions options_;
  std::unique_ptr<audio::AudioOutput> output_;
  std::filesystem::path voice_file_;
  audio::SoundModels models_;
  audio::TickVoice voice_;  // the voice that plays the ticks; used only by the audio thread
  std::unique_ptr<audio::DrillSynth> synth_;
  Ring<ServoTick> ticks_{1 << 14};
  std::atomic<double> spray_{0}, suction_{0};  // flows of spray and suction, 0..1, for audio::SoundState
  Latest<Listener> listener_;
  // The rest is used only by the audio thread, and only with binaural sound.
  std::optional<audio::Binaural> ears_;
  std::array<float, 1024> mono_{};
  dvec3 tool_W_{0};  // m, position of the tool's head in the latest tick
  bool listened_ = false, seen_tool_ = false;
};

}  // namespace typodont
