// Interface of a sound library: PortAudio in the program, a simulated card in tests.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "engine/base/clock.h"

namespace typodont::audio {

struct StreamRequest {
  std::string device;      // name of the device, or a part of it; empty: the default device
  double sample_rate = 0;  // Hz, sampling rate; 0: the device's own rate
  int buffer = 256;
  int channels = 1;  // wanted number of channels; the stream may have 1 or 2
  /// Called by the audio thread to fill frames × channels samples. Returning false ends the stream.
  bool (*callback)(void* self, float* out, int frames, int channels, Nanos t, bool underrun) noexcept = nullptr;
  void* self = nullptr;
};

struct StreamOpened {
  std::string name;
  double sample_rate = 0;
  double device_latency = 0;  // s, additional latency as reported by the device
};

class StreamBackend {
 public:
  virtual ~StreamBackend() = default;
  /// Opens a stream. Throws Error for an unknown name, RunFailure if the device can't be opened.
  virtual StreamOpened open(const StreamRequest& request) = 0;
  virtual void start() = 0;
  /// Returns false if the device is gone or the stream has stopped.
  virtual bool alive() noexcept = 0;
  /// Closes the stream; no callback comes after it. May take minutes if the sound server has crashed.
  virtual void close() noexcept = 0;
};

std::unique_ptr<StreamBackend> make_portaudio_backend();

}  // namespace typodont::audio
