// One page for people: what each step found, its residuals as plots, and the co-location error as a map.
#pragma once

#include <string>

#include "calibration/routine.h"

namespace typodont::calibration {

/// A whole HTML file, nothing outside it.
std::string report_page(const BenchState& bench, const std::string& title);

/// The map of verify alone, as an SVG picture: three levels of the workspace, colour by error.
std::string error_map_svg(const VerifyResult& result);

}  // namespace typodont::calibration
