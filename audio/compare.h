// How far two sounds are apart, in numbers that the ear would sign.
#pragma once

#include <filesystem>
#include <vector>

namespace typodont::audio {

struct SoundMeasure {
  double duration = 0, rate = 0;
  double level_dB = 0;  // rms re full scale
  double peak_dB = 0;
  double centroid = 0;                 // Hz, of the power spectrum up to the common limit: brightness
  double rotor = 0;                    // Hz, estimated; 0: none found
  std::vector<double> tones;           // Hz, up to five strongest lines
  std::vector<double> tone_variation;  // of each tone's amplitude, over its mean: 0 steady, 0.52 noise in a narrow band
};

struct Comparison {
  SoundMeasure a, b;
  double distance_dB = 0;          // log-spectral, levels included
  double shape_distance_dB = 0;    // after the mean difference in dB is taken off
  double itakura_saito = 0;        // of a against b
  double level_difference_dB = 0;  // b − a
  double tone_ratio = 0;           // strongest tone of b over that of a; 0 where one has none
  double up_to = 0;                // Hz that the distances reach to
};

/// Channels are averaged, silence is not trimmed; different rates are compared where both have something. `up_to`: Hz,
/// 200 or more. Throws Error as read_recording does, and where a sample is not finite.
Comparison compare_sounds(const std::filesystem::path& a, const std::filesystem::path& b, double up_to = 16000);

}  // namespace typodont::audio
