// Two motions so close together that one fit through both looks like a noisy one. Only for the registration.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "engine/base/pose.h"

namespace typodont::calibration {

struct Split {
  Pose X_first, X_second;                  // the larger set first
  std::vector<std::size_t> first, second;  // indices of pairs, ascending
  double sigma = 0;                        // m per axis, about the two motions
  double log_nfa = 0;                      // how often chance alone splits one normal cloud as well, its logarithm
};

/// The best way to see `pairs` as two sets that each move rigidly, where that explains them better than one noisy
/// motion does (also than one whose noise is larger in some directions). `known_sigma` m per axis, 0: estimated.
/// `rounding` m.
std::optional<Split> split_in_two(std::span<const dvec3> p_H, std::span<const dvec3> p_D,
                                  std::span<const std::size_t> pairs, double known_sigma, double rounding);

/// Gives each of all pairs to the nearer of the two motions, where it lies within `limit` m of it, and fits both again,
/// until that stays the same. Returns how many of them are expected to have come to the wrong one by noise alone.
double share_out(std::span<const dvec3> p_H, std::span<const dvec3> p_D, double limit, Split& split);

}  // namespace typodont::calibration
