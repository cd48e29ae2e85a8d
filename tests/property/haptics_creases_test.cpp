// Presses resting heads on edges, rims and corners, given and drilled, and compares with the exact contact.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/presses.h"

namespace typodont {
namespace {

using namespace literals;
using haptics::HeadShape;
using haptics::ServoSettings;
using test::HapticBench;
using test::Press;
using test::press_all;
using test::PressCase;
using test::PressErrors;
using test::Random;
using test::uniform;

PressErrors press(const PressCase& c, double voxel) {
  const PressErrors errors = test::press_ball(c, voxel, nullptr);
  errors.print(fmt::format("{}, {} mm", c.name, voxel / 1.0_mm));
  return errors;
}

void expect_exact(const PressErrors& errors, const std::string& name) {
  EXPECT_LT(errors.median_direction(), 0.2) << name;
  EXPECT_LT(PressErrors::quantile(errors.direction, 1), 2) << name;
  EXPECT_LT(PressErrors::quantile(errors.force, 1), 0.02) << name;
  EXPECT_LT(PressErrors::quantile(errors.position, 1), 0.1) << name;
}

TEST(Creases, ABallRestsOnEdgesRimsAndCornersWithin2PercentAndATenthOfAVoxel) {
  for (const std::uint32_t seed : {1u, 2u}) {
    Random random(seed);
    for (const PressCase& c : test::press_cases(random)) {
      for (const double voxel : {0.1_mm, 0.05_mm}) {
        expect_exact(press(c, voxel), c.name);
      }
    }
  }
}

TEST(Creases, ATipThatSlidesThroughAGrooveRestsOnItsWallsInEveryTick) {
  const double r = 0.125_mm, voxel = 0.1_mm, slope = std::sqrt(3.0);
  const std::string groove = R"({"difference": [{"box": {"center_mm": [0, 0, -1.5], "size_mm": [8, 6, 3]}},
      {"intersection": [{"box": {"size_mm": [8, 8, 8]}},
                        {"halfspace": {"normal": [0.8660254037844387, 0, -0.5], "offset_mm": 1}},
                        {"halfspace": {"normal": [-0.8660254037844387, 0, -0.5], "offset_mm": 1}}]}]})";
  HapticBench bench(test::press_tissue(groove, voxel), test::press_probe(2 * r));
  const double bottom = -2.0_mm + 2 * r;  // height of the tip's centre on both walls
  for (double z = 2.0_mm; z > bottom; z -= 5e-6) bench.tick({{0, 0, z}}, 0);
  double away = 0;
  for (int i = 0; i < 4000; ++i) {
    const double x = 0.6_mm * std::sin(0.05 * i), y = 0.7e-6 * i;
    const dvec3 hand(x, y, bottom + slope * std::abs(x) - 0.07_mm);
    // on the wall at the hand's side, or at the bottom
    const dvec3 n(x < 0 ? slope / 2 : -slope / 2, 0, 0.5), at_bottom(0, y, bottom);
    dvec3 truth = hand - glm::dot(hand - at_bottom, n) * n;
    if (truth.x * x <= 0) truth = at_bottom;
    bench.tick({hand}, 0);
    away = std::max(away, glm::length(bench.last.X_WG.p - truth));
  }
  fmt::print("{:.4f} voxel away\n", away / voxel);
  EXPECT_LT(away, 0.1 * voxel);
}

TEST(Creases, ALargeBallFeelsASmallCuspAndTheCornerOfASmallBox) {
  Random random(6);
  for (const PressCase& c : test::large_ball_cases(random)) expect_exact(press(c, 0.1_mm), c.name);
}

TEST(Creases, HalvingTheVoxelAtLeastHalvesTheErrorAtARim) {
  Random random(3);
  for (const PressCase& c : test::press_cases(random)) {
    if (c.name.find("rim") == std::string::npos) continue;
    const double coarse = press(c, 0.1_mm).median_direction(), fine = press(c, 0.05_mm).median_direction();
    EXPECT_LT(fine, coarse / 2) << c.name;
    EXPECT_LT(press(c, 0.025_mm).median_direction(), std::max(fine / 2, 1e-3)) << c.name;
  }
}

TEST(Creases, ARimThatABurHasDrilledOrAFillingHasIsFeltAsAGivenOne) {
  for (const double voxel : {0.1_mm, 0.05_mm}) {
    Random random(4);
    const PressErrors drilled = test::press_drilled_rim(random, voxel), filled = test::press_filled_rim(random, voxel);
    drilled.print(fmt::format("drilled rim, {} mm", voxel / 1.0_mm));
    filled.print(fmt::format("filled rim, {} mm", voxel / 1.0_mm));
    expect_exact(drilled, "drilled rim");
    expect_exact(filled, "filled rim");
  }
}

/// A surface with an outward normal and its solid as JSON: ball, cylinder, half-space, or the outside of the first two.
struct Sheet {
  enum Kind { kBall, kCylinder, kHalfSpace } kind = kBall;
  dvec3 center{0}, axis{0, 0, 1};  // m; unit vector, of a half-space outwards
  double radius = 0;               // m
  double sign = 1;                 // -1: the outside is tissue

  double distance(const dvec3& x, dvec3& n) const {
    dvec3 d = x - center;
    if (kind == kHalfSpace) {
      n = axis;
      return glm::dot(d, axis);
    }
    if (kind == kCylinder) d -= glm::dot(d, axis) * axis;
    n = sign * glm::normalize(d);
    return sign * (glm::length(d) - radius);
  }
  std::string json() const {
    const dvec3 c = center / 1.0_mm;
    if (kind == kHalfSpace) {
      return fmt::format(R"({{"halfspace": {{"normal": [{}, {}, {}], "offset_mm": {}}}}})", axis.x, axis.y, axis.z,
                         glm::dot(c, axis));
    }
    return kind == kBall ? fmt::format(R"({{"sphere": {{"center_mm": [{}, {}, {}], "radius_mm": {}}}}})", c.x, c.y, c.z,
                                       radius / 1.0_mm)
                         : fmt::format(R"({{"cylinder": {{"center_mm": [{}, {}, {}], "axis": [{}, {}, {}],
                                         "radius_mm": {}, "height_mm": 30}}}})",
                                       c.x, c.y, c.z, axis.x, axis.y, axis.z, radius / 1.0_mm);
  }
};

/// A ball, cut by half-spaces, with balls and cylinders taken off.
struct RandomSolid {
  std::vector<Sheet> sheets;

  explicit RandomSolid(Random& random) {
    std::normal_distribution<double> normal;
    const auto direction = [&] { return glm::normalize(dvec3(normal(random), normal(random), normal(random))); };
    sheets.push_back({Sheet::kBall, dvec3(0), {0, 0, 1}, uniform(random, 3.0_mm, 4.0_mm), 1});
    for (int i = 0; i < 3; ++i) {
      const dvec3 n = direction();
      sheets.push_back({Sheet::kHalfSpace, uniform(random, 1.2_mm, 2.6_mm) * n, n, 0, 1});
    }
    for (int i = 0; i < 2; ++i) {
      const Sheet::Kind kind = random() % 2 == 0 ? Sheet::kBall : Sheet::kCylinder;
      sheets.push_back(
          {kind, uniform(random, 2.0_mm, 4.0_mm) * direction(), direction(), uniform(random, 1.0_mm, 2.0_mm), -1});
    }
  }
  /// Lower bound of the distance, exact inside and at smooth places.
  double distance(const dvec3& x) const {
    double most = -1;
    dvec3 n;
    for (const Sheet& sheet : sheets) most = std::max(most, sheet.distance(x, n));
    return most;
  }
  std::string json() const {
    std::string kept, all;
    for (const Sheet& sheet : sheets) {
      if (sheet.sign > 0) kept += (kept.empty() ? "" : ", ") + sheet.json();
    }
    all = fmt::format(R"({{"intersection": [{}]}})", kept);
    for (const Sheet& sheet : sheets) {
      if (sheet.sign < 0) all = fmt::format(R"({{"difference": [{}, {}]}})", all, sheet.json());
    }
    return all;
  }
};

/// A place where `count` sheets meet, a direction within their normals, and room for the head there and above. The head
/// is a ball, or a cylinder with round ends across the direction.
bool find_press(Random& random, const RandomSolid& solid, int count, double r, double length, Press& press) {
  constexpr double kClear = 0.4_mm;
  std::vector<int> chosen;
  while (static_cast<int>(chosen.size()) < count) {
    const int i = static_cast<int>(random() % solid.sheets.size());
    // Not certainly stable: a long head in a bore.
    if (length > 2 * r && solid.sheets[static_cast<std::size_t>(i)].sign < 0) return false;
    if (std::ranges::find(chosen, i) == chosen.end()) chosen.push_back(i);
  }
  std::normal_distribution<double> normal;
  dvec3 x = 3.0_mm * glm::normalize(dvec3(normal(random), normal(random), normal(random))), n[3];
  double worst = 1;
  for (int step = 0; step < 300 && worst > 1e-13; ++step) {
    worst = 0;
    for (int k = 0; k < count; ++k) {
      const double d = solid.sheets[static_cast<std::size_t>(chosen[static_cast<std::size_t>(k)])].distance(x, n[k]);
      x -= d * n[k];
      worst = std::max(worst, std::abs(d));
    }
  }
  if (worst > 1e-9) return false;
  for (std::size_t i = 0; i < solid.sheets.size(); ++i) {
    dvec3 unused;
    if (std::ranges::find(chosen, static_cast<int>(i)) == chosen.end() && solid.sheets[i].distance(x, unused) > -kClear)
      return false;
  }
  for (int k = 0; k < count; ++k) {
    for (int j = 0; j < k; ++j) {
      if (glm::dot(n[j], n[k]) > 0.9 || glm::dot(n[j], n[k]) < -0.6) return false;
    }
  }
  if (count == 3 && std::abs(glm::dot(n[0], glm::cross(n[1], n[2]))) < 0.25) return false;
  dvec3 sum(0);
  for (int k = 0; k < count; ++k) sum += uniform(random, 0.15, 1) * n[k];
  press.p = x, press.n = glm::normalize(sum);
  const dvec3 along = glm::normalize(glm::cross(press.n, dvec3(normal(random), normal(random), normal(random))));
  press.R = glm::quat_cast(glm::dmat3(press.n, glm::cross(along, press.n), along));
  // Samples of the head: none nearer than half a voxel, but at the contact.
  constexpr int kSamples = 400;
  for (double height = r; height < 12.0_mm; height += 0.1_mm) {
    for (int i = 0; i < kSamples; ++i) {
      const double z = 1 - (2 * i + 1.0) / kSamples, a = 2.399963 * i, w = std::sqrt(1 - z * z);
      const dvec3 d(w * std::cos(a), w * std::sin(a), z);
      const double end = length / 2 - r, shift = end * std::clamp(3 * z, -1.0, 1.0);
      const dvec3 q = x + height * press.n + r * d + shift * along;
      if (glm::length(q - x) > kClear && solid.distance(q) < 0.05_mm) return false;
      if (solid.distance(q) < -1e-9) return false;
    }
  }
  return true;
}

TEST(Creases, HeadsRestOnRandomSolidsInAnyPose) {
  for (const double voxel : {0.1_mm, 0.05_mm}) {
    for (const HeadShape shape : {HeadShape::kSphere, HeadShape::kRoundEndCylinder}) {
      PressErrors all[3];
      for (std::uint32_t seed = 1; seed <= 4; ++seed) {
        Random random(seed);
        const RandomSolid solid(random);
        const double r = uniform(random, 0.3_mm, 0.8_mm), length = shape == HeadShape::kSphere ? 2 * r : 5 * r;
        ServoSettings s = test::press_probe(2 * r);
        s.tool.shape = shape, s.tool.length = length;
        HapticBench bench(test::press_tissue(solid.json(), voxel), s);
        std::vector<Press> presses;
        std::vector<std::size_t> sheets;  // that meet, less one
        for (std::size_t count = 1; count <= 3; ++count) {
          int found = 0;
          for (int tries = 0; tries < 20'000 && found < 12; ++tries) {
            Press press;
            if (!find_press(random, solid, static_cast<int>(count), r, length, press)) continue;
            presses.push_back(press), sheets.push_back(count - 1), ++found;
          }
        }
        const PressErrors errors = press_all(bench, voxel, r, presses, 0);
        for (std::size_t i = 0; i < presses.size(); ++i) {
          PressErrors& of = all[sheets[i]];
          of.direction.push_back(errors.direction[i]);
          of.force.push_back(errors.force[i]);
          of.position.push_back(errors.position[i]);
        }
      }
      const char* const names[] = {"faces", "edges", "corners"};
      for (int k = 0; k < 3; ++k) {
        const std::string name =
            fmt::format("{} of random solids, head {}, {} mm", names[k], static_cast<int>(shape), voxel / 1.0_mm);
        ASSERT_FALSE(all[k].direction.empty()) << name;
        all[k].print(name);
        if (k == 0) expect_exact(all[k], name);
        if (k == 1) {
          EXPECT_LT(PressErrors::quantile(all[k].direction, 1), 2) << name;
        }
        // Known gap (docs/contact.md): in one corner of a hundred, a sheet is missed.
        EXPECT_LT(all[k].median_direction(), 0.2) << name;
        EXPECT_LT(PressErrors::quantile(all[k].direction, 0.95), 2) << name;
        EXPECT_LT(PressErrors::quantile(all[k].force, 0.95), 0.02) << name;
        EXPECT_LT(PressErrors::quantile(all[k].position, 0.95), 0.1) << name;
      }
    }
  }
}

TEST(Creases, ABallThatSlidesOverRandomSolidsRestsOnThemInEveryTick) {
  constexpr double kVoxel = 0.1_mm;
  constexpr int kSamples = 3000;
  double deepest = 0, farthest = 0;
  for (std::uint32_t seed = 1; seed <= 6; ++seed) {
    Random random(seed);
    const RandomSolid solid(random);
    const double r = uniform(random, 0.3_mm, 0.8_mm), speed = uniform(random, 0.004_mm, 0.04_mm);
    HapticBench bench(test::press_tissue(solid.json(), kVoxel), test::press_probe(2 * r));
    const dvec3 around = glm::normalize(dvec3(1, uniform(random, -1, 1), uniform(random, -1, 1)));
    bench.tick({{0, 0, 8.0_mm}});
    int touching = 0;
    for (int i = 0; i < 6000; ++i) {
      const dvec3 c = bench.last.X_WG.p, out = glm::normalize(c);
      bench.tick({c - test::kPressDepth * out +
                  speed * glm::normalize(glm::cross(around + 0.3 * std::sin(2e-3 * i) * out, out))});
      if (bench.last.f_T_W == dvec3(0) || i % 5 != 0) continue;
      ++touching;
      double gap = 1;  // m, of the nearest sample
      for (int k = 0; k < kSamples; ++k) {
        const double z = 1 - (2 * k + 1.0) / kSamples, a = 2.399963 * k, w = std::sqrt(1 - z * z);
        gap = std::min(gap, solid.distance(bench.last.X_WG.p + r * dvec3(w * std::cos(a), w * std::sin(a), z)));
      }
      deepest = std::max(deepest, -gap / kVoxel), farthest = std::max(farthest, gap / kVoxel);
    }
    EXPECT_GT(touching, 500) << seed;
  }
  fmt::print("at most {:.2g} voxel deep and {:.2g} voxel away\n", deepest, farthest);
  EXPECT_LT(deepest, 0.1);
  EXPECT_LT(farthest, 0.1);
}

}  // namespace
}  // namespace typodont
