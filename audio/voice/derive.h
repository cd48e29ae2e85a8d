// Working sounds from the idle model, chosen by ear, for drills without a recording of work.
#pragma once

#include <array>

#include "audio/ar_model.h"
#include "engine/contract/tissue.h"

namespace typodont::audio {

/// Brittle tissue: level and slope. Bone and dentin: lower resonance. Soft tissue: damped. See audio/README.md.
struct TissueColour {
  double level_dB;       // dB of power over idle, at free speed
  double slope_dB;       // dB per octave around 3 kHz, from 200 Hz to 16 kHz
  double centre;         // Hz, centre frequency of the tissue's resonance
  double resonance_dB;   // dB, gain at the centre of the resonance
  double width_octaves;  // octaves, standard deviation of the Gaussian resonance curve
};
const TissueColour& colour_of(Tissue tissue) noexcept;

/// One model per tissue, of the idle model's order and rate (air: the idle model): spectrum × factors, autocorrelation,
/// Levinson–Durbin.
std::array<ArModel, kTissueCount> derived_working_models(const ArModel& idle);

}  // namespace typodont::audio
