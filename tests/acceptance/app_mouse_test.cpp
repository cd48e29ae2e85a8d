// Tests the mouse as the hand in the program's own window. Reads the result from the recording.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <thread>

#include "engine/base/error.h"
#include "engine/base/units.h"
#include "engine/session/session_file.h"
#include "tests/support/desktop.h"
#include "tests/support/program.h"

namespace typodont::test {
namespace {

using namespace std::chrono_literals;

bool eventually(const std::function<bool()>& condition) {
  for (int i = 0; i < 1200 && !condition(); ++i) std::this_thread::sleep_for(100ms);
  return condition();
}

/// Content of a recording until now.
struct SoFar {
  int presses = 0;    // number of times that the pedal was pressed
  bool down = false;  // it is down
  dvec3 p{0};         // m, W: where the hand is
  std::uint64_t ticks = 0;
};
SoFar so_far(const std::string& file) {
  SoFar found;
  try {
    const session::SessionReader session(file);
    found.ticks = session.tick_count();
    for (const ServoTick& tick : session.ticks(0, found.ticks)) {
      found.presses += tick.pedal > 0 && !found.down;
      found.down = tick.pedal > 0;
      found.p = tick.X_WT.p;
    }
  } catch (const Error&) {  // the file does not exist yet
  }
  return found;
}

/// Three clicks must be three presses. Four notches of the wheel must be exactly four steps along the shank.
void click_and_turn(const std::string& file, double step) {
  const dvec3 shank(0, std::sin(24 * kPi / 180), std::cos(24 * kPi / 180));  // as the mouse holds it at first
  for (int click = 1; click <= 3; ++click) {
    Desktop::xdotool("click 1");
    const auto pressed = [&] {
      const SoFar now = so_far(file);
      return now.presses == click && !now.down;
    };
    EXPECT_TRUE(eventually(pressed)) << click << " " << so_far(file).presses;
  }
  const double before = glm::dot(so_far(file).p, shank);
  for (int notch = 1; notch <= 4; ++notch) {
    Desktop::xdotool("click 4");
    const auto moved = [&] { return glm::dot(so_far(file).p, shank) - before; };
    EXPECT_TRUE(eventually([&] { return std::abs(moved() - notch * step) < 1e-5; })) << notch << " " << moved();
  }
  EXPECT_EQ(so_far(file).presses, 3);
}

TEST(MouseInTheOperatorsWindow, ClicksShorterThanAFrameDrillAndEveryNotchMovesTheToolByItsStep) {
  const Desktop desktop({1280, 800});
  ASSERT_GT(desktop.server.process, 0) << "Xvfb is needed (apt install xvfb)";
  const ProgramFolder folder(TYPODONT_PROGRAM);
  std::filesystem::create_directories(folder / "home/scenes");
  folder.write("home/scenes/zz_ball.json", R"({"name": "ball", "tissue": {"voxel_mm": 0.2, "solids": [
    {"tissue": "dentin", "solid": {"sphere": {"center_mm": [6.8, 5.5, 16], "radius_mm": 2}}}]}, "tool": "round_012",
    "spindle_krpm": 300, "parts": ["haptics", "render"]})");
  const pid_t child = folder.start("", fmt::format("DISPLAY={} HOME={} TYPODONT_HOME={}", std::getenv("DISPLAY"),
                                                   folder.path().string(), folder / "home"));
  EXPECT_TRUE(eventually([] { return !Desktop::xdotool("search --name Typodont").empty(); })) << folder.said();
  std::this_thread::sleep_for(2s);
  Desktop::xdotool("search --name Typodont windowfocus");
  Desktop::xdotool("key --delay 60 ctrl+Up");  // the user's own scenes come last
  std::this_thread::sleep_for(500ms);
  Desktop::xdotool("key --delay 60 F5");  // the mouse is the hand where no device is plugged in
  std::string file;
  EXPECT_TRUE(eventually([&] {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder.path()))
      if (entry.path().extension() == ".h5") file = entry.path().string();
    return !file.empty() && so_far(file).ticks > 500;
  })) << folder.said();
  const dvec3 rests = so_far(file).p;
  Desktop::xdotool("mousemove 640 260");
  EXPECT_TRUE(eventually([&] { return glm::length(so_far(file).p - rests) > 1e-3; }));
  std::this_thread::sleep_for(500ms);
  click_and_turn(file, 0.15e-3);
  const Ran ended = folder.finish(child, SIGTERM);
  EXPECT_NE(ended.status, -1) << ended.err;
}

}  // namespace
}  // namespace typodont::test
