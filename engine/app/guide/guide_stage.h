// Guided capture on a real bench: input from a hand's touches and the keyboard; prompts on the bench's screen, as sound
// and as text. Connects calibration/, which does not use devices, with the hands, the screen and the sound.
#pragma once

#include <filesystem>
#include <string>

#include "calibration/guided_capture.h"
#include "calibration/still_touch.h"

namespace typodont {

struct GuideOptions {
  std::filesystem::path rig;   // rig file; its screen and mirror determine how the prompts are drawn
  std::string hand;            // address; empty: touches come only from standard input
  std::string pedal = "auto";  // address of the pedal, as in haptics::HandOptions, or "none"
  bool fast = false;           // true: scripted hands run as fast as possible, and wait for each prompt
  calibration::StillTouch::Limits still;
  bool window = true;             // opens a window, if there is a hand, a desktop and a build with windows
  int monitor = -1;               // monitor for full screen
  std::filesystem::path picture;  // file to which a picture is written before each touch; empty: none
  std::string audio;              // address of the sound output for cues; empty: silent
};

enum class GuideEnd { kSolve, kSkip, kStop };

/// Runs the step of `guide` until it has its touches or the user ends it. Every touch is written to disk before the
/// next prompt. `device`, if not null, receives the hand's model and serial number, or an empty text if there is no
/// hand. Throws Error at set-up, and RunFailure if the hand disappears before the step is done.
GuideEnd run_guide(calibration::GuidedCapture& guide, const GuideOptions& options, std::string* device = nullptr);

/// Writes a PGM file, or a PNG file if the file's extension is .png.
void write_picture(const std::filesystem::path& file, const calibration::Picture& picture);

}  // namespace typodont
