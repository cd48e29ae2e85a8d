// Output to a sound card that may be unplugged and plugged in again.
#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <string>

#include "audio/audio_output.h"
#include "audio/output/clock_filter.h"
#include "audio/output/stream_backend.h"

namespace typodont::audio {

class DeviceOutput final : public AudioOutput {
 public:
  DeviceOutput(std::unique_ptr<StreamBackend> backend, std::string device, const AudioOptions& options);
  ~DeviceOutput() override;

  double sample_rate() const override { return opened_.sample_rate; }
  void start(const AudioSource& source, Nanos t_start) override;
  void advance(Nanos t) override;
  void stop() override;
  AudioStats stats() const override;
  std::string description() const override;

  /// Delay of the output that allows for late callbacks and for ticks still in the queue, ns.
  static constexpr Nanos kMargin = 1'000'000;
  /// If no callback comes during this time, the device counts as lost, ns.
  static constexpr Nanos kSilentFor = 500'000'000;
  static constexpr Nanos kRetryEvery = 1'000'000'000;
  /// Largest time to wait until the library closes a stream, ns.
  static constexpr Nanos kPatience = 2'000'000'000;

 private:
  static bool callback(void* self, float* out, int frames, int channels, Nanos t, bool underrun) noexcept;
  bool fill(float* out, int frames, int channels, Nanos t, bool underrun) noexcept;
  void open();
  bool close_within(Nanos patience);

  /// The sound library, shared with the thread that closes the stream.
  std::shared_ptr<StreamBackend> backend_;
  std::shared_ptr<std::atomic<bool>> closed_;  // false while another thread closes the stream
  std::string device_;
  AudioOptions options_;
  StreamOpened opened_;
  AudioSource source_;
  bool started_ = false, lost_ = false;
  Nanos last_look_samples_at_ = 0, next_try_ = 0;
  std::uint64_t last_look_samples_ = 0, losses_ = 0, recoveries_ = 0, underruns_told_ = 0;

  // While a stream runs, only the audio thread uses clock_, offset_ and block_.
  ClockFilter clock_{48000};
  Nanos offset_ = 0;  // ns, tick time minus host time
  std::array<float, 4096> block_{};

  std::atomic<std::uint64_t> samples_{0}, underruns_{0}, clipped_{0};
};

}  // namespace typodont::audio
