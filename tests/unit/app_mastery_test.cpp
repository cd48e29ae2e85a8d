// The estimate of a trainee's mastery against analytic solutions.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>

#include "engine/app/cases/mastery.h"
#include "engine/session/score.h"

namespace typodont {
namespace {

const MasteryModel kModel{
    .prior_sd = 1.5, .noise_sd = 0.8, .session_sd = 0.1, .day_sd = 0.05, .span = 0.5, .goal = 0.8};

double logit(double p) {
  return std::log(p / (1 - p));
}
double square(double x) {
  return x * x;
}

TEST(Mastery, TheFirstSessionGivesThePosteriorOfAGaussianPriorAndAGaussianObservation) {
  Mastery m = unknown_mastery(kModel);
  observe(kModel, m, 1, 0.7, 30);
  const double prior = square(1.5), noise = square(0.8);
  EXPECT_NEAR(m.variance, 1 / (1 / prior + 1 / noise), 1e-12);
  EXPECT_NEAR(m.ability, m.variance / noise * (logit(0.7) + 0.25), 1e-12);
}

TEST(Mastery, MorePointsAndHarderCasesGiveAHigherAbility) {
  double last = -100;
  for (const double share : {0.0, 0.1, 0.5, 0.9, 0.97}) {
    Mastery easy = unknown_mastery(kModel), hard = easy;
    observe(kModel, easy, 0, share, 0);
    observe(kModel, hard, 1, share, 0);
    EXPECT_GT(easy.ability, last);
    EXPECT_GT(hard.ability, easy.ability);
    last = easy.ability;
  }
}

TEST(Mastery, EqualSessionsConvergeToTheirLogitWithTheStandardErrorOfTheRiccatiEquation) {
  Mastery m = unknown_mastery(kModel);
  for (int i = 0; i < 300; ++i) observe(kModel, m, 0.5, 0.9, 0);
  const double q = square(0.1), r = square(0.8), before = (q + std::sqrt(q * q + 4 * q * r)) / 2;
  EXPECT_NEAR(m.ability, logit(0.9), 1e-9);
  EXPECT_NEAR(m.variance, before * r / (before + r), 1e-9);
  EXPECT_EQ(m.sessions, 300);
}

TEST(Mastery, APauseWidensTheErrorButNeverBeyondThatOfANewTrainee) {
  const auto gain_after = [](double days) {
    Mastery m = unknown_mastery(kModel);
    for (int i = 0; i < 50; ++i) observe(kModel, m, 0.5, 0.9, 0);
    const double before = m.ability;
    observe(kModel, m, 0.5, 0.5, days);
    return (before - m.ability) / before;  // the weight of the new session
  };
  EXPECT_GT(gain_after(100), gain_after(1) + 0.05);
  const double prior = square(1.5);
  EXPECT_NEAR(gain_after(1e9), prior / (prior + square(0.8)), 1e-9);
}

TEST(Mastery, TheExpectedShareIsTheMeanOfTheLogitNormalDistributionWithin002) {
  for (const double ability : {-1.0, 0.0, 1.5})
    for (const double variance : {0.1, 1.0, 2.25}) {
      const Mastery m{ability, variance, 1};
      const double mean = ability - 0.125, sd = std::sqrt(variance + square(0.8));
      double sum = 0;
      constexpr double kStep = 0.01;
      for (double z = -6; z <= 6; z += kStep)
        sum += kStep * std::exp(-z * z / 2) / std::sqrt(2 * std::numbers::pi) / (1 + std::exp(-(mean + sd * z)));
      EXPECT_NEAR(expected_share(kModel, m, 0.75), sum, 0.02) << ability << " " << variance;
      EXPECT_NEAR(expected_share(kModel, m, difficulty_for(kModel, m, 0.8)), 0.8, 1e-12);
    }
}

TEST(Mastery, TheLevelOfWarningsFallsLinearlyFromANewTraineeToTheGoal) {
  EXPECT_DOUBLE_EQ(warning_level(kModel, unknown_mastery(kModel)), 1);
  for (const double variance : {0.1, 1.0})
    for (const auto& [expected, level] : {std::pair{0.3, 1.0}, {0.5, 1.0}, {0.65, 0.5}, {0.8, 0.0}, {0.9, 0.0}}) {
      const double flat = std::sqrt(1 + std::numbers::pi * (variance + square(0.8)) / 8);
      EXPECT_NEAR(warning_level(kModel, {logit(expected) * flat, variance, 5}), level, 1e-12) << expected;
    }
}

TEST(Mastery, EachItemOfTheScoreBelongsToOneSkillAndASkillHasNoOtherItems) {
  const SkillTable table = skill_table();
  std::map<std::string, int> skills;
  for (const Skill& skill : table.skills) {
    for (const std::string& item : skill.items) ++skills[item];
    for (const std::string& title : skill.title.text) EXPECT_FALSE(title.empty()) << skill.name;
  }
  for (const std::string& name : session::known_score_names()) EXPECT_EQ(skills[name], 1) << name;
  EXPECT_EQ(skills.size(), session::known_score_names().size());
}

TEST(Mastery, ASkillsShareIsThatOfItsItemsTimesTheCompletion) {
  SkillTable table;
  table.skills = {{"a", {}, {"x", "y"}}, {"b", {}, {"z"}}};
  const std::vector<ItemPoints> items = {{"x", 4, 10}, {"y", 30, 30}, {"other", 1, 60}};
  const auto shares = shares_of(table, items, 0.5);
  EXPECT_DOUBLE_EQ(shares[0].value(), 0.5 * 34 / 40);
  EXPECT_FALSE(shares[1]);
}

}  // namespace
}  // namespace typodont
