// Recognises that pairs of points follow two similar rigid motions, which look like one motion with noise.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "engine/base/pose.h"

namespace typodont::calibration {

struct Split {
  Pose X_first, X_second;                  // X_first: the motion with more pairs
  std::vector<std::size_t> first, second;  // ascending indices of the pairs that follow X_first, and X_second
  double sigma = 0;                        // m per axis, standard deviation of the residuals of all pairs
  double log_nfa = 0;                      // logarithm of the expected number of equally good splits of random pairs
};

/// Best split of `pairs` into two motions; nullopt if they fit one motion, also one with more noise along one axis.
/// `known_sigma`: m per axis, 0: estimated; `rounding`: m, rounding error of the coordinates.
std::optional<Split> split_in_two(std::span<const dvec3> p_H, std::span<const dvec3> p_D,
                                  std::span<const std::size_t> pairs, double known_sigma, double rounding);

/// Assigns pairs within `limit` (m) to the nearer motion and refits, until nothing changes. Returns the expected number
/// of pairs that noise has assigned to the wrong motion.
double assign_to_nearer(std::span<const dvec3> p_H, std::span<const dvec3> p_D, double limit, Split& split);

}  // namespace typodont::calibration
