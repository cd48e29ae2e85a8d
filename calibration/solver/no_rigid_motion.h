// Recognises pairs of points that are mirror images or have wrong units; used by the registration.
#pragma once

#include <optional>

#include "calibration/solver/agreement.h"

namespace typodont::calibration {

/// Returns true if the points p_D are a mirror image of p_H (F-test at 1 %); false for flat sets.
bool mirrored(Points p_H, Points p_D, const Fit& fit, double rounding);

/// Returns true if a mirror image fits more pairs, or fits them better. For data with outliers.
bool mirror_fits_better(Points p_H, Points p_D, const Fit& fit, const RegistrationOptions& options);

/// Scale: distances in D / distances in H. Empty unless this scale fits much better than 1 and differs from 1 by ≥ 2 %.
std::optional<double> other_scale(Points p_H, Points p_D, const Fit& fit, double rounding);

/// Like other_scale(), for data with outliers: median over pairs of points of (distance in D / distance in H).
std::optional<double> other_scale_by_median(Points p_H, Points p_D, double rounding);

}  // namespace typodont::calibration
