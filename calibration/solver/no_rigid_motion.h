// Detects pairs that no rigid motion explains: a mirror image, or lengths in different units. Only for the
// registration.
#pragma once

#include <optional>

#include "calibration/solver/agreement.h"

namespace typodont::calibration {

/// Returns true if a mirrored fit explains the pairs far better than a rigid fit (F-test at 1 %). For a flat set, both
/// fits are equal, so the result is false.
bool mirrored(Points p_H, Points p_D, const Fit& fit, double rounding);

/// Same test as mirrored(), but in the presence of outliers. Returns true if, after the points p_D are reflected, more
/// pairs agree, or the pairs agree more closely.
bool mirror_fits_better(Points p_H, Points p_D, const Fit& fit, const RegistrationOptions& options);

/// Returns the ratio of lengths in frame D to lengths in frame H if two conditions hold: a rigid fit with a scale
/// explains the pairs far better than a fit without scale, and the scale differs from 1 by 2 % or more. Otherwise
/// returns no value.
std::optional<double> other_scale(Points p_H, Points p_D, const Fit& fit, double rounding);

/// Same as other_scale(), but in the presence of outliers. The scale is the median of the ratios of corresponding
/// distances in D and H, so up to half of these ratios may be wrong.
std::optional<double> other_scale_by_median(Points p_H, Points p_D, double rounding);

}  // namespace typodont::calibration
