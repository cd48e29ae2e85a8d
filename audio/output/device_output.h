// A sound card that may be unplugged and return.
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

  /// ns, for late callbacks and the ticks' queue
  static constexpr Nanos kMargin = 1'000'000;
  /// ns without a callback: lost
  static constexpr Nanos kSilentFor = 500'000'000;
  static constexpr Nanos kRetryEvery = 1'000'000'000;
  /// ns, longest wait for a library that does not let go
  static constexpr Nanos kPatience = 2'000'000'000;

 private:
  static bool callback(void* self, float* out, int frames, int channels, Nanos t, bool underrun) noexcept;
  bool fill(float* out, int frames, int channels, Nanos t, bool underrun) noexcept;
  void open();
  bool close_within(Nanos patience);

  /// shared with the thread that closes it
  std::shared_ptr<StreamBackend> backend_;
  std::shared_ptr<std::atomic<bool>> closed_;  // false while it is being closed
  std::string device_;
  AudioOptions options_;
  StreamOpened opened_;
  AudioSource source_;
  bool started_ = false, lost_ = false;
  Nanos last_look_samples_at_ = 0, next_try_ = 0;
  std::uint64_t last_look_samples_ = 0, losses_ = 0, recoveries_ = 0, underruns_told_ = 0;

  // Only the audio thread uses clock_, offset_ and block_ while a stream runs.
  ClockFilter clock_{48000};
  Nanos offset_ = 0;  // ns, tick time minus host time
  std::array<float, 4096> block_{};

  std::atomic<std::uint64_t> samples_{0}, underruns_{0}, clipped_{0};
};

}  // namespace typodont::audio
