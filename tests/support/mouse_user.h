// Simulates a user who drills with the mouse alone. The user moves the mouse over the picture, turns its wheel and
// presses its buttons, watches the tool, and continues when the tool has followed.
#pragma once

#include <vector>

#include "engine/app/scene.h"
#include "engine/app/task/task.h"
#include "engine/display/display_rig.h"

namespace typodont::test {

/// State of the mouse at one moment.
struct MouseStep {
  double t = 0;            // s
  glm::ivec2 pixel{0};     // position in the window, from its upper left corner
  int wheel = 0;           // notches, towards the user positive
  bool left = false;       // pressed
  std::uint32_t tool = 0;  // index of the tool that the number keys have selected
};

/// Dimensions of a slot with round ends, as the task's goal states them, m. `depth`: below the old surface on average.
struct SlotSize {
  double length = 0, width = 0, depth = 0;
};

struct MouseSession {
  std::vector<MouseStep> steps;  // thirty per second
  double seconds = 0;
  haptics::TissueVolume tissue;  // the final tissue
  session::Score score;
};

/// Prepares the slot of the scene's task with the tools of the task's steps, in a window of the rig's size. The user
/// knows the slot's size, sees its outline on the tooth before drilling (key D), and then only the drawn tool. Uses the
/// program's pointer, smoothing, servo and carver, in simulated time. `wheel_step`: m per notch of the wheel.
MouseSession drill_with_mouse(const Scene& scene, const display::DisplayRig& rig, double wheel_step,
                              const SlotSize& slot, double max_seconds);

}  // namespace typodont::test
