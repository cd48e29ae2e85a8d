// A drill's models: idle, work in each tissue, dependence on the speed.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "audio/ar_model.h"
#include "engine/contract/tissue.h"

namespace typodont::audio {

/// For drills without a recording of the tone.
struct RotorTone {
  double multiple = 1;   // of the rotor's turns per second
  double amplitude = 0;  // at free speed, ∝ speed; full scale 1
};

/// Measured at one contact, against idling at free speed.
struct WorkLevel {
  Tissue tissue = Tissue::kEnamel;
  double force = 0;         // N
  double contact_area = 0;  // m², contact area at which the sound was recorded
  double removal_rate = 0;  // m³/s, removal rate at which the sound was recorded
  double spindle = 0;       // rad/s, spindle speed at work
  double level_dB = 0;      // dB, whole sound
  double high_dB = 0;       // dB, above 4 kHz
};

/// Missing working models are derived from the idle one (audio/README.md).
struct SoundModels {
  ArModel idle;
  // Working models from recordings; empty if none was recorded.
  std::array<std::optional<ArModel>, kTissueCount> working;
  // rad/s of the idle recording; 0: the highest speed so far
  double free_speed = 0;
  std::vector<RotorTone> tones;
  // cutting edges, heard one by one at low speed; 0: never
  double teeth = 0;
  double working_gain = 1;  // factor of all working models' amplitude
  // largest gain of high frequencies; 1 doubles their amplitude
  double brightness = 1;
  double spray_dB = 0;  // dB that spray adds to the idling drill; 0: silent
  double level = 1;     // gain of the whole voice
  std::string name, source, licence;
};

/// A voice file with its models, or a model file as idle voice. Throws Error.
SoundModels load_sound_models(const std::filesystem::path& file);

}  // namespace typodont::audio
