// Reads all sound formats of libsndfile. Writes WAV files, completely or not at all.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

namespace typodont::audio {

struct Recording {
  std::vector<std::vector<double>> channels;  // samples of each channel; full scale is 1
  double rate = 0;                            // Hz, sampling rate
  std::size_t length() const { return channels.empty() ? 0 : channels.front().size(); }
  /// Returns one channel; -1: the mean of all channels.
  std::vector<double> mono(int channel = -1) const;
};

/// Reads a sound file. Throws Error if it is missing, no sound, empty, or longer than 30 minutes.
Recording read_recording(const std::filesystem::path& file);

enum class SampleFormat { kPcm16, kFloat32 };

/// Writes a WAV file; its name is temporary until finish().
class WavWriter {
 public:
  WavWriter(const std::filesystem::path& file, double rate, SampleFormat format = SampleFormat::kPcm16,
            int channels = 1);
  ~WavWriter();
  WavWriter(const WavWriter&) = delete;
  WavWriter& operator=(const WavWriter&) = delete;
  /// Writes interleaved samples. Throws Error if the disk is full.
  void write(std::span<const float> samples);
  void finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace typodont::audio
