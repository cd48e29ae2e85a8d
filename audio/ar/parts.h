// Divides a recording into run-up, idle, load and run-down. Not for real time.
#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "audio/ar_fit.h"

namespace typodont::audio {

/// Finds the parts of a recording by level: run-up before the first constant level, run-down after the last; between
/// them, load where the level is 2.5 dB above idle. Empty if shorter than 0.5 s, or without a constant level.
std::vector<SoundPart> parts_of(std::span<const double> x, double rate);

std::optional<DrillPart> drill_part_named(std::string_view name) noexcept;

}  // namespace typodont::audio
