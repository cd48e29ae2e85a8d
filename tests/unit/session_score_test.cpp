#include <gmock/gmock.h>

#include "engine/base/error.h"
#include "engine/base/units.h"
#include "engine/session/score.h"
#include "engine/session/strings.h"
#include "engine/session/task.h"
#include "tests/support/session_fixture.h"

namespace typodont::session {
namespace {

using testing::HasSubstr;

/// Returns ten seconds of ticks at 1 kHz. The hand is at `path(t)`, and is in contact and cuts where `contact(t)` is
/// true.
template <class Path, class Contact>
HandMeasures measure(Path path, Contact contact, double rate = 1000, double force = 0.5) {
  HandMeter meter(rate);
  std::vector<ServoTick> ticks;
  double removed = 0;
  for (int i = 0; i < static_cast<int>(10 * rate); ++i) {
    ServoTick t;
    t.t = from_seconds(i / rate);
    t.X_WT.p = path(i / rate);
    if (contact(i / rate)) {
      t.depth = 1e-4;
      t.f_T_W = {0, 0, force};
      removed += 1e-13;
    }
    t.removed[1] = removed;
    ticks.push_back(t);
  }
  meter.add(ticks);
  return meter.result();
}

const auto always = [](double) { return true; };

TEST(HandMeter, PathLengthIsTheLineWithoutTheTremorOnIt) {
  const auto line = [](double t) { return dvec3(1e-3 * t + 50e-6 * std::sin(2 * kPi * 10 * t), 0, 0); };
  EXPECT_NEAR(measure(line, always).path_length, 10e-3, 0.15e-3);
  const auto circle = [](double t) { return dvec3(5e-3 * std::cos(0.2 * kPi * t), 5e-3 * std::sin(0.2 * kPi * t), 0); };
  EXPECT_NEAR(measure(circle, always).path_length, 2 * kPi * 5e-3, 0.5e-3);
}

/// A sine along y, with the amplitude m.
dvec3 sine(double t, double hz, double amplitude) {
  return {0, amplitude * std::sin(2 * kPi * hz * t), 0};
}

/// Strokes along x, 1.5 mm long, which reverse in one tick. `hz`: there and back.
dvec3 strokes(double t, double hz) {
  return {1.5e-3 / kPi * std::asin(std::sin(2 * kPi * hz * t)), 0, 0};
}

TEST(HandMeter, TremorIsTheHandFromEightToTwelveHertz) {
  const double a = 100e-6;
  const auto at = [&](double hz, double amplitude) {
    return measure([&](double t) { return sine(t, hz, amplitude); }, always).tremor_rms;
  };
  for (const double hz : {8.0, 9.0, 10.0, 11.0, 12.0}) {
    // Power of the sine in the octave around f. The background is the geometric mean of the two other octaves.
    const auto power = [&](double f) { return std::pow(std::sin(kPi / 2 * hz / f), 8); };
    const double expected = a / std::sqrt(2.0) * std::sqrt((power(10) - std::sqrt(power(5) * power(20))) / 0.9);
    EXPECT_NEAR(at(hz, a), expected, 0.03 * expected) << hz;
    EXPECT_NEAR(at(hz, a), a / std::sqrt(2.0), 0.2 * a / std::sqrt(2.0)) << hz;
  }
  EXPECT_LT(at(0.5, a), 1e-3 * a);
  EXPECT_LT(at(1, 5e-3), 10e-6);
  EXPECT_EQ(measure([](double) { return dvec3(0.1, -0.2, 0.3); }, always).tremor_rms, 0);
}

TEST(HandMeter, StrokesWithSharpTurnsAreNoTremorAndHideNone) {
  for (const double hz : {1.0, 1.4, 1.7, 2.0, 2.3, 2.6, 3.0}) {
    EXPECT_LT(measure([&](double t) { return strokes(t, hz); }, always).tremor_rms, 20e-6) << hz;
    const auto trembling = [&](double t) { return strokes(t, hz) + sine(t, 9, 100e-6 * std::sqrt(2.0)); };
    EXPECT_NEAR(measure(trembling, always).tremor_rms, 100e-6, 15e-6) << hz;
  }
}

TEST(HandMeter, AJumpOfTheHandIsNoTremor) {
  const auto jump = [](double t) { return dvec3(t < 5 ? 0 : 5e-3, 0, 0); };
  EXPECT_LT(measure(jump, always).tremor_rms, 1e-6);
}

TEST(HandMeter, TremorDoesNotDependOnTheServoRate) {
  const auto path = [](double t) { return dvec3(1e-4 * std::sin(2 * kPi * 10 * t), 0, 0); };
  const double slow = measure(path, always, 500).tremor_rms, fast = measure(path, always, 8000).tremor_rms;
  EXPECT_NEAR(slow, fast, 0.02 * fast);
}

TEST(HandMeter, StrokesArePeriodsOfCuttingAndShortLossesOfContactDoNotEndThem) {
  const auto still = [](double) { return dvec3(0); };
  // Three periods of contact with 1 s between them. Each is interrupted for 50 ms.
  const auto spells = [](double t) {
    const double phase = std::fmod(t, 3.0);
    return t < 9 && phase < 2.0 && !(phase > 1.0 && phase < 1.05);
  };
  EXPECT_EQ(measure(still, spells).strokes, 3);
  EXPECT_EQ(measure(still, [](double) { return false; }).strokes, 0);
  EXPECT_EQ(measure(still, always).strokes, 1);
}

TEST(HandMeter, ForceAndTimeAreThoseOfTheContact) {
  const auto half = [](double t) { return t < 5; };
  const HandMeasures m = measure([](double) { return dvec3(0); }, half, 1000, 1.5);
  EXPECT_DOUBLE_EQ(m.force_mean, 1.5);
  EXPECT_DOUBLE_EQ(m.force_max, 1.5);
  EXPECT_NEAR(m.contact_time, 5, 1e-9);
  EXPECT_NEAR(m.time, 9.999, 1e-9);
}

TEST(HandMeter, TicksWithTheEmergencyKeyCountNeitherAsContactNorForce) {
  std::vector<ServoTick> ticks(4000);
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    const bool held = i >= 1000 && i < 3000;
    ticks[i].t = from_seconds(static_cast<double>(i) * 1e-3);
    ticks[i].depth = held ? 10e-3 : 1e-4;
    ticks[i].f_T_W = {0, 0, held ? 10.0 : 0.5};
    if (held) ticks[i].faults = bits(Fault::kHeld);
  }
  HandMeter meter(1000);
  meter.add(ticks);
  const HandMeasures m = meter.result();
  EXPECT_DOUBLE_EQ(m.force_max, 0.5);
  EXPECT_DOUBLE_EQ(m.force_mean, 0.5);
  EXPECT_DOUBLE_EQ(m.contact_time, 2);
  EXPECT_NEAR(m.time, 4, 2e-3);
}

TEST(Score, WithoutATaskAnUntouchedToothScoresZeroAndACutToothIsScored) {
  ScoreInput in;
  in.before[static_cast<std::size_t>(Tissue::kEnamel)] = 100e-9;
  in.after = in.before;
  EXPECT_EQ(score(in, default_rules(in)).completion, 0);
  EXPECT_EQ(score(in, default_rules(in)).points, 0);
  in.after[static_cast<std::size_t>(Tissue::kEnamel)] -= 1e-9;
  EXPECT_EQ(score(in, default_rules(in)).completion, 1);
  EXPECT_GT(score(in, default_rules(in)).points, 0);
}

TEST(Score, RoundingErrorsAreNeitherMeasuresNorTargets) {
  ScoreInput in;
  in.before[static_cast<std::size_t>(Tissue::kEnamel)] = 100e-9;
  in.after = in.before;
  in.after[static_cast<std::size_t>(Tissue::kEnamel)] -= 6.506e-17;  // m³
  in.ideal = in.before;
  (*in.ideal)[static_cast<std::size_t>(Tissue::kEnamel)] -= 1.519e-19;
  for (const ScoreItem& item : score(in, task_rules(Json::parse("{}", "task"), in)).items) {
    EXPECT_TRUE(item.value == 0 || std::abs(item.value) >= 1e-6 || std::isnan(item.value)) << item.name;
    EXPECT_TRUE(item.target == 0 || std::abs(item.target) >= 1e-6) << item.name;
  }
}

TEST(Quantities, AreWrittenWithoutPowersOfTenAndMissingOnesAsADash) {
  EXPECT_EQ(quantity_text(6.506e-08, "mm³", Language::kEnglish), "0\u00a0mm³");
  EXPECT_EQ(quantity_text(-1e-9, "mm", Language::kEnglish), "0\u00a0mm");
  EXPECT_EQ(quantity_text(std::nan(""), "mm", Language::kEnglish), "–");
  EXPECT_EQ(quantity_text(1.98, "mm", Language::kGerman), "1,98\u00a0mm");
  EXPECT_EQ(quantity_text(12345678, "mm³", Language::kEnglish), "12345678\u00a0mm³");
  EXPECT_EQ(quantity_text(3, "", Language::kEnglish), "3");
}

TEST(HandMeter, DivisionIntoPartsMakesNoDifferenceAndInvalidTicksAreOmitted) {
  auto ticks = test::random_ticks(2000, 5);
  HandMeter whole(1000), pieces(1000);
  whole.add(ticks);
  for (std::size_t i = 0; i < ticks.size(); i += 7)
    pieces.add(std::span(ticks).subspan(i, std::min<std::size_t>(7, ticks.size() - i)));
  EXPECT_EQ(whole.result().path_length, pieces.result().path_length);
  EXPECT_EQ(whole.result().tremor_rms, pieces.result().tremor_rms);
  EXPECT_EQ(whole.result().strokes, pieces.result().strokes);
  ticks[700].X_WT.p.x = std::nan("");
  ticks[701].f_T_W.z = std::numeric_limits<double>::infinity();
  HandMeter broken(1000);
  broken.add(ticks);
  EXPECT_TRUE(std::isfinite(broken.result().path_length));
  EXPECT_TRUE(std::isfinite(broken.result().force_mean));
}

ScoreInput carious() {
  ScoreInput in;
  in.before[1] = 200e-9;
  in.before[2] = 400e-9;
  in.before[3] = 10e-9;
  in.before[4] = 20e-9;
  in.after = in.before;
  return in;
}

TEST(Score, OneToleranceBeyondTheTargetLeavesHalfTwoAThird) {
  ScoreInput in = carious();
  in.after[3] = 0;
  in.hand.force_max = 3;
  const ScoreRule rule{"force_max_N", 3, 2, 10, Best::kAtMost, ""};
  EXPECT_DOUBLE_EQ(score(in, {&rule, 1}).points, 100);
  in.hand.force_max = 5;
  EXPECT_DOUBLE_EQ(score(in, {&rule, 1}).points, 50);
  in.hand.force_max = 7;
  EXPECT_DOUBLE_EQ(score(in, {&rule, 1}).points, 100.0 / 3);
}

TEST(Score, HasAHundredPointsDividedByTheWeights) {
  ScoreInput in = carious();
  in.after[3] = 0;
  in.hand.force_max = 5;
  const std::vector<ScoreRule> rules = {{"force_max_N", 3, 2, 30, Best::kAtMost, ""},
                                        {"residual_caries_percent", 0, 10, 90, Best::kAtMost, ""},
                                        {"strokes", 0, 10, 0, Best::kAtMost, ""}};
  const Score s = score(in, rules);
  EXPECT_DOUBLE_EQ(s.full, 100);
  EXPECT_DOUBLE_EQ(s.items[0].full, 25);
  EXPECT_DOUBLE_EQ(s.items[0].points, 12.5);
  EXPECT_DOUBLE_EQ(s.items[1].points, 75);
  EXPECT_DOUBLE_EQ(s.items[2].full, 0);
  EXPECT_DOUBLE_EQ(s.points, 87.5);
  EXPECT_FALSE(score(in, {&rules[2], 1}).counts());
}

TEST(Score, AHalfDoneTaskShowsPerfectItemsInFullAndCountsHalfOfTheirSum) {
  ScoreInput in = carious();
  in.after[3] = 0.5 * in.before[3];
  const std::vector<ScoreRule> rules = {{"pulp_removed_mm3", 0, 1, 1, Best::kAtMost, ""},
                                        {"force_max_N", 3, 2, 1, Best::kAtMost, ""}};
  const Score s = score(in, rules);
  EXPECT_DOUBLE_EQ(s.completion, 0.5);
  for (const ScoreItem& item : s.items) EXPECT_DOUBLE_EQ(item.points, item.full) << item.name;
  EXPECT_DOUBLE_EQ(s.points, 50);
}

TEST(PassMark, AScoreEqualToThePassMarkPassesAndALowerOneFails) {
  ScoreInput in = carious();
  in.after[3] = 0;
  in.hand.force_max = 5;  // half of its points
  const auto scored = [&](const std::string& pass) {
    return score_of_scene(
        Json::parse(R"({"task": {"goal": "g", "defaults": false, )" + pass +
                        R"("rules": [{"name": "force_max_N", "target": 3, "tolerance": 2, "weight": 1}]}})",
                    "s"),
        in);
  };
  const Score usual = scored("");
  EXPECT_EQ(usual.pass.points, 75);
  EXPECT_THAT(usual.pass.source, HasSubstr("ADEX"));
  EXPECT_TRUE(has_text(usual.pass.source));
  EXPECT_FALSE(usual.passed());
  EXPECT_TRUE(usual.missed(usual.items[0]));
  const Score own = scored(R"("pass": {"points": 50, "source": "Course 3"}, )");
  EXPECT_EQ(own.pass.source, "Course 3");
  EXPECT_TRUE(own.passed());
  EXPECT_FALSE(own.missed(own.items[0]));
  EXPECT_THROW(scored(R"("pass": {"points": 101, "source": "x"}, )"), Error);
  EXPECT_THROW(scored(R"("pass": {"points": 50}, )"), Error);
}

TEST(Score, ACriticalErrorFailsASessionWithEnoughPointsAndOnlyBeyondItsLimit) {
  ScoreInput in = carious();
  in.after[3] = 0;
  const auto scored = [&](double force, const std::string& kind) {
    in.hand.force_max = force;
    const std::string rules = R"([{"name": "residual_caries_percent", "target": 0, "tolerance": 1, "weight": 9},
                                  {"name": "force_max_N", "target": 3, "tolerance": 2, "weight": 1, "critical": 1.5)";
    return score_of_scene(
        Json::parse(R"({"task": {"goal": "g", "defaults": false, "rules": )" + rules + kind + "}]}}", "s"), in);
  };
  for (const auto& [force, kind, critical] :
       std::initializer_list<std::tuple<double, const char*, bool>>{{4.5, "", false},
                                                                    {4.6, "", true},
                                                                    {1.4, "", false},
                                                                    {1.4, R"(, "best": "near")", true},
                                                                    {1.4, R"(, "best": "at_least")", true},
                                                                    {9, R"(, "best": "at_least")", false}}) {
    const Score s = scored(force, kind);
    EXPECT_GE(s.points, 90);
    EXPECT_EQ(s.items[1].critical, critical) << force << kind;
    EXPECT_EQ(s.passed(), !critical) << force << kind;
    EXPECT_EQ(s.missed(s.items[1]), s.items[1].critical || s.items[1].points < 7.5) << force << kind;
  }
}

TEST(Score, AnOpenedPulpIsACriticalErrorUnlessTheIdealOpensIt) {
  ScoreInput in = carious();
  in.after[3] = 0;
  in.after[4] = in.before[4] - 0.1e-9;  // pulp
  EXPECT_TRUE(score(in, default_rules(in)).failed_critically());
  in.ideal = in.after;
  EXPECT_FALSE(score(in, task_rules(Json::parse("{}", "s"), in)).failed_critically());
}

TEST(Score, UnknownMeasuresAreOmittedWithTheirWeight) {
  ScoreInput in = carious();
  in.before[3] = in.after[3] = 0;  // no caries
  in.before[4] = in.after[4] = 0;  // no pulp
  const Score s = score(in, default_rules(in));
  for (const ScoreItem& item : s.items) {
    EXPECT_THAT(item.name, testing::Not(HasSubstr("caries")));
    EXPECT_THAT(item.name, testing::Not(HasSubstr("pulp")));
    EXPECT_THAT(item.name, testing::Not(HasSubstr("_cut_")));
  }
  double full = 0;
  for (const ScoreItem& item : s.items) full += item.full;
  EXPECT_DOUBLE_EQ(full, s.full);
}

TEST(Score, OverAndUnderCutAreCountedAgainstTheIdealTissueByTissue) {
  ScoreInput in = carious();
  in.ideal = in.before;
  (*in.ideal)[3] = 0;
  (*in.ideal)[1] = 195e-9;
  in.after[3] = 1e-9;    // 1 mm³ of caries left
  in.after[1] = 192e-9;  // 3 mm³ of enamel too much
  const std::vector<ScoreRule> rules = {{"over_cut_mm3", 0, 1, 1, Best::kAtMost, ""},
                                        {"under_cut_mm3", 0, 1, 1, Best::kAtMost, ""}};
  const Score s = score(in, rules);
  EXPECT_NEAR(s.items[0].value, 3, 1e-9);
  EXPECT_NEAR(s.items[1].value, 1, 1e-9);
  EXPECT_NEAR(s.completion, 14.0 / 15.0, 1e-9);
}

std::string message_of(const std::string& json) {
  return test::refusal([&] { rules_from(Json::parse(json, "scene.json"), carious()); });
}

TEST(ScoreRules, OfASceneReplaceTheDefaultsOfTheSameName) {
  const ScoreInput in = carious();
  const auto rules = rules_from(
      Json::parse(
          R"({"rules": [{"name": "time_s", "target": 60, "tolerance": 30, "weight": 7, "source": "Course 3"}]})", "s"),
      in);
  EXPECT_EQ(rules.size(), default_rules(in).size());
  const auto it = std::find_if(rules.begin(), rules.end(), [](const ScoreRule& r) { return r.name == "time_s"; });
  ASSERT_NE(it, rules.end());
  EXPECT_EQ(it->target, 60);
  EXPECT_EQ(it->weight, 7);
  EXPECT_EQ(it->source, "Course 3");
  const auto alone = rules_from(
      Json::parse(R"({"defaults": false, "rules": [{"name": "strokes", "target": 10, "tolerance": 5, "weight": 1}]})",
                  "s"),
      in);
  EXPECT_EQ(alone.size(), 1u);
}

const ScoreRule& rule_named(const std::vector<ScoreRule>& rules, const std::string& name) {
  const auto it = std::find_if(rules.begin(), rules.end(), [&](const ScoreRule& r) { return r.name == name; });
  EXPECT_NE(it, rules.end()) << name;
  return *it;
}

TEST(ScoreRules, AnIdealThatLeavesCariesAndOpensThePulpScoresFullByTheDefaults) {
  ScoreInput in = carious();
  in.ideal = in.before;
  (*in.ideal)[1] -= 7e-9;
  (*in.ideal)[3] *= 0.2;
  (*in.ideal)[4] -= 1.5e-9;
  in.after = *in.ideal;
  in.hand.force_max = 2;
  const auto rules = rules_from(Json::parse("{}", "s"), in);
  const Score ideal = score(in, rules);
  EXPECT_DOUBLE_EQ(ideal.points, ideal.full);
  EXPECT_NEAR(rule_named(rules, "residual_caries_percent").target, 20, 1e-9);
  in.after[3] += 0.5e-9;
  EXPECT_LT(score(in, rules).points, ideal.points);
  in.after = *in.ideal;
  in.after[4] -= 0.1e-9;
  EXPECT_LT(score(in, rules).points, ideal.points);
}

TEST(ScoreRules, AMissingTargetIsNeverTakenFromTheScoredSessionItself) {
  ScoreInput in = carious();
  in.damage = DamageMeasures{true, true, 5e-9, 3e-9, {}};
  in.hand.force_max = 9;
  const std::string block =
      R"({"rules": [{"name": "force_max_N", "tolerance": 1, "weight": 5}, {"name": "neighbour_removed_mm3", "tolerance": 1, "weight": 5},
      {"name": "gingiva_removed_mm3", "tolerance": 1, "weight": 5}]})";
  for (const bool with_ideal : {false, true}) {
    if (with_ideal) {
      in.ideal = in.before;
      (*in.ideal)[3] = 0;
    }
    const auto rules = rules_from(Json::parse(block, "s"), in);
    EXPECT_EQ(rule_named(rules, "force_max_N").target, 3);
    EXPECT_EQ(rule_named(rules, "neighbour_removed_mm3").target, 0);
    EXPECT_EQ(rule_named(rules, "gingiva_removed_mm3").target, 0);
  }
}

TEST(ScoreRules, InvalidRulesAreReported) {
  EXPECT_THAT(message_of(R"({"rules": [{"name": "taper_deg", "tolerance": 1, "weight": 1}]})"),
              HasSubstr("there is no ideal to take it from"));
  EXPECT_THAT(message_of(R"({"rulez": []})"), HasSubstr("\"rulez\": found an unknown key"));
  EXPECT_THAT(message_of(R"({"rules": [{"name": "beauty", "target": 0, "tolerance": 1, "weight": 1}]})"),
              HasSubstr("\"rules[0].name\": found \"beauty\", expected one of residual_caries_mm3"));
  EXPECT_THAT(message_of(R"({"rules": [{"name": "time_s", "target": 0, "tolerance": 0, "weight": 1}]})"),
              HasSubstr("\"rules[0].tolerance\": found 0"));
  EXPECT_THAT(message_of(R"({"rules": [{"name": "time_s", "target": 0, "tolerance": 1, "weight": -1}]})"),
              HasSubstr("\"rules[0].weight\": found -1"));
  EXPECT_THAT(
      message_of(R"({"rules": [{"name": "time_s", "target": 0, "tolerance": 1, "weight": 1, "critical": -1}]})"),
      HasSubstr("\"rules[0].critical\": found -1"));
  EXPECT_THAT(message_of(R"({"rules": [{"name": "time_s", "target": 0, "tolerance": 1, "weight": 1, "best": "big"}]})"),
              HasSubstr("at_most, at_least or near"));
  EXPECT_THAT(message_of(R"({"rules": [{"name": "time_s", "target": 0, "tolerance": 1, "weight": 1},
                                       {"name": "time_s", "target": 0, "tolerance": 1, "weight": 1}]})"),
              HasSubstr("each rule once"));
}

}  // namespace
}  // namespace typodont::session
