// Detects two motions that are so similar that a common fit looks like one noisy motion. Only for the registration.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "engine/base/pose.h"

namespace typodont::calibration {

struct Split {
  Pose X_first, X_second;                  // the two motions; X_first is the motion with more pairs
  std::vector<std::size_t> first, second;  // indices of pairs, ascending
  double sigma = 0;                        // m per axis, noise around the two motions
  double log_nfa = 0;  // logarithm of the expected number of equally good splits of one normal distribution
};

/// Finds the best division of `pairs` into two sets with separate rigid motions. Returns it only if it explains the
/// pairs better than one motion with noise (also with noise that is larger in some directions). `known_sigma`: m per
/// axis, known noise; 0: the noise is estimated. `rounding`: m, rounding error of the coordinates.
std::optional<Split> split_in_two(std::span<const dvec3> p_H, std::span<const dvec3> p_D,
                                  std::span<const std::size_t> pairs, double known_sigma, double rounding);

/// Assigns every pair within `limit` (m) of a motion to the nearer of the two motions, and fits both motions again,
/// until nothing changes. Returns the expected number of pairs that noise assigned to the wrong motion.
double assign_to_nearer(std::span<const dvec3> p_H, std::span<const dvec3> p_D, double limit, Split& split);

}  // namespace typodont::calibration
