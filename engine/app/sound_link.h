// From ticks to sound: the synthesizer of a scene and where its samples go. Application thread.
#pragma once

#include <filesystem>
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
  /// Application thread, at least ten times a second.
  void advance(Nanos t);
  /// The end; a file is complete only after this. Throws Error where it cannot be written.
  void stop(Nanos t);
  audio::AudioStats stats() const { return output_->stats(); }
  /// The voice's file and its hash, and the sample rate: for a recording.
  std::string about() const;

 private:
  static void render(void* self, std::span<float> mono, Nanos t_first) noexcept;

  void make_synth(double sample_rate);

  audio::SynthOptions options_;
  std::unique_ptr<audio::AudioOutput> output_;
  std::filesystem::path voice_file_;
  audio::SoundModels models_;
  audio::TickVoice voice_;  // audio thread
  std::unique_ptr<audio::DrillSynth> synth_;
  Ring<ServoTick> ticks_{1 << 14};
};

}  // namespace typodont
