// Tests the single steps of calibration, their files, and the guided capture.
#include <gtest/gtest.h>

#include <fstream>

#include "calibration/bench_simulator.h"
#include "calibration/calibration_files.h"
#include "calibration/guided_capture.h"
#include "calibration/report_page.h"
#include "calibration/rig_file.h"
#include "engine/base/json.h"
#include "tests/support/folder.h"

namespace typodont::calibration {
namespace {

using test::Folder, test::refusal;

TEST(RigGeometry, AWiderEyeDistanceBringsThePointNearer) {
  // numbers.md: IPD +1 mm at 50 mm from the screen plane, 500 mm away: -0.70 mm of depth (without a mirror).
  RigGeometry truth, believed;
  truth.eyes.center = believed.eyes.center = {0, 0, 0.5};
  believed.eyes.ipd = truth.eyes.ipd + 1e-3;
  EXPECT_NEAR(perceived(believed, truth, dvec3(0, 0, 0.05)).z - 0.05, 0.70e-3, 0.03e-3);
}

TEST(RigGeometry, AnEyeSeesAPixelOfABentPanelInACurvedMirrorAlongTheLineOfSightThatEndsInThisPixel) {
  Noise random(7);
  for (int n = 0; n < 200; ++n) {
    RigGeometry rig = BenchSimulator({.seed = static_cast<std::uint64_t>(n + 1)}).truth();
    rig.panel.bow = random.in_box(dvec3(-2e-3), dvec3(2e-3));
    rig.mirror->curvature = random.in_box(dvec3(-0.2), dvec3(0.2));
    rig.mirror->middle = random.in_box(dvec3(-0.1), dvec3(0.1));
    const PanelPoint pixel{random.uniform(0, 1), random.uniform(0, 1)};
    const dvec3 eye = rig.eyes.left_eye(), seen = rig.appears(pixel.u, pixel.v, eye);
    const PanelPoint found = pixel_for(rig, eye, eye + random.uniform(0.3, 1.2) * (seen - eye));
    EXPECT_NEAR(found.u, pixel.u, 1e-7);
    EXPECT_NEAR(found.v, pixel.v, 1e-7);
    rig.mirror->curvature = dvec3(0), rig.panel.bow = dvec3(0);
    EXPECT_LT(glm::distance(rig.appears(pixel.u, pixel.v, eye), rig.mirror->reflect(rig.panel.at(pixel.u, pixel.v))),
              1e-15);
  }
}

TEST(ArmGeometry, TheTipMovesWithEachParameterAsItsDerivativesSay) {
  Noise random(4);
  const auto scales = arm_parameter_scales();
  for (int pose = 0; pose < 20; ++pose) {
    auto parameters = to_vector(ArmGeometry{});
    for (std::size_t p = 0; p < parameters.size(); ++p) parameters[p] += random.uniform(-5, 5) * scales[p];
    ArmReading reading;
    for (double& angle : reading.angle) angle = random.uniform(-1.5, 1.5);
    const auto slopes = tip_derivatives(to_geometry(parameters), reading);
    for (std::size_t p = 0; p < parameters.size(); ++p) {
      auto more = parameters, less = parameters;
      more[p] += 1e-6, less[p] -= 1e-6;
      const dvec3 moved = (tip_position(to_geometry(more), reading) - tip_position(to_geometry(less), reading)) / 2e-6;
      EXPECT_LT(glm::length(moved - slopes[p]), 1e-8) << arm_parameter_names()[p];
    }
  }
}

TEST(Panel, ThreeMarksOnOneLineAreNotEnough) {
  const std::vector<MarkTouch> touches{{{0, 0.5}, {0, 0, 0}}, {{0.5, 0.5}, {0.1, 0, 0}}, {{1, 0.5}, {0.2, 0, 0}}};
  EXPECT_NE(solve_panel(touches).not_determined, "");
}

TEST(Mirror, TouchesOnALineDoNotDetermineItsTilt) {
  std::vector<dvec3> touches;
  Noise random(1);
  for (int i = 0; i < 20; ++i) touches.push_back(dvec3(0.01 * i, 0, 0) + random.normal3(2e-4));
  EXPECT_NE(solve_mirror(touches, dvec3(0, 1, 0)).not_determined, "");
}

TEST(Mirror, TheRadiusOfTheStylusBallIsSubtracted) {
  std::vector<dvec3> touches;
  for (int i = 0; i < 9; ++i) touches.push_back(dvec3(0.05 * (i % 3), 0.103, 0.05 * (i / 3)));
  const MirrorResult result = solve_mirror(touches, dvec3(0, 1, 0), 0.003);
  EXPECT_NEAR(result.mirror.offset, 0.1, 1e-12);
  EXPECT_NEAR(result.mirror.normal.y, 1, 1e-12);
}

TEST(Eyes, AlignmentsAtOneDepthDoNotDetermineTheDistance) {
  BenchSimulator bench({});
  RigGeometry rig = bench.truth();
  std::vector<EyeAlignment> alignments;
  Noise random(3);
  for (int i = 0; i < 40; ++i) {
    const bool right = i % 2;
    const dvec3 eye = right ? rig.eyes.right_eye() : rig.eyes.left_eye();
    // All touched points are within a millimetre of the panel's image. So these alignments do not determine the
    // direction in which the eye sees.
    const PanelPoint dot{random.uniform(0.45, 0.55), random.uniform(0.45, 0.55)};
    const dvec3 image = rig.appears(dot.u, dot.v, eye);
    alignments.push_back({right, dot, image + 1e-3 * glm::normalize(eye - image) + random.normal3(2e-4)});
  }
  rig.eyes.center += dvec3(0.01, -0.02, 0.01);
  EXPECT_NE(solve_eyes(alignments, rig).not_determined, "");
}

TEST(Eyes, TheUsersOffsetIsMeasuredWithinItsUncertainty) {
  std::vector<SeenTouch> touches;
  Noise random(4);
  for (int i = 0; i < 60; ++i) {
    const dvec3 p = random.in_box(dvec3(-0.05), dvec3(0.05));
    touches.push_back({p, p + dvec3(0.001, -0.002, 0.003) + random.normal3(1e-4)});
  }
  const UserOffset offset = user_offset_of(touches);
  for (int axis = 0; axis < 3; ++axis)
    EXPECT_NEAR(offset.W[axis], dvec3(0.001, -0.002, 0.003)[axis], 4 * offset.sigma[axis]);
}

TEST(Verify, DistinguishesPassFailAndTooFewPoints) {
  Noise random(5);
  const auto judged = [&](int count, const dvec3& bias) {
    std::vector<dvec3> h, d;
    for (int i = 0; i < count; ++i) {
      d.push_back(random.in_box(dvec3(-0.04), dvec3(0.04)));
      h.push_back(d.back() + bias + random.normal3(2e-4));
    }
    return verify(h, d, Pose{}, {0.2e-3, 0.5e-3}, {dvec3(-0.04), dvec3(0.04)});
  };
  EXPECT_TRUE(judged(200, dvec3(0)).pass);
  EXPECT_FALSE(judged(200, dvec3(0.5e-3, 0, 0)).pass);
  EXPECT_NEAR(judged(200, dvec3(0.5e-3, 0, 0)).rms, 0.5e-3, 0.1e-3);
  EXPECT_NE(judged(3, dvec3(0)).verdict.find("not enough"), std::string::npos);
}

TEST(Drift, AMovedMirrorIsDetectedAndHandNoiseIsNot) {
  Noise random(6);
  const std::vector<dvec3> then{{0, 0, 0}, {0.3, 0, 0}, {0, 0.2, 0}};
  int false_alarms = 0;
  for (int run = 0; run < 300; ++run) {
    std::vector<dvec3> before = then, now = then;
    for (dvec3& p : before) p += random.normal3(2e-4);
    for (dvec3& p : now) p += random.normal3(2e-4);
    false_alarms += check_drift(before, now, 2e-4, dvec3(0)).drifted;
    for (dvec3& p : now) p += dvec3(0, 0.002, 0);
    EXPECT_TRUE(check_drift(before, now, 2e-4, dvec3(0)).drifted);
  }
  EXPECT_LE(false_alarms, 9);  // 1 % expected
}

TEST(RigFile, KeepsUnknownKeys) {
  const Folder folder;
  std::ofstream(folder / "rig.json") << R"({"display": "mirror", "note": {"who": "keeps this"},
    "screen": {"corners_mm": {"lower_left": [0,0,0], "lower_right": [300,0,0], "upper_left": [0,200,0]}, "pixels": [1920,1080], "layout": "side_by_side"},
    "head": {"eye_center_mm": [0,300,400], "ipd_mm": 63, "right": [1,0,0], "tracker": "opentrack:4242"}})";
  RigFile rig = RigFile::load(folder / "rig.json");
  BenchState bench = rig.bench();
  EXPECT_NEAR(bench.rig.panel.lower_right.x, 0.3, 1e-15);
  EXPECT_FALSE(bench.rig.mirror.has_value());
  bench.rig.X_WH = {{0.01, 0.02, 0.03}, glm::normalize(dquat(1, 2, 3, 4))};
  rig.set(bench);
  rig.set_device("arm", "WH-007");
  rig.save();
  const Json json = Json::load(folder / "rig.json");
  EXPECT_EQ(json["note"]["who"].string(), "keeps this");
  EXPECT_EQ(json["head"]["tracker"].string(), "opentrack:4242");
  EXPECT_EQ(json["calibration"]["devices"]["arm"].string(), "WH-007");
  EXPECT_TRUE(json["calibration"].has("date"));
  const Pose X = RigFile::load(folder / "rig.json").bench().rig.X_WH;
  EXPECT_LT(
      glm::length(X.p - bench.rig.X_WH.p) +
          glm::length(dvec3(X.R.x, X.R.y, X.R.z) - dvec3(bench.rig.X_WH.R.x, bench.rig.X_WH.R.y, bench.rig.X_WH.R.z)),
      1e-15);
}

TEST(RigFile, EyesAndPanelsThatNoBenchHasAreNotWrittenAndTheLikelyCauseIsNamed) {
  const Folder folder;
  std::ofstream(folder / "rig.json") << "{}";
  RigFile rig = RigFile::load(folder / "rig.json");
  BenchState swapped = rig.bench();
  swapped.rig.eyes.ipd = 3.34;
  EXPECT_NE(refusal([&] { rig.set(swapped); }).find("left and the right eye exchanged"), std::string::npos);
  BenchState in_metres = rig.bench();
  in_metres.rig.panel = {{0, 0, 0}, {0.53e-3, 0, 0}, {0, 0.3e-3, 0}};
  EXPECT_NE(refusal([&] { rig.set(in_metres); }).find("metres instead of mm"), std::string::npos);
  rig.save();
  EXPECT_NEAR(RigFile::load(folder / "rig.json").bench().rig.eyes.ipd, 0.063, 1e-12);
}

TEST(RigFile, AnArmThatReadsThreePercentLongInOneAxisIsNoticedByThePixelsOfThePanel) {
  const Folder folder;
  std::ofstream(folder / "rig.json") << R"({"screen": {"pixels": [1920, 1080]}})";
  RigFile rig = RigFile::load(folder / "rig.json");
  for (const std::uint64_t seed : {1, 2, 3, 4, 5, 6}) {
    BenchSimulator simulator({.seed = seed, .arm_errors = false});
    for (const dvec3 scale : {dvec3(1), dvec3(1, 1.03, 1), dvec3(1, 0.97, 1), dvec3(1.03)}) {
      BenchState bench = simulator.drawings();
      Captures captures;
      simulator.capture_screen(captures, bench);
      for (MarkCapture& capture : captures.marks) {
        capture.touch.reading.reset();  // an arm without joint angles
        capture.touch.p_H *= scale;
      }
      captures.mirror.clear();
      solve_screen_step(bench, captures);
      const bool skewed = scale != dvec3(scale.x);
      const std::string said = refusal([&] { rig.set(bench); });
      EXPECT_EQ(said.find("does the arm read") != std::string::npos, skewed) << seed << ": " << said;
    }
  }
}

TEST(CaptureFiles, EverythingWrittenIsReadBackToTheLastBit) {
  const Folder folder;
  const SimulatedRoutine run = simulate_routine({});
  write_captures(folder / "captures", run.captures);
  const Captures again = read_captures(folder / "captures");
  ASSERT_EQ(again.arm.size(), run.captures.arm.size());
  ASSERT_EQ(again.eyes.size(), run.captures.eyes.size());
  ASSERT_EQ(again.registration.size(), run.captures.registration.size());
  EXPECT_EQ(again.arm.back().reading.angle, run.captures.arm.back().reading.angle);
  EXPECT_EQ(again.arm.front().known.has_value(), run.captures.arm.front().known.has_value());
  EXPECT_EQ(again.registration[7].dots->left.u, run.captures.registration[7].dots->left.u);
  // So every step can be solved again.
  BenchState bench = BenchSimulator({}).drawings();
  solve_all(bench, again);
  EXPECT_LT(glm::length(bench.rig.X_WH * dvec3(0.1, 0, 0.1) - run.bench.rig.X_WH * dvec3(0.1, 0, 0.1)), 1e-4);
}

TEST(CaptureFiles, MistakesNameFileLineAndColumn) {
  const Folder folder;
  std::ofstream(folder / "pairs.csv") << "hx_mm,hy_mm,hz_mm,dx_mm,dy_mm,dz_mm\n1,2,3,4,5,6\n1,2,nan,4,5,6\n";
  const std::string nan = refusal([&] { read_pairs(folder / "pairs.csv"); });
  EXPECT_NE(nan.find("pairs.csv"), std::string::npos) << nan;
  EXPECT_NE(nan.find("line 3"), std::string::npos) << nan;
  EXPECT_NE(nan.find("hz_mm"), std::string::npos) << nan;
  std::ofstream(folder / "empty.csv") << "hx_mm,hy_mm,hz_mm,dx_mm,dy_mm,dz_mm\n";
  EXPECT_NE(refusal([&] { read_pairs(folder / "empty.csv"); }).find("no rows"), std::string::npos);
  std::ofstream stream(folder / "back.csv");
  stream << "t_s,x_mm,y_mm,z_mm\n";
  for (int i = 0; i < 30; ++i) stream << (i == 20 ? 0.5 : i) << ",0,0,0\n";
  stream.close();
  EXPECT_NE(refusal([&] { read_stream(folder / "back.csv"); }).find("line 22"), std::string::npos);
  std::ofstream(folder / "eyes.csv") << "right,u,v,x_mm,y_mm,z_mm\n2,0,0,0,0,0\n";
  EXPECT_NE(refusal([&] { read_eye_captures(folder / "eyes.csv"); }).find("0 or 1"), std::string::npos);
  std::ofstream(folder / "some.csv") << "x_mm,y_mm,z_mm,a_rad,b_rad,c_rad,d_rad,e_rad,f_rad\n0,0,0,1,1,,1,1,1\n";
  EXPECT_NE(refusal([&] { read_touches(folder / "some.csv"); }).find("all or none"), std::string::npos);
}

TEST(GuidedCapture, TheWholeRoutineCanBeGuided) {
  const Folder folder;
  SimulationOptions options;
  options.placement_error = 0.005;
  BenchSimulator bench(options);
  BenchState state = bench.drawings();
  const double before = bench.colocation(state).rms;
  for (const Step step : kSteps) {
    GuidedCapture guide(state, folder / "captures");
    guide.begin(step);
    const RigGeometry& truth = bench.truth();
    const Pose X_WP{{-0.05, -0.05, -0.05}, glm::normalize(dquat(1, -0.6, 0.1, 0))};
    for (std::size_t i = 0; !guide.done(); ++i) {
      const Prompt asked = guide.prompt();
      dvec3 aim(0);
      if (step == Step::kArm && i < 120) aim = dvec3(i / 30 % 2 ? 0.06 : -0.06, -0.04, i / 60 ? 0.05 : -0.03);
      if (step == Step::kArm && i >= 120) {
        const std::size_t k = i - 120;
        const Pose moved = k >= 25 ? Pose{dvec3(0, 0, 0.03), glm::normalize(dquat(1, 0.3, 0, 0.1))} : Pose{};
        aim = moved * (X_WP * (0.04 * dvec3(static_cast<double>(k % 5), static_cast<double>(k % 25 / 5), 0)));
      }
      if (step == Step::kScreen) aim = truth.panel.at(asked.mark->u, asked.mark->v);
      if (step == Step::kMirror) {
        const dvec3 n = truth.mirror->normal,
                    p(0.03 * static_cast<double>(i % 7) - 0.09, 0, 0.03 * static_cast<double>(i / 7 % 7) - 0.09);
        aim = p - n * (glm::dot(n, p) - truth.mirror->offset);
      }
      if (step == Step::kEyes) {
        const dvec3 eye = asked.right_eye ? truth.eyes.right_eye() : truth.eyes.left_eye();
        const PanelPoint dot = asked.right_eye ? asked.dots->right : asked.dots->left;
        const dvec3 sight = glm::normalize(truth.appears(dot.u, dot.v, eye) - eye);
        aim = eye + sight * glm::dot(sight, *asked.target_D - eye);
      }
      if (step == Step::kRegister || step == Step::kVerify) aim = bench.reached_for(guide.bench().rig, *asked.target_D);
      guide.add(bench.touch(aim, guide.bench().arm));
    }
    guide.solve();
    state = guide.bench();
  }
  EXPECT_GT(before, 3e-3);
  EXPECT_LT(bench.colocation(state).rms, 0.15e-3);
  EXPECT_TRUE(state.verification.has_value());
}

TEST(PromptMarks, AMarkIsDrawnAtItsPlaceOnThePanel) {
  Prompt prompt;
  prompt.mark = PanelPoint{0.25, 0.5};
  const Picture marks = prompt_marks(prompt, 640, 360);
  EXPECT_EQ(marks.grey[180 * 640 + 160], 255);
  EXPECT_EQ(marks.grey[180 * 640 + 480], 0);
}

TEST(ReportPage, EscapesItsInputAndShowsTheVerdict) {
  const SimulatedRoutine run = simulate_routine({});
  const std::string page = report_page(run.bench, "bench <1> & co");
  EXPECT_NE(page.find("bench &lt;1&gt; &amp; co"), std::string::npos);
  EXPECT_NE(page.find("class=\"verdict pass\""), std::string::npos);
  EXPECT_NE(page.find("</html>"), std::string::npos);
}

}  // namespace
}  // namespace typodont::calibration
