// What a scene does not need is not done: `typodont run` counts its work, kind by kind. What the picture leaves out
// (mono, bodies out of sight, untouched bricks, frames equal to the last) is tested in unit/render_frame_test.cpp.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "engine/base/json.h"
#include "engine/session/session_file.h"
#include "tests/support/desktop.h"
#include "tests/support/program.h"

namespace typodont {
namespace {

class Work : public testing::Test {
 protected:
  /// A block whose top is at z = 200 mm, and parts as named.
  std::string scene(const char* parts, bool cuts = true) {
    return folder.write("scene.json", fmt::format(R"({{"name": "block", "tissue": {{"voxel_mm": 0.25, "solids": [
      {{"tissue": "enamel", "solid": {{"box": {{"center_mm": [25, 0, 196], "size_mm": [10, 10, 8]}}}}}}]}},
      "tool": {{"shape": "sphere", "diameter_mm": 2, "cuts": {}}}, "spindle_krpm": 300, "parts": [{}]}})", cuts, parts));
  }
  /// A hand that goes to and fro by `reach_mm` at a height, the pedal down or not.
  std::string hand(double height_mm, double reach_mm, double pedal, double seconds = 8) {
    std::string csv = "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n";
    for (double t = 0; t <= seconds; t += 0.02) {
      csv += fmt::format("{},{},0,{},1,0,0,0,{}\n", t, 25 + reach_mm * std::sin(3 * t), height_mm, pedal);
    }
    return folder.write("hand.csv", csv);
  }
  Json run(const std::string& what, double seconds, const std::string& more = "") {
    const char* audio = more.find("--audio") == std::string::npos ? "--audio none:" : "";
    const test::Ran ran = folder.run(fmt::format("run {} --hand script:{} --pedal none {} --seconds {} --json {}", what,
                                                 folder / "hand.csv", audio, seconds, more));
    EXPECT_EQ(ran.status, 0) << ran.err;
    said = ran.err;
    return Json::parse(ran.out, "run")["work"];
  }

  test::ProgramFolder folder{TYPODONT_PROGRAM};
  std::string said;
};

TEST_F(Work, AnIdleHandCutsNothingDrawsNothingAndAllocatesNothing) {
  hand(210, 0, 0);
  const Json brief = run(scene("\"haptics\""), 1.5), lasting = run(scene("\"haptics\""), 4.5);
  EXPECT_GT(lasting["ticks"].number(), 2 * brief["ticks"].number());
  for (const char* kind : {"voxels_cut", "voxels_redistanced", "bricks_meshed", "triangles_made", "frames", "passes", "triangles_drawn", "pipelines", "samples", "particles_stepped"}) {
    EXPECT_EQ(lasting[kind].integer(), 0) << kind;
  }
  EXPECT_LE(lasting["patches"].integer(), 2);
  EXPECT_NEAR(lasting["allocations"].number(), brief["allocations"].number(), 20) << "three seconds more allocate nothing";
  EXPECT_LT(lasting["bytes_written"].number(), brief["bytes_written"].number() + 4096);
}

TEST_F(Work, AnIdleSceneTakesLessThanAHundredthOfACoreBeyondTheDevicesLoop) {
  hand(210, 0, 0);
  const Json work = run(scene("\"haptics\""), 5);
  EXPECT_LT(work["cpu_s"].number() - work["servo_cpu_s"].number(), 0.01 * 5);
}

TEST_F(Work, MotionInTheAirIsLookedAtButCutsNothing) {
  hand(208, 8, 1);
  const Json work = run(scene("\"haptics\""), 3);
  EXPECT_GT(work["patches"].integer(), 2) << "the field goes with the tool";
  EXPECT_EQ(work["voxels_cut"].integer(), 0);
}

TEST_F(Work, AToolThatDoesNotCutIsFeltAndLeavesTheTissueAlone) {
  hand(200.8, 2, 1);
  const Json probe = run(scene("\"haptics\"", false), 2);
  EXPECT_EQ(probe["voxels_cut"].integer(), 0);
  EXPECT_GT(probe["queries"].number(), probe["ticks"].number()) << "it is in touch";
  const Json drill = run(scene("\"haptics\"", true), 2);
  EXPECT_GT(drill["voxels_cut"].integer(), 0);
}

TEST_F(Work, SoundIsMadeOnlyWhereItIsNamedAndARecordingTakesOneThreadMore) {
  hand(210, 0, 0);
  const Json silent = run(scene("\"haptics\""), 1), recorded = run(scene("\"haptics\""), 1, "--record " + (folder / "s.h5"));
  EXPECT_EQ(silent["samples"].integer(), 0);
  EXPECT_EQ(recorded["threads"].integer(), silent["threads"].integer() + 1);
  EXPECT_GT(recorded["bytes_written"].number(), silent["bytes_written"].number() + 10'000);
  const Json heard = run(scene("\"haptics\", \"sound\""), 1, "--audio wav:" + (folder / "s.wav"));
  EXPECT_GT(heard["samples"].number(), 20'000);
}

TEST_F(Work, IsToldInWordsWithTheReasonsForWhatIsOff) {
  hand(210, 0, 0);
  run(scene("\"haptics\""), 1, "--explain");
  for (const char* words : {"looks into the field", "voxels re-distanced", "bricks meshed", "libraries loaded", "of a core beyond the device's loop",
                            "recording: off", "sound: off, the scene does not name it", "debris: off"}) {
    EXPECT_NE(said.find(words), std::string::npos) << words << "\n" << said;
  }
}

#ifdef TYPODONT_WINDOW
TEST_F(Work, AWindowThatIsMinimisedDrawsNoFrameAndIsDrawnAgainWhenItIsBack) {
  hand(208, 8, 1, 60);  // to and fro: every frame differs from the last
  const test::Desktop desktop;
  const pid_t child = folder.start(fmt::format("run {} --rig assets/rigs/window.json --hand script:{} --pedal none --audio none: --record {}",
                                               scene("\"haptics\", \"render\""), folder / "hand.csv", folder / "s.h5"),
                                   fmt::format("DISPLAY={}", std::getenv("DISPLAY")));
  std::string window;
  for (int i = 0; i < 300 && window.empty(); ++i, ::usleep(100'000)) window = test::Desktop::xdotool("search --name Typodont");
  window = window.substr(0, window.find('\n'));
  ASSERT_FALSE(window.empty()) << folder.said();
  ::usleep(2'000'000);
  test::Desktop::xdotool("windowunmap " + window);
  ::usleep(4'000'000);
  test::Desktop::xdotool("windowmap " + window);
  ::usleep(2'000'000);
  ASSERT_EQ(folder.finish(child).status, 0) << folder.said();
  const session::SessionReader session(folder / "s.h5");
  const auto picture = std::find_if(session.header().streams.begin(), session.header().streams.end(),
                                    [](const auto& stream) { return stream.name == "picture"; });
  ASSERT_NE(picture, session.header().streams.end());
  const auto& drawn = session.streams()[static_cast<std::size_t>(picture - session.header().streams.begin())].t;
  ASSERT_GT(drawn.size(), 4u);
  std::size_t longest = 1;
  for (std::size_t i = 1; i < drawn.size(); ++i) {
    if (drawn[i] - drawn[i - 1] > drawn[longest] - drawn[longest - 1]) longest = i;
  }
  EXPECT_GT(to_seconds(drawn[longest] - drawn[longest - 1]), 3) << "hidden for four seconds";
  EXPECT_GT(longest, 2u) << "drawn before";
  EXPECT_GT(drawn.size(), longest + 2) << "drawn after";
}
#endif

}  // namespace
}  // namespace typodont
