// Opens outputs by address, and contains the two outputs that need no device.
#include <algorithm>
#include <cmath>

#include "audio/audio_output.h"
#include "audio/output/device_output.h"
#include "audio/sound_file.h"
#include "engine/base/error.h"
#include "engine/base/log.h"

namespace typodont::audio {

namespace {

/// Output to a file; advance() renders as fast as possible.
class FileOutput final : public AudioOutput {
 public:
  FileOutput(const std::string& file, const AudioOptions& options)
      : file_(file),
        rate_(options.sample_rate > 0 ? options.sample_rate : 48000),
        channels_(static_cast<std::size_t>(options.channels)),
        buffer_(static_cast<std::size_t>(options.buffer) * channels_),
        wav_(file, rate_, SampleFormat::kPcm16, options.channels) {}

  double sample_rate() const override { return rate_; }
  void start(const AudioSource& source, Nanos t_start) override {
    source_ = source;
    t_start_ = t_start;
  }
  void advance(Nanos t) override {
    if (!source_.render) return;
    const auto due = static_cast<std::uint64_t>(std::max(0.0, std::floor(to_seconds(t - t_start_) * rate_)));
    while (stats_.samples < due) {
      const auto count =
          static_cast<std::size_t>(std::min<std::uint64_t>(buffer_.size() / channels_, due - stats_.samples));
      const std::span<float> part(buffer_.data(), count * channels_);
      const double elapsed = static_cast<double>(stats_.samples) / rate_;
      source_.render(source_.self, part, t_start_ + from_seconds(elapsed));
      for (float& v : part) {
        stats_.clipped += std::abs(v) > 1.0f;
        v = std::clamp(v, -1.0f, 1.0f);
      }
      wav_.write(part);
      stats_.samples += count;
    }
  }
  void stop() override {
    source_ = {};
    wav_.finish();
  }
  AudioStats stats() const override {
    AudioStats stats = stats_;
    stats.sample_rate = rate_;
    return stats;
  }
  std::string description() const override { return "wav:" + file_; }

 private:
  std::string file_;
  double rate_;
  std::size_t channels_;
  std::vector<float> buffer_;
  WavWriter wav_;
  AudioSource source_;
  Nanos t_start_ = 0;
  AudioStats stats_;
};

/// Output "none:": never calls the source.
class NoOutput final : public AudioOutput {
 public:
  explicit NoOutput(const AudioOptions& options) : rate_(options.sample_rate > 0 ? options.sample_rate : 48000) {}
  double sample_rate() const override { return rate_; }
  void start(const AudioSource&, Nanos) override {}
  void advance(Nanos) override {}
  void stop() override {}
  AudioStats stats() const override {
    AudioStats stats;
    stats.sample_rate = rate_;
    return stats;
  }
  std::string description() const override { return "none:"; }

 private:
  double rate_;
};

}  // namespace

std::unique_ptr<AudioOutput> AudioOutput::open(const std::string& address, const AudioOptions& options) {
  if (options.buffer < 16 || options.buffer > 65536) {
    throw Error("audio buffer", "", fmt::format("{} samples", options.buffer), "16 to 65536");
  }
  if (options.sample_rate != 0 && !(options.sample_rate >= 8000 && options.sample_rate <= 384000)) {
    throw Error("audio rate", "", fmt::format("{} Hz", options.sample_rate), "8000 to 384000 Hz");
  }
  if (options.channels != 1 && options.channels != 2) {
    throw Error("audio channels", "", fmt::to_string(options.channels), "1 or 2");
  }
  const auto colon = address.find(':');
  const std::string kind = address.substr(0, colon);
  const std::string rest = colon == std::string::npos ? "" : address.substr(colon + 1);
  if (kind == "none" && rest.empty()) return std::make_unique<NoOutput>(options);
  if (kind == "wav" && !rest.empty()) return std::make_unique<FileOutput>(rest, options);
  if (kind == "portaudio") {
#ifdef TYPODONT_PORTAUDIO
    return std::make_unique<DeviceOutput>(make_portaudio_backend(), rest, options);
#else
    throw Error("--audio", "", "\"" + address + "\"", "wav:FILE or none: (this program was built without PortAudio)");
#endif
  }
  throw Error("--audio", "", "\"" + address + "\"", "portaudio:[DEVICE], wav:FILE or none:");
}

#ifndef TYPODONT_PORTAUDIO
std::vector<AudioDevice> audio_devices() {
  return {};
}
#endif

}  // namespace typodont::audio
