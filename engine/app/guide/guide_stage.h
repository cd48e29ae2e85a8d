// Guided capture for a real bench: keyboard and touches in; prompts on the bench's screen, as sound and as text.
// Connects calibration/, which uses no devices, with hands, screen and sound.
#pragma once

#include <filesystem>
#include <string>

#include "calibration/guided_capture.h"
#include "calibration/still_touch.h"

namespace typodont {

struct GuideOptions {
  std::filesystem::path rig;  // its screen and mirror decide how prompts are drawn
  // address of the haptic device; empty: touches from standard input
  std::string hand;
  std::string pedal = "auto";  // "auto", a path, a serial number, or "none"
  bool fast = false;           // scripted hands: as fast as possible, waiting for each prompt
  calibration::StillTouch::Limits still;
  /// if there is a hand, a desktop and support for windows
  bool window = true;
  int monitor = -1;  // number of the monitor for a full-screen window
  /// picture of the prompt before each touch; empty: none
  std::filesystem::path picture;
  std::string audio;  // output for cues; empty: silent
};

enum class GuideEnd { kSolve, kSkip, kStop };

/// Runs until all touches are captured or the user ends it; each is on disk before the next prompt. `device`: model and
/// serial number, or empty without a hand. Throws Error at set-up, RunFailure if the hand disappears.
GuideEnd run_guide(calibration::GuidedCapture& guide, const GuideOptions& options, std::string* device = nullptr);

/// PGM, or PNG with the extension .png.
void write_picture(const std::filesystem::path& file, const calibration::Picture& picture);

}  // namespace typodont
