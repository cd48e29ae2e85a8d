// The sound models of a drill: one for idling, one for work in each tissue, and the parameters of their dependence on
// the spindle's speed.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "audio/ar_model.h"
#include "engine/contract/tissue.h"

namespace typodont::audio {

/// A tone at a multiple of the rotor's frequency. It is used for drills without a recording of this tone.
struct RotorTone {
  double multiple = 1;   // ratio of the tone's frequency to the rotor's turns per second
  double amplitude = 0;  // amplitude at free speed; at lower speeds it is proportional to the speed; full scale is 1
};

/// Levels of a real drill, measured at one contact: the sound at work minus the sound when the drill idles at free
/// speed.
struct WorkLevel {
  Tissue tissue = Tissue::kEnamel;
  double force = 0;         // N, force of the contact at which the sound was recorded
  double contact_area = 0;  // m², contact area at which the sound was recorded
  double removal_rate = 0;  // m³/s, removal rate at which the sound was recorded
  double spindle = 0;       // rad/s, spindle speed at work
  double level_dB = 0;      // dB, level of the whole sound at work minus its level at idle
  double high_dB = 0;       // dB, level above 4 kHz at work minus the level at idle
};

/// Plain data. A missing working model is derived from the idle model by the mapping in audio/README.md ("Working
/// sound without a recording").
struct SoundModels {
  ArModel idle;
  // Working models from recordings; empty if none was recorded.
  std::array<std::optional<ArModel>, kTissueCount> working;
  // rad/s, speed at which the idle model was recorded; 0: unknown, so the highest speed of the spindle so far is used
  double free_speed = 0;
  std::vector<RotorTone> tones;
  // Number of cutting edges (blades) of the bur. At low speed, each edge is heard separately. 0: never separately.
  double teeth = 0;
  double working_gain = 1;  // factor by which the amplitude of all working models is multiplied
  // gain of the additional high frequencies at high force and high removal rate; the value 1 doubles the amplitude of
  // the high frequencies
  double brightness = 1;
  double spray_dB = 0;  // dB, increase of the idling drill's level by water spray; 0: the spray is silent
  double level = 1;     // gain of the whole voice, which makes voices of different recordings equally loud
  std::string name, source, licence;
};

/// Reads a voice file ("kind": "voice") and the model files that it names, or a single model file as an idle voice.
/// Throws Error with the file, the key, the value that was found, and the value that was expected.
SoundModels load_sound_models(const std::filesystem::path& file);

}  // namespace typodont::audio
