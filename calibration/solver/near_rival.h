// The registration fits a rigid motion X_DH, from frame H of the haptic base to frame D of the display, to pairs of
// points (p_H, p_D). This file detects sets of pairs that follow two different rigid motions, even if these motions are
// so similar that one motion with noise seems to fit all pairs.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "engine/base/pose.h"

namespace typodont::calibration {

struct Split {
  Pose X_first, X_second;  // the two rigid motions X_DH; X_first is the motion that more pairs of points follow
  std::vector<std::size_t> first, second;  // ascending indices of the pairs that follow X_first, and X_second
  double sigma = 0;                        // m, standard deviation per axis of the pairs' residuals under their motion
  double log_nfa = 0;                      // log of the expected number of equally good divisions by chance (NFA)
};

/// Finds the best division of some pairs of points (p_H[i], p_D[i]) into two sets with separate rigid motions. `pairs`:
/// indices i of these pairs. Returns the division only if it explains the pairs better than one motion with noise (also
/// with noise that is larger in some directions). `known_sigma`: m, known standard deviation of the noise per axis; 0:
/// the noise is estimated. `rounding`: m, rounding error of the coordinates.
std::optional<Split> split_in_two(std::span<const dvec3> p_H, std::span<const dvec3> p_D,
                                  std::span<const std::size_t> pairs, double known_sigma, double rounding);

/// Every pair whose residual under one of the two motions is at most `limit` (m) goes to the motion with the smaller
/// residual. Then both motions are fitted again. This is repeated until nothing changes. Returns the expected number of
/// pairs that noise assigned to the wrong motion.
double assign_to_nearer(std::span<const dvec3> p_H, std::span<const dvec3> p_D, double limit, Split& split);

}  // namespace typodont::calibration
