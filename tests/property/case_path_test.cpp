// The path of cases: its limits for random histories, and simulated learners. Simulated learners are not people.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>

#include "engine/app/cases/next_case.h"

namespace typodont {
namespace {

const SkillTable& table() {
  static const SkillTable read = skill_table();
  return read;
}
const std::vector<TrainedFamily>& families() {
  static const std::vector<TrainedFamily> read = trained_by(table(), case_families());
  return read;
}
double logistic(double x) {
  return 1 / (1 + std::exp(-x));
}

NextCase next_for(const PathLimits& limits, const std::vector<PastSession>& past, const std::string& trainee = "") {
  return next_case(table(), families(), limits, past, mastery_after(table(), past), trainee);
}

std::vector<PastSession> random_past(std::mt19937_64& random) {
  std::uniform_real_distribution<double> any(0, 1);
  std::vector<PastSession> past(random() % 12);
  for (PastSession& one : past) {
    const TrainedFamily& family = families()[random() % families().size()];
    one = {family.name, random() % 5, any(random),
           any(random) < 0.5 ? std::optional(1000 * any(random)) : std::nullopt};
    for (const double trained : family.shares)
      one.shares.push_back(trained > 0 ? std::optional(any(random)) : std::nullopt);
  }
  return past;
}

TEST(CasePath, TheNextCaseIsAlwaysWithinTheTeachersLimitsAndEqualForEqualHistories) {
  std::mt19937_64 random{5};
  std::uniform_real_distribution<double> any(0, 1);
  for (int i = 0; i < 2000; ++i) {
    PathLimits limits;
    for (const TrainedFamily& family : families())
      if (any(random) < 0.4) limits.families.push_back(family.name);
    std::ranges::shuffle(limits.families, random);
    limits.min_difficulty = any(random);
    limits.max_difficulty = limits.min_difficulty + (1 - limits.min_difficulty) * any(random);
    limits.in_order = any(random) < 0.5;
    const std::vector<PastSession> past = random_past(random);
    const NextCase next = next_for(limits, past, "Anna"), again = next_for(limits, past, "Anna");
    ASSERT_GE(next.difficulty, limits.min_difficulty);
    ASSERT_LE(next.difficulty, limits.max_difficulty);
    const std::string& family = families()[next.family].name;
    ASSERT_TRUE(limits.families.empty() || std::ranges::find(limits.families, family) != limits.families.end());
    ASSERT_GT(families()[next.family].shares[next.skill], 0);
    for (const PastSession& one : past) ASSERT_FALSE(one.family == family && one.seed == next.seed);
    ASSERT_EQ(std::tuple(next.family, next.skill, next.difficulty, next.seed),
              std::tuple(again.family, again.skill, again.difficulty, again.seed));
    ASSERT_NE(next.seed, next_for(limits, past, "Ben").seed);
  }
}

TEST(CasePath, InTheTeachersOrderAFamilyFollowsWhenTheSkillsBeforeItAreMastered) {
  const PathLimits limits{.families = {"class-5", "class-1"}, .max_difficulty = 0.5, .in_order = true};
  const auto after = [&](double share) {
    std::vector<PastSession> past(20, {"class-5", 1, 0.5, {}, {}});
    for (PastSession& one : past) one.shares.assign(table().skills.size(), share);
    return families()[next_for(limits, past).family].name;
  };
  EXPECT_EQ(families()[next_for(limits, {}).family].name, "class-5");
  EXPECT_EQ(after(0.5), "class-5");
  EXPECT_EQ(after(0.95), "class-1");
}

TEST(CasePath, ItTrainsTheWeakestSkillAndGetsHarderWithTheTrainee) {
  for (std::size_t weak = 0; weak < table().skills.size(); ++weak) {
    if (std::ranges::none_of(families(), [&](const auto& family) { return family.shares[weak] > 0.03; })) continue;
    std::vector<PastSession> past(5, {"", 1, 0.5, {}, {}});
    for (PastSession& one : past) {
      one.shares.assign(table().skills.size(), 0.85);
      one.shares[weak] = 0.6;
    }
    const NextCase next = next_for({}, past);
    EXPECT_EQ(table().skills[next.skill].name, table().skills[weak].name);
    EXPECT_EQ(next.difficulty, 0);
    for (PastSession& one : past) one.shares.assign(table().skills.size(), 0.95);
    EXPECT_EQ(next_for({}, past).difficulty, 1);
  }
}

/// The families of the simulated course.
const std::vector<TrainedFamily>& course() {
  static const std::vector<TrainedFamily> chosen = [] {
    std::vector<TrainedFamily> of;
    for (const char* name : {"class-1", "caries", "class-2-mo", "class-2-do", "class-2-mod", "class-3", "class-5",
                             "access-front", "access-premolar", "access-molar", "crown-zirconia"})
      of.push_back(*std::ranges::find(families(), name, &TrainedFamily::name));
    return of;
  }();
  return chosen;
}

/// A simulated learner. The deviation from the ideal, relative to the tolerance, follows the power law of practice
/// (Newell & Rosenbloom 1981). The points are 1 / (1 + deviation / tolerance), so their logit grows by the rate times
/// the logarithm of the practised cases.
struct Cohort {
  const char* what;
  double rate = 0.4;    // exponent of the power law; an estimate
  double within = 0.5;  // deviation of a learner's skills at the start, logits: the lowest means of a rubric's criteria
                        // are 56 and 67 % where the mean is 76 % (Habib 2018)
  double attempts = 8;  // a mean skill is mastered after so many cases (Mhanni and others 2025)
  double between = 0.2;       // deviation of the logarithm of these cases: the halves of a class need 9 and 12 weeks
                              // (Ben-Gal and others 2017)
  bool hard_teaches = false;  // true: a case teaches in proportion to p (1 − p), so most at half of the points
};

constexpr int kLearners = 1000, kMostCases = 400;

/// Number of cases until a learner has mastered every skill at the largest difficulty.
int cases_to_mastery(const Cohort& cohort, unsigned learner, bool path) {
  std::mt19937_64 random{learner}, noise{learner + 1'000'000};
  std::normal_distribution<double> normal;
  const MasteryModel& model = table().model;
  const std::size_t skills = table().skills.size();
  const double aim = std::log(model.goal / (1 - model.goal)) + model.item_difficulty(1);
  const double attempts = cohort.attempts * std::exp(cohort.between * normal(random));
  std::vector<double> start(skills), practice(skills);
  std::vector<bool> taught(skills);
  for (std::size_t i = 0; i < skills; ++i) {
    start[i] = aim - cohort.rate * std::log1p(attempts) + cohort.within * normal(random);
    taught[i] = std::ranges::any_of(course(), [&](const TrainedFamily& f) { return f.shares[i] >= 0.025; });
  }
  std::vector<Mastery> mastery(skills, unknown_mastery(model));
  std::vector<PastSession> past;
  for (int n = 0; n < kMostCases; ++n) {
    const auto ability = [&](std::size_t i) { return start[i] + cohort.rate * std::log1p(practice[i]); };
    bool all = true;
    for (std::size_t i = 0; i < skills; ++i) all = all && (!taught[i] || ability(i) >= aim);
    if (all) return n;
    // The fixed order: each family once, then again, at the difficulties 0, ½ and 1, then always at 1.
    const auto round = static_cast<std::size_t>(n) / course().size();
    NextCase next{.family = static_cast<std::size_t>(n) % course().size(),
                  .difficulty = std::min(1.0, 0.5 * static_cast<double>(round))};
    if (path) next = next_case(table(), course(), {}, past, mastery, "");
    const TrainedFamily& family = course()[next.family];
    for (std::size_t i = 0; i < skills; ++i) {
      if (family.shares[i] <= 0) continue;
      const double logit = ability(i) - model.item_difficulty(next.difficulty), p = logistic(logit);
      observe(model, mastery[i], next.difficulty, logistic(logit + model.noise_sd * normal(noise)), 0);
      if (family.shares[i] >= 0.025) practice[i] += cohort.hard_teaches ? 4 * p * (1 - p) : 1;
    }
    past.push_back({family.name, next.seed, next.difficulty, {}, {}});
  }
  return kMostCases;
}

struct Saving {
  double fixed = 0, path = 0;           // mean number of cases
  double share = 0, low = 0, high = 0;  // saved fraction of all cases, with its 95 % interval
};
Saving saving(const Cohort& cohort) {
  std::vector<double> fixed, path;
  Saving s;
  for (unsigned i = 0; i < kLearners; ++i) {
    fixed.push_back(cases_to_mastery(cohort, i, false)), path.push_back(cases_to_mastery(cohort, i, true));
    s.fixed += fixed.back() / kLearners, s.path += path.back() / kLearners;
  }
  double squares = 0;
  for (std::size_t i = 0; i < kLearners; ++i) squares += std::pow(path[i] - s.path / s.fixed * fixed[i], 2);
  const double half = 1.96 * std::sqrt(squares / kLearners / kLearners) / s.fixed;
  s.share = 1 - s.path / s.fixed, s.low = s.share - half, s.high = s.share + half;
  std::printf("%s: %.1f cases in the fixed order, %.1f on the path, %.1f %% fewer (95 %%: %.1f to %.1f)\n", cohort.what,
              s.fixed, s.path, 100 * s.share, 100 * s.low, 100 * s.high);
  return s;
}

TEST(CasePath, AThousandSimulatedLearnersNeedAQuarterFewerCasesThanInAFixedOrder) {
  for (const Cohort& cohort : {Cohort{.what = "learners"}, Cohort{.what = "with more equal skills", .within = 0.3},
                               Cohort{.what = "with a rate of 0.5", .rate = 0.5}})
    EXPECT_GT(saving(cohort).low, 0.25) << cohort.what;
}

TEST(CasePath, SimulatedLearnersWhomHardCasesTeachMostNeedFewerCasesToo) {
  EXPECT_GT(saving({.what = "whom hard cases teach most", .hard_teaches = true}).low, 0.05);
}

}  // namespace
}  // namespace typodont
