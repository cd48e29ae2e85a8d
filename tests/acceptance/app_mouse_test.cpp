// The mouse as the hand in the program's own window, as its recording tells it.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <thread>

#include "engine/base/error.h"
#include "engine/session/session_file.h"
#include "tests/support/desktop.h"
#include "tests/support/program.h"

namespace typodont::test {
namespace {

using namespace std::chrono_literals;

TEST(MouseInTheWindow, ClicksShorterThanAFrameDrillAndEveryNotchMovesTheToolByItsStep) {
  const Desktop desktop({640, 480});
  ASSERT_GT(desktop.server.process, 0) << "Xvfb is needed (apt install xvfb)";
  const ProgramFolder folder(TYPODONT_PROGRAM);
  folder.write("scene.json", R"({"name": "ball", "tissue": {"voxel_mm": 0.2, "solids": [
    {"tissue": "dentin", "solid": {"sphere": {"radius_mm": 3}}}]}, "tool": "round_012", "spindle_krpm": 300,
    "parts": ["haptics", "render"]})");
  folder.write("rig.json", R"({"display": "window", "screen": {"corners_mm": {"lower_left": [-8, -6, 0],
    "lower_right": [8, -6, 0], "upper_left": [-8, 6, 0]}, "pixels": [640, 480], "layout": "mono"},
    "head": {"eye_center_mm": [0, 0, 300], "ipd_mm": 63}})");
  const std::string file = folder / "s.h5";
  const pid_t child =
      folder.start(fmt::format("run {} --rig {} --hand mouse:0.5 --pedal none --audio none: --record {}",
                               folder / "scene.json", folder / "rig.json", file),
                   fmt::format("DISPLAY={}", std::getenv("DISPLAY")));
  const auto eventually = [](const auto& condition) {
    for (int i = 0; i < 1200 && !condition(); ++i) std::this_thread::sleep_for(100ms);
    return condition();
  };
  /// How often the pedal went down, and how far the tool is from the screen (z of W), so far.
  struct SoFar {
    int presses = 0;
    double z = -1;
    std::uint64_t ticks = 0;
  };
  const auto so_far = [&] {
    SoFar found;
    try {
      const session::SessionReader session(file);
      found.ticks = session.tick_count();
      bool down = false;
      for (const ServoTick& tick : session.ticks(0, found.ticks)) {
        found.presses += tick.pedal > 0 && !down;
        down = tick.pedal > 0;
        found.z = tick.X_WT.p.z;
      }
    } catch (const Error&) {  // not there yet
    }
    return found;
  };
  EXPECT_TRUE(eventually([&] { return so_far().ticks > 500; })) << folder.said();
  Desktop::xdotool("search --name Typodont windowfocus");
  Desktop::xdotool("mousemove 500 100");
  const double before = so_far().z;
  for (int click = 1; click <= 3; ++click) {
    Desktop::xdotool("click 1");
    EXPECT_TRUE(eventually([&] { return so_far().presses == click; })) << click << " " << so_far().presses;
  }
  for (int notch = 1; notch <= 4; ++notch) {
    Desktop::xdotool("click 4");
    EXPECT_TRUE(eventually([&] { return std::abs(so_far().z - (before + notch * 0.5e-3)) < 1e-5; }))
        << notch << " " << so_far().z - before;
  }
  const Ran ended = folder.finish(child);
  EXPECT_EQ(ended.status, 0) << ended.err;
}

}  // namespace
}  // namespace typodont::test
