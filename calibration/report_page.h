// Report page of a calibration: results, residuals, and the map of the co-location error.
#pragma once

#include <string>

#include "calibration/routine.h"

namespace typodont::calibration {

/// Complete HTML without external files.
std::string report_page(const BenchState& bench, const std::string& title);

/// Map of the co-location error as SVG: three horizontal slices of the workspace.
std::string error_map_svg(const VerifyResult& result);

}  // namespace typodont::calibration
