// Tests experiments: staircases, the psychometric fit with observers of known threshold, the log, and what a scripted
// hand feels for each stimulus.
#include "engine/app/experiment/experiment.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <random>
#include <vector>

#include "engine/app/experiment/simulated_subject.h"
#include "engine/app/experiment/trial_log.h"
#include "engine/base/error.h"
#include "engine/session/session_file.h"
#include "haptics/force_delay.h"
#include "tests/support/session_fixture.h"

namespace typodont {
namespace {

ExperimentPlan stiffness_plan(std::uint64_t seed) {
  ExperimentPlan plan;
  plan.scene_stiffness = 1000;
  plan.reference = 1;
  plan.seed = seed;
  return plan;
}

/// Carries out an experiment with an observer who feels each stimulus exactly as it is planned.
Experiment done(const ExperimentPlan& plan, const Psychometric& truth) {
  Experiment experiment(plan);
  SimulatedObserver observer(truth, plan.seed + 1000);
  while (!experiment.over()) experiment.answer(observer.judge(nominal_difference(experiment.trial())), 0);
  return experiment;
}

TEST(Staircase, TwoDownOneUpGoesDownAfterTwoRightAnswersAndUpAfterOneWrongOne) {
  StaircaseRule rule;
  rule.start = 40, rule.coarse = 0, rule.step = 2;
  Staircase staircase(rule);
  staircase.answer(true);
  EXPECT_EQ(staircase.level(), 40);
  staircase.answer(true);
  EXPECT_DOUBLE_EQ(staircase.level(), 20);
  staircase.answer(true);
  staircase.answer(false);
  EXPECT_DOUBLE_EQ(staircase.level(), 40);
  EXPECT_EQ(staircase.turns(), 1);
  staircase.answer(true);
  staircase.answer(true);
  EXPECT_DOUBLE_EQ(staircase.level(), 20);
  EXPECT_EQ(staircase.turns(), 2);
  EXPECT_DOUBLE_EQ(staircase.settled_level(), std::sqrt(20.0 * 40)) << "the geometric mean of both turns";
}

TEST(Staircase, NeverLeavesItsRange) {
  StaircaseRule rule;
  rule.most = 100, rule.least = 2;
  Staircase up(rule), down(rule);
  for (int i = 0; i < 50; ++i) up.answer(false), down.answer(true);
  EXPECT_EQ(up.level(), 100);
  EXPECT_EQ(down.level(), 2);
}

/// Returns the fraction of correct answers at the level at which long staircases of this rule settle. It is computed
/// with the observer's own psychometric function.
double settles_at(const StaircaseRule& rule) {
  const Psychometric truth{0, 20, 0};
  ExperimentPlan plan = stiffness_plan(1);
  plan.rule = rule;
  plan.rule.first_step = 1.1, plan.rule.step = 1.05;  // fine steps: coarse ones settle beside the target
  plan.trials = 20'000, plan.turns = 1'000'000;
  return truth.second(done(plan, truth).staircase().settled_level());
}

TEST(Staircase, ConvergesAsPublishedByLevittAndKaernbach) {
  StaircaseRule rule;
  EXPECT_NEAR(rule.target(), 0.7071, 1e-4);
  EXPECT_NEAR(settles_at(rule), rule.target(), 0.015);
  rule.down = 3;
  EXPECT_NEAR(rule.target(), 0.7937, 1e-4);
  EXPECT_NEAR(settles_at(rule), rule.target(), 0.015);
  rule.kind = StaircaseRule::Kind::kWeighted;
  EXPECT_EQ(rule.target(), 0.75);
  EXPECT_NEAR(settles_at(rule), rule.target(), 0.015);
}

TEST(Psychometric, AtTheJustNoticeableDifferenceThreeQuartersOfTheAnswersAreRight) {
  const Psychometric f{0, Psychometric::width_of_jnd(8), 0};
  EXPECT_NEAR(f.jnd(), 8, 1e-12);
  EXPECT_NEAR(f.second(8), 0.75, 1e-9);
  EXPECT_NEAR(f.second(-8), 0.25, 1e-9);
}

TEST(Psychometric, TheFitIsTheGreatestLikelihoodOfAll) {
  std::mt19937_64 random(3);
  const std::vector<AnsweredTrial> answered = done(stiffness_plan(5), {2, 15, 0.02}).answered();
  std::vector<Judgement> judgements;
  for (const AnsweredTrial& a : answered)
    judgements.push_back({nominal_difference(a.trial), a.answer == Answer::kSecond});
  const PsychometricFit fit = fit_psychometric(judgements);
  std::uniform_real_distribution<double> fraction(0, 1);
  for (int i = 0; i < 20'000; ++i) {
    const Psychometric other{-20 + 40 * fraction(random), std::exp(5 * fraction(random)),
                             kMaxLapses * fraction(random)};
    double sum = 0;
    for (const Judgement& j : judgements) {
      const double p = other.second(j.difference);
      sum += std::log(j.second ? p : 1 - p);
    }
    ASSERT_LE(sum, fit.log_likelihood + 1e-6) << other.bias << " " << other.width << " " << other.lapse;
  }
}

TEST(Psychometric, AnswersByChanceDoNotBoundTheThresholdFromAbove) {
  std::vector<Judgement> judgements;
  for (int i = 0; i < 20; ++i)
    for (const double difference : {-10.0, 10.0}) judgements.push_back({difference, i % 2 == 0});
  const PsychometricFit fit = fit_psychometric(judgements);
  EXPECT_TRUE(std::isinf(fit.jnd.high));
  EXPECT_GT(fit.jnd.low, 0);
}

// What the whole command claims: its result is the observer's threshold, with the uncertainty that it states.
TEST(Psychometric, TheIntervalHoldsTheObserversThresholdInNineteenOfTwentyExperiments) {
  constexpr int kExperiments = 120;
  int held = 0, bias_held = 0;
  double logs = 0;
  for (int i = 0; i < kExperiments; ++i) {
    // Thresholds are from 4 to 25 %, biases of the order up to a third of the threshold, and lapses up to 4 %.
    const double jnd = 4 + 21.0 * (i % 10) / 9;
    const Psychometric truth{jnd / 3 * (i % 3 - 1), Psychometric::width_of_jnd(jnd), 0.02 * (i % 3)};
    const Experiment experiment = done(stiffness_plan(100 + static_cast<std::uint64_t>(i)), truth);
    const ExperimentResult result = result_of(experiment.plan(), experiment.answered());
    held += result.fit->jnd.low <= jnd && jnd <= result.fit->jnd.high;
    bias_held += result.fit->bias.low <= truth.bias && truth.bias <= result.fit->bias.high;
    logs += std::log(result.fit->jnd.value / jnd);
  }
  // The interval is meant to contain the true value in at least 95 % of the experiments. If it does, it
  // contains the value in fewer than 106 of 120 experiments with a probability of only 0.1 %.
  EXPECT_GE(held, 106);
  EXPECT_GE(bias_held, 106);
  EXPECT_NEAR(logs / kExperiments, 0, 0.15) << "mean error of the threshold";
}

TEST(Shares, ConfidenceIntervalsOfFractionsAreThoseOfClopperAndPearson) {
  const Estimate fraction = fraction_of(8, 10);  // R: binom.test(8, 10)
  EXPECT_NEAR(fraction.low, 0.4439045, 1e-6);
  EXPECT_NEAR(fraction.high, 0.9747893, 1e-6);
  EXPECT_NEAR(chance_of(8, 10), 0.109375, 1e-9);
  EXPECT_EQ(fraction_of(0, 5).low, 0);
  EXPECT_EQ(fraction_of(5, 5).high, 1);
}

TEST(Experiment, TheOrderIsRandomBySeedAndEvenOverManyTrials) {
  ExperimentPlan plan = stiffness_plan(1);
  plan.trials = 2000, plan.turns = 1'000'000;
  int second = 0, repeated = 0;
  const std::vector<AnsweredTrial> once = done(plan, {0, 10, 0}).answered(), again = done(plan, {0, 10, 0}).answered();
  for (std::size_t i = 0; i < once.size(); ++i) {
    second += once[i].trial.greater_second;
    repeated += i > 0 && once[i].trial.greater_second == once[i - 1].trial.greater_second;
    ASSERT_EQ(once[i].trial.greater_second, again[i].trial.greater_second) << "the same seed";
  }
  EXPECT_NEAR(second, 1000, 100);
  EXPECT_NEAR(repeated, 1000, 100) << "no order follows from the one before";
  plan.seed = 2;
  const std::vector<AnsweredTrial> other = done(plan, {0, 10, 0}).answered();
  int differ = 0;
  for (std::size_t i = 0; i < 100; ++i) differ += other[i].trial.greater_second != once[i].trial.greater_second;
  EXPECT_GT(differ, 20);
}

TEST(Experiment, OfModelsEachIsAsOftenFirstAsSecond) {
  ExperimentPlan plan;
  plan.question = Question::kModel;
  plan.models = {"offset", "vertex"};
  plan.trials = 30;
  Experiment experiment(plan);
  int second = 0;
  while (!experiment.over()) {
    second += experiment.trial().stimuli[1].model == "vertex";
    experiment.answer(Answer::kFirst, 0);
  }
  EXPECT_EQ(second, 15);
  EXPECT_EQ(result_of(plan, experiment.answered()).chosen.value, 0.5) << "a subject who always says \"first\"";
}

TEST(TrialLog, IsReadBackAsItWasWrittenWithTheSameFit) {
  const session::test::TemporaryFolder folder;
  for (const Question question : {Question::kStiffness, Question::kDelay, Question::kModel}) {
    ExperimentPlan plan = stiffness_plan(3);
    plan.question = question;
    if (question == Question::kModel) plan.models = {"offset", "packing"};
    const Experiment experiment = done(plan, {0, 20, 0.02});
    const TrialLog log{plan, "scene.json", question == Question::kDelay ? "" : "P07", experiment.answered()};
    write_trial_log(folder / "trials.csv", log);
    const TrialLog read = read_trial_log(folder / "trials.csv");
    EXPECT_TRUE(table_of(read) == table_of(log)) << name_of(question);
    EXPECT_EQ(json_of(result_of(read.plan, read.answered), ""), json_of(result_of(plan, log.answered), ""));
  }
}

TEST(TrialLog, AWrongRowIsRefusedWithItsPlace) {
  const session::test::TemporaryFolder folder;
  const TrialLog log{stiffness_plan(3), "scene.json", "P07", done(stiffness_plan(3), {0, 20, 0}).answered()};
  std::string text = table_of(log);
  text += "999,1,1.2,20,3,1,0\n";
  std::ofstream(folder / "trials.csv") << text;
  EXPECT_THAT(test::refusal([&] { read_trial_log(folder / "trials.csv"); }),
              testing::AllOf(testing::HasSubstr("column answer"), testing::HasSubstr("1 (first) or 2 (second)")));
}

class Touch : public testing::Test {
 protected:
  Touch() {
    std::ofstream(folder / "scene.json") << R"({"name": "block", "tissue": {"voxel_mm": 0.2, "solids": [
      {"tissue": "enamel", "solid": {"box": {"size_mm": [8, 8, 6]}}}]}, "friction": false,
      "tool": {"shape": "sphere", "diameter_mm": 2, "cuts": false}, "parts": ["haptics"]})";
    std::ofstream(folder / "hand.csv") << "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,0,0,4.5,1,0,0,0,0\n"
                                          "0.2,0,0,3.6,1,0,0,0,0\n0.4,0,0,4.5,1,0,0,0,0\n";
  }
  session::test::TemporaryFolder folder;
};

TEST_F(Touch, AScriptedHandFeelsTheStiffnessForceAndDelayOfEachStimulus) {
  ScriptedTouch touch(read_scene(folder / "scene.json"), (folder / "hand.csv").string(), 1000);
  const Felt plain = touch.feel({});
  EXPECT_NEAR(plain.stiffness, 1000, 30);
  EXPECT_NEAR(plain.force, 0.4, 0.02);
  Stimulus stiffer;
  stiffer.stiffness_ratio = 1.3;
  EXPECT_NEAR(touch.feel(stiffer).stiffness / plain.stiffness, 1.3, 0.01);
  Stimulus weaker;
  weaker.force_fraction = 0.5;
  EXPECT_NEAR(touch.feel(weaker).force / plain.force, 0.5, 0.005);
  Stimulus later;
  later.delay = 0.04;
  EXPECT_NEAR(touch.feel(later).delay - plain.delay, 0.04, 0.002);
  EXPECT_NEAR(touch.feel({}).stiffness, plain.stiffness, 1) << "a stimulus leaves nothing behind";
}

TEST_F(Touch, TheThresholdOfASimulatedObserverWithARealServoIsFound) {
  const Scene scene = read_scene(folder / "scene.json");
  for (const Question question : {Question::kStiffness, Question::kForce, Question::kDelay}) {
    ExperimentPlan plan = stiffness_plan(11);
    plan.question = question;
    plan.reference = question == Question::kForce ? 50 : question == Question::kDelay ? 0 : 1;
    plan.trials = 60;  // for the test to be short
    const double jnd = question == Question::kDelay ? 25 : 10;
    ScriptedTouch touch(scene, (folder / "hand.csv").string(), 1000);
    SimulatedObserver observer({0, Psychometric::width_of_jnd(jnd), 0}, 5);
    Experiment experiment(plan);
    while (!experiment.over())
      experiment.answer(observer.judge(touch.measured_difference(question, experiment.trial())), 0);
    const ExperimentResult result = result_of(plan, experiment.answered());
    EXPECT_LT(result.fit->jnd.low, jnd) << name_of(question);
    EXPECT_GT(result.fit->jnd.high, jnd) << name_of(question);
  }
}

TEST_F(Touch, APathThatBeginsInTheTissueIsRefused) {
  std::ofstream(folder / "hand.csv") << "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,0,0,3.6,1,0,0,0,0\n"
                                        "1,0,0,4.5,1,0,0,0,0\n";
  ScriptedTouch touch(read_scene(folder / "scene.json"), (folder / "hand.csv").string(), 1000);
  EXPECT_THROW(touch.feel({}), Error);
}

/// Returns a tick of a hand that presses on a wall at z = 0. The hand moves as a cosine of amplitude `reach_mm`. The
/// force is that of a servo without delay.
ServoTick pressed(double t, double reach_mm, double stiffness) {
  ServoTick tick;
  tick.t = from_seconds(t);
  tick.X_WT.p = dvec3(0, 0, 1e-3 * reach_mm * std::cos(6 * t));
  tick.f_T_W = dvec3(0, 0, stiffness * std::max(0.0, -tick.X_WT.p.z));
  return tick;
}

TEST(ForceDelay, WithoutADelayItIsTheServosForceToTheBit) {
  haptics::ForceDelay delay(haptics::ServoSettings{}, 0.1);
  for (int i = 0; i < 5000; ++i) {
    const ServoTick tick = pressed(1e-3 * i, 1, 1000);
    ASSERT_EQ(delay.pass(tick, 0).f_T_W, tick.f_T_W);
  }
}

TEST(ForceDelay, TheForceIsDelayedByTheRequestedTimeWhileTheHandPressesIn) {
  haptics::ForceDelay delay(haptics::ServoSettings{}, 0.1);
  const auto at = [](int i) { return pressed(1e-3 * i, 1, 1000); };
  for (int i = 0; i < 500; ++i) {  // the first way in: from 262 ms to 523 ms
    const dvec3 f = delay.pass(at(i), from_seconds(0.02)).f_T_W;
    if (i >= 20) {
      ASSERT_NEAR(f.z, at(i - 20).f_T_W.z, 1e-12) << i;
    }
  }
}

// A delayed spring gives more energy on the way out than it took on the way in. The energy ledger must prevent this.
TEST(ForceDelay, NeverGivesTheHandMoreEnergyThanItTook) {
  for (const double ms : {5.0, 20.0, 60.0, 100.0}) {
    haptics::ForceDelay delay(haptics::ServoSettings{}, 0.1);
    double given = 0, worst = 0, unguarded = 0;
    dvec3 f(0), late(0), last = pressed(0, 1, 1000).X_WT.p;
    for (int i = 0; i < 20'000; ++i) {
      const ServoTick tick = pressed(1e-3 * i, 1, 1000);
      given += glm::dot(f, tick.X_WT.p - last), unguarded += glm::dot(late, tick.X_WT.p - last);
      worst = std::max(worst, given);
      if (f == dvec3(0) && tick.f_T_W == dvec3(0)) given = std::min(given, 0.0);  // a contact's debt ends with it
      last = tick.X_WT.p;
      f = delay.pass(tick, from_seconds(1e-3 * ms)).f_T_W;
      late = pressed(std::max(0.0, 1e-3 * (i - ms)), 1, 1000).f_T_W;
    }
    EXPECT_GT(unguarded, 1e-6) << "a delayed spring alone does";
    EXPECT_LT(worst, 1e-9) << ms << " ms";
  }
}

}  // namespace
}  // namespace typodont
