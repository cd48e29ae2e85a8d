// Derives the sound of cutting from the idle model, for drills without a recording of cutting. Parameters were chosen
// by ear.
#pragma once

#include <array>

#include "audio/ar_model.h"
#include "engine/contract/tissue.h"

namespace typodont::audio {

/// How a tissue changes the idle sound. Brittle tissue changes level and slope, bone and dentin add a lower resonance,
/// soft tissue damps. See audio/README.md.
struct TissueColour {
  double level_dB;       // dB, power of the sound in this tissue relative to that of the idle sound, both at free speed
  double slope_dB;       // dB per octave, slope of the gain from 200 Hz to 16 kHz, 0 dB at 3 kHz
  double centre;         // Hz, centre frequency of the tissue's resonance
  double resonance_dB;   // dB, gain at the centre of the resonance
  double width_octaves;  // octaves, standard deviation of the Gaussian resonance curve
};
const TissueColour& colour_of(Tissue tissue) noexcept;

/// Returns one model per tissue, with order and rate of the idle model; air: the idle model itself. Computation: idle
/// spectrum × factors, autocorrelation, Levinson–Durbin.
std::array<ArModel, kTissueCount> derived_working_models(const ArModel& idle);

}  // namespace typodont::audio
