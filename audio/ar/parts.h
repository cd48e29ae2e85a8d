// The phases of a drill in a recording: run-up, idling, work under load, run-down. Not for real time.
#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "audio/ar_fit.h"

namespace typodont::audio {

/// Divides a sound into its parts, in order of time, by loudness alone. The drill runs up before the first interval of
/// constant level and runs down after the last such interval. Between them the drill idles, except in intervals that
/// are at least 2.5 dB louder, in which it is under load. Empty if the sound is shorter than 0.5 s or has no interval
/// of constant level.
std::vector<SoundPart> parts_of(std::span<const double> x, double rate);

std::optional<DrillPart> drill_part_named(std::string_view name) noexcept;

}  // namespace typodont::audio
