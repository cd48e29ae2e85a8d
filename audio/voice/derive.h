// Derives the working sound from the idle model, for drills of which no working sound was recorded. The mapping was
// chosen by ear; it is not measured.
#pragma once

#include <array>

#include "audio/ar_model.h"
#include "engine/contract/tissue.h"

namespace typodont::audio {

/// Changes that a tissue makes to the drill's spectrum; see audio/README.md. Hard, brittle tissue breaks in short
/// bursts (higher level and slope). Bone and dentin resonate at lower frequencies. Soft tissue damps high frequencies.
struct TissueColour {
  double level_dB;       // dB, power of the working sound relative to the idle sound, at free speed
  double slope_dB;       // dB per octave, slope of the gain (0 dB at 3 kHz); no slope below 200 Hz and above 16 kHz
  double centre;         // Hz, centre frequency of the tissue's resonance
  double resonance_dB;   // dB, gain at the centre of the resonance
  double width_octaves;  // octaves, standard deviation of the Gaussian resonance curve
};
const TissueColour& colour_of(Tissue tissue) noexcept;

/// Returns one working model per tissue; the model for air is the idle model. The power spectrum of each model is the
/// idle power spectrum times the tissue's factors. The order and the rate are those of the idle model. Each model is
/// stable by construction (autocorrelation, then Levinson–Durbin).
std::array<ArModel, kTissueCount> derived_working_models(const ArModel& idle);

}  // namespace typodont::audio
