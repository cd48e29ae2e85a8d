// Turns one channel of sound into two channels for a listener whose head is a sphere. If an ear is turned away from the
// source, the sound at this ear is later and duller (Woodworth 1938; Brown & Duda, IEEE Trans. Speech Audio Process. 6
// (1998) 476-488).
#pragma once

#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "engine/base/pose.h"

namespace typodont::audio {

inline constexpr double kHeadRadius = 0.0875;  // m, mean radius of an adult head (Brown & Duda)
inline constexpr double kSpeedOfSound = 343;   // m/s, speed of sound in air
/// m, distance from the midpoint of the eyes back to the midpoint of the ears
inline constexpr double kEarsBehindEyes = 0.09;

/// The direction of a source for a spherical head, as two angles (rad): the angle between the direction to the source
/// and the direction of each ear, from 0 (straight into the ear) to π.
struct EarAngles {
  double left = kPiHalf, right = kPiHalf;
  static constexpr double kPiHalf = 1.5707963267948966;
};
/// Returns the direction of a source. `source_W`, `eyes_W`: m, positions of the source and of the midpoint of the eyes.
/// `right_W`: unit vector from the left to the right eye. The head is assumed to face the source. A source closer than
/// the head's radius counts as straight ahead.
EarAngles ear_angles(const dvec3& source_W, const dvec3& eyes_W, const dvec3& right_W);

/// Returns the delay (s) of the sound at an ear, compared with its arrival at the head's centre; negative if the ear
/// faces the source. Brown & Duda 1998, eq. 6 (Woodworth's formula for distant sources).
double ear_delay(double angle);
/// Returns the factor α(θ) of the filter H = (1 + jαω/2ω0) / (1 + jω/2ω0), which models the acoustic shadow of the head
/// at the angle θ (rad); ω0 = speed of sound / head radius. A factor of 2 doubles high frequencies; a factor of 0.1
/// nearly removes them. Brown & Duda 1998, eqs. 3 and 4.
double ear_shadow(double angle);

/// Renders a mono sound for two ears. Used by one thread at a time. Only the constructor allocates. If the head moves,
/// delays and acoustic shadows approach their new values with the time constant kGlide, so that no clicks are heard.
class Binaural {
 public:
  explicit Binaural(double sample_rate);

  /// Sets the direction of the source from the next sample on. Before the first call the source is straight ahead.
  void turn(const EarAngles& angles) noexcept;
  /// Renders `stereo` from `mono`. In `stereo`, left and right samples alternate, so it is twice as long as `mono`.
  void render(std::span<const float> mono, std::span<float> stereo) noexcept;

  /// Returns the delay (s) of both channels, compared with the mono sound, if the source is straight ahead.
  double latency() const noexcept;
  static constexpr double kGlide = 0.02;  // s, time constant of the delay and of the head's acoustic shadow

 private:
  struct Ear {
    // in samples: the present delay of this ear (`delay`), and the delay that it approaches (`wanted_delay`)
    double delay = 0, wanted_delay = 0;
    // `shadow`: present factor α of the head's acoustic shadow; `wanted_shadow`: factor that `shadow` approaches
    double shadow = 1, wanted_shadow = 1;
    // previous input (`before`) and previous output (`after`) of the filter that models the head's acoustic shadow
    float before = 0, after = 0;
  };
  float read(double delay) const noexcept;

  double rate_;
  double glide_;  // fraction of the remaining difference by which delay and acoustic shadow change per sample
  /// coefficients of the filter that models the head's acoustic shadow: y = input_ (x + x') + slope (x - x') - pole_
  /// y'; x: input, y: output, x' and y': previous values
  double pole_, input_;
  double slope_;
  std::vector<float> line_;  // ring buffer of the mono samples
  std::size_t at_ = 0;
  Ear ears_[2];
  bool turned_ = false;
};

}  // namespace typodont::audio
