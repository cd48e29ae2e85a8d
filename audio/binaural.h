// Mono to two ears of a spherical head: later and duller on the far side (Woodworth 1938; Brown & Duda, IEEE Trans.
// Speech Audio Process. 6 (1998) 476-488).
#pragma once

#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "engine/base/pose.h"

namespace typodont::audio {

inline constexpr double kHeadRadius = 0.0875;  // m, mean radius of an adult head (Brown & Duda)
inline constexpr double kSpeedOfSound = 343;   // m/s, speed of sound in air
/// m, ears behind the eyes
inline constexpr double kEarsBehindEyes = 0.09;

/// Angles (rad) from each ear's direction to the source, 0 … π.
struct EarAngles {
  double left = kPiHalf, right = kPiHalf;
  static constexpr double kPiHalf = 1.5707963267948966;
};
/// m; `right_W`: unit vector from left to right eye. The head faces the source; one closer than the radius is straight
/// ahead.
EarAngles ear_angles(const dvec3& source_W, const dvec3& eyes_W, const dvec3& right_W);

/// s, against the head's centre; negative on the near side. Brown & Duda 1998, eq. 6.
double ear_delay(double angle);
/// α(θ) of H = (1 + jαω/2ω0) / (1 + jω/2ω0), ω0 = speed of sound / radius. Brown & Duda 1998, eqs. 3 and 4.
double ear_shadow(double angle);

/// One thread at a time; only the constructor allocates. Moves glide, without clicks.
class Binaural {
 public:
  explicit Binaural(double sample_rate);

  /// From the next sample on; at first straight ahead.
  void turn(const EarAngles& angles) noexcept;
  /// Interleaved; twice as long as `mono`.
  void render(std::span<const float> mono, std::span<float> stereo) noexcept;

  /// s, of both channels for a source straight ahead.
  double latency() const noexcept;
  static constexpr double kGlide = 0.02;  // s, time constant of delay and shadow

 private:
  struct Ear {
    // samples
    double delay = 0, wanted_delay = 0;
    // factor α
    double shadow = 1, wanted_shadow = 1;
    // last input and output of the shadow's filter
    float before = 0, after = 0;
  };
  float read(double delay) const noexcept;

  double rate_;
  double glide_;  // fraction of the difference per sample
  /// y = input_ (x + x') + slope (x - x') - pole_ y'
  double pole_, input_;
  double slope_;
  std::vector<float> line_;  // ring buffer of the mono samples
  std::size_t at_ = 0;
  Ear ears_[2];
  bool turned_ = false;
};

}  // namespace typodont::audio
