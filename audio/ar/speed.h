// Changes of the spindle's speed in a recording: measured on a steady line, and removed. Set-up time.
#pragma once

#include <span>
#include <vector>

namespace typodont::audio {

/// Speed of the spindle over time, relative to its mean. One value per `step` s; the first belongs to time 0.
struct SpeedTrack {
  double frequency = 0;       // Hz, mean frequency of the line on which the speed was measured
  double step = 0;            // s
  std::vector<double> ratio;  // speed over the mean speed; empty if no line could be followed

  bool known() const { return !ratio.empty(); }
  double at(double t) const;  // t in s; linear between the values, constant beyond the ends; 1 if not known
  double range() const;       // highest ratio − lowest ratio
};

/// Follows the strongest steady line of the sound. Not known if no line is steady, or if the sound is shorter than
/// 0.5 s or longer than a minute.
SpeedTrack speed_of(std::span<const double> x, double rate);

/// The sound as it would be at the mean speed: played faster where the spindle was slow, and slower where it was fast.
/// So every line of the rotor keeps one frequency.
std::vector<double> at_constant_speed(std::span<const double> x, double rate, const SpeedTrack& speed);

}  // namespace typodont::audio
