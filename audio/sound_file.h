// Recordings: read in any format that libsndfile knows, written as WAV, whole or not at all.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

namespace typodont::audio {

struct Recording {
  std::vector<std::vector<double>> channels;  // full scale is 1
  double rate = 0;                            // Hz
  std::size_t length() const { return channels.empty() ? 0 : channels.front().size(); }
  /// One channel (0, 1, …), or with -1 the mean of all.
  std::vector<double> mono(int channel = -1) const;
};

/// Throws Error when it is missing, no sound file, empty, or over 30 minutes long.
Recording read_recording(const std::filesystem::path& file);

enum class SampleFormat { kPcm16, kFloat32 };

/// A WAV file under way: under a temporary name until finish(). A writer that dies leaves nothing behind.
class WavWriter {
 public:
  WavWriter(const std::filesystem::path& file, double rate, SampleFormat format = SampleFormat::kPcm16);
  ~WavWriter();
  WavWriter(const WavWriter&) = delete;
  WavWriter& operator=(const WavWriter&) = delete;
  void write(std::span<const float> mono);  // throws Error when the disk is full
  void finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace typodont::audio
