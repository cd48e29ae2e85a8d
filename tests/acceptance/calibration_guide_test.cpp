// Tests guided capture through the command line, with a scripted hand in place of a device.
#include <gmock/gmock.h>

#include "calibration/bench_simulator.h"
#include "calibration/guided_capture.h"
#include "calibration/rig_file.h"
#include "engine/base/json.h"
#include "tests/support/program.h"

namespace typodont::calibration {
namespace {

using test::ProgramFolder;
using test::Ran;
using testing::HasSubstr;

/// A bench whose screen and eyes are known, and the points that its user touches when guided through `register`.
class GuidedBench : public testing::Test {
 protected:
  GuidedBench() : simulator({}), bench(simulator.drawings()) {
    simulator.capture_arm(known, bench);
    solve_arm_step(bench, known);
    simulator.capture_screen(known, bench);
    solve_screen_step(bench, known);
    simulator.capture_eyes(known, bench);
    solve_eyes_step(bench, known);
    make_rig("rig.json");
  }

  std::filesystem::path make_rig(const std::string& name) {
    RigFile rig = RigFile::create(folder.path() / name);
    write_captures(rig.captures_folder(), known);
    rig.set(bench);
    rig.save();
    return folder.path() / name;
  }

  /// Writes the touches of the step as numbers, as from a hand without encoders, and solves the step from them.
  BenchState by_file(std::vector<dvec3>& touches) {
    RigFile rig = RigFile::load(make_rig("file.json"));
    GuidedCapture guide(rig.bench(), rig.captures_folder());
    guide.begin(Step::kRegister);
    while (!guide.done()) {
      const Touch touch =
          simulator.touch(simulator.reached_for(guide.bench().rig, *guide.prompt().target_D), bench.arm);
      guide.add({touch.p_H, std::nullopt});
      touches.push_back(touch.p_H);
    }
    BenchState solved = RigFile::load(folder.path() / "file.json").bench();
    solve_register_step(solved, read_captures(rig.captures_folder()));
    return solved;
  }

  /// Returns a hand that rests at each point for 0.15 s and presses the pedal at the end. `hasty`: it presses as soon
  /// as it arrives.
  std::string script(const std::vector<dvec3>& points, bool hasty = false) {
    std::string csv = "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n";
    double t = 0;
    const auto row = [&](const dvec3& p, double pedal) {
      csv += fmt::format("{:.3f},{},{},{},1,0,0,0,{}\n", t, p.x * 1e3, p.y * 1e3, p.z * 1e3, pedal);
    };
    for (const dvec3& p : points) {
      row(p, 0), t += hasty ? 0.01 : 0.15;
      row(p, 0), t += 0.002;
      row(p, 1), t += 0.01;
      row(p, 1), t += 0.002;
      row(p, 0), t += 0.05;
    }
    row(points.back(), 0);
    return folder.write("hand.csv", csv);
  }

  Ran guide(const std::string& options, const std::string& before = "") {
    return folder.run(fmt::format("calibrate guide register --rig {} --no-window {}", folder / "rig.json", options),
                      before);
  }
  std::size_t kept() {
    return read_captures(RigFile::load(folder.path() / "rig.json").captures_folder()).registration.size();
  }

  ProgramFolder folder{TYPODONT_PROGRAM};
  BenchSimulator simulator;
  BenchState bench;
  Captures known;
};

TEST_F(GuidedBench, TouchesByHandAndPedalGiveTheSameResultAsTheSameTouchesFromAFile) {
  std::vector<dvec3> touches;
  const BenchState expected = by_file(touches);
  const Ran ran = expect_ok(guide(fmt::format("--hand script:{} --fast </dev/null", script(touches))));
  EXPECT_EQ(kept(), touches.size());
  const BenchState live = RigFile::load(folder.path() / "rig.json").bench();
  EXPECT_GT(glm::length(live.rig.X_WH.p - bench.rig.X_WH.p), 1e-5) << "the step changed nothing";
  EXPECT_LT(glm::length(live.rig.X_WH.p - expected.rig.X_WH.p), 1e-9);
  EXPECT_LT(glm::length(live.rig.X_WH.R - expected.rig.X_WH.R), 1e-9);
  EXPECT_LT(glm::length(live.rig.eyes.center - expected.rig.eyes.center), 1e-9);
  EXPECT_LT(glm::length(live.rig.panel.lower_left - expected.rig.panel.lower_left), 1e-9);
  EXPECT_NEAR(live.rig.eyes.ipd, expected.rig.eyes.ipd, 1e-9);
  EXPECT_THAT(ran.out, HasSubstr("predicted error")) << "residuals come with each touch";
}

TEST_F(GuidedBench, AnInterruptedCaptureKeepsItsTouchesAndCanBeContinued) {
  std::vector<dvec3> touches;
  const BenchState expected = by_file(touches);
  expect_exit(guide(fmt::format("--hand script:{} --fast </dev/null", script({touches.begin(), touches.begin() + 70}))),
              1, "70 of 120 touches are kept");
  EXPECT_EQ(kept(), 70u);
  const Ran second = expect_ok(
      guide(fmt::format("--hand script:{} --fast </dev/null", script({touches.begin() + 70, touches.end()}))));
  EXPECT_THAT(second.err, HasSubstr("continuing after 70 touches"));
  EXPECT_LT(glm::length(RigFile::load(folder.path() / "rig.json").bench().rig.X_WH.p - expected.rig.X_WH.p), 1e-9);
}

TEST_F(GuidedBench, APressWhileTheTipMovesIsRefusedWithAMessage) {
  const std::vector<dvec3> touches{dvec3(0.01, 0, 0), dvec3(0.04, 0, 0), dvec3(0.01, 0, 0.03)};
  const Ran ran = guide(fmt::format("--hand script:{} --fast </dev/null", script(touches, true)));
  EXPECT_EQ(ran.status, 1);
  EXPECT_EQ(kept(), 0u);
  EXPECT_THAT(ran.out, HasSubstr("not taken: hold the tip still for 100 ms first"));
  EXPECT_THAT(ran.out, HasSubstr("not taken: the tip moved"));
}

TEST_F(GuidedBench, EnterTakesATouchAndUUndoesIt) {
  // The hand rests in one place. The keyboard asks until a second touch is taken, takes the last one back, and stops.
  folder.write("hand.csv", "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,10,20,30,1,0,0,0,0\n60,10,20,30,1,0,0,0,0\n");
  folder.write("keys.sh",
               "cd $(dirname $0)\nuntil grep -q 'touch 2:' .stdout; do echo; sleep 0.2; done\necho u; echo q\n");
  const std::string keys = fmt::format("sh {} |", folder / "keys.sh");
  const Ran ran = expect_ok(guide(fmt::format("--hand script:{}", folder / "hand.csv"), keys));
  EXPECT_THAT(ran.out, HasSubstr("the last touch is undone"));
  const std::size_t taken = ran.out.find("touch 3:") == std::string::npos ? 2 : 3;
  ASSERT_EQ(kept(), taken - 1);
  const auto captures = read_captures(RigFile::load(folder.path() / "rig.json").captures_folder());
  EXPECT_LT(glm::length(captures.registration[0].touch.p_H - dvec3(0.01, 0.02, 0.03)), 1e-12);
}

TEST_F(GuidedBench, TheArmStepRefusesAHandWithoutJointAngles) {
  expect_exit(folder.run(fmt::format("calibrate guide arm --rig {} --fast --no-window --hand script:{} </dev/null",
                                     folder / "rig.json", script(std::vector<dvec3>(2, dvec3(0.01, 0.02, 0.03))))),
              2, "joint angles");
}

TEST_F(GuidedBench, AVerificationThatFailsEndsWithStatusOne) {
  RigFile rig = RigFile::load(make_rig("file.json"));
  GuidedCapture guide(rig.bench(), rig.captures_folder());
  guide.begin(Step::kVerify);
  std::vector<dvec3> touches;
  while (!guide.done()) {
    const dvec3 seen = simulator.reached_for(guide.bench().rig, *guide.prompt().target_D);
    touches.push_back(simulator.touch(seen + dvec3(0, 0, 5e-3), bench.arm).p_H);
    guide.add({touches.back(), std::nullopt});
  }
  expect_exit(folder.run(fmt::format("calibrate guide verify --rig {} --fast --no-window --hand script:{} </dev/null",
                                     folder / "rig.json", script(touches))),
              1, "verify: ");
}

TEST_F(GuidedBench, DriftMarksAreTouchedOnceAndComparedAtEverySession) {
  const std::string marks = "\"10 20 30\\n60 20 30\\n10 70 35\\n\"", moved = "\"10 20 31\\n60 20 31\\n10 70 36\\n\"";
  expect_ok(folder.run("calibrate guide drift --rig {}/rig.json", fmt::format("printf {} |", marks)));
  const Ran same = expect_ok(folder.run("calibrate drift --rig {}/rig.json", fmt::format("printf {} |", marks)));
  EXPECT_THAT(same.out, HasSubstr("no drift"));
  const Ran later = folder.run("calibrate drift --rig {}/rig.json", fmt::format("printf {} |", moved));
  EXPECT_EQ(later.status, 1);
  EXPECT_THAT(later.out, HasSubstr("calibrate again"));
}

TEST_F(GuidedBench, CompletedStepsAreSkippedAndAnyStepCanBeSkipped) {
  // Arm, screen, mirror and eyes are already solved. The user skips `register` and stops at `verify`.
  const Ran ran = expect_ok(folder.run("calibrate guide --rig {}/rig.json --no-window", "printf 's\\nq\\n' |"));
  EXPECT_THAT(ran.out, HasSubstr("== arm: done, skipped"));
  EXPECT_THAT(ran.out, HasSubstr("== eyes: done, skipped"));
  EXPECT_THAT(ran.out, HasSubstr("== register\n"));
  EXPECT_THAT(ran.out, HasSubstr("== verify\n"));
  EXPECT_THAT(ran.out, testing::Not(HasSubstr("== drift")));
}

TEST_F(GuidedBench, AnOutlierTouchIsMarkedOnScreenUntilTheNextTouch) {
  RigFile rig = RigFile::load(folder.path() / "rig.json");
  GuidedCapture guide(rig.bench(), rig.captures_folder());
  guide.begin(Step::kRegister);
  const auto touch = [&](const dvec3& slip) {
    const Touch t =
        simulator.touch(simulator.reached_for(guide.bench().rig, *guide.prompt().target_D) + slip, bench.arm);
    return guide.add({t.p_H, std::nullopt});
  };
  while (guide.taken() < 12) touch(dvec3(0));
  const Live live = touch(dvec3(0.02, 0, 0.01));
  ASSERT_TRUE(live.outlier);
  const Prompt prompt = guide.prompt();
  ASSERT_TRUE(prompt.astray.has_value());
  const Dots expected = dots_for(guide.bench().rig, *live.p_W);
  EXPECT_NEAR(prompt.astray->left.u, expected.left.u, 1e-12);
  Prompt without = prompt;
  without.astray.reset();
  const auto lit = [](const Prompt& p) {
    const Picture picture = prompt_marks(p, 640, 360);
    return std::count_if(picture.grey.begin(), picture.grey.end(), [](unsigned char g) { return g > 100; });
  };
  EXPECT_GT(lit(prompt), lit(without) + 40);
  touch(dvec3(0));
  EXPECT_FALSE(guide.prompt().astray.has_value());
}

TEST_F(GuidedBench, TheEyesStepReportsTheUsersOffsetOnRequest) {
  std::vector<dvec3> touches;
  (void)by_file(touches);
  const Ran ran = expect_ok(folder.run("calibrate eyes --rig {}/file.json --user-offset"));
  EXPECT_THAT(ran.out, HasSubstr("this user feels"));
  EXPECT_THAT(test::read_text(folder / "file.json"), HasSubstr("user_offset_mm"));
}

TEST_F(GuidedBench, EveryTouchHasASoundCueAndAPromptPicture) {
  const std::vector<dvec3> touches(5, dvec3(0.01, 0.02, 0.03));
  const Ran ran = guide(fmt::format("--hand script:{} --fast --audio wav:{} --picture {} </dev/null", script(touches),
                                    folder / "cues.wav", folder / "prompt.png"));
  EXPECT_EQ(ran.status, 1) << "five touches are not the whole step";
  EXPECT_THAT(test::read_text(folder / "prompt.png"), HasSubstr("PNG"));
  const std::string wav = test::read_text(folder / "cues.wav");
  ASSERT_GT(wav.size(), 6 * 0.16 * 48000) << "a ready and five taken";
  EXPECT_TRUE(std::any_of(wav.begin() + 64, wav.end(), [](char c) { return c != 0; }));
}

TEST_F(GuidedBench, TheDelayOfTwoLiveStreamsIsMeasuredAndStored) {
  const auto hand = [&](const char* name, double lag) {
    std::string csv = "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n";
    for (int i = 0; i <= 3000; ++i) {
      const double t = 0.01 * i, u = t - lag;
      csv += fmt::format("{:.3f},{},{},{},1,0,0,0,0\n", t, 40 * std::sin(2.3 * u) + 9 * std::sin(7.1 * u + 1),
                         30 * std::sin(3.7 * u), 20 * std::cos(1.9 * u));
    }
    return folder.write(name, csv);
  };
  const std::string a = hand("a.csv", 0), b = hand("b.csv", 0.06);
  // On a busy machine samples come late, which is not an error of the program. If they come so late that they do not
  // determine the delay, the program must not store it, and it is measured again.
  Captures captures;
  const auto stored = [&] { return test::read_text(folder / "rig.json").find("delay_ms") != std::string::npos; };
  for (int attempt = 0; attempt < 5 && !stored(); ++attempt) {
    const Ran ran = expect_ok(folder.run(fmt::format(
        "calibrate delay --rig {} --hand script:{} --with script:{} --seconds 8", folder / "rig.json", a, b)));
    EXPECT_THAT(ran.out, HasSubstr("to and fro"));
    captures = read_captures(RigFile::load(folder.path() / "rig.json").captures_folder());
    EXPECT_GT(captures.delay_a.t.size(), 1000u);
    EXPECT_NE(stored(), estimate_delay(captures.delay_a, captures.delay_b).ambiguous) << ran.out << ran.err;
  }
  ASSERT_TRUE(stored());
  // The program must state the delay of the samples that it stored. (property/calibration_delay_test.cpp compares the
  // estimate with the true delay.)
  const Ran again = expect_ok(folder.run("calibrate delay --rig {}/rig.json --json"));
  EXPECT_NEAR(Json::parse(again.out, "delay")["delay_ms"].number(),
              1e3 * estimate_delay(captures.delay_a, captures.delay_b).delay, 1e-9);
  const Ran still = folder.run(fmt::format(
      "calibrate delay --hand script:{0} --with script:{0} --seconds 4",
      folder.write("rest.csv", "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,10,20,30,1,0,0,0,0\n60,10,20,30,1,0,0,0,0\n")));
  EXPECT_THAT(still.out + still.err, HasSubstr("no motion: both streams are at rest"));
  EXPECT_EQ(folder.run("calibrate delay --hand script:x.csv").status, 2);
}

TEST(CalibrateHelp, EverySubcommandNamesAnExample) {
  const ProgramFolder folder{TYPODONT_PROGRAM};
  for (const char* step : {"--simulate", "arm", "screen", "eyes", "register", "hand-eye", "robot-world", "delay",
                           "verify", "solve", "drift", "guide", "status", "board", "camera"}) {
    const Ran ran = folder.run(fmt::format("calibrate {} --help", step));
    EXPECT_EQ(ran.status, 0) << step;
    EXPECT_THAT(ran.out, HasSubstr(fmt::format("Example: typodont calibrate {}", step))) << step;
  }
}

}  // namespace
}  // namespace typodont::calibration
