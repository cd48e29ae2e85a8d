#include "audio/output/device_output.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>

#include "engine/base/error.h"
#include "engine/base/log.h"

namespace typodont::audio {

DeviceOutput::DeviceOutput(std::unique_ptr<StreamBackend> backend, std::string device, const AudioOptions& options)
    : backend_(std::move(backend)),
      closed_(std::make_shared<std::atomic<bool>>(true)),
      device_(std::move(device)),
      options_(options) {
  open();
}

DeviceOutput::~DeviceOutput() {
  close_within(kPatience);
}

bool DeviceOutput::close_within(Nanos patience) {
  // Closes the stream on another thread, because PortAudio can wait ten minutes for a JACK server that has crashed.
  if (closed_->load()) {
    closed_->store(false);
    std::thread([backend = backend_, closed = closed_] {
      backend->close();
      closed->store(true);
    }).detach();
  }
  const Nanos end = now() + patience;
  while (!closed_->load() && now() < end) std::this_thread::sleep_for(std::chrono::microseconds(200));
  return closed_->load();
}

void DeviceOutput::open() {
  StreamRequest request;
  request.device = device_;
  request.sample_rate = options_.sample_rate;
  request.buffer = options_.buffer;
  request.channels = options_.channels;
  request.callback = &DeviceOutput::callback;
  request.self = this;
  opened_ = backend_->open(request);
  clock_ = ClockFilter(opened_.sample_rate);
}

void DeviceOutput::start(const AudioSource& source, Nanos t_start) {
  source_ = source;
  offset_ = t_start - now();
  started_ = true;
  last_look_samples_at_ = t_start;
  backend_->start();
}

void DeviceOutput::advance(Nanos t) {
  if (!started_) return;
  const std::uint64_t rendered = samples_.load(std::memory_order_relaxed);
  if (const auto under = underruns_.load(std::memory_order_relaxed); under > underruns_told_) {
    log::warn("sound: {} under-runs on {}", under - underruns_told_, opened_.name);
    underruns_told_ = under;
  }
  if (options_.end_after > 0 && rendered >= options_.end_after) return;
  if (!lost_) {
    if (rendered != last_look_samples_) {
      last_look_samples_ = rendered;
      last_look_samples_at_ = t;
    }
    if (backend_->alive() && t - last_look_samples_at_ < kSilentFor) return;
    lost_ = true;
    ++losses_;
    close_within(50'000'000);
    next_try_ = t;
    log::warn("sound: {} is lost; the session continues and tries every second to open it again", opened_.name);
  }
  if (t < next_try_ || !closed_->load()) return;
  next_try_ = t + kRetryEvery;
  try {
    const double before = opened_.sample_rate;
    open();
    if (opened_.sample_rate != before && source_.rate_changed) {
      source_.rate_changed(source_.self, opened_.sample_rate);
      log::info("sound: the rate is now {} Hz", opened_.sample_rate);
    }
    backend_->start();
    lost_ = false;
    ++recoveries_;
    last_look_samples_at_ = t;
    log::info("sound: {} is back", opened_.name);
  } catch (const std::exception&) {  // the device is still disconnected; this was already reported
    close_within(50'000'000);
  }
}

void DeviceOutput::stop() {
  started_ = false;
  if (!close_within(kPatience)) log::warn("sound: {} does not close; the program continues without it", opened_.name);
}

AudioStats DeviceOutput::stats() const {
  AudioStats stats;
  stats.samples = samples_.load(std::memory_order_relaxed);
  stats.underruns = underruns_.load(std::memory_order_relaxed);
  stats.clipped = clipped_.load(std::memory_order_relaxed);
  stats.losses = losses_;
  stats.recoveries = recoveries_;
  stats.sample_rate = opened_.sample_rate;
  stats.latency = options_.buffer / opened_.sample_rate + to_seconds(kMargin);
  stats.device_latency = opened_.device_latency;
  return stats;
}

std::string DeviceOutput::description() const {
  return fmt::format("portaudio:{} ({:.0f} Hz, {} samples, {:.1f} ms in the device)", opened_.name, opened_.sample_rate,
                     options_.buffer, 1e3 * opened_.device_latency);
}

bool DeviceOutput::callback(void* self, float* out, int frames, int channels, Nanos t, bool underrun) noexcept {
  return static_cast<DeviceOutput*>(self)->fill(out, frames, channels, t, underrun);
}

bool DeviceOutput::fill(float* out, int frames, int channels, Nanos t, bool underrun) noexcept {
  if (underrun) underruns_.fetch_add(1, std::memory_order_relaxed);
  const double period = 1e9 / opened_.sample_rate;
  // The buffer ends kMargin before the time at which this callback was due, so all servo ticks in it have arrived.
  const Nanos t_first =
      clock_.filtered(t, frames) + offset_ - kMargin - static_cast<Nanos>(std::llround(frames * period));
  std::uint64_t clipped = 0;
  const int given = options_.channels;
  for (int done = 0; done < frames;) {
    const int count = std::min(frames - done, static_cast<int>(block_.size()) / given);
    const std::span<float> part(block_.data(), static_cast<std::size_t>(count * given));
    source_.render(source_.self, part, t_first + static_cast<Nanos>(std::llround(done * period)));
    for (float& v : part) {
      clipped += v > 1.0f || v < -1.0f;
      v = std::clamp(v, -1.0f, 1.0f);
    }
    for (int i = 0; i < count; ++i) {
      const float* const frame = part.data() + i * given;
      for (int c = 0; c < channels; ++c) {
        // Copies mono to all channels of the device, stereo to the first two. A device with one channel gets the mean.
        if (given == 1)
          *out++ = frame[0];
        else if (channels == 1)
          *out++ = 0.5f * (frame[0] + frame[1]);
        else
          *out++ = c < 2 ? frame[c] : 0.0f;
      }
    }
    done += count;
  }
  clipped_.fetch_add(clipped, std::memory_order_relaxed);
  const auto rendered = samples_.fetch_add(static_cast<std::uint64_t>(frames), std::memory_order_relaxed) +
                        static_cast<std::uint64_t>(frames);
  return options_.end_after == 0 || rendered < options_.end_after;
}

}  // namespace typodont::audio
