// Pairs that no rigid motion explains: a mirror image, or lengths in other units. Only for the registration.
#pragma once

#include <optional>

#include "calibration/solver/agreement.h"

namespace typodont::calibration {

/// Pairs that a mirrored fit explains far better than a rigid one (F-test at 1 %; flat sets fit both ways alike).
bool mirrored(Points p_H, Points p_D, const Fit& fit, double rounding);

/// The same where outliers hide it: more agree, or more closely, once D is turned inside out.
bool mirror_fits_better(Points p_H, Points p_D, const Fit& fit, const RegistrationOptions& options);

/// Lengths in D over lengths in H, where a rigid fit with a scale explains the pairs far better and the scale is 2 %
/// off.
std::optional<double> other_scale(Points p_H, Points p_D, const Fit& fit, double rounding);

/// The same where outliers hide it: by the median over pairs of points, which up to half of them cannot move.
std::optional<double> other_scale_by_median(Points p_H, Points p_D, double rounding);

}  // namespace typodont::calibration
