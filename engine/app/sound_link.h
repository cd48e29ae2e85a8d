// Converts the servo's ticks to sound: contains a scene's sound synthesizer and the output for its samples. Application
// thread only, unless a comment names another thread.
#pragma once

#include <array>
#include <atomic>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "audio/audio_output.h"
#include "audio/binaural.h"
#include "audio/drill_synth.h"
#include "audio/tick_voice.h"
#include "engine/app/event_logs.h"
#include "engine/app/scene.h"

namespace typodont {

/// Data on which the sound depends, besides the servo's ticks.
struct SoundVoice {
  std::string model;            // name of the synthesizer's model in assets/sounds/
  double free_speed = 0;        // rad/s, speed of the free-running spindle
  std::vector<bool> tools_cut;  // for each tool (index ServoTick::tool): true if it cuts
  bool lower_order = false;
};

/// The voice of a scene: the sound model of its motor, or, if there is none, a model chosen by the free speed.
SoundVoice voice_of(const Scene& scene);

class SoundLink {
 public:
  /// Opens the sound output `address`, for example "portaudio:" or "wav:FILE". Throws Error or RunFailure.
  ///   `event_logs`: source of the ticks, and of the pose of the listener's head.
  ///   `live`: the sound stops if no ticks arrive.
  ///   `binaural`: two channels for the listener's ears; the tool is the source. Until the head's pose is known, the
  /// tool is straight ahead.
  ///   `begin`: session time at which a sound file begins; earlier ticks are not heard.
  SoundLink(const std::string& address, const SoundVoice& voice, const EventLogs& event_logs, bool live,
            bool binaural = false, Nanos begin = 0);
  ~SoundLink();
  SoundLink(const SoundLink&) = delete;
  SoundLink& operator=(const SoundLink&) = delete;

  /// Sets the state of water and suction from the next audio block on. `spray`: the handpiece's water is on; it flows
  /// only while the pedal is pressed. `suction_flow`: m³/s; 0: off. Any thread.
  void water(bool spray, double suction_flow) noexcept;
  /// Computes the sound up to the time t. The first call starts the sound; after the session's clock has started, call
  /// it at least ten times per second. `t`: current time on this clock; for a sound file, time of the latest tick. A
  /// tick with time t is heard in the sample with the same time. A sound file contains the session from its beginning.
  void advance(Nanos t);
  /// Ends the sound. A sound file is complete only after this call. Throws Error if the file cannot be written.
  void stop(Nanos t);
  bool live() const { return live_; }
  /// The last measured latency from a tick to its sound, s, including the latency that the device states. NaN before
  /// the first sound, and for files. Any thread.
  double latency() const noexcept { return latency_.load(std::memory_order_relaxed); }
  audio::AudioStats stats() const { return output_->stats(); }
  /// The number of ticks that were lost because the sound device did not play for a long time. For any thread.
  std::uint64_t unheard() const noexcept { return unheard_.load(std::memory_order_relaxed); }
  /// The text for the recording: file name and hash of the synthesizer's model, and sample rate.
  std::string about() const;

 private:
  static void render(void* self, std::span<float> samples, Nanos t_first) noexcept;

  void make_synth(double sample_rate);

  const bool live_;
  const Nanos begin_;  // ns, session time at which a sound file begins
  bool begun_ = false;
  /// Time of the machine's clock at which the session's time is zero, ns; only for live sound.
  Nanos zero_ = 0;
  double device_latency_ = 0;  // s, latency that the sound device states
  std::atomic<double> latency_{std::numeric_limits<double>::quiet_NaN()};
  audio::SynthOptions options_;
  std::unique_ptr<audio::AudioOutput> output_;
  std::filesystem::path voice_file_;
  audio::SoundModels models_;
  audio::TickVoice voice_;  // converts ticks to samples; used only by the audio thread
  std::unique_ptr<audio::DrillSynth> synth_;
  EventLog<ServoEvent>::Reader servo_;  // used only by the audio thread
  EventLog<ViewEvent>::Reader view_;    // used only by the audio thread
  std::atomic<std::uint64_t> unheard_{0};
  std::atomic<double> spray_{0}, suction_{0};  // flows of spray and suction as fractions 0..1, for audio::SoundState
  // The audio thread alone uses the next members, and only for binaural sound.
  std::optional<audio::Binaural> ears_;
  std::array<float, 1024> mono_{};
  dvec3 tool_W_{0};  // m, position of the tool's head in the latest tick
  SeenFrom listener_;
  std::uint64_t next_tick_ = 0;  // 1 + index of the latest tick
  bool listened_ = false, seen_tool_ = false;
};

}  // namespace typodont
