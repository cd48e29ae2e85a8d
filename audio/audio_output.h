// Outputs for sound, by address: "portaudio:[DEVICE]", "wav:FILE", "none:".
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "engine/base/clock.h"

namespace typodont::audio {

/// Source of the samples. The audio thread calls `render`, which fills `samples` (interleaved if stereo) and never
/// blocks or allocates. `t_first`: time of the first sample. This time is so far in the past that all servo ticks up to
/// the last sample have arrived.
struct AudioSource {
  void* self = nullptr;
  void (*render)(void* self, std::span<float> samples, Nanos t_first) noexcept = nullptr;
  /// Called if the device returns with another sampling rate, by the thread of advance() and never during `render`. May
  /// allocate.
  void (*rate_changed)(void* self, double sample_rate) = nullptr;
};

struct AudioOptions {
  double sample_rate = 0;  // Hz; 0: the device's own rate, 48000 for files
  int channels = 1;        // number of channels of the source, 1 or 2
  // Samples per channel and callback; also the latency that is requested from the device.
  int buffer = 256;
  std::uint64_t end_after = 0;  // number of samples after which a device's output ends; 0: never
};

struct AudioStats {
  std::uint64_t samples = 0;     // number of rendered samples of each channel so far
  std::uint64_t underruns = 0;   // number of underruns reported by the device
  std::uint64_t losses = 0;      // number of times that the device was lost
  std::uint64_t recoveries = 0;  // number of times that the device was opened again
  std::uint64_t clipped = 0;     // number of samples that were limited to full scale
  double sample_rate = 0;
  /// Latency from a servo tick to the output of its sample, without the device's latency, s.
  double latency = 0;
  double device_latency = 0;  // s, latency that the device reports; 0 for files
};

/// Owned and called by the application thread.
class AudioOutput {
 public:
  virtual ~AudioOutput() = default;

  /// Opens an output. Throws Error for an unknown address, RunFailure if the device can't be opened.
  static std::unique_ptr<AudioOutput> open(const std::string& address, const AudioOptions& options = {});

  virtual double sample_rate() const = 0;
  /// Starts the output. In a file, the first sample belongs to the tick time `t_start`; a device plays it now.
  virtual void start(const AudioSource& source, Nanos t_start) = 0;
  /// Call at least ten times per second. A file is rendered up to time `t`; a device is checked, and opened again if it
  /// was lost.
  virtual void advance(Nanos t) = 0;
  /// Ends the output. Until then, a file has a temporary name. Throws Error.
  virtual void stop() = 0;
  virtual AudioStats stats() const = 0;
  /// Description for messages, for example "portaudio:HDA Intel (48000 Hz, 256 samples)".
  virtual std::string description() const = 0;
};

/// A sound device, for the address "portaudio:NAME". Without PortAudio in the program, there are no such devices.
struct AudioDevice {
  std::string name, host;
  double sample_rate = 0;
  int channels = 0;
  double latency = 0;  // s, smallest delay that the device states
  bool is_default = false;
};
std::vector<AudioDevice> audio_devices();

}  // namespace typodont::audio
