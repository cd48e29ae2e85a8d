// Mirror images and other units. For the registration.
#pragma once

#include <optional>

#include "calibration/solver/agreement.h"

namespace typodont::calibration {

/// F-test at 1 %; false for flat sets.
bool mirrored(Points p_H, Points p_D, const Fit& fit, double rounding);

/// The same with outliers: more pairs, or closer ones.
bool mirror_fits_better(Points p_H, Points p_D, const Fit& fit, const RegistrationOptions& options);

/// Lengths in D / in H, if a scale fits far better and differs by 2 %.
std::optional<double> other_scale(Points p_H, Points p_D, const Fit& fit, double rounding);

/// The same with outliers, by the median of distance ratios.
std::optional<double> other_scale_by_median(Points p_H, Points p_D, double rounding);

}  // namespace typodont::calibration
