// What a drill does in a recording: run up, idle, work under load, run down. Set-up time.
#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "audio/ar_fit.h"

namespace typodont::audio {

/// The parts of a sound in their order, from loudness alone. A drill runs up before its first even stretch and down
/// after its last one. Between them it idles; stretches that are louder by 2.5 dB or more are under load. Empty where
/// the sound is shorter than 0.5 s or nowhere even.
std::vector<SoundPart> parts_of(std::span<const double> x, double rate);

std::optional<DrillPart> drill_part_named(std::string_view name) noexcept;

}  // namespace typodont::audio
