// Turns one channel of sound into two, for a listener whose head is a sphere: each ear hears the source later and
// duller the further the source is behind the head for this ear (Woodworth 1938; Brown & Duda, IEEE Trans. Speech Audio
// Process. 6 (1998) 476-488).
#pragma once

#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "engine/base/pose.h"

namespace typodont::audio {

inline constexpr double kHeadRadius = 0.0875;    // m, mean adult head (Brown & Duda)
inline constexpr double kSpeedOfSound = 343;     // m/s
inline constexpr double kEarsBehindEyes = 0.09;  // m, distance from the midpoint of the eyes back to that of the ears

/// The direction of a source for a spherical head: the angles between the direction to the source and to each ear, rad,
/// 0 (straight into the ear) to π.
struct EarAngles {
  double left = kPiHalf, right = kPiHalf;
  static constexpr double kPiHalf = 1.5707963267948966;
};
/// `source_W`, `eyes_W`: m, the source and the midpoint of the eyes. `right_W`: unit vector from the left to the right
/// eye. The head is assumed to face the source. A source closer than the head's radius counts as straight ahead.
EarAngles ear_angles(const dvec3& source_W, const dvec3& eyes_W, const dvec3& right_W);

/// s by which the sound reaches an ear later than it would reach the head's centre; negative on the source's side.
/// Brown & Duda 1998, eq. 6 (Woodworth's formula for distant sources).
double ear_delay(double angle);
/// α(θ) of the head's shadow H = (1 + jαω/2ω0) / (1 + jω/2ω0), ω0 = c/a: 2 doubles high frequencies, 0.1 nearly removes
/// them. Brown & Duda 1998, eqs. 3 and 4.
double ear_shadow(double angle);

/// One thread at a time. Only the constructor allocates. Delays and shadows follow the head smoothly, without clicks:
/// they approach their new values with a time constant of kGlide.
class Binaural {
 public:
  explicit Binaural(double sample_rate);

  /// The direction from the next sample on. Before the first call the source is straight ahead.
  void turn(const EarAngles& angles) noexcept;
  /// `stereo`: left and right samples in turn, twice as many as `mono`.
  void render(std::span<const float> mono, std::span<float> stereo) noexcept;

  /// s by which both channels are later than the mono sound if the source is straight ahead.
  double latency() const noexcept;
  static constexpr double kGlide = 0.02;  // s

 private:
  struct Ear {
    double delay = 0, wanted_delay = 0;    // samples
    double shadow = 1, wanted_shadow = 1;  // α
    float before = 0, after = 0;           // last input and output of the shadow's filter
  };
  float read(double delay) const noexcept;

  double rate_;
  double glide_;         // fraction of the way to the wanted value per sample
  double pole_, input_;  // shadow: y = input_ (x + x') + slope (x - x') - pole_ y'
  double slope_;
  std::vector<float> line_;  // ring buffer of the mono samples
  std::size_t at_ = 0;
  Ear ears_[2];
  bool turned_ = false;
};

}  // namespace typodont::audio
