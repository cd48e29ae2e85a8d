// PortAudio in the program, a simulated card in tests.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "engine/base/clock.h"

namespace typodont::audio {

struct StreamRequest {
  std::string device;      // name or a part of it; empty: default
  double sample_rate = 0;  // Hz, sampling rate; 0: the device's own rate
  int buffer = 256;
  int channels = 1;  // wanted; the stream may have one or two
  /// Audio thread; frames × channels samples; false ends the stream.
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
  /// Throws Error for an unknown name, RunFailure if the device refuses.
  virtual StreamOpened open(const StreamRequest& request) = 0;
  virtual void start() = 0;
  /// false: the device is gone, or the stream stopped.
  virtual bool alive() noexcept = 0;
  /// No callback from now on. May take minutes if the sound server died.
  virtual void close() noexcept = 0;
};

std::unique_ptr<StreamBackend> make_portaudio_backend();

}  // namespace typodont::audio
