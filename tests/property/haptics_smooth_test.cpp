// Smooth tissue has no edges, and a head that slides there feels no step.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "engine/base/voxels.h"
#include "haptics/contact/proxy/crease.h"
#include "tests/support/heads.h"
#include "tests/support/presses.h"
#include "tests/support/sliding_hand.h"

namespace typodont {
namespace {

using namespace literals;
using haptics::HeadShape;
using test::uniform;

constexpr double kVoxel = 0.1_mm;

/// Tissue below a sum of smooth bumps, whose largest curvature is 1 / radius.
class Bumps {
 public:
  Bumps(std::mt19937& random, double radius) {
    for (Bump& b : bumps_) {
      b = {uniform(random, -kHalf, kHalf), uniform(random, -kHalf, kHalf), uniform(random, 0.4_mm, 1.2_mm), 0};
      b.height = uniform(random, -1, 1) * b.width * b.width;
    }
    double low = 0, high = 1e6;
    for (int i = 0; i < 60; ++i) {
      scale_ = (low + high) / 2;
      (max_curvature() < 1 / radius ? low : high) = scale_;
    }
  }
  struct At {
    double h = 0, hx = 0, hy = 0, hxx = 0, hxy = 0, hyy = 0;
  };
  At at(double x, double y) const {
    At a;
    for (const Bump& b : bumps_) {
      const double u = (x - b.x) / b.width, v = (y - b.y) / b.width,
                   g = scale_ * b.height * std::exp(-(u * u + v * v) / 2);
      a.h += g, a.hx -= g * u / b.width, a.hy -= g * v / b.width;
      const double w2 = b.width * b.width;
      a.hxx += g * (u * u - 1) / w2, a.hxy += g * u * v / w2, a.hyy += g * (v * v - 1) / w2;
    }
    return a;
  }
  double max_curvature() const {
    double most = 0;
    for (double x = -kHalf; x <= kHalf; x += 0.1_mm)
      for (double y = -kHalf; y <= kHalf; y += 0.1_mm) {
        const At a = at(x, y);
        const double w = 1 + a.hx * a.hx + a.hy * a.hy;
        const double mean =
            ((1 + a.hx * a.hx) * a.hyy - 2 * a.hx * a.hy * a.hxy + (1 + a.hy * a.hy) * a.hxx) / (2 * w * std::sqrt(w));
        const double gauss = (a.hxx * a.hyy - a.hxy * a.hxy) / (w * w);
        most = std::max(most, std::abs(mean) + std::sqrt(std::max(mean * mean - gauss, 0.0)));
      }
    return most;
  }
  haptics::DenseTissue tissue(double voxel) const {
    constexpr double kFine = 0.05_mm;
    const int fine = static_cast<int>(2 * kHalf / kFine) + 1;
    std::vector<double> height(static_cast<std::size_t>(fine) * fine);
    double lo = 1, hi = -1;
    for (int i = 0; i < fine; ++i)
      for (int j = 0; j < fine; ++j) {
        double& h = height[static_cast<std::size_t>(i) * fine + j];
        h = at(-kHalf + kFine * i, -kHalf + kFine * j).h;
        lo = std::min(lo, h), hi = std::max(hi, h);
      }
    haptics::DenseTissue t;
    t.band = kBand;
    t.frame.voxel = voxel;
    t.frame.origin = dvec3(-kHalf, -kHalf, lo - 2 * kBand);
    t.size = glm::ivec3(glm::dvec3(2 * kHalf, 2 * kHalf, hi - lo + 4 * kBand) / voxel) + 1;
    t.distance.resize(static_cast<std::size_t>(t.size.x) * t.size.y * t.size.z);
    t.tissue.resize(t.distance.size());
    for_each_voxel(t.size, [&](int x, int y, int z) {
      const dvec3 p = t.frame.origin + voxel * dvec3(x, y, z);
      const double above = p.z - at(p.x, p.y).h, reach = std::min(std::abs(above), 4 * kBand);
      double best = 1;
      dvec3 q(0);
      if (std::abs(above) > 4 * kBand)
        best = kBand * kBand;
      else {
        const int w = static_cast<int>(std::min(reach, kBand) / kFine) + 1,
                  ci = static_cast<int>(std::lround((p.x + kHalf) / kFine)),
                  cj = static_cast<int>(std::lround((p.y + kHalf) / kFine));
        for (int i = std::max(ci - w, 0); i <= std::min(ci + w, fine - 1); ++i)
          for (int j = std::max(cj - w, 0); j <= std::min(cj + w, fine - 1); ++j) {
            const dvec3 s(-kHalf + kFine * i, -kHalf + kFine * j, height[static_cast<std::size_t>(i) * fine + j]);
            if (const double d = glm::dot(s - p, s - p); d < best) best = d, q = s;
          }
        for (int k = 0; k < 6 && best < 1; ++k) {
          const At a = at(q.x, q.y);
          const double r = a.h - p.z;
          const double gx = q.x - p.x + r * a.hx, gy = q.y - p.y + r * a.hy;
          const double xx = 1 + a.hx * a.hx + r * a.hxx, xy = a.hx * a.hy + r * a.hxy, yy = 1 + a.hy * a.hy + r * a.hyy,
                       det = xx * yy - xy * xy;
          if (!(det > 1e-6 && xx > 0)) break;
          const double nx = q.x - (yy * gx - xy * gy) / det, ny = q.y - (xx * gy - xy * gx) / det;
          const dvec3 s(nx, ny, at(nx, ny).h);
          const double d = glm::dot(s - p, s - p);
          if (d >= best) break;
          best = d, q = s;
        }
      }
      const double d = std::min(std::sqrt(best), kBand);
      t.distance[t.at(x, y, z)] = static_cast<float>(above < 0 ? -d : d);
      t.tissue[t.at(x, y, z)] = above < 1.5 * voxel ? Tissue::kEnamel : Tissue::kAir;
    });
    return t;
  }
  static constexpr double kHalf = 3.5_mm, kBand = 0.6_mm;

 private:
  struct Bump {
    double x, y, width, height;
  } bumps_[40];
  double scale_ = 1;
};

/// Number of creases found at random places of the surface near the tool.
int creases(const test::HapticBench& bench, const Bumps& bumps, std::mt19937& random) {
  int found = 0, tried = 0;
  const haptics::TissuePatch& patch = bench.patch();
  for (int i = 0; i < 300; ++i) {
    const dvec3 c = bench.last.X_WG.p;
    const double x = c.x + uniform(random, -1.0_mm, 1.0_mm), y = c.y + uniform(random, -1.0_mm, 1.0_mm);
    const Bumps::At at = bumps.at(x, y);
    const dvec3 p = bench.settings.frame.to_voxels({x, y, at.h});
    if (!patch.holds(p, 8)) continue;
    const dvec3 n(uniform(random, -0.5, 0.5) - at.hx, uniform(random, -0.5, 0.5) - at.hy, 1);
    haptics::Crease crease;
    ++tried;
    found += haptics::is_sharp_at(patch, p) && haptics::find_crease(patch, p, glm::normalize(n), crease);
  }
  EXPECT_GT(tried, 50);
  return found;
}

TEST(SmoothTissue, NeverHasACreaseAndAHeadThatSlidesThereFeelsNoStepBeyondItsMotion) {
  constexpr double kDepth = 0.05_mm;
  double worst = 0;
  for (unsigned seed = 1; seed <= 6; ++seed) {
    std::mt19937 random(seed);
    const Bumps bumps(random, uniform(random, 3, 10) * kVoxel);
    const haptics::TissueVolume volume(bumps.tissue(kVoxel));
    for (const HeadShape shape : test::head_shapes()) {
      haptics::ServoSettings s = test::probe_settings("offset");
      s.passivity = s.boundary_walls = false;
      s.tick = 0.25e-3;
      s.tool.shape = shape, s.tool.diameter = uniform(random, 0.4_mm, 1.2_mm);
      s.tool.length = s.tool.diameter * (shape == HeadShape::kSphere ? 1 : uniform(random, 1.5, 2.5));
      test::HapticBench bench(volume.clone(), s);
      test::SlidingHand hand;
      hand.depth = kDepth, hand.range = 1.5_mm;
      hand.R = glm::angleAxis(uniform(random, 0, 0.7), dvec3(0.6, 0.8, 0));
      bench.tick({{0, 0, bumps.at(0, 0).h + 3.0_mm}, hand.R});
      const test::SlideResult result = test::slide(bench, hand, 1, 2);
      const std::string at = fmt::format("seed {}, {} of {:.2f} x {:.2f} mm", seed, name_of(shape),
                                         s.tool.diameter / 1.0_mm, s.tool.length / 1.0_mm);
      EXPECT_EQ(creases(bench, bumps, random), 0) << at;
      EXPECT_LT(result.step_beyond_motion, 0.15 * s.stiffness * kDepth) << at;
      EXPECT_GT(result.times.size(), 0.8 * result.ticks) << at;
      worst = std::max(worst, result.step_beyond_motion);
    }
  }
  fmt::print("largest step beyond the motion: {:.4f} N\n", worst);
}

TEST(Bump, NarrowerThanTheDistanceOfTheHeadsSamplesIsFeltAtFirstTouch) {
  constexpr double kBump = 0.3_mm, kBallRadius = 1.15_mm;
  std::mt19937 random(5);
  double late = 0;
  for (int i = 0; i < 40; ++i) {
    const dvec3 top(uniform(random, -kVoxel, kVoxel), uniform(random, -kVoxel, kVoxel), 0);
    haptics::ServoSettings s = test::press_probe(2 * kBallRadius);
    test::HapticBench bench(fmt::format(R"({{"voxel_mm": 0.1, "solids": [{{"tissue": "enamel", "solid": {{"union": [
          {{"box": {{"center_mm": [0, 0, -1], "size_mm": [6, 6, 2]}}}},
          {{"sphere": {{"center_mm": [{}, {}, -0.15], "radius_mm": 0.3}}}}]}}}}]}})",
                                        top.x / 1.0_mm, top.y / 1.0_mm),
                            s);
    const dvec3 bump = top - dvec3(0, 0, 0.15_mm);
    dvec3 at = bump + dvec3(uniform(random, -0.2_mm, 0.2_mm), uniform(random, -0.2_mm, 0.2_mm), 1.7_mm);
    bench.tick({at, {1, 0, 0, 0}});
    for (int tick = 0; bench.last.depth == 0 && tick < 1000; ++tick) {
      at.z -= 1e-6;
      bench.tick({at, {1, 0, 0, 0}});
    }
    ASSERT_GT(bench.last.depth, 0);
    late = std::max(late, kBump + kBallRadius - glm::length(at - bump));
  }
  fmt::print("latest touch: {:.5f} mm below the bump\n", late / 1.0_mm);
  EXPECT_LT(late, 3e-6);
}

// During a slip, the force may change at most this much faster than the hand's own motion changes it (contact.md).
constexpr double kSlip = 60;  // N/s

/// Moves the hand from `at` to `to` at 20 mm/s. Returns by how much the force's largest step exceeds 1.1 times the
/// change that the hand's motion causes. `f`: force before and after.
double slide(test::HapticBench& bench, const haptics::ServoSettings& s, dvec3& at, const dvec3& to, dvec3& f) {
  double step = 0;
  while (glm::length(to - at) > 0) {
    const dvec3 before = at;
    at += (to - at) * std::min(1.0, 20e-3 * s.tick / glm::length(to - at));
    bench.tick({at, {1, 0, 0, 0}});
    step = std::max(step, glm::length(bench.last.f_T_W - f) - 1.1 * s.stiffness * glm::length(at - before));
    f = bench.last.f_T_W;
  }
  return step;
}

// A hand that is nearly as deep as the radius of curvature turns the proxy by far more than it moves itself.
TEST(Slip, AHeadThatSlipsOffARidgeIsSlowedSoThatItsForceTurnsWithoutAStep) {
  constexpr double kRidge = 0.3_mm;
  for (const double rate : {1000.0, 4000.0}) {
    for (const double height : {0.02_mm, 0.1_mm, 0.3_mm}) {  // of the hand above the ridge's axis
      haptics::ServoSettings s = test::press_probe(0.6_mm);
      s.tick = 1 / rate;
      test::HapticBench bench(
          R"({"voxel_mm": 0.05, "solids": [{"tissue": "enamel", "solid": {"cylinder": {"radius_mm": 0.3, "height_mm": 6}}}]})",
          s);
      const double rest = kRidge + s.tool.diameter / 2;
      SCOPED_TRACE(testing::Message() << height / 1.0_mm << " mm above the axis, " << rate << " Hz");
      dvec3 f(0), at(-0.1 * height, 1.2 * rest, 0);
      slide(bench, s, at, {-0.1 * height, height, 0}, f);
      EXPECT_GT(f.y, 0.9 * s.stiffness * (rest - height)) << "it is still on the ridge";
      EXPECT_LT(slide(bench, s, at, {1.5_mm, height, 0}, f), 1.1 * kSlip * s.tick);
      EXPECT_EQ(f, dvec3(0)) << "it has slipped off";
    }
  }
}

// The hand is out of the tissue before the proxy is: the rest of the slip goes through air.
TEST(Slip, AHeadThatFallsOffAnEdgeIsSlowedInAirTooUntilTheForceIsZero) {
  for (const double rate : {1000.0, 4000.0}) {
    for (const double depth : {0.5_mm, 1.0_mm, 2.0_mm}) {  // of the hand below the block's top
      haptics::ServoSettings s = test::press_probe(0.6_mm);
      s.tick = 1 / rate;
      test::HapticBench bench(
          R"({"voxel_mm": 0.05, "solids": [{"tissue": "enamel", "solid": {"box": {"size_mm": [6, 6, 6]}}}]})", s);
      const double top = 3.0_mm + s.tool.diameter / 2;
      SCOPED_TRACE(testing::Message() << depth / 1.0_mm << " mm deep, " << rate << " Hz");
      dvec3 f(0), at(2.5_mm, top + 0.1_mm, 0);
      slide(bench, s, at, {2.5_mm, top - depth, 0}, f);
      EXPECT_GT(f.y, 0.9 * s.stiffness * depth) << "it is still on the block";
      EXPECT_LT(slide(bench, s, at, {6.0_mm, top - depth, 0}, f), 1.1 * kSlip * s.tick);
      EXPECT_EQ(f, dvec3(0)) << "it has fallen off";
    }
  }
}

}  // namespace
}  // namespace typodont
