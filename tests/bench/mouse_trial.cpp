// Drills a class I cavity with the mouse alone: the simulated user of mouse_user.h sees the tool in simulated time;
// then xdotool repeats these motions of the pointer in the program's own window, in real time. Takes four minutes.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdio>
#include <thread>

#include "engine/app/assets.h"
#include "engine/app/hands/mouse_hand.h"
#include "engine/base/json.h"
#include "tests/support/desktop.h"
#include "tests/support/mouse_user.h"
#include "tests/support/program.h"

namespace typodont::test {
namespace {

using namespace std::chrono_literals;

TEST(Trial, AClassICavityIsDrilledWithTheMouseAlone) {
  const std::string file = (assets_folder() / "scenes/class-1-cavity.json").string();
  const MouseSession planned =
      drill_with_mouse(read_scene(file), display::load_rig(assets_folder() / "rigs/window.json"), wheel_step_of("0.05"),
                       {.length = 5.2e-3, .width = 1.5e-3, .depth = 2.0e-3}, 175);
  fmt::print("class I by the mouse: {:.1f} points in {:.0f} s\n", planned.score.points, planned.seconds);
  for (const session::ScoreItem& item : planned.score.items)
    if (item.full > 0) fmt::print("  {} {}: {:.1f} of {:.1f}\n", item.name, item.value, item.points, item.full);
  EXPECT_GE(planned.score.points, 75);
  const Desktop desktop({1280, 720});
  ASSERT_GT(desktop.server.process, 0) << "Xvfb is needed (apt install xvfb)";
  const ProgramFolder folder(TYPODONT_PROGRAM);
  const std::string session = folder / "mouse.h5";
  const pid_t child = folder.start(
      fmt::format("run {} --rig window --hand mouse:0.05 --pedal none --audio none: --record {}", file, session),
      fmt::format("DISPLAY={}", std::getenv("DISPLAY")));
  for (int i = 0; i < 600 && Desktop::xdotool("search --name Typodont").empty(); ++i)
    std::this_thread::sleep_for(100ms);
  std::this_thread::sleep_for(3s);  // waits until the picture is shown and its quality no longer changes
  Desktop::xdotool("search --name Typodont windowfocus");

  std::FILE* xdotool = popen("xdotool -", "w");
  ASSERT_TRUE(xdotool);
  const auto began = std::chrono::steady_clock::now();
  MouseStep last;  // drill off, first tool
  for (const MouseStep& step : planned.steps) {
    std::this_thread::sleep_until(began + std::chrono::duration<double>(step.t));
    std::string said = fmt::format("mousemove {} {}\n", step.pixel.x, step.pixel.y);
    for (int i = 0; i < std::abs(step.wheel); ++i)
      said += step.wheel > 0 ? "mousedown 4 mouseup 4\n" : "mousedown 5 mouseup 5\n";
    if (step.left != last.left) said += step.left ? "mousedown 1\n" : "mouseup 1\n";
    if (step.tool != last.tool) said += fmt::format("key {}\n", step.tool + 1);
    last = step;
    std::fputs(said.c_str(), xdotool);
    std::fflush(xdotool);
  }
  std::fputs("mouseup 1\n", xdotool);
  pclose(xdotool);
  const double took = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  expect_ok(folder.finish(child));

  const Ran check = expect_ok(folder.run("replay " + session + " --check --json"));
  const Ran report = expect_ok(folder.run("report " + session + " --json --out " + (folder / "r.html")));
  fmt::print("class I by the mouse, live: {:.0f} s\n{}\n{}\n", took, check.out, report.out);
  EXPECT_LT(took, 180);
}

}  // namespace
}  // namespace typodont::test
