// Sound outputs by address: a sound card ("portaudio:[DEVICE]"), a WAV file ("wav:FILE"), or none ("none:").
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "engine/base/clock.h"

namespace typodont::audio {

/// The source of an output's samples. `render` runs on the audio thread; it neither blocks nor allocates. It reads the
/// ticks that have arrived, then fills `samples`; with two channels, left and right samples alternate. `t_first` is the
/// tick time for which the first sample is computed. It lies one buffer length and a margin in the past, so all ticks
/// for this buffer have already arrived.
struct AudioSource {
  void* self = nullptr;
  void (*render)(void* self, std::span<float> samples, Nanos t_first) noexcept = nullptr;
  /// Called if the device was opened again at another rate. Runs on the thread of advance() while `render` is not
  /// running. May allocate.
  void (*rate_changed)(void* self, double sample_rate) = nullptr;
};

struct AudioOptions {
  double sample_rate = 0;  // Hz, sampling rate; 0: the device's own rate, 48000 for files
  int channels = 1;        // number of channels of the source, 1 or 2
  // samples per channel that one callback fills; the device is asked for a latency of the same length
  int buffer = 256;
  std::uint64_t end_after = 0;  // a device's stream ends after this number of samples; 0: it does not end
};

struct AudioStats {
  std::uint64_t samples = 0;     // number of rendered samples of each channel so far
  std::uint64_t underruns = 0;   // number of underruns reported by the device
  std::uint64_t losses = 0;      // number of times that the device was lost
  std::uint64_t recoveries = 0;  // number of times that the device was opened again
  std::uint64_t clipped = 0;     // number of samples that were limited to full scale
  double sample_rate = 0;
  /// s, time from a servo tick until its sound leaves the program; the device's own latency is not included
  double latency = 0;
  double device_latency = 0;  // s, additional latency as reported by the device; 0 for files
};

/// The application thread owns the object and calls start, advance and stop.
class AudioOutput {
 public:
  virtual ~AudioOutput() = default;

  /// Opens the output. Not for real time. Throws Error for an unknown address, RunFailure if the device refuses.
  static std::unique_ptr<AudioOutput> open(const std::string& address, const AudioOptions& options = {});

  virtual double sample_rate() const = 0;
  /// Starts the output. Its first sample has the tick time `t_start` (files) or the current time (devices).
  virtual void start(const AudioSource& source, Nanos t_start) = 0;
  /// Files: renders up to tick time `t`. Devices: checks whether the device still works, reports a lost device, and
  /// opens it again. Call it at least ten times a second.
  virtual void advance(Nanos t) = 0;
  /// Ends the output. A file gets its final name only now, when it is complete. Throws Error if the file cannot be
  /// written.
  virtual void stop() = 0;
  virtual AudioStats stats() const = 0;
  /// Describes the output for the user, for example "wav:drill.wav" or "portaudio:HDA Intel (48000 Hz, 256 samples)".
  virtual std::string description() const = 0;
};

/// A sound output that the user can select with the address "portaudio:NAME". A program that was built without
/// PortAudio finds no such outputs.
struct AudioDevice {
  std::string name, host;
  double sample_rate = 0;
  int channels = 0;
  bool is_default = false;
};
std::vector<AudioDevice> audio_devices();

}  // namespace typodont::audio
