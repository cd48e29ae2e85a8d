// The working sound where none was recorded: derived from the idle model by a mapping anyone can read, not measured.
#pragma once

#include <array>

#include "audio/ar_model.h"
#include "engine/contract/tissue.h"

namespace typodont::audio {

/// How a tissue colours the drill's spectrum. Chosen by ear and reason, see audio/README.md: hard, brittle tissue chips
/// in short bursts (level and slope up); bone and dentin ring lower; soft tissue damps.
struct TissueColour {
  double level_dB;       // power of the working sound above the idle one, at free speed
  double slope_dB;       // per octave about 3 kHz, held beyond 200 Hz and 16 kHz
  double centre;         // Hz of the resonance
  double resonance_dB;   // at its centre
  double width_octaves;  // standard deviation
};
const TissueColour& colour_of(Tissue tissue) noexcept;

/// One working model per tissue (air: the idle one itself): the idle model's power spectrum times the tissue's colour,
/// as a model of the same order and rate; stable by construction (autocorrelation, then Levinson).
std::array<ArModel, kTissueCount> derived_working_models(const ArModel& idle);

}  // namespace typodont::audio
