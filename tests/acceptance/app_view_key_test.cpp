// Tests what key V shows in a live window. The recording shows that each view comes in the right order, however slow
// the computer is.
#include <gtest/gtest.h>

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

/// Returns the views in the recording of a running session, in their order.
std::vector<std::string> views_in(const std::string& file) {
  std::vector<std::string> views;
  try {
    const session::SessionReader session(file);
    for (const session::SessionEvent& event : session.events())
      if (event.kind == session::EventKind::kView) views.push_back(event.text);
  } catch (const Error&) {  // not there yet
  }
  return views;
}

TEST(ViewKey, CyclesThroughSectionXrayDifferenceTemperatureAndTheNaturalView) {
  const Desktop desktop;
  ASSERT_GT(desktop.server.process, 0) << "Xvfb is needed (apt install xvfb)";
  const ProgramFolder folder(TYPODONT_PROGRAM);
  folder.write("scene.json", R"({"name": "ball", "tissue": {"voxel_mm": 0.2, "solids": [
    {"tissue": "dentin", "solid": {"sphere": {"radius_mm": 3}}}]}, "tool": "round_012", "spindle_krpm": 300,
    "parts": ["haptics", "render"], "heat": {},
    "task": {"goal": "a pit", "ideal": {"remove": [{"sphere": {"center_mm": [0, 0, 3], "radius_mm": 1}}]}}})");
  folder.write("hand.csv", "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,0,0,5,1,0,0,0,0\n900,0,0,5,1,0,0,0,0\n");
  folder.write("rig.json", R"({"display": "window", "screen": {"corners_mm": {"lower_left": [-8, -6, 0],
    "lower_right": [8, -6, 0], "upper_left": [-8, 6, 0]}, "pixels": [160, 120], "layout": "mono"},
    "head": {"eye_center_mm": [0, 0, 300], "ipd_mm": 63}})");
  const std::string file = folder / "s.h5";
  const pid_t child =
      folder.start(fmt::format("run {} --rig {} --hand script:{} --pedal none --audio none: --record {}",
                               folder / "scene.json", folder / "rig.json", folder / "hand.csv", file),
                   fmt::format("DISPLAY={}", std::getenv("DISPLAY")));
  const auto eventually = [](const auto& condition) {
    for (int i = 0; i < 1200 && !condition(); ++i) std::this_thread::sleep_for(100ms);
    return condition();
  };
  EXPECT_TRUE(eventually([] { return !Desktop::xdotool("search --name Typodont").empty(); })) << folder.said();
  EXPECT_TRUE(eventually([&] { return std::filesystem::exists(file); })) << folder.said();
  Desktop::xdotool("search --name Typodont windowfocus");
  // Until the ideal is computed, the view "difference" is the ordinary look.
  for (const char* view : {"section", "xray", "difference", "temperature", "look"}) {
    Desktop::xdotool("key --delay 100 v");
    const auto shown = [&] {
      const std::vector<std::string> views = views_in(file);
      return !views.empty() && views.back() == view;
    };
    ASSERT_TRUE(eventually(shown)) << view << "\n" << folder.said();
  }
  EXPECT_EQ(folder.finish(child).status, 0) << folder.said();
}

}  // namespace
}  // namespace typodont::test
