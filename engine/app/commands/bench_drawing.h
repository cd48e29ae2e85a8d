// Draws the plan of a mirror bench with dimensions on one A4 page: side view, top view, table of positions.
#pragma once

#include <string>

#include "engine/base/file_kind.h"
#include "engine/display/rig_plan.h"

namespace typodont {

/// Draws the plan. Returns the bytes of an SVG drawing (FileKind::kDrawing) or a PDF document (FileKind::kDocument).
/// Throws RunFailure if the drawing library fails.
std::string draw_bench(const display::BenchSpec& spec, const display::BenchPlan& plan, FileKind kind);

}  // namespace typodont
