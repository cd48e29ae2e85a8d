// Models of a drill's sound: while idling, while cutting each tissue, and at different speeds.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "audio/ar_model.h"
#include "engine/contract/tissue.h"

namespace typodont::audio {

/// A tone of the rotor, for drills whose rotor was not recorded.
struct RotorTone {
  double multiple = 1;   // frequency relative to the rotor's turns per second
  double amplitude = 0;  // amplitude at free speed, where full scale is 1; proportional to the speed
};

/// Measured level of the sound in one contact, relative to idling at free speed.
struct WorkLevel {
  Tissue tissue = Tissue::kEnamel;
  double force = 0;         // N, force at which the sound was recorded
  double contact_area = 0;  // m², contact area at which the sound was recorded
  double removal_rate = 0;  // m³/s, removal rate at which the sound was recorded
  double spindle = 0;       // rad/s, spindle speed at work
  double level_dB = 0;      // dB, level of the whole sound minus the idle level
  double high_dB = 0;       // dB, level above 4 kHz minus the idle level above 4 kHz
};

/// The models of one drill. Missing models for cutting are derived from the idle model (audio/README.md).
struct SoundModels {
  ArModel idle;
  // Models for cutting each tissue, from recordings; empty for a tissue that was not recorded.
  std::array<std::optional<ArModel>, kTissueCount> working;
  // rad/s, spindle speed in the idle recording; 0: the highest speed of the spindle so far is used instead.
  double free_speed = 0;
  std::vector<RotorTone> tones;
  // Number of cutting edges. At low speed, the impacts of the edges are heard one by one; 0: never.
  double teeth = 0;
  double working_gain = 1;  // factor of the amplitude of all models for cutting
  // Largest amplification of high frequencies by contact: factor 1 + brightness on their amplitude.
  double brightness = 1;
  double spray_dB = 0;  // dB, increase of the idle level by full spray; 0: spray is silent
  double level = 1;     // factor on the amplitude of the whole sound
  std::string name, source, licence;
};

/// Reads a voice file (JSON) and the models that it names, or a model file as the idle model. Throws Error.
SoundModels load_sound_models(const std::filesystem::path& file);

}  // namespace typodont::audio
