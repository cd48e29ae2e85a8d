// Guided capture on a real bench: a hand's touches go in, prompts come out on the bench's own screen, by sound and in
// words, the keyboard steers. Joins calibration/, which knows no device, to the hands, the screen and the sound.
#pragma once

#include <filesystem>
#include <string>

#include "calibration/guided_capture.h"
#include "calibration/still_touch.h"

namespace typodont {

struct GuideOptions {
  std::filesystem::path rig;   // its screen and mirror say how prompts are drawn
  std::string hand;            // address; empty: touches come from standard input only
  std::string pedal = "auto";  // "none", or as haptics::HandOptions has it
  bool fast = false;           // scripted hands run as fast as they can, and wait for each prompt
  calibration::StillTouch::Limits still;
  bool window = true;             // where there is a hand, a desktop and a build with windows
  int monitor = -1;               // full screen on this one
  std::filesystem::path picture;  // written before each touch; empty: none
  std::string audio;              // address of the cues' output; empty: silent
};

enum class GuideEnd { kSolve, kSkip, kStop };

/// Runs the step of `guide` until it has its touches or somebody ends it. Every touch is on disk when it is answered.
/// `device`, where given: the hand's model and serial, empty without a hand.
/// Throws Error at set-up, RunFailure when the hand is gone before the step is done.
GuideEnd run_guide(calibration::GuidedCapture& guide, const GuideOptions& options, std::string* device = nullptr);

/// PGM, or PNG where the file's name ends so.
void write_picture(const std::filesystem::path& file, const calibration::Picture& picture);

}  // namespace typodont
