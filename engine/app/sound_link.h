// From ticks to sound: the synthesizer of a scene and where its samples go. Application thread.
#pragma once

#include <memory>
#include <string>

#include "audio/audio_output.h"
#include "audio/drill_synth.h"
#include "engine/app/scene.h"
#include "engine/base/ring.h"
#include "engine/contract/contact.h"

namespace typodont {

/// What the ear needs of a tick. `previous`: the tick before it, of the same session.
audio::SoundState sound_state(const ServoTick& tick, const ServoTick& previous, bool cutting_tool) noexcept;

class SoundLink {
 public:
  /// `address` as INTERFACE.md has it. The voice is the one named like the scene's motor in assets/sounds/, or
  /// "handpiece". Throws Error or RunFailure.
  SoundLink(const std::string& address, const Scene& scene);
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

 private:
  static void render(void* self, std::span<float> mono, Nanos t_first) noexcept;

  bool cutting_tool_;
  std::unique_ptr<audio::AudioOutput> output_;
  audio::SoundModels models_;
  std::unique_ptr<audio::DrillSynth> synth_;
  Ring<audio::SoundState> states_{65536};
  ServoTick previous_;
};

}  // namespace typodont
