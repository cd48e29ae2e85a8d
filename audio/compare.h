// Compares two sounds by measures that agree with hearing.
#pragma once

#include <filesystem>
#include <vector>

namespace typodont::audio {

struct SoundMeasure {
  double duration = 0, rate = 0;
  double level_dB = 0;  // dB re full scale, root-mean-square level
  double peak_dB = 0;
  double centroid = 0;        // Hz, spectral centroid up to Comparison::up_to: a measure of brightness
  double rotor = 0;           // Hz, estimated rotation frequency of the rotor; 0: none found
  std::vector<double> tones;  // Hz, frequencies of the strongest spectral lines, at most five
  // For each tone: ratio of its amplitude's standard deviation to the mean; 0: steady tone, 0.52: narrow-band noise.
  std::vector<double> tone_variation;
  // For each frequency in CompareOptions::lines: standard deviation of its amplitude divided by the mean amplitude.
  std::vector<double> line_variation;
};

struct Comparison {
  SoundMeasure a, b;
  double distance_dB = 0;  // dB, log-spectral distance, including the difference in level
  // Log-spectral distance without the mean difference in level, dB.
  double shape_distance_dB = 0;
  double itakura_saito = 0;        // Itakura–Saito distance of sound a from sound b
  double level_difference_dB = 0;  // dB, level of sound b minus level of sound a
  /// Frequency of the strongest tone of sound b divided by that of sound a; 0: one of them has no tone.
  double tone_ratio = 0;
  double up_to = 0;  // Hz, the distances compare the spectra up to this frequency
};

struct CompareOptions {
  double up_to = 16000;  // Hz, highest compared frequency, at least 200
  // True: before the comparison, removes changes of the spindle's speed, measured on a steady spectral line.
  bool constant_speed = false;
  // Frequencies of additional spectral lines whose amplitude variation is measured, Hz.
  std::vector<double> lines;
};

/// Compares the means of all channels, including silence, up to the highest common frequency. Throws Error.
Comparison compare_sounds(const std::filesystem::path& a, const std::filesystem::path& b,
                          const CompareOptions& options = {});

}  // namespace typodont::audio
