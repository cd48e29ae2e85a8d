// Tests recordings that are watched in a window on a desktop in memory: alone, beside another recording, and from
// another position of the eyes. A key ends the program.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <set>
#include <string>
#include <thread>

#include "tests/support/desktop.h"
#include "tests/support/program.h"

namespace typodont::test {
namespace {

using namespace std::chrono_literals;

constexpr glm::ivec2 kScreen{1700, 900};

struct Watched : testing::Test {
  Desktop desktop{kScreen};
  ProgramFolder folder{TYPODONT_PROGRAM};

  void SetUp() override {
    ASSERT_GT(desktop.server.process, 0) << "Xvfb is needed (apt install xvfb)";
    ASSERT_FALSE(Desktop::xdotool("version").empty()) << "xdotool is needed (apt install xdotool)";
    folder.write("block.json",
                 R"({"name": "block", "tissue": {"voxel_mm": 0.1, "solids": [{"tissue": "enamel", "solid":
                     {"box": {"center_mm": [6.8, 5.8, 15], "size_mm": [8, 8, 4]}}}]},
                     "tool": "round_012", "spindle_krpm": 300, "parts": ["haptics", "render", "debris", "record"]})");
    folder.write("hand.csv",
                 "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,6.8,5.8,18,1,0,0,0,1\n1,6.8,5.8,17.2,1,0,0,0,1\n"
                 "2,8,5.8,17.2,1,0,0,0,1\n");
    expect_ok(folder.run("servo {}/block.json --hand {}/hand.csv --out {}/session.h5"));
  }

  /// Returns the number of different colours in a part of the screen. An empty screen has one, a shaded picture has
  /// many.
  std::size_t colours(glm::ivec2 lo, glm::ivec2 hi) const {
    const render::Picture p = desktop.screen(kScreen);
    std::set<std::uint32_t> seen;
    for (int y = lo.y; y < hi.y; ++y)
      for (int x = lo.x; x < hi.x; ++x) seen.insert(p.at(x, y)[0] << 16 | p.at(x, y)[1] << 8 | p.at(x, y)[2]);
    return seen.size();
  }
  /// Shows the recording until Escape is pressed. `drawn` returns true when the picture is on the screen.
  template <class Drawn>
  void watch(const std::string& how, Drawn&& drawn) {
    const std::string session = folder / "session.h5";
    const pid_t player =
        folder.start("replay " + session + " --show " + how, std::string("DISPLAY=") + std::getenv("DISPLAY"));
    bool shown = false;
    for (int i = 0; i < 600 && !shown; ++i) {
      std::this_thread::sleep_for(50ms);
      shown = drawn();
    }
    EXPECT_TRUE(shown) << folder.said();
    Desktop::xdotool("search --name Typodont windowfocus");
    int status = 0;
    pid_t ended = 0;
    for (int i = 0; i < 100 && ended == 0; ++i) {
      Desktop::xdotool("key --delay 60 Escape");
      std::this_thread::sleep_for(200ms);
      ended = ::waitpid(player, &status, WNOHANG);
    }
    if (ended == 0) folder.finish(player, SIGKILL);
    EXPECT_TRUE(ended == player && WIFEXITED(status) && WEXITSTATUS(status) == 0) << folder.said();
  }
};

TEST_F(Watched, ASessionIsShownFromAnotherViewpointAndEndedByAKey) {
  watch("--eye-mm 0,-150,300 --view section", [&] { return colours({0, 0}, {1200, 700}) > 50; });
}

TEST_F(Watched, TwoSessionsAreShownSideBySide) {
  watch("--speed 0.5 --beside " + (folder / "session.h5"), [&] {
    return colours({0, 0}, {780, 440}) > 50 && colours({820, 0}, {1590, 440}) > 50;
  });
}

}  // namespace
}  // namespace typodont::test
