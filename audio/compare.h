// Compares two sounds with measures that agree with hearing.
#pragma once

#include <filesystem>
#include <vector>

namespace typodont::audio {

struct SoundMeasure {
  double duration = 0, rate = 0;
  double level_dB = 0;  // dB re full scale, root-mean-square level
  double peak_dB = 0;
  double centroid = 0;        // Hz, spectral centroid up to Comparison::up_to: a measure of brightness
  double rotor = 0;           // Hz, estimated frequency of the rotor; 0: none found
  std::vector<double> tones;  // Hz, frequencies of the strongest lines, at most five
  // standard deviation of each tone's amplitude divided by the mean: 0 for a steady tone, 0.52 for noise in a narrow
  // band
  std::vector<double> tone_variation;
  // for each spectral line of CompareOptions::lines: standard deviation of its amplitude divided by the mean amplitude
  std::vector<double> line_variation;
};

struct Comparison {
  SoundMeasure a, b;
  double distance_dB = 0;  // dB, log-spectral distance between the sounds, including the difference in level
  // dB, log-spectral distance without the difference in level: the mean difference of the two spectra (dB) is
  // subtracted
  double shape_distance_dB = 0;
  double itakura_saito = 0;        // Itakura–Saito distance of sound a from sound b
  double level_difference_dB = 0;  // dB, level of sound b minus level of sound a
  /// frequency of the strongest tone of sound b divided by that of sound a; 0 if one sound has no tone
  double tone_ratio = 0;
  double up_to = 0;  // Hz, the distances compare the spectra up to this frequency
};

struct CompareOptions {
  double up_to = 16000;  // Hz, the distances compare the spectra up to this frequency; at least 200 Hz
  // true: changes of the spindle's speed are removed from each sound before the comparison; they are measured on a
  // steady spectral line of the sound
  bool constant_speed = false;
  // Hz, frequencies of additional spectral lines; the variation of each line's amplitude is measured in both sounds
  std::vector<double> lines;
};

/// Compares two sounds. The channels of each sound are averaged, and silence is included. Sounds of different sample
/// rates are compared up to the highest frequency that both contain. Throws Error like read_recording(), and if a
/// sample is not finite.
Comparison compare_sounds(const std::filesystem::path& a, const std::filesystem::path& b,
                          const CompareOptions& options = {});

}  // namespace typodont::audio
