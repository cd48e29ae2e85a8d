// Tests the command `experiment` as users run it: with a simulated observer, with a person at a window, and with a
// person at a terminal.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <string>
#include <thread>

#include "engine/base/json.h"
#include "tests/support/desktop.h"
#include "tests/support/program.h"

namespace typodont::test {
namespace {

using namespace std::chrono_literals;

class ExperimentCommand : public testing::Test {
 protected:
  ExperimentCommand() {
    folder.write("scene.json", R"({"name": "block", "tissue": {"voxel_mm": 0.25, "solids": [
      {"tissue": "enamel", "solid": {"box": {"size_mm": [8, 8, 6]}}}]},
      "tool": {"shape": "sphere", "diameter_mm": 2, "cuts": false}, "parts": ["haptics", "render"]})");
    folder.write("air.csv", "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,0,0,6,1,0,0,0,0\n900,0,0,6,1,0,0,0,0\n");
    folder.write("press.csv",
                 "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,0,0,4.5,1,0,0,0,0\n0.2,0,0,3.6,1,0,0,0,0\n"
                 "0.4,0,0,4.5,1,0,0,0,0\n");
  }
  /// Returns the number of trials in a log, without its comment and header.
  static long trials_in(const std::string& file) {
    const std::string text = read_text(file);
    return std::max(0L, static_cast<long>(std::count(text.begin(), text.end(), '\n')) - 2);
  }
  ProgramFolder folder{TYPODONT_PROGRAM};
};

TEST_F(ExperimentCommand, ASimulatedObserverIsReproducibleAndItsLogGivesTheSameFit) {
  const std::string command = "experiment " + folder / "scene.json" +
                              " --question force --observer 12 --lapse 0.02 --seed 4 --json --out " + folder / "t.csv";
  const Ran ran = expect_ok(folder.run(command + " --page {}/r.html"));
  const Json told = Json::parse(ran.out, "experiment");
  EXPECT_LT(told["jnd_percent"]["low"].number(), 12);
  EXPECT_GT(told["jnd_percent"]["high"].number(), 12);
  EXPECT_EQ(trials_in(folder / "t.csv"), told["trials"].integer());
  const std::string log = read_text(folder / "t.csv"), page = read_text(folder / "r.html");
  EXPECT_NE(log.find("first_force_percent,second_force_percent,level_percent"), std::string::npos);
  EXPECT_NE(page.find("Which was stronger?"), std::string::npos);
  EXPECT_EQ(folder.run(command).out, ran.out);
  EXPECT_EQ(read_text(folder / "t.csv"), log);
  EXPECT_EQ(folder.run("experiment --json {}/t.csv").out, ran.out);
}

TEST_F(ExperimentCommand, ASensitiveObserverAlwaysChoosesTheSameModelAndAnInsensitiveOneChoosesByChance) {
  const auto fraction = [&](double jnd) {
    const Ran ran = expect_ok(folder.run(fmt::format(
        "experiment {} --question model --models voxel_penalty offset --trials 20 --observer {} --hand {} --json "
        "--out {}",
        folder / "scene.json", jnd, folder / "press.csv", folder / "t.csv")));
    return Json::parse(ran.out, "experiment");
  };
  const Json keen = fraction(0.01), dull = fraction(1e4);
  const double chosen = keen["chosen_percent"]["value"].number();
  EXPECT_TRUE(chosen == 0 || chosen == 100) << "voxels are not felt as a smooth surface is: " << chosen;
  EXPECT_LT(keen["chance"].number(), 1e-5);
  EXPECT_EQ(keen["chosen_percent"]["model"].string(), "offset");
  EXPECT_GT(dull["chance"].number(), 0.01);
}

TEST_F(ExperimentCommand, AStiffSceneIsComparedFromASmallerReference) {
  std::string scene = read_text(folder / "scene.json");
  scene.insert(1, R"("coupling": {"stiffness_N_per_mm": 60}, )");
  folder.write("stiff.json", scene);
  expect_ok(folder.run("experiment {}/stiff.json --observer 12 --out {}/t.csv"));
  EXPECT_NE(read_text(folder / "t.csv").find("\"reference\":5.0"), std::string::npos) << read_text(folder / "t.csv");
}

TEST_F(ExperimentCommand, BadUsageNamesTheOptionAndWritesNothing) {
  const auto refused = [&](const std::string& options, const std::string& words) {
    expect_exit(folder.run("experiment {}/scene.json --out {}/t.csv " + options), 2, words);
    EXPECT_FALSE(std::filesystem::exists(folder / "t.csv")) << options;
  };
  refused("--question taste --observer 5", "--question");
  refused("--question model --models offset offset --observer 5", "two different contact models");
  refused("--question model --models offset packing --observer 5", "--hand");
  refused("--question model --models offset nothing --observer 5", "nothing");
  refused("--question force --reference 120 --observer 5", "--reference");
  refused("--start 1000 --observer 5", "--start");
  refused("--lapse 0.1", "--observer");
  refused("--observer 5 --seconds 3", "a person");
  EXPECT_EQ(folder.run("experiment {}/scene.json --observer 5").status, 2) << "no --out";
}

TEST_F(ExperimentCommand, AtATerminalThePersonTypesAndAnInterruptLeavesTheTrialsSoFar) {
  const std::string live = fmt::format("experiment {} --hand script:{} --audio none: --seconds 0.1 --out {}",
                                       folder / "scene.json", folder / "air.csv", folder / "t.csv");
  const Ran whole =
      expect_ok(folder.run(live + " --trials 3", "printf '1\\n2\\n1\\n' | env -u DISPLAY -u WAYLAND_DISPLAY"));
  EXPECT_EQ(trials_in(folder / "t.csv"), 3);
  EXPECT_EQ(whole.err.find("percent"), std::string::npos) << "nothing tells the person what was shown";
  const Ran brief = folder.run(live, "printf '2\\n2\\n' | env -u DISPLAY -u WAYLAND_DISPLAY");
  EXPECT_EQ(brief.status, 1);
  EXPECT_EQ(trials_in(folder / "t.csv"), 2);
  EXPECT_NE(brief.err.find("after 2 trials"), std::string::npos) << brief.err;
  EXPECT_EQ(folder.run("experiment {}/t.csv").status, 0);
}

#ifdef TYPODONT_WINDOW
TEST_F(ExperimentCommand, InTheWindowArrowKeysAnswer) {
  const Desktop desktop;
  ASSERT_GT(desktop.server.process, 0) << "Xvfb is needed (apt install xvfb)";
  folder.write("rig.json", R"({"display": "window", "screen": {"corners_mm": {"lower_left": [-8, -6, 0],
    "lower_right": [8, -6, 0], "upper_left": [-8, 6, 0]}, "pixels": [320, 240], "layout": "mono"},
    "head": {"eye_center_mm": [0, 0, 300], "ipd_mm": 63}})");
  const pid_t child = folder.start(
      "experiment {}/scene.json --rig {}/rig.json --hand script:{}/air.csv --audio none: --seconds 0.1 --trials 2 "
      "--out {}/t.csv --json",
      fmt::format("DISPLAY={}", std::getenv("DISPLAY")));
  const auto times_asked = [&] {
    const std::string said = folder.said();
    int count = 0;
    for (std::size_t at = 0; (at = said.find("Which was stiffer?", at)) != std::string::npos; ++at) ++count;
    return count;
  };
  for (const char* key : {"Left", "Right"}) {
    const int asked = std::string(key) == "Left" ? 1 : 2;
    for (int i = 0; i < 1200 && times_asked() < asked; ++i) std::this_thread::sleep_for(100ms);
    ASSERT_EQ(times_asked(), asked) << folder.said();
    for (int i = 0; i < 50 && trials_in(folder / "t.csv") < asked; ++i) {
      Desktop::xdotool(fmt::format("key {}", key));
      std::this_thread::sleep_for(200ms);
    }
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_EQ(WEXITSTATUS(status), 0) << folder.said();
  // The program under test has no standard input. It must not use any other file that it opens as standard input.
  const std::string log = read_text(folder / "t.csv");
  EXPECT_NE(log.find(",50,1,"), std::string::npos) << log;
  EXPECT_NE(log.find(",2,"), std::string::npos) << log;
  EXPECT_EQ(trials_in(folder / "t.csv"), 2);
}
#endif

}  // namespace
}  // namespace typodont::test
