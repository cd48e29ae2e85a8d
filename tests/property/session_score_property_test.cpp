// Tests that scores obey two laws in any session: a perfect result gets the full score, and every worsening lowers the
// score.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

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
  void (*apply)(ScoreInput&, double);  // worsens by an amount of about 0 to 1
};
// Each worsening starts on the perfect side of its target and moves across the target.
const Worsening kWorsenings[] = {
    {"caries left",
     [](ScoreInput& in, double d) { in.after[kCaries] += d * (in.before[kCaries] - in.after[kCaries]); }},
    {"pulp cut", [](ScoreInput& in, double d) { in.after[kPulp] -= d * 0.5e-9; }},
    {"force", [](ScoreInput& in, double d) { in.hand.force_max = std::max(in.hand.force_max, 3.0) + 10 * d; }},
    {"mean force", [](ScoreInput& in, double d) { in.hand.force_mean = std::max(in.hand.force_mean, 1.0) + 3 * d; }},
    {"time", [](ScoreInput& in, double d) { in.hand.time = std::max(in.hand.time, 600.0) + 1000 * d; }},
    {"tremor", [](ScoreInput& in, double d) { in.hand.tremor_rms = std::max(in.hand.tremor_rms, 100e-6) + 1e-3 * d; }},
    {"near the pulp",
     [](ScoreInput& in, double d) { in.pulp_distance = std::min(*in.pulp_distance, 0.5e-3) * (1 - d); }},
    {"healthy tissue",
     [](ScoreInput& in, double d) {
       // Removes more than the volume that access may remove without loss of points.
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

TEST(ScoreLaws, EveryDefectLowersTheScoreFromAnyState) {
  Random random(2);
  for (int i = 0; i < 500; ++i) {
    ScoreInput in = perfect(random, i % 2 == 1);
    // A random state between perfect and bad.
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

TEST(ScoreLaws, PointsAreWithinTheirRangeAddUpTo100AndAreWeightedByCompletion) {
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
    double sum = 0, full = 0;
    for (const ScoreItem& item : s.items) {
      ASSERT_GE(item.points, 0);
      ASSERT_LE(item.points, item.full);
      sum += item.points;
      full += item.full;
    }
    ASSERT_NEAR(full, 100, 1e-9);
    ASSERT_NEAR(s.completion * sum, s.points, 1e-9);
    ASSERT_LE(s.points, s.full);
  }
}

/// Makes one measure worse by `d` times its tolerance, and begins at its target. The tolerance is 1 millimetre, 1
/// newton and so on, in SI units.
struct MeasureWorsening {
  const char* name;
  double target;  // target in the measure's unit
  void (*set)(ScoreInput&, double value);
  Best best = Best::kAtMost;
  bool is_size = false;  // never below zero
  double step = 1;       // number of its units in one step for which also an integer changes
};
const MeasureWorsening kMeasures[] = {
    {"residual_caries_mm3", 0, [](ScoreInput& in, double v) { in.after[kCaries] = v * 1e-9; }},
    {"residual_caries_percent", 0, [](ScoreInput& in, double v) { in.after[kCaries] = v / 100 * in.before[kCaries]; }},
    {"over_cut_mm3", 0, [](ScoreInput& in, double v) { in.cavity->over_volume = v * 1e-9; }},
    {"under_cut_mm3", 0, [](ScoreInput& in, double v) { in.cavity->under_volume = v * 1e-9; }},
    {"over_cut_depth_mm", 0, [](ScoreInput& in, double v) { in.cavity->over.depth = v * 1e-3; }},
    {"under_cut_depth_mm", 0, [](ScoreInput& in, double v) { in.cavity->under.depth = v * 1e-3; }},
    {"contour_rms_um", 0, [](ScoreInput& in, double v) { in.cavity->contour = v * 1e-6; }},
    {"floor_depth_mm", 2, [](ScoreInput& in, double v) { in.cavity->floor_depth = v * 1e-3; }, Best::kNear},
    {"floor_flatness_um", 0, [](ScoreInput& in, double v) { in.cavity->floor_flatness = v * 1e-6; }},
    {"floor_tilt_deg", 0, [](ScoreInput& in, double v) { in.cavity->floor_tilt = v * 3.14159265358979 / 180; }},
    {"taper_deg", 6, [](ScoreInput& in, double v) { in.cavity->taper = v * 3.14159265358979 / 180; }, Best::kNear},
    {"axial_depth_mm", 1, [](ScoreInput& in, double v) { in.cavity->wall_depth = v * 1e-3; }, Best::kNear},
    {"isthmus_mm", 1.5, [](ScoreInput& in, double v) { in.cavity->isthmus = v * 1e-3; }, Best::kNear},
    {"wall_thickness_mm", 2, [](ScoreInput& in, double v) { in.cavity->wall_thickness = v * 1e-3; }, Best::kAtLeast},
    {"margin_roughness_um", 0, [](ScoreInput& in, double v) { in.cavity->margin_roughness = v * 1e-6; }},
    {"cup_center_mm", 0, [](ScoreInput& in, double v) { in.cavity->cup_offset = v * 1e-3; }},
    {"cup_radius_mm", 30,
     [](ScoreInput& in, double v) {
       in.cavity->cup = CavityMeasures::Cup{{}, v * 1e-3, {0, 0, 1}};
     }},
    {"cup_angle_deg", 0, [](ScoreInput& in, double v) { in.cavity->cup_tilt = v * 3.14159265358979 / 180; }},
    {"healthy_removed_mm3", 0, [](ScoreInput& in, double v) { in.after[kEnamel] = in.before[kEnamel] - v * 1e-9; }},
    {"gingiva_removed_mm3", 0, [](ScoreInput& in, double v) { in.damage->gum_volume = v * 1e-9; }},
    {"neighbour_removed_mm3", 0, [](ScoreInput& in, double v) { in.damage->neighbour_volume = v * 1e-9; }},
    {"protected_removed_mm3", 0, [](ScoreInput& in, double v) { in.cavity->kept_removed = v * 1e-9; }},
    {"pulp_removed_mm3", 0, [](ScoreInput& in, double v) { in.after[kPulp] = in.before[kPulp] - v * 1e-9; }},
    {"pulp_distance_mm", 1, [](ScoreInput& in, double v) { in.cavity->pulp_distance = v * 1e-3; }, Best::kAtLeast},
    {"pulp_exposed_mm2", 0, [](ScoreInput& in, double v) { in.cavity->pulp_exposed = v * 1e-6; }},
    {"lesions_found_percent", 100,
     [](ScoreInput& in, double v) { in.explore->found = static_cast<int>(v / 100 * in.explore->lesions); },
     Best::kAtLeast},
    {"false_finds", 0, [](ScoreInput& in, double v) { in.explore->false_finds = static_cast<int>(std::ceil(v)); },
     Best::kAtMost, false, 5},
    {"explored_percent", 90, [](ScoreInput& in, double v) { in.explore->explored = v / 100; }, Best::kAtLeast},
    {"sites_within_1mm_percent", 100,
     [](ScoreInput& in, double v) {
       in.explore->sites.assign(1000, {0, 0.0011, 0});
       for (std::size_t i = 0; static_cast<double>(i) < 10 * v; ++i) in.explore->sites[i].reading = 0.0009;
     },
     Best::kAtLeast},
    {"probing_force_N", 0.3,
     [](ScoreInput& in, double v) {
       in.explore->sites.assign(1, {0, 0, 0});
       in.explore->probing_force = v;
     }},
    {"implant_phases_percent", 100,
     [](ScoreInput& in, double v) {
       in.implant->phases.assign(1000, {});
       for (std::size_t i = 0; i < 1000; ++i) in.implant->phases[i].done = static_cast<double>(i) < 10 * v;
     },
     Best::kAtLeast},
    {"implant_entry_mm", 0.3, [](ScoreInput& in, double v) { in.implant->bed.entry_error = v * 1e-3; }},
    {"implant_apex_mm", 0.5, [](ScoreInput& in, double v) { in.implant->bed.apex_error = v * 1e-3; }},
    {"implant_angle_deg", 1, [](ScoreInput& in, double v) { in.implant->bed.axis_error = v * 3.14159265358979 / 180; }},
    {"bed_depth_mm", 12, [](ScoreInput& in, double v) { in.implant->bed.depth = v * 1e-3; }, Best::kNear, true},
    {"bed_diameter_mm", 4.2, [](ScoreInput& in, double v) { in.implant->bed.diameter = v * 1e-3; }, Best::kNear, true},
    {"bed_ovality_mm", 0, [](ScoreInput& in, double v) { in.implant->bed.ovality = v * 1e-3; }},
    {"cortical_perforation_percent", 0, [](ScoreInput& in, double v) { in.implant->bed.perforated = v / 100; }},
    {"canal_distance_mm", 2, [](ScoreInput& in, double v) { in.implant->bed.canal_distance = v * 1e-3; },
     Best::kAtLeast},
    {"neighbour_distance_mm", 1.5, [](ScoreInput& in, double v) { in.implant->bed.neighbour_distance = v * 1e-3; },
     Best::kAtLeast},
    {"insertion_torque_Ncm", 35, [](ScoreInput& in, double v) { in.implant->insertion_torque = v / 100; }, Best::kNear},
    {"bone_contact_percent", 90, [](ScoreInput& in, double v) { in.implant->bone_contact = v / 100; }, Best::kAtLeast},
    {"over_force_s", 0, [](ScoreInput& in, double v) { in.implant->over_force = v; }},
    {"pulp_heating_K", 3, [](ScoreInput& in, double v) { in.heat->pulp_max = 37 + v; }},
    {"bone_temperature_C", 44, [](ScoreInput& in, double v) { in.implant->hottest = v; }},
    {"force_mean_N", 1, [](ScoreInput& in, double v) { in.hand.force_mean = v; }},
    {"force_max_N", 3, [](ScoreInput& in, double v) { in.hand.force_max = v; }},
    {"path_length_mm", 100, [](ScoreInput& in, double v) { in.hand.path_length = v * 1e-3; }},
    {"time_s", 600, [](ScoreInput& in, double v) { in.hand.time = v; }},
    {"contact_time_s", 300, [](ScoreInput& in, double v) { in.hand.contact_time = v; }},
    {"strokes", 10, [](ScoreInput& in, double v) { in.hand.strokes = static_cast<int>(std::ceil(v)); }, Best::kAtMost,
     false, 5},
    {"tremor_rms_um", 100, [](ScoreInput& in, double v) { in.hand.tremor_rms = v * 1e-6; }},
};

/// A session that has every measure, for the law of the measure `name`.
ScoreInput measured(Random& random, std::string_view name) {
  constexpr std::string_view kExplore[] = {"lesions_found", "explored", "false_finds", "sites_within", "probing_force"};
  constexpr std::string_view kImplant[] = {"implant_",           "bed_",       "cortical_", "canal_",
                                           "neighbour_distance", "insertion_", "bone_",     "over_force"};
  const auto starts = [&](std::string_view start) { return name.starts_with(start); };
  ScoreInput in = perfect(random, false);
  if (std::ranges::any_of(kExplore, starts)) {
    in.explore.emplace();
    in.explore->lesions = in.explore->found = 1000;
    in.explore->explored = 1;
    return in;
  }
  in.cavity.emplace();
  in.cavity->has_ideal = true;
  in.cavity->wanted = in.cavity->done = 1e-9;
  in.damage = DamageMeasures{true, true, 0, 0, {}};
  if (name == "pulp_heating_K") in.heat.emplace().pulp = true;
  if (std::ranges::any_of(kImplant, starts)) {
    in.implant.emplace();
    in.implant->phases.assign(1, {});
    in.implant->phases.front().done = in.implant->placed = in.implant->bed.found = true;
  }
  return in;
}

TEST(ScoreLaws, HoldForEveryMeasureAndOnBothSidesOfATarget) {
  std::vector<std::string> names;
  for (const MeasureWorsening& m : kMeasures) names.emplace_back(m.name);
  EXPECT_EQ(names.size(), known_score_names().size());
  for (const std::string& name : known_score_names())
    EXPECT_NE(std::find(names.begin(), names.end(), name), names.end()) << name;
  Random random(4);
  for (const MeasureWorsening& m : kMeasures) {
    for (const double way : {1.0, -1.0}) {
      if (m.best != Best::kNear && (way > 0) != (m.best == Best::kAtMost)) continue;
      ScoreInput in = measured(random, m.name);
      const ScoreRule rule{m.name, m.target, 10, 7, m.best, "", true};
      m.set(in, m.target);
      const Score full = score(in, std::array{rule});
      ASSERT_EQ(full.items.size(), 1u) << m.name;
      EXPECT_NEAR(full.points, full.full, 1e-9) << m.name;
      double last = full.points;
      for (double off = 0.4; off < 40; off *= 1.7) {  // in steps for which also integer counts change
        if (way < 0 && (m.best == Best::kAtLeast || m.is_size) && m.target - off < 0) break;
        m.set(in, m.target + way * off * m.step);
        const double points = score(in, std::array{rule}).points;
        EXPECT_LT(points, last) << m.name << " off by " << way * off;
        last = points;
      }
    }
  }
}

}  // namespace
}  // namespace typodont::session
