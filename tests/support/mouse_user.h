// A user who drills with the mouse alone: moves it over the picture, turns its wheel, presses its buttons. He looks
// where the tool is and goes on once it has followed.
#pragma once

#include <vector>

#include "engine/app/scene.h"
#include "engine/app/task/task.h"
#include "engine/display/display_rig.h"

namespace typodont::test {

/// What the mouse does at one moment.
struct MouseStep {
  double t = 0;         // s
  glm::ivec2 pixel{0};  // of the window, from its upper left
  int wheel = 0;        // notches, towards the user positive
  bool left = false;    // held
  bool middle = false;  // clicked
};

struct MouseSession {
  std::vector<MouseStep> steps;  // thirty a second
  double seconds = 0;
  haptics::TissueVolume tissue;  // as it was left
};

/// Drills the ideal of the scene's task with the tool that is first in its tray, in a window of the rig's size, with
/// the real pointer, smoothing, servo and carver, in simulated time. `wheel_step`: m a notch.
MouseSession drill_with_mouse(const Scene& scene, const display::DisplayRig& rig, double wheel_step,
                              double most_seconds);

}  // namespace typodont::test
