// Writes the report page of a calibration: the result of each step, its residuals as plots, and the co-location error
// as a map.
#pragma once

#include <string>

#include "calibration/routine.h"

namespace typodont::calibration {

/// Returns the report as a complete HTML file without external resources.
std::string report_page(const BenchState& bench, const std::string& title);

/// Returns the error map of the step `verify` as an SVG picture: three levels of the workspace; colours show the error.
std::string error_map_svg(const VerifyResult& result);

}  // namespace typodont::calibration
