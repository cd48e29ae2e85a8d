// Scores obey two laws, whatever the session: a perfect result scores full, and every worsening lowers the score.
#include <gtest/gtest.h>

#include "engine/session/score.h"
#include "tests/support/session_fixture.h"

namespace typodont::session {
namespace {

using test::Random;

constexpr std::size_t kEnamel = 1, kDentin = 2, kCaries = 3, kPulp = 4;

ScoreInput perfect(Random& random, bool with_ideal) {
  ScoreInput in;
  in.before[kEnamel] = (150 + random.number(50)) * 1e-9;
  in.before[kDentin] = (300 + random.number(50)) * 1e-9;
  in.before[kCaries] = (8 + random.number(5)) * 1e-9;
  in.before[kPulp] = (20 + random.number(5)) * 1e-9;
  in.after = in.before;
  in.after[kCaries] = 0;
  if (with_ideal) {
    in.after[kEnamel] -= 2e-9;
    in.ideal = in.after;
  }
  in.hand.time = 100;
  in.hand.contact_time = 50;
  in.hand.force_mean = 0.5;
  in.hand.force_max = 2;
  in.hand.strokes = 12;
  in.hand.path_length = 0.2;
  in.hand.tremor_rms = 40e-6;
  in.pulp_distance = 1e-3;
  return in;
}

struct Worsening {
  const char* name;
  void (*apply)(ScoreInput&, double);  // by an amount of about 0 to 1
};
// Each from the perfect side of its target outwards, so that the target is crossed on the way.
const Worsening kWorsenings[] = {
    {"caries left", [](ScoreInput& in, double d) { in.after[kCaries] += d * (in.before[kCaries] - in.after[kCaries]); }},
    {"pulp cut", [](ScoreInput& in, double d) { in.after[kPulp] -= d * 0.5e-9; }},
    {"force", [](ScoreInput& in, double d) { in.hand.force_max = std::max(in.hand.force_max, 3.0) + 10 * d; }},
    {"mean force", [](ScoreInput& in, double d) { in.hand.force_mean = std::max(in.hand.force_mean, 1.0) + 3 * d; }},
    {"time", [](ScoreInput& in, double d) { in.hand.time = std::max(in.hand.time, 600.0) + 1000 * d; }},
    {"tremor", [](ScoreInput& in, double d) { in.hand.tremor_rms = std::max(in.hand.tremor_rms, 100e-6) + 1e-3 * d; }},
    {"near the pulp", [](ScoreInput& in, double d) { in.pulp_distance = std::min(*in.pulp_distance, 0.5e-3) * (1 - d); }},
    {"healthy tissue",
     [](ScoreInput& in, double d) {
       // Beyond what is free for the access.
       in.after[kDentin] = std::min(in.after[kDentin], in.before[kDentin] - in.before[kCaries]) - 20e-9 * d;
     }},
};

TEST(ScoreLaws, APerfectResultScoresFull) {
  Random random(1);
  for (int i = 0; i < 200; ++i) {
    const ScoreInput in = perfect(random, i % 2 == 1);
    const Score s = score(in, default_rules(in));
    ASSERT_NEAR(s.points, s.full, 1e-9 * s.full);
    ASSERT_GT(s.full, 50);
  }
}

TEST(ScoreLaws, EveryWorseningLowersTheScoreFromAnyState) {
  Random random(2);
  for (int i = 0; i < 500; ++i) {
    ScoreInput in = perfect(random, i % 2 == 1);
    // Somewhere between perfect and bad.
    for (const Worsening& w : kWorsenings) {
      if (random.engine() % 2) w.apply(in, 0.5 * std::abs(random.number(1)));
    }
    const auto rules = default_rules(in);
    const double before = score(in, rules).points;
    for (const Worsening& w : kWorsenings) {
      ScoreInput worse = in;
      w.apply(worse, 0.01 + 0.9 * std::abs(random.number(1)));
      ASSERT_LT(score(worse, rules).points, before) << w.name;
    }
  }
}

TEST(ScoreLaws, PointsStayBetweenNothingAndTheirWeightAndAddUp) {
  Random random(3);
  for (int i = 0; i < 500; ++i) {
    ScoreInput in;
    for (std::size_t k = 1; k < kTissueCount; ++k) {
      in.before[k] = std::abs(random.number(1e-7));
      in.after[k] = std::abs(random.number(1e-7));
    }
    if (i % 2) {
      in.ideal.emplace();
      for (double& v : *in.ideal) v = std::abs(random.number(1e-7));
    }
    in.hand.force_max = std::abs(random.number(100));
    in.hand.time = std::abs(random.number(1e5));
    const Score s = score(in, default_rules(in));
    double sum = 0;
    for (const ScoreItem& item : s.items) {
      ASSERT_GE(item.points, 0);
      ASSERT_LE(item.points, item.weight);
      sum += item.points;
    }
    ASSERT_DOUBLE_EQ(sum, s.points);
  }
}

}  // namespace
}  // namespace typodont::session
