// Measures changes of the spindle's speed and removes them. Not for real time.
#pragma once

#include <span>
#include <vector>

namespace typodont::audio {

/// Speed relative to the mean speed, every `step` seconds from 0 on.
struct SpeedTrack {
  double frequency = 0;       // Hz, mean frequency of the followed line
  double step = 0;            // s, time between two values of the speed
  std::vector<double> ratio;  // speed divided by mean speed; empty: no line could be followed

  bool known() const { return !ratio.empty(); }
  // Speed divided by mean speed at time t (s): interpolated, constant beyond the ends of the track; 1 if unknown.
  double at(double t) const;
  double range() const;  // highest minus lowest value of `ratio`
};

/// Measures the speed by following the strongest steady spectral line. Returns an empty track if there is no such line,
/// or if the sound is shorter than 0.5 s or longer than a minute.
SpeedTrack speed_of(std::span<const double> x, double rate);

/// Resamples the sound so that every line of the rotor has a constant frequency.
std::vector<double> at_constant_speed(std::span<const double> x, double rate, const SpeedTrack& speed);

}  // namespace typodont::audio
