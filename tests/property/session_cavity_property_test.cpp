// Tests that scores of geometry obey the same laws: the ideal gets the full score. Each excess cut and each uncut
// remainder lowers the score; larger errors lower it more.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <random>
#include <string_view>
#include <thread>
#include <vector>

#include "engine/base/units.h"
#include "engine/base/voxels.h"
#include "engine/session/dense_field.h"
#include "engine/session/score.h"
#include "tests/support/cavity_fixture.h"
#include "tests/support/session_fixture.h"

namespace typodont::session {
namespace {

using namespace test;

/// Returns all geometric rules, with the values of the ideal as targets.
std::vector<ScoreRule> all_rules(const ScoreInput& input) {
  const Json block = Json::parse(R"({"rules": [
    {"name": "over_cut_mm3", "target": 0, "tolerance": 1, "weight": 20},
    {"name": "under_cut_mm3", "target": 0, "tolerance": 1, "weight": 20},
    {"name": "over_cut_depth_mm", "target": 0, "tolerance": 0.3, "weight": 10},
    {"name": "under_cut_depth_mm", "target": 0, "tolerance": 0.3, "weight": 10},
    {"name": "contour_rms_um", "target": 0, "tolerance": 100, "weight": 10},
    {"name": "floor_depth_mm", "tolerance": 0.5, "weight": 1},
    {"name": "taper_deg", "tolerance": 10, "weight": 1},
    {"name": "isthmus_mm", "tolerance": 0.5, "weight": 1},
    {"name": "floor_flatness_um", "tolerance": 100, "weight": 1},
    {"name": "margin_roughness_um", "tolerance": 100, "weight": 1}]})",
                                 "rules");
  return rules_from(block, input);
}

struct Judged {
  Preparation preparation = a_block();
  ScoreInput input;
  std::vector<ScoreRule> rules;
  CavityReference reference;

  template <class Ideal>
  explicit Judged(Ideal ideal) {
    preparation.ideal = preparation.after = without(ideal);
    input.before[2] = 100e-9;
    input.after = input.before;
    reference = cavity_reference(preparation);
    input.cavity_ideal = reference.measures;
    input.cavity = input.cavity_ideal;
    rules = all_rules(input);
  }
  Score of(DenseField after) {
    preparation.after = std::move(after);
    input.cavity = measure_against_ideal(preparation, reference).result;
    return score(input, rules);
  }
};

/// Distances (voxels) to a random block with solids taken away and put back, composed by minimum and maximum.
class Composition {
 public:
  explicit Composition(std::mt19937& random) {
    const auto in = [&](double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random); };
    for (int k = 0; k < 5; ++k) {
      parts_.push_back({static_cast<int>(random() % 3), {in(8, 24), in(8, 24), in(8, 24)}, in(2, 7), in(2, 7)});
    }
  }
  float operator()(const glm::dvec3& p) const {
    const glm::dvec3 q = glm::abs(p - 16.0) - glm::dvec3(11, 10, 8);
    double d = glm::length(glm::max(q, 0.0)) + std::min(0.0, std::max({q.x, q.y, q.z}));
    for (std::size_t k = 0; k < parts_.size(); ++k)
      d = k + 1 < parts_.size() ? std::max(d, -distance(parts_[k], p)) : std::min(d, distance(parts_[k], p));
    return static_cast<float>(d);
  }

 private:
  struct Part {
    int kind;
    glm::dvec3 center;
    double radius, half;
  };
  static double distance(const Part& part, const glm::dvec3& p) {
    const glm::dvec3 r = p - part.center;
    if (part.kind == 0) return glm::length(r) - part.radius;
    const glm::dvec3 q = part.kind == 1 ? glm::dvec3(std::hypot(r.x, r.y) - part.radius, std::abs(r.z) - part.half, -99)
                                        : glm::abs(r) - glm::dvec3(part.radius, part.half, part.radius);
    return glm::length(glm::max(q, 0.0)) + std::min(0.0, std::max({q.x, q.y, q.z}));
  }
  std::vector<Part> parts_;
};

TEST(TrueDistances, AreThoseToTheSurfaceHoweverItsSolidsAreComposed) {
  std::mt19937 random(64);
  std::vector<double> errors;  // voxels
  double max_mend = 0;
  for (int round = 0; round < 12; ++round) {
    const Composition solid(random);
    session::DenseField field;
    field.size = glm::ivec3(33);
    for_each_voxel(glm::ivec3(33), [&](int x, int y, int z) { field.distance.push_back(solid({x, y, z})); });
    // Its surface, by points a quarter of a voxel apart in the cells that it crosses.
    std::vector<glm::dvec3> surface;
    for (int cell = 0; cell < 32 * 32 * 32; ++cell) {
      const glm::ivec3 lo(cell / 1024, cell / 32 % 32, cell % 32);
      int inside = 0;
      for (int corner = 0; corner < 8; ++corner)
        inside += field.distance[field.at(lo.x + (corner & 1), lo.y + (corner >> 1 & 1), lo.z + (corner >> 2))] < 0;
      if (inside == 0 || inside == 8) continue;
      for (int part = 0; part < 64; ++part) {
        const glm::dvec3 p = glm::dvec3(lo) + 0.25 * glm::dvec3(part / 16, part / 4 % 4, part % 4);
        for (int axis = 0; axis < 3; ++axis) {
          glm::dvec3 q = p;
          q[axis] += 0.25;
          const double d = field.sample(p), e = field.sample(q);
          if ((d < 0) != (e < 0)) surface.push_back(p + (q - p) * (d / (d - e)));
        }
      }
    }
    const session::TrueDistances distances(field);
    for (int k = 0; k < 400; ++k) {
      const glm::ivec3 p(random() % 33, random() % 33, random() % 33);
      const std::size_t at = field.at(p.x, p.y, p.z);
      double nearest = 1e9;
      for (const glm::dvec3& s : surface) nearest = std::min(nearest, glm::distance(s, glm::dvec3(p)));
      const auto given = static_cast<double>(field.distance[at]), told = static_cast<double>(distances[at]);
      EXPECT_EQ(told < 0, given < 0);
      errors.push_back(std::abs(std::abs(told) - nearest));
      if (std::abs(given) < 1.8) max_mend = std::max(max_mend, nearest - std::abs(given));
    }
  }
  std::ranges::sort(errors);
  EXPECT_LT(errors[errors.size() * 99 / 100], 0.5);
  EXPECT_LT(errors.back(), 1.2) << "at a corner, which samples cut off";
  EXPECT_GT(max_mend, 3) << "a field that was right needs no mending";
}

TEST(TrueDistances, ThreadsThatReadAtTheSameTimeReadEqualDistances) {
  std::mt19937 random(65);
  const Composition solid(random);
  session::DenseField field;
  field.size = glm::ivec3(33);
  for_each_voxel(glm::ivec3(33), [&](int x, int y, int z) { field.distance.push_back(solid({x, y, z})); });
  const session::TrueDistances shared(field);
  const session::DenseField expected = session::redistanced(field);
  std::atomic<int> different = 0;
  {
    std::vector<std::jthread> threads;
    for (int k = 0; k < 4; ++k)
      threads.emplace_back([&] {
        for (std::size_t at = 0; at < expected.distance.size(); ++at) different += shared[at] != expected.distance[at];
      });
  }
  EXPECT_EQ(different, 0);
}

TEST(CavityLaws, TheIdealScoresFullWhateverItsShape) {
  Random random(11);
  for (int i = 0; i < 4; ++i) {
    const double lean = random.number(8) * kPi / 180, depth = 1.4e-3 + random.number(0.4e-3);
    const dvec3 middle = kMiddle + dvec3(random.number(1e-3), random.number(1e-3), 0);
    const Judged judged(tapered_hole(1.3e-3 + random.number(0.3e-3), depth, lean, middle));
    const Score s = score(judged.input, judged.rules);
    ASSERT_NEAR(s.points, s.full, 1e-9 * s.full);
    ASSERT_EQ(s.completion, 1);
  }
}

TEST(CavityLaws, AMissingMeasureScoresZeroAndKeepsItsWeight) {
  Judged judged(tapered_box({1.4e-3, 1e-3}, 1.5e-3, 0));
  const Score none = judged.of(judged.preparation.before);
  const auto item = std::find_if(none.items.begin(), none.items.end(), [](auto& i) { return i.name == "taper_deg"; });
  ASSERT_NE(item, none.items.end());
  EXPECT_TRUE(std::isnan(item->value));
  EXPECT_EQ(item->points, 0);
  EXPECT_EQ(item->weight, 1);
}

constexpr double kDegree = kPi / 180, kUm = 1e-6, kMm3 = 1e-9;

/// `shape`, rotated about the vertical axis through the middle and displaced, so that it does not lie on voxel edges.
template <class Shape>
auto turned(Shape shape, double angle, const dvec3& by) {
  return [=](const dvec3& p) {
    const dvec3 q = p - by - kMiddle;
    return shape(kMiddle + dvec3(std::cos(angle) * q.x + std::sin(angle) * q.y,
                                 -std::sin(angle) * q.x + std::cos(angle) * q.y, q.z));
  };
}

TEST(AnalyticCavities, OfAnySizeTiltAndPositionAreMeasuredWithinTheErrorOfTheField) {
  Random random(21);
  for (int i = 0; i < 8; ++i) {
    const double a = 1.7e-3 + random.number(0.4e-3), b = 0.9e-3 + random.number(0.2e-3),
                 d = 1.4e-3 + random.number(0.5e-3);
    const double lean = random.number(7) * kDegree, t = std::tan(lean);
    const dvec3 by(random.number(0.4e-3), random.number(0.4e-3), 0);
    Preparation in = a_block();
    in.ideal = in.before;
    in.after = without(turned(tapered_box({a, b}, d, lean), random.number(kPi), by));
    const CavityMeasures box = measure_cavity(in);
    const double volume = 4 * (a * b * d + (a + b) * t * d * d / 2 + t * t * d * d * d / 3);
    EXPECT_NEAR(box.over_volume, volume, 0.01 * volume) << i;
    EXPECT_NEAR(box.floor_depth.value(), d, 8 * kUm) << i;
    EXPECT_LT(box.floor_flatness.value(), 8 * kUm) << i;
    EXPECT_LT(box.floor_tilt.value(), 0.5 * kDegree) << i;
    EXPECT_NEAR(box.over.depth, d, 0.05e-3) << i;
    EXPECT_FALSE(box.pulp_distance || box.kept_removed) << i;
    EXPECT_NEAR(box.taper.value() / kDegree, 2 * lean / kDegree, 0.5) << i;
    EXPECT_NEAR(box.isthmus.value(), 2 * (b + t * d / 2), 25 * kUm) << i;

    in.after = without(turned(tapered_hole(b, d, lean), 0, by));
    const CavityMeasures hole = measure_cavity(in);
    const double top = b + t * d, cone = kPi * d / 3 * (b * b + b * top + top * top);
    EXPECT_NEAR(hole.over_volume, cone, 0.01 * cone) << i;
    EXPECT_NEAR(hole.floor_depth.value(), d, 8 * kUm) << i;
    EXPECT_NEAR(hole.taper.value() / kDegree, 2 * lean / kDegree, 0.6) << i;
    EXPECT_NEAR(hole.isthmus.value(), 2 * (b + t * d / 2), 25 * kUm) << i;
  }
}

/// Returns the block without a box of the width 2·half_x, 2·half_y.
DenseField box(double half_x, double half_y, double depth, double lean = 0) {
  return without(tapered_box({half_x, half_y}, depth, lean));
}

/// One rule alone, with the ideal's value as target. The real geometry of the shape is made worse step by step.
struct Spoilt {
  const char* rule;
  double tolerance;
  DenseField (*worse)(double);  // returns the shape worsened by 0 (the ideal) or more
};
const Spoilt kSpoilt[] = {
    {"floor_depth_mm", 0.3, [](double by) { return box(1.4e-3, 1e-3, 1.5e-3 + 0.3e-3 * by); }},
    {"floor_depth_mm", 0.3, [](double by) { return box(1.4e-3, 1e-3, 1.5e-3 - 0.3e-3 * by); }},
    {"floor_flatness_um", 60,
     [](double by) {
       return without([=](const dvec3& p) {
         const double wave = 0.12e-3 * by * std::sin((p.x - kMiddle.x) * 2 * kPi / 0.9e-3);
         return std::max(
             {std::abs(p.x - kMiddle.x) - 1.4e-3, std::abs(p.y - kMiddle.y) - 1e-3, kTop - 1.5e-3 + wave - p.z});
       });
     }},
    {"floor_tilt_deg", 5,
     [](double by) {
       return without([=](const dvec3& p) {
         const double tilt = 12 * kDegree * by;
         const double floor = (p.z - (kTop - 1.5e-3)) * std::cos(tilt) - (p.x - kMiddle.x) * std::sin(tilt);
         return std::max({std::abs(p.x - kMiddle.x) - 1.4e-3, std::abs(p.y - kMiddle.y) - 1e-3, -floor});
       });
     }},
    {"taper_deg", 6, [](double by) { return box(1.4e-3, 1e-3, 1.5e-3, (3 + 6 * by) * kDegree); }},
    {"taper_deg", 6, [](double by) { return box(1.6e-3, 1.2e-3, 1.5e-3, (3 - 6 * by) * kDegree); }},
    {"isthmus_mm", 0.3, [](double by) { return box(1.9e-3, 0.75e-3 + 0.3e-3 * by, 1.5e-3); }},
    {"margin_roughness_um", 40,
     [](double by) {
       return without([=](const dvec3& p) {
         const double angle = std::atan2(p.y - kMiddle.y, p.x - kMiddle.x);
         return std::max(std::hypot(p.x - kMiddle.x, p.y - kMiddle.y) - 1.5e-3 - 0.15e-3 * by * std::cos(24 * angle),
                         kTop - 1.5e-3 - p.z);
       });
     }},
    {"contour_rms_um", 100, [](double by) { return box(1.4e-3 + 0.3e-3 * by, 1e-3, 1.5e-3); }},
    {"over_cut_depth_mm", 0.3, [](double by) { return box(1.4e-3 + 0.3e-3 * by, 1e-3, 1.5e-3); }},
    {"under_cut_depth_mm", 0.3, [](double by) { return box(1.4e-3 - 0.3e-3 * by, 1e-3, 1.5e-3); }},
    {"pulp_distance_mm", 0.25, [](double by) { return box(1.4e-3, 1e-3, 1.5e-3 + 0.4e-3 * by); }},
    {"pulp_exposed_mm2", 1, [](double by) { return box(1.4e-3, 1e-3, 1.85e-3 + 0.35e-3 * by); }},
    {"wall_thickness_mm", 0.4,
     [](double by) {
       DenseField cut = without(tapered_box({1.4e-3 + 0.4e-3 * by, 1e-3}, 1.5e-3, 0));
       const DenseField end = sampled(kBlock, [](const dvec3& p) { return p.x - 6.5e-3; });
       for (std::size_t i = 0; i < cut.distance.size(); ++i)
         cut.distance[i] = std::max(cut.distance[i], end.distance[i]);
       return cut;
     }},
};

TEST(CavityLaws, EveryGeometricMeasureLowersTheScoreMonotonically) {
  for (const Spoilt& spoilt : kSpoilt) {
    Preparation in = a_block();
    in.ideal = in.after = spoilt.worse(0);
    if (std::string_view(spoilt.rule) == "wall_thickness_mm")
      in.before = sampled(kBlock, [](const dvec3& p) { return std::max(block(p), p.x - 6.5e-3); });
    for_each_voxel(kBlock, [&](int x, int y, int z) {
      if (ball(kMiddle - dvec3(0, 0, 2.4e-3), 0.5e-3)(kVoxel * dvec3(x, y, z)) < 0)
        in.tissue[in.before.at(x, y, z)] = Tissue::kPulp;
    });
    ScoreInput input;
    const CavityReference reference = cavity_reference(in);
    input.cavity = input.cavity_ideal = reference.measures;
    const auto rules = rules_from(
        Json::parse(fmt::format(R"({{"defaults": false, "rules": [{{"name": "{}", "tolerance": {}, "weight": 10}}]}})",
                                spoilt.rule, spoilt.tolerance),
                    "rules"),
        input);
    double last = score(input, rules).points;
    ASSERT_NEAR(last, 100, 1e-9) << spoilt.rule;
    for (const double by : {0.35, 0.7, 1.0}) {
      in.after = spoilt.worse(by);
      input.cavity = measure_against_ideal(in, reference).result;
      const Score s = score(input, rules);
      EXPECT_LT(s.points, last - 0.5) << spoilt.rule << " by " << by << ": " << s.items.front().value;
      last = s.points;
    }
  }
}

TEST(CavityLaws, AReamedBallIsMeasuredWithItsRadiusAndItsDisplacement) {
  const auto reamed = [](const dvec3& c, double r) {
    return without([=](const dvec3& p) { return glm::distance(p, c) - r; });
  };
  const dvec3 wanted(kMiddle.x, kMiddle.y, kTop - 0.2e-3);
  Preparation p = a_block();
  p.ideal = reamed(wanted, 1.5e-3);
  const CavityReference reference = cavity_reference(p);
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> u(-0.2e-3, 0.2e-3);
  for (int i = 0; i < 6; ++i) {
    const double x = u(random), y = u(random), z = u(random), r = 1.4e-3 + u(random);
    p.after = reamed(wanted + dvec3(x, y, z), r);
    const CavityMeasures m = measure_against_ideal(p, reference).result;
    ASSERT_TRUE(m.cup && m.cup_offset && m.cup_tilt);
    EXPECT_NEAR(glm::distance(m.cup->center_W, wanted + dvec3(x, y, z)), 0, 0.02e-3);
    EXPECT_NEAR(m.cup->radius, r, 0.02e-3);
    EXPECT_NEAR(*m.cup_offset, glm::length(dvec3(x, y, z)), 0.03e-3);
    EXPECT_LT(*m.cup_tilt, 1.5 * kDegree);
    EXPECT_GT(m.cup->axis_W.z, std::cos(1.5 * kDegree));
  }
}

}  // namespace
}  // namespace typodont::session
