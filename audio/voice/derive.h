// Derives the sound of cutting from the idle model, for drills without a recording of cutting. Parameters were chosen
// by ear.
#pragma once

#include <array>

#include "audio/ar_model.h"
#include "engine/contract/tissue.h"

namespace typodont::audio {

/// Returns one model per tissue, with order and rate of the idle model; air: the idle model itself. Computation: idle
/// spectrum × factors, autocorrelation, Levinson–Durbin.
std::array<ArModel, kTissueCount> derived_working_models(const ArModel& idle);

}  // namespace typodont::audio
