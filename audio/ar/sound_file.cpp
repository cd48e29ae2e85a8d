#include "audio/sound_file.h"

#include <fmt/format.h>
#include <sndfile.h>

#include <cerrno>
#include <cmath>
#include <cstring>

#include "engine/base/error.h"
#include "engine/base/input_file.h"
#include "engine/base/late_library.h"
#include "engine/base/partial_file.h"

namespace typodont::audio {

namespace {
constinit LateLibrary sndfile{TYPODONT_LATE_SNDFILE};
TYPODONT_LATE(sndfile, sf_open, sf_close, sf_strerror, sf_readf_double, sf_writef_float, sf_command)

struct CloseSound {
  void operator()(SNDFILE* f) const { sf_close(f); }
};
using SoundFile = std::unique_ptr<SNDFILE, CloseSound>;
}  // namespace

std::vector<double> Recording::mono(int channel) const {
  if (channel >= 0) return channels.at(static_cast<std::size_t>(channel));
  std::vector<double> mean(length(), 0.0);
  for (const auto& samples : channels) {
    for (std::size_t i = 0; i < mean.size(); ++i) mean[i] += samples[i];
  }
  for (double& v : mean) v /= static_cast<double>(channels.size());
  return mean;
}

Recording read_recording(const std::filesystem::path& file) {
  require_input(file, InputKind::kSound);
  SF_INFO info{};
  const SoundFile sound(sf_open(file.c_str(), SFM_READ, &info));
  if (!sound) {
    throw Error(file.string(), "", fmt::format("{}", sf_strerror(nullptr)), "a WAV, FLAC, OGG or AIFF file");
  }
  if (info.channels < 1 || info.channels > 64 || info.samplerate < 1000 || info.samplerate > 1'000'000) {
    throw Error(file.string(), "header", fmt::format("{} channels at {} Hz", info.channels, info.samplerate),
                "1 to 64 channels at 1000 Hz to 1 MHz");
  }
  if (static_cast<double>(info.frames) > 1800.0 * info.samplerate) {
    throw Error(file.string(), "", fmt::format("{:.0f} s of sound", static_cast<double>(info.frames) / info.samplerate),
                "at most 1800 s");
  }
  Recording recording;
  recording.rate = info.samplerate;
  recording.channels.resize(static_cast<std::size_t>(info.channels));
  std::vector<double> frames(static_cast<std::size_t>(info.channels) * 4096);
  for (;;) {  // reads until the end, because a header may state more samples than the file has
    const sf_count_t got = sf_readf_double(sound.get(), frames.data(), 4096);
    if (got <= 0) break;
    for (std::size_t i = 0; i < static_cast<std::size_t>(got); ++i) {
      for (std::size_t c = 0; c < recording.channels.size(); ++c) {
        recording.channels[c].push_back(frames[i * recording.channels.size() + c]);
      }
    }
  }
  if (recording.length() == 0) throw Error(file.string(), "", "no samples", "a recording");
  return recording;
}

struct WavWriter::Impl {
  Impl(const std::filesystem::path& file, int count) : partial(file, FileKind::kSound), channels(count) {}
  PartialFile partial;
  int channels;
  SoundFile sound;
};

WavWriter::WavWriter(const std::filesystem::path& file, double rate, SampleFormat format, int channels)
    : impl_(std::make_unique<Impl>(file, channels)) {
  SF_INFO info{};
  info.channels = channels;
  info.samplerate = static_cast<int>(std::lround(rate));
  info.format = SF_FORMAT_WAV | (format == SampleFormat::kPcm16 ? SF_FORMAT_PCM_16 : SF_FORMAT_FLOAT);
  impl_->sound.reset(sf_open(impl_->partial.path().c_str(), SFM_WRITE, &info));
  if (!impl_->sound) throw Error(file.string(), "", sf_strerror(nullptr), "a writable place");
  // Omits the PEAK chunk, which contains the time of creation, so that equal sounds give equal bytes.
  sf_command(impl_->sound.get(), SFC_SET_ADD_PEAK_CHUNK, nullptr, SF_FALSE);
  sf_command(impl_->sound.get(), SFC_SET_CLIPPING, nullptr, SF_TRUE);
}

WavWriter::~WavWriter() = default;

void WavWriter::write(std::span<const float> samples) {
  const auto frames = static_cast<sf_count_t>(samples.size()) / impl_->channels;
  if (sf_writef_float(impl_->sound.get(), samples.data(), frames) != frames) {
    throw Error(impl_->partial.file().string(), "", sf_strerror(impl_->sound.get()), "room for the sound");
  }
}

void WavWriter::finish() {
  if (!impl_->sound) return;
  if (sf_close(impl_->sound.release()) != 0) {
    throw Error(impl_->partial.file().string(), "", "an error on closing", "room for the sound");
  }
  impl_->partial.keep();
}

}  // namespace typodont::audio
