// Where sound goes: a sound card, a WAV file, or nowhere, by address ("portaudio:[DEVICE]", "wav:FILE", "none:").
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "engine/base/clock.h"

namespace typodont::audio {

/// Who makes the samples. `render` runs on the audio thread and neither blocks nor allocates: it first takes the ticks
/// that have arrived, then fills `mono`, whose first sample stands for what happened at t_first (a tick at t is heard
/// in the sample at t; the output has already put one buffer and a margin between the two, so it has arrived).
struct AudioSource {
  void* self = nullptr;
  void (*render)(void* self, std::span<float> mono, Nanos t_first) noexcept = nullptr;
  /// The device came back at another rate: called while nothing renders, on the thread of advance(); may allocate.
  void (*rate_changed)(void* self, double sample_rate) = nullptr;
};

struct AudioOptions {
  double sample_rate = 0;       // Hz; 0: the device's own, 48000 for files
  int buffer = 256;             // samples a callback; also the latency asked of the device
  std::uint64_t end_after = 0;  // samples after which a device stream ends; 0: never
};

struct AudioStats {
  std::uint64_t samples = 0;     // rendered so far
  std::uint64_t underruns = 0;   // told by the device
  std::uint64_t losses = 0;      // times the device went away
  std::uint64_t recoveries = 0;  // times it was opened again
  std::uint64_t clipped = 0;     // samples limited to full scale
  double sample_rate = 0;
  double latency = 0;         // s from a tick to its sample leaving the program, the device's own latency not included
  double device_latency = 0;  // s that the device says it adds; 0 for files
};

/// Owned by the application thread; start, advance and stop are called there.
class AudioOutput {
 public:
  virtual ~AudioOutput() = default;

  /// Set-up: throws Error for an address that names nothing, RunFailure where the device refuses.
  static std::unique_ptr<AudioOutput> open(const std::string& address, const AudioOptions& options = {});

  virtual double sample_rate() const = 0;
  /// Sample 0 of the output stands for the tick time `t_start` (files) or now (devices: their clock is the host's).
  virtual void start(const AudioSource& source, Nanos t_start) = 0;
  /// Files: renders up to tick time `t`. Devices: looks after the stream; a lost device is said and opened again.
  /// Call it at least ten times a second; any number of times is right.
  virtual void advance(Nanos t) = 0;
  /// Ends the sound; a file is complete, under its name, only after this. Throws Error where it cannot be written.
  virtual void stop() = 0;
  virtual AudioStats stats() const = 0;
  /// "wav:drill.wav", "portaudio:HDA Intel (48000 Hz, 256 samples)": for people.
  virtual std::string description() const = 0;
};

/// Names of the sound card outputs, as "portaudio:NAME" takes them; empty where built without PortAudio.
struct AudioDevice {
  std::string name, host;
  double sample_rate = 0;
  int channels = 0;
  bool is_default = false;
};
std::vector<AudioDevice> audio_devices();

}  // namespace typodont::audio
