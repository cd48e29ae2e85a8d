// Detects pairs that no rigid motion explains: a mirror image, or lengths in different units. Only for the
// registration.
#pragma once

#include <optional>

#include "calibration/solver/agreement.h"

namespace typodont::calibration {

/// True if a mirrored fit explains the pairs far better than a rigid one (F-test at 1 %; flat sets fit both ways
/// equally).
bool mirrored(Points p_H, Points p_D, const Fit& fit, double rounding);

/// Same test as mirrored(), in the presence of outliers: true if, after D is reflected, more pairs agree, or agree
/// more closely.
bool mirror_fits_better(Points p_H, Points p_D, const Fit& fit, const RegistrationOptions& options);

/// Ratio of lengths in D to lengths in H, if a rigid fit with a scale explains the pairs far better and the scale
/// differs by 2 % or more.
std::optional<double> other_scale(Points p_H, Points p_D, const Fit& fit, double rounding);

/// Same as other_scale(), in the presence of outliers: the median over pairs of points tolerates that up to half of
/// them are wrong.
std::optional<double> other_scale_by_median(Points p_H, Points p_D, double rounding);

}  // namespace typodont::calibration
