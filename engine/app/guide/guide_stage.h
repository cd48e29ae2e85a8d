// Guided capture on a real bench. Input: keyboard and touches; output: prompts on the bench's screen, as sound and as
// text. Connects calibration/, which uses no devices, with hands, screen and sound.
#pragma once

#include <filesystem>
#include <string>

#include "calibration/guided_capture.h"
#include "calibration/still_touch.h"

namespace typodont {

struct GuideOptions {
  std::filesystem::path rig;  // rig file; its screen and mirror determine the prompts' layout
  // Haptic device's address; empty: touches are read from standard input.
  std::string hand;
  std::string pedal = "auto";  // "auto", a path, a serial number, or "none"
  bool fast = false;           // true: scripted hands move fast, but wait for prompts
  calibration::StillTouch::Limits still;
  /// True: opens a window if there are a hand, a desktop and support for windows.
  bool window = true;
  int monitor = -1;  // monitor number for a full-screen window; -1: not full-screen
  /// File to which the picture of the prompt is written before each touch; empty: none.
  std::filesystem::path picture;
  std::string audio;  // audio output for the guide's sounds; empty: silent
};

enum class GuideEnd { kSolve, kSkip, kStop };

/// Runs until all touches are captured or the user ends it. Each touch is on disk before the next prompt. `device`
/// receives model and serial number; empty without a device. Throws Error at set-up, RunFailure if the device
/// disappears.
GuideEnd run_guide(calibration::GuidedCapture& guide, const GuideOptions& options, std::string* device = nullptr);

/// Writes a picture as PGM, or as PNG if the file's extension is .png.
void write_picture(const std::filesystem::path& file, const calibration::Picture& picture);

}  // namespace typodont
