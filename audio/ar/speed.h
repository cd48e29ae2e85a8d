// Measures and removes changes of the spindle's speed. Not for real time.
#pragma once

#include <span>
#include <vector>

namespace typodont::audio {

/// Speed / mean speed, every `step` s from 0.
struct SpeedTrack {
  double frequency = 0;       // Hz, mean frequency of the line followed
  double step = 0;            // s, time between two values of the speed
  std::vector<double> ratio;  // empty: no line could be followed

  bool known() const { return !ratio.empty(); }
  // at t (s): interpolated, constant beyond the ends; 1 if unknown
  double at(double t) const;
  double range() const;  // highest minus lowest ratio
};

/// Follows the strongest steady line. Empty without one, below 0.5 s or above a minute.
SpeedTrack speed_of(std::span<const double> x, double rate);

/// Resampled so that every line of the rotor has a constant frequency.
std::vector<double> at_constant_speed(std::span<const double> x, double rate, const SpeedTrack& speed);

}  // namespace typodont::audio
