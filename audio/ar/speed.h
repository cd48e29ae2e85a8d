// Measures the changes of the spindle's speed in a recording by following a spectral line, and removes them. Not for
// real time.
#pragma once

#include <span>
#include <vector>

namespace typodont::audio {

/// Speed of the spindle over time, relative to its mean. One value per `step` s; the first value is the speed at time
/// 0.
struct SpeedTrack {
  double frequency = 0;       // Hz, mean frequency of the spectral line that gives the speed
  double step = 0;            // s, time between two values of the speed
  std::vector<double> ratio;  // ratio of the speed to the mean speed; empty if no line could be followed

  bool known() const { return !ratio.empty(); }
  // returns the speed ratio at time t (s): interpolated linearly, constant beyond the ends; 1 if the speed is not known
  double at(double t) const;
  double range() const;  // returns the highest minus the lowest ratio of the speed to its mean
};

/// Follows the strongest steady spectral line of the sound. The result is empty if no line is steady, or if the sound
/// is shorter than 0.5 s or longer than a minute.
SpeedTrack speed_of(std::span<const double> x, double rate);

/// Returns the sound as it would be at the mean speed. The sound is played faster where the spindle was slow, and
/// slower where the spindle was fast. Then every line of the rotor has a constant frequency.
std::vector<double> at_constant_speed(std::span<const double> x, double rate, const SpeedTrack& speed);

}  // namespace typodont::audio
