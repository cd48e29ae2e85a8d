// Sound outputs by address: "portaudio:[DEVICE]", "wav:FILE", "none:".
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "engine/base/clock.h"

namespace typodont::audio {

/// Audio thread; `render` never blocks or allocates. It reads the ticks, then fills `samples` (interleaved if stereo).
/// `t_first` lies a buffer and a margin in the past, so all its ticks have arrived.
struct AudioSource {
  void* self = nullptr;
  void (*render)(void* self, std::span<float> samples, Nanos t_first) noexcept = nullptr;
  /// The device came back with another rate. Thread of advance(), not during `render`. May allocate.
  void (*rate_changed)(void* self, double sample_rate) = nullptr;
};

struct AudioOptions {
  double sample_rate = 0;  // Hz; 0: the device's own, 48000 for files
  int channels = 1;        // number of channels of the source, 1 or 2
  // samples per channel and callback, also the latency asked of the device
  int buffer = 256;
  std::uint64_t end_after = 0;  // a device's stream ends after as many samples; 0: never
};

struct AudioStats {
  std::uint64_t samples = 0;     // number of rendered samples of each channel so far
  std::uint64_t underruns = 0;   // number of underruns reported by the device
  std::uint64_t losses = 0;      // number of times that the device was lost
  std::uint64_t recoveries = 0;  // number of times that the device was opened again
  std::uint64_t clipped = 0;     // number of samples that were limited to full scale
  double sample_rate = 0;
  /// s, from tick to output, without the device
  double latency = 0;
  double device_latency = 0;  // s, as the device reports; 0 for files
};

/// Owned and called by the application thread.
class AudioOutput {
 public:
  virtual ~AudioOutput() = default;

  /// Throws Error for an unknown address, RunFailure if the device refuses.
  static std::unique_ptr<AudioOutput> open(const std::string& address, const AudioOptions& options = {});

  virtual double sample_rate() const = 0;
  /// First sample at tick time `t_start` (files) or now (devices).
  virtual void start(const AudioSource& source, Nanos t_start) = 0;
  /// Files render up to `t`; devices are checked, and opened again. Ten times a second or more.
  virtual void advance(Nanos t) = 0;
  /// A file gets its name only now. Throws Error.
  virtual void stop() = 0;
  virtual AudioStats stats() const = 0;
  /// For example "portaudio:HDA Intel (48000 Hz, 256 samples)".
  virtual std::string description() const = 0;
};

/// Address "portaudio:NAME". None without PortAudio.
struct AudioDevice {
  std::string name, host;
  double sample_rate = 0;
  int channels = 0;
  bool is_default = false;
};
std::vector<AudioDevice> audio_devices();

}  // namespace typodont::audio
