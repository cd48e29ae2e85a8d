// Tests `typodont run` with a headset as users run it, with the test runtime and the real OpenXR loader.
#include <gmock/gmock.h>

#include <algorithm>

#include "engine/base/json.h"
#include "engine/session/session_file.h"
#include "tests/support/program.h"
#include "tests/support/xr_fixture.h"

namespace typodont::test {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr const char* kScene = R"({
  "name": "block", "tool": {"shape": "sphere", "diameter_mm": 1.6}, "spindle_krpm": 300,
  "tissue": {"voxel_mm": 0.2, "band_mm": 1.0,
             "solids": [{"tissue": "dentin", "solid": {"box": {"center_mm": [0, 0, 0], "size_mm": [6, 6, 6]}}}]},
  "parts": ["haptics", "render", "record", "score"]})";

constexpr const char* kRig =
    R"({"display": "hmd", "hmd": {"space": "local", "magnify": 4, "wait_s": 4, "stall_s": 3}})";

// A slow headset, so that a busy machine keeps up. The controller points down, its tip above the work, and goes down. A
// trigger that is down when the session begins counts only after it was released: on a busy machine the session may
// begin after the first press, and a frame that takes longer than 150 ms stops the drill until the trigger is pressed
// again. So the trigger is pressed several times.
const std::string kHeadset = R"("view_size": [96, 64], "paced": true, "period_ms": 25, "prediction_error_mm": 1.5,
  "profile": "/interaction_profiles/oculus/touch_controller",
  "hands": {"right": [{"frame": 0, "p": [0, 1.36, -0.35], "q": [0.70711, -0.70711, 0, 0]},
                      {"frame": 160, "p": [0, 1.36, -0.35], "q": [0.70711, -0.70711, 0, 0], "trigger": 1},
                      {"frame": 210, "p": [0, 1.325, -0.35], "q": [0.70711, -0.70711, 0, 0], "trigger": 1},
                      {"frame": 290, "p": [0, 1.325, -0.35], "q": [0.70711, -0.70711, 0, 0]},
                      {"frame": 300, "p": [0, 1.325, -0.35], "q": [0.70711, -0.70711, 0, 0], "trigger": 1},
                      {"frame": 500, "p": [0, 1.325, -0.35], "q": [0.70711, -0.70711, 0, 0]},
                      {"frame": 510, "p": [0, 1.325, -0.35], "q": [0.70711, -0.70711, 0, 0], "trigger": 1},
                      {"frame": 700, "p": [0, 1.325, -0.35], "q": [0.70711, -0.70711, 0, 0]},
                      {"frame": 710, "p": [0, 1.325, -0.35], "q": [0.70711, -0.70711, 0, 0], "trigger": 1}]})";

struct HeadsetRun : testing::Test {
  XrFixture xr;
  ProgramFolder program{TYPODONT_PROGRAM};
  std::string scene = program.write("scene.json", kScene), rig = program.write("rig.json", kRig);

  Ran run(const std::string& more = "", const std::string& before = "timeout 120") {
    // A fixed quality level, because a change of the level compiles shaders, which stops the picture for up to 0.6 s.
    return program.run(
        fmt::format("run {} --rig {} --quality fast --audio none: --seconds 90 --json {}", scene, rig, more), before);
  }
  static std::string one_line(const std::string& err) {
    EXPECT_EQ(std::count(err.begin(), err.end(), '\n'), 1) << err;
    return err;
  }
};

TEST_F(HeadsetRun, AControllerDrillsWithHapticFeedbackAndIsRecordedUntilTheUserLeaves) {
  // The user leaves once the drill has been felt for 150 frames, however long a busy machine takes for that. At most 50
  // of them lie before the hand goes down to the work.
  xr.script(kHeadset + R"(, "events": [{"frame": 360, "vibrations": 150, "event": "exit"}])");
  const std::string file = program / "session.h5";
  const Ran ran = expect_ok(run("--record " + file));
  const Json json = Json::parse(ran.out, "summary");
  EXPECT_GT(json["frames"].number(), 30);
  // Its work is counted like a screen's.
  const Json work = json["work"];
  EXPECT_EQ(work["frames"].number(), json["frames"].number());
  for (const char* kind : {"passes", "bricks_meshed", "triangles_drawn", "pipelines"})
    EXPECT_GT(work[kind].integer(), 0) << kind;
  EXPECT_GT(json["cuts"].number(), 0);
  EXPECT_GT(json["removed_mm3"].number(), 0.1);
  EXPECT_EQ(xr.violations(), "");
  EXPECT_GT(xr.count("vibration /user/hand/right"), 10);
  EXPECT_EQ(xr.count("vibration /user/hand/left"), 0);
  EXPECT_GT(xr.count("projection+depth"), 30);

  const session::SessionReader session(file);
  EXPECT_FALSE(session.truncated());
  ASSERT_EQ(session.header().streams.size(), 1u);
  const session::StreamData& frames = session.streams()[0];
  EXPECT_GT(frames.t.size(), 30u);
  // The test runtime predicts each head position with an error of 1.5 mm.
  int judged = 0;
  for (const double error : frames.columns[4]) {
    if (!(error >= 0)) continue;
    EXPECT_NEAR(error, 1.5e-3, 1e-5);
    ++judged;
  }
  EXPECT_GT(judged, 20);

  expect_ok(program.run("replay " + file + " --check"));
  ASSERT_EQ(program.run("report " + file + " --out " + (program / "report.html")).status, 0);
  EXPECT_THAT(read_text(program / "report.html"), HasSubstr("Frames in the headset"));
}

TEST_F(HeadsetRun, ExplainStatesTheGpuTimeOfEachPassAndLateFramesInThePeriodOfTheRuntime) {
  xr.script(R"("view_size": [48, 32], "paced": true, "period_ms": 25,
    "hands": {"right": [{"frame": 0, "p": [0, 1.36, -0.35]}, {"frame": 240, "p": [0, 1.40, -0.35]}]},
    "events": [{"frame": 240, "event": "exit"}])");
  const Ran ran = expect_ok(run("--explain"));
  EXPECT_THAT(ran.err,
              HasSubstr(" of 1,000, more than 1.5 × 25.0 ms after the previous one (predicted by the headset's"));
  for (const char* pass : {"whole frame", "shadow", "tissue", "picture"})
    EXPECT_THAT(ran.err, HasSubstr(fmt::format("GPU time, {}: median ", pass)));
}

TEST_F(HeadsetRun, ALostControllerStopsDrillingAndReturnsWithoutAJump) {
  // The trigger is pressed twice before the hand is lost, for a session that begins late (see kHeadset). On a busy
  // machine a frame can take longer than 150 ms; the hand then counts as lost too, and the second press starts the
  // drill again. So the test recognises the scripted loss by the place where the hand returns: 40 mm beside the first
  // place, which is 10 mm in frame W of this magnified rig.
  xr.script(R"("view_size": [96, 64], "paced": true, "period_ms": 25,
    "profile": "/interaction_profiles/valve/index_controller",
    "hands": {"left": [{"frame": 0, "p": [0, 1.36, -0.35], "q": [0.70711, -0.70711, 0, 0]},
                       {"frame": 140, "p": [0, 1.36, -0.35], "q": [0.70711, -0.70711, 0, 0], "trigger": 1},
                       {"frame": 250, "p": [0, 1.36, -0.35], "q": [0.70711, -0.70711, 0, 0]},
                       {"frame": 260, "p": [0, 1.36, -0.35], "q": [0.70711, -0.70711, 0, 0], "trigger": 1},
                       {"frame": 360, "tracked": false},
                       {"frame": 420, "p": [0.04, 1.36, -0.35], "q": [0.70711, -0.70711, 0, 0], "trigger": 1}]},
    "events": [{"frame": 500, "event": "exit"}])");
  const std::string file = program / "session.h5";
  expect_ok(run("--hand openxr:left --record " + file));
  EXPECT_EQ(xr.violations(), "");
  const auto ticks = session::SessionReader(file).ticks();
  ASSERT_GT(ticks.size(), 1000u);
  double longest = 0;
  std::size_t lost = 0, returned = 0, drilled_after = 0;
  bool was_drilling = false;
  dvec3 first_place_W(0);
  for (std::size_t i = 1; i < ticks.size(); ++i) {
    longest = std::max(longest, glm::length(ticks[i].X_WT.p - ticks[i - 1].X_WT.p));
    const bool is_lost = ticks[i].faults & bits(Fault::kDeviceLost);
    if (!was_drilling && ticks[i].pedal > 0.5) {
      was_drilling = true;
      first_place_W = ticks[i].X_WT.p;
    }
    if (is_lost && was_drilling) {
      ++lost;
      EXPECT_EQ(ticks[i].pedal, 0);
    }
    if (was_drilling && !is_lost && glm::length(ticks[i].X_WT.p - first_place_W) > 5e-3) {
      ++returned;
      if (ticks[i].pedal > 0) ++drilled_after;
    }
  }
  EXPECT_TRUE(was_drilling);
  EXPECT_GT(lost, 100u);
  EXPECT_GT(returned, 100u);
  EXPECT_EQ(drilled_after, 0u) << "the trigger was never let go";
  EXPECT_LT(longest, 1e-3);  // 10 mm in 0.4 s
}

TEST_F(HeadsetRun, TheKhronosValidationLayerReportsNothingInASession) {
  // Uses another judge than our test runtime: the validation layer of the package openxr-layer-corevalidation.
  xr.script(kHeadset + R"(, "mask": [[-2, -2], [-0.7, -2], [-0.7, 2]], "blend_modes": ["opaque", "alpha"],
    "events": [{"frame": 15, "event": "stop", "count": 3}, {"frame": 30, "event": "mask"}, {"frame": 32, "event": "recenter"},
               {"frame": 34, "event": "profile"}, {"frame": 60, "event": "exit"}])");
  program.write("rig.json",
                R"({"display": "hmd", "hmd": {"passthrough": true, "refresh_hz": 80, "wait_s": 5, "stall_s": 5}})");
  const std::string found = program / "found.txt";
  const Ran ran = expect_ok(run("",
                                "timeout 120 env XR_ENABLE_API_LAYERS=XR_APILAYER_LUNARG_core_validation "
                                "XR_CORE_VALIDATION_EXPORT_TYPE=text XR_CORE_VALIDATION_FILE_NAME=" +
                                    found));
  EXPECT_THAT(ran.out + ran.err, HasSubstr("Core Validation output type: text"));  // it was there
  EXPECT_EQ(read_text(found), "");
  EXPECT_EQ(xr.violations(), "");
}

TEST_F(HeadsetRun, ASceneWithSoftGumRuns) {
  xr.script(kHeadset + R"(, "events": [{"frame": 40, "event": "exit"}])");
  scene = "class-2-cavity";
  const Ran ran = expect_ok(run());
  EXPECT_GT(Json::parse(ran.out, "summary")["frames"].number(), 1);
  EXPECT_EQ(xr.violations(), "");
}

TEST_F(HeadsetRun, AButtonSelectsTheNextTool) {
  program.write("scene.json", R"({"name": "tray", "tools": ["round_012", "cylinder_010", "round_014"],
    "tissue": {"voxel_mm": 0.2, "band_mm": 1.0,
               "solids": [{"tissue": "dentin", "solid": {"box": {"center_mm": [0, 0, 0], "size_mm": [6, 6, 6]}}}]},
    "parts": ["haptics", "render", "record"]})");
  // On a busy machine, the session may begin late, or a frame may take so long that the runtime skips a press. So the
  // button is pressed several times, and the first press that arrives counts.
  xr.script(R"("view_size": [96, 64], "paced": true, "period_ms": 25,
    "profile": "/interaction_profiles/oculus/touch_controller",
    "hands": {"right": [{"frame": 0, "p": [0, 1.36, -0.35]},
                        {"frame": 60, "p": [0, 1.36, -0.35], "buttons": ["a/click"]},
                        {"frame": 100, "p": [0, 1.36, -0.35]},
                        {"frame": 160, "p": [0, 1.36, -0.35], "buttons": ["a/click"]},
                        {"frame": 200, "p": [0, 1.36, -0.35]},
                        {"frame": 260, "p": [0, 1.36, -0.35], "buttons": ["a/click"]},
                        {"frame": 300, "p": [0, 1.36, -0.35]},
                        {"frame": 360, "p": [0, 1.36, -0.35], "buttons": ["a/click"]},
                        {"frame": 400, "p": [0, 1.36, -0.35]}]},
    "events": [{"frame": 420, "event": "exit"}])");
  const std::string file = program / "session.h5";
  expect_ok(run("--record " + file));
  const auto ticks = session::SessionReader(file).ticks();
  ASSERT_FALSE(ticks.empty());
  EXPECT_EQ(ticks.front().tool, 0u);
  const auto changed = std::ranges::find_if(ticks, [](const auto& tick) { return tick.tool != 0; });
  ASSERT_NE(changed, ticks.end());
  EXPECT_EQ(changed->tool, 1u);
}

TEST_F(HeadsetRun, TouchesAtTheControllersTipRegisterTheArmToTheHeadset) {
  // X_WH: pose of the arm's base in the workbench. X_DH: pose of the same base in the headset's space, turned and
  // shifted.
  const Pose X_WH{{0.01, -0.02, 0.05}, {1, 0, 0, 0}},
      X_DH{{0.2, 1.1, -0.4}, glm::normalize(dquat(0.9, -0.3, 0.2, 0.1))};
  const std::vector<dvec3> points{{0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0.02}, {0.03, 0, 0.1}};
  std::string hand = "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n", keys;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const dvec3 w = (X_WH * points[k]) * 1e3, d = X_DH * points[k] + dvec3(0, 0, 0.06);  // the tip is 60 mm ahead of it
    for (const double at : {0.05, 2.95})
      hand += fmt::format("{},{},{},{},1,0,0,0,0\n", 3 * static_cast<double>(k) + at, w.x, w.y, w.z);
    for (const auto& [frame, trigger] : {std::pair{1, 0}, std::pair{90, 1}, std::pair{104, 0}, std::pair{118, 0}})
      keys += fmt::format("{}{{\"frame\": {}, \"p\": [{}, {}, {}], \"trigger\": {}}}", keys.empty() ? "" : ", ",
                          120 * k + static_cast<std::size_t>(frame), d.x, d.y, d.z, trigger);
  }
  program.write("rig.json", R"({"display": "hmd", "hmd": {"wait_s": 5, "stall_s": 5},
                               "X_WH": {"translation_mm": [10, -20, 50], "rotation_wxyz": [1, 0, 0, 0]}})");
  xr.script(R"("view_size": [48, 32], "paced": true, "period_ms": 25,
    "hands": {"right": [)" +
            keys + R"(]}, "events": [{"frame": 480, "event": "exit"}])");
  const std::string pairs = program / "pairs.csv", reg = program / "reg.json";
  const Ran ran = expect_ok(run("--hand script:" + program.write("arm.csv", hand) + " --touches " + pairs));
  EXPECT_EQ(xr.violations(), "");
  ASSERT_EQ(program.run("calibrate register --pairs " + pairs + " --out " + reg).status, 0)
      << read_text(pairs) << ran.err;
  const Json found = Json::load(reg);
  const dvec3 p = found["X_DH"]["translation_mm"].vec3() * 1e-3;
  EXPECT_LT(glm::length(p - X_DH.p), 1e-4) << read_text(pairs);
  const std::vector<double> q = found["X_DH"]["rotation_wxyz"].numbers(4);
  EXPECT_GT(std::abs(glm::dot(dquat(q[0], q[1], q[2], q[3]), X_DH.R)), 1 - 1e-7);
  EXPECT_GE(found["inliers"].items().size(), 3u);  // on a starved machine a touch may not count as still
  // And the rig takes it over.
  program.write("rig.json", R"({"display": "hmd", "hmd": {"registration": "reg.json", "wait_s": 5, "stall_s": 5}})");
  xr.script(R"("view_size": [48, 32], "paced": true, "events": [{"frame": 20, "event": "exit"}])");
  const Ran again = expect_ok(run("--explain --hand script:" + (program / "arm.csv")));
  EXPECT_THAT(again.err, HasSubstr("STAGE, measured"));
  EXPECT_EQ(run("--touches " + pairs).status, 2) << "a controller is the hand";
}

TEST_F(HeadsetRun, AnUnwritableFileForTouchesIsRefusedBeforeTheSession) {
  xr.script(R"("view_size": [48, 32], "paced": true, "period_ms": 25, "events": [{"frame": 200, "event": "exit"}])");
  const std::string arm =
      program.write("arm.csv", "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,0,0,9,1,0,0,0,0\n60,0,0,9,1,0,0,0,0\n");
  const std::string session = program / "session.h5", tissue = program / "tissue.vdb";
  expect_exit(run(fmt::format("--hand script:{} --touches {} --record {} --save {}", arm, program / "nowhere/pairs.csv",
                              session, tissue)),
              2, "nowhere/pairs.csv");
  EXPECT_FALSE(std::filesystem::exists(session));
  EXPECT_FALSE(std::filesystem::exists(tissue));
}

TEST_F(HeadsetRun, AHangingRuntimeFailsTheRunAndTheRecordingIsSaved) {
  for (const char* call : {"xrWaitFrame", "xrEndFrame"}) {
    xr.script(kHeadset +
              fmt::format(R"(, "events": [{{"frame": 30, "event": "stall", "call": "{}", "seconds": 100}}])", call));
    const std::string file = program / (std::string(call) + ".h5");
    const Ran ran = expect_exit(run("--record " + file), 1, "error: headset: the runtime has not answered for");
    EXPECT_THAT(ran.err, HasSubstr(call));
    const session::SessionReader session(file);
    EXPECT_FALSE(session.truncated());
    EXPECT_GT(session.tick_count(), 300u);
  }
}

TEST_F(HeadsetRun, ALostRuntimeFailsTheRunAndTheRecordingIsSaved) {
  for (const char* event : {"session_lost", "loss_pending", "instance_lost", "instance_loss_pending"}) {
    xr.script(kHeadset + fmt::format(R"(, "events": [{{"frame": 30, "event": "{}"}}])", event));
    const std::string file = program / (std::string(event) + ".h5");
    expect_exit(run("--record " + file), 1, "headset: ");
    EXPECT_FALSE(session::SessionReader(file).truncated()) << event;
    EXPECT_EQ(xr.violations(), "") << event;
  }
}

TEST_F(HeadsetRun, AMissingRuntimeHeadsetOrUserIsReportedInOneLine) {
  const auto refused = [&](const std::string& what, const std::string& before = "timeout 60") {
    const Ran ran = run("", before);
    EXPECT_EQ(ran.status, 2) << what;
    EXPECT_THAT(one_line(ran.err), HasSubstr(what));
    EXPECT_EQ(xr.violations(), "");
  };
  xr.script("");
  refused("no runtime", "timeout 60 env XR_RUNTIME_JSON=/nowhere/runtime.json");
  // An empty file takes the place of the OpenXR loader's library.
  program.write("libopenxr_loader.so.1", "");
  refused("sudo apt install libopenxr-loader1", "timeout 60 env LD_LIBRARY_PATH=" + program.path().string());
  xr.script("\"headset\": false");
  refused("no headset");
  xr.script("\"asleep\": true");
  refused("asleep for 4 s");
  xr.script("\"extensions\": []");
  refused("no XR_KHR_vulkan_enable2");
  xr.script(R"("events": [{"state": "CREATED", "event": "stall", "call": "xrGetSystem", "seconds": 100}])");
  refused("no answer of the runtime for 4 s (in xrGetSystem)");
}

TEST_F(HeadsetRun, AControllerWithoutAHeadsetIsRefused) {
  const Ran ran =
      program.run(fmt::format("run {} --hand openxr:right --audio none: --seconds 1", scene), "env -u DISPLAY");
  EXPECT_EQ(ran.status, 2);
  EXPECT_THAT(one_line(ran.err), HasSubstr("openxr:right"));
  const Ran both = program.run(fmt::format("run {} --rig {} --hand openxr:both", scene, rig));
  EXPECT_EQ(both.status, 2);
  EXPECT_THAT(one_line(both.err), HasSubstr("openxr:left"));
}

TEST(OpenXrLoader, IsNeitherLinkedNorLoadedUnlessAHeadsetIsAskedFor) {
  ProgramFolder program(TYPODONT_PROGRAM);
  const std::string listed = program / "needed";
  ASSERT_EQ(std::system(fmt::format("readelf -d {} > {}", TYPODONT_PROGRAM, listed).c_str()), 0);
  EXPECT_THAT(read_text(listed), HasSubstr("NEEDED"));
  EXPECT_THAT(read_text(listed), Not(HasSubstr("openxr")));
  const std::string hand =
      program.write("hand.csv", "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,0,0,9,1,0,0,0,0\n0.2,0,0,9,1,0,0,0,0\n");
  const std::string scene = program.write("scene.json", kScene);
  const Ran ran = expect_ok(
      program.run(fmt::format("run {} --hand script:{} --audio none:", scene, hand), "env -u DISPLAY LD_DEBUG=files"));
  EXPECT_THAT(ran.err, HasSubstr("libvulkan"));
  EXPECT_THAT(ran.err, Not(HasSubstr("openxr")));
}

}  // namespace
}  // namespace typodont::test
