// Renders mono sound for the two ears of a spherical head: on the far side, it arrives later and with less high
// frequencies (Woodworth 1938; Brown & Duda, IEEE Trans. Speech Audio Process. 6 (1998) 476-488).
#pragma once

#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "engine/base/pose.h"

namespace typodont::audio {

inline constexpr double kHeadRadius = 0.0875;  // m, mean radius of an adult head (Brown & Duda)
inline constexpr double kSpeedOfSound = 343;   // m/s, speed of sound in air
/// Distance by which the ears lie behind the eyes, m.
inline constexpr double kEarsBehindEyes = 0.09;

/// For each ear: angle between its direction from the head's centre and that of the source, rad, 0 … π.
struct EarAngles {
  double left = kPiHalf, right = kPiHalf;
  static constexpr double kPiHalf = 1.5707963267948966;
};
/// Positions in m; `eyes_W`: between the eyes; `right_W`: unit vector from left to right eye. The head is assumed to be
/// turned about `right_W` towards the source. A source inside the head counts as straight ahead.
EarAngles ear_angles(const dvec3& source_W, const dvec3& eyes_W, const dvec3& right_W);

/// Delay relative to a sound at the head's centre, s; negative on the near side. Brown & Duda 1998, eq. 6.
double ear_delay(double angle);
/// Factor α of the head's shadow filter H = (1 + jαω/2ω0) / (1 + jω/2ω0), ω0 = speed of sound / radius. Brown & Duda
/// 1998, eqs. 3 and 4.
double ear_shadow(double angle);

/// Renders sound for two ears. Used by one thread at a time; only the constructor allocates. Delay and shadow change
/// gradually, so there are no clicks.
class Binaural {
 public:
  explicit Binaural(double sample_rate);

  /// Sets the direction of the source from the next sample on; at first it is straight ahead.
  void turn(const EarAngles& angles) noexcept;
  /// Writes interleaved stereo samples, twice as many as `mono` has.
  void render(std::span<const float> mono, std::span<float> stereo) noexcept;

  /// Latency of both channels for a source straight ahead, s.
  double latency() const noexcept;
  // s, time constant with which delay and shadow change
  static constexpr double kGlide = 0.02;

 private:
  struct Ear {
    // Current and target delay, samples.
    double delay = 0, wanted_delay = 0;
    // Current and target factor α of the head's shadow filter.
    double shadow = 1, wanted_shadow = 1;
    // Previous input and output sample of the shadow filter.
    float before = 0, after = 0;
  };
  float read(double delay) const noexcept;

  double rate_;
  double glide_;  // fraction of the difference between wanted and current delay or shadow that is applied per sample
  /// Coefficients of the shadow filter: y = input_ (x + x') + slope (x - x') - pole_ y', where x' and y' are the
  /// previous input and output.
  double pole_, input_;
  double slope_;
  std::vector<float> line_;  // ring buffer of the latest mono samples
  std::size_t at_ = 0;
  Ear ears_[2];
  bool turned_ = false;
};

}  // namespace typodont::audio
