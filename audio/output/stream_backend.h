// Interface to a sound card library: PortAudio in the program, a simulated card in the tests.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "engine/base/clock.h"

namespace typodont::audio {

struct StreamRequest {
  std::string device;      // device name or a part of it; empty: the default device
  double sample_rate = 0;  // Hz, sampling rate; 0: the device's own rate
  int buffer = 256;
  int channels = 1;  // wanted number of channels; if the device does not support it, the stream has one or two channels
  /// Called on the audio thread. Fills frames × channels samples. Returns false to end the stream.
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
  /// Opens a stream. Throws Error if no device has this name, RunFailure if the device refuses.
  virtual StreamOpened open(const StreamRequest& request) = 0;
  virtual void start() = 0;
  /// Returns false after the device has disappeared or the stream has stopped by itself.
  virtual bool alive() noexcept = 0;
  /// Closes the stream. Once this call has begun, the callback is not called again. The call may take minutes if the
  /// sound server died.
  virtual void close() noexcept = 0;
};

std::unique_ptr<StreamBackend> make_portaudio_backend();

}  // namespace typodont::audio
