// Guided capture for the calibration of a real bench. The input comes from the keyboard and from touches (points that
// the user touches with the hand's tip). Prompts appear on the bench's screen, as sound and as text. The module
// calibration/ does not use devices; this file connects it with the hands, the screen and the sound.
#pragma once

#include <filesystem>
#include <string>

#include "calibration/guided_capture.h"
#include "calibration/still_touch.h"

namespace typodont {

struct GuideOptions {
  std::filesystem::path rig;  // rig file; its screen and mirror determine how the prompts are drawn
  // address of the haptic device that the user holds (the hand); empty: touches are read from standard input only
  std::string hand;
  std::string pedal = "auto";  // pedal: "auto", a path, a serial number, or "none"
  bool fast = false;           // true: scripted hands run as fast as possible, and wait for each prompt
  calibration::StillTouch::Limits still;
  /// true: opens a window, if there is a hand and a desktop, and if the program was built with support for windows
  bool window = true;
  int monitor = -1;  // number of the monitor for a full-screen window
  /// file to which a picture of the prompt is written before each touch; empty: no file is written
  std::filesystem::path picture;
  std::string audio;  // address of the sound output for cues; empty: silent
};

enum class GuideEnd { kSolve, kSkip, kStop };

/// Runs the step of `guide` until all its touches are captured or the user ends it. Every touch is written to disk
/// before the next prompt. If `device` is not null, it receives the hand's model and serial number, or an empty text if
/// there is no hand. Throws Error at set-up, and RunFailure if the hand disappears before the step is done.
GuideEnd run_guide(calibration::GuidedCapture& guide, const GuideOptions& options, std::string* device = nullptr);

/// Writes a picture as a PGM file, or as a PNG file if the file's extension is .png.
void write_picture(const std::filesystem::path& file, const calibration::Picture& picture);

}  // namespace typodont
