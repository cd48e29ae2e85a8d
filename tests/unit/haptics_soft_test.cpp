// Tests soft tissue against closed solutions: stiffness of a layer, return after release, shape of a dent, and work of
// a cut.
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "engine/base/units.h"
#include "tests/support/no_alloc.h"
#include "tests/support/soft_layer.h"

namespace typodont {
namespace {

using namespace literals;
using haptics::SoftLaw;
using haptics::SoftSurface;
using haptics::SoftTissue;
using haptics::Tool;
using test::ball_probe;
using test::flat_layer;

constexpr double kCoupling = 1000;  // N/m

/// A cylinder that covers the whole layer.
Tool wide_plate() {
  Tool tool = ball_probe();
  tool.shape = haptics::HeadShape::kCylinder;
  tool.diameter = 12.0_mm;
  tool.length = 1.0_mm;
  return tool;
}

/// Soft tissue with one tool, without a servo.
struct Pressed {
  std::vector<Tool> tools;
  std::shared_ptr<const SoftSurface> surface;
  SoftTissue tissue;
  SoftTissue::Output out;
  Nanos t = 0;

  Pressed(const Tool& tool, std::shared_ptr<const SoftSurface> layer)
      : tools{tool}, surface(std::move(layer)), tissue(surface, tools, kCoupling) {}
  /// Holds the lowest point of the tool at the height z (m) over the layer for `seconds`.
  void hold(double z, double seconds, double cutting = 0, dvec3 at = dvec3(0)) {
    for (int i = 0; i < static_cast<int>(std::lround(seconds * 1000)); ++i, t += 1'000'000) {
      const Pose X_WG{at + dvec3(0, 0, z + tools[0].half())};
      if (tissue.at_rest(X_WG, 0)) {
        out = {};
      } else {
        out = tissue.tick({t, 1e-3, X_WG, 0, cutting});
      }
    }
  }
  /// Moves the lowest point from one height to another at `speed` (m/s).
  void move(double from, double to, double speed, double cutting = 0) {
    const int ticks = std::max(1, static_cast<int>(std::lround(std::abs(to - from) / speed * 1000)));
    for (int i = 1; i <= ticks; ++i) hold(from + (to - from) * i / ticks, 1e-3, cutting);
  }
  std::uint32_t nearest(const dvec3& p) const {
    std::uint32_t best = 0;
    for (std::uint32_t i = 0; i < surface->points().size(); ++i) {
      if (glm::length(surface->points()[i].p_W - p) < glm::length(surface->points()[best].p_W - p)) best = i;
    }
    return best;
  }
};

double area_of(const SoftSurface& surface) {
  return std::accumulate(surface.points().begin(), surface.points().end(), 0.0,
                         [](double sum, const SoftSurface::Point& p) { return sum + p.area; });
}

TEST(SoftSurface, PointsLieOnTheSurfaceWithItsNormalAreaAndThickness) {
  SoftLaw law;
  law.spacing = 0.25_mm;
  law.thickness = 1.5_mm;
  const double radius = 3.0_mm, core = 2.2_mm;  // a shell around a hard ball
  const SoftSurface shell(
      law, dvec3(-3.5_mm), dvec3(3.5_mm), [&](const dvec3& p) { return glm::length(p) - radius; },
      [&](const dvec3& p) { return glm::length(p) < core; });
  ASSERT_GT(shell.points().size(), 1000u);
  for (const SoftSurface::Point& point : shell.points()) {
    EXPECT_NEAR(glm::length(point.p_W), radius, 2e-6);
    EXPECT_NEAR(glm::dot(point.n_W, glm::normalize(point.p_W)), 1, 1e-4);
    EXPECT_NEAR(point.thickness, radius - core, 0.11_mm);
  }
  EXPECT_NEAR(area_of(shell) / (4 * kPi * radius * radius), 1, 0.03);
}

TEST(SoftSurface, ClearanceIsALowerBoundOfTheDistance) {
  const auto layer = flat_layer();
  for (const dvec3& p :
       {dvec3(0, 0, 8.0_mm), dvec3(9.0_mm, 1.0_mm, 3.0_mm), dvec3(0, 0, 0.9_mm), dvec3(-7.0_mm, -9.0_mm, -5.0_mm)}) {
    double distance = 1;
    for (const SoftSurface::Point& point : layer->points()) distance = std::min(distance, glm::length(point.p_W - p));
    EXPECT_LE(layer->clearance(p), distance);
    EXPECT_GE(layer->clearance(p), distance - 4.0_mm);  // the cells are coarse, but far is known to be far
  }
}

TEST(SoftTissue, AnEvenlyPressedLayerYieldsLikeASpringOfModulusTimesAreaOverThickness) {
  Pressed layer(wide_plate(), flat_layer());
  const SoftLaw& law = layer.surface->law();
  double stiffness = 0;  // N/m
  for (const SoftSurface::Point& p : layer.surface->points()) stiffness += law.elastic_modulus * p.area / p.thickness;
  const double depth = 0.4_mm;
  layer.move(0, -depth, 2e-3);
  layer.hold(-depth, 10 * law.return_time);
  const double expected = depth * kCoupling * stiffness / (kCoupling + stiffness);
  EXPECT_NEAR(layer.out.force.z / expected, 1, 1e-3);
  EXPECT_NEAR(layer.tissue.inward(layer.nearest(dvec3(0))), expected / stiffness, 1e-7);
}

TEST(SoftTissue, ABallMeetsAboutTheForceOfHertzsTheory) {
  for (const double diameter : {0.5_mm, 1.2_mm, 2.0_mm}) {
    Pressed layer(ball_probe(diameter), flat_layer({}, 4.2e-3));
    layer.move(0, -0.5_mm, 2e-3);
    layer.hold(-0.5_mm, 3);
    const double dent = 0.5_mm - layer.out.yielded.z;
    const double modulus = layer.surface->law().elastic_modulus / (1 - 0.45 * 0.45);  // of a half-space
    const double hertz = 4 / 3.0 * modulus * std::sqrt(diameter / 2) * std::pow(dent, 1.5);
    EXPECT_GT(layer.out.force.z, 0.6 * hertz) << diameter;
    EXPECT_LT(layer.out.force.z, 1.5 * hertz) << diameter;
  }
}

TEST(SoftTissue, ADentReturnsWithTheStatedTimeConstant) {
  for (const double time : {0.05, 0.2}) {
    SoftLaw law;
    law.return_time = time;
    law.elastic_modulus = 20e3;  // soft enough for a deep dent
    Pressed layer(wide_plate(), flat_layer(law));
    layer.move(0, -0.8_mm, 5e-3);
    layer.hold(-0.8_mm, 8 * time);
    const std::uint32_t middle = layer.nearest(dvec3(0));
    const double before = layer.tissue.inward(middle);
    ASSERT_GT(before, 0.1_mm);
    layer.hold(5.0_mm, time);  // released at once
    EXPECT_NEAR(layer.tissue.inward(middle) / before, std::exp(-1.0), 0.01) << time;
    EXPECT_EQ(layer.out.force, dvec3(0));
  }
}

TEST(SoftTissue, TheDentAroundATipIsThatOfAPasternakFoundation) {
  SoftLaw law;
  law.spacing = 0.15_mm;
  law.elastic_modulus = 50e3;  // so soft that the coupling leaves a deep dent
  Pressed layer(ball_probe(0.4_mm), flat_layer(law, 2.1e-3));
  layer.move(0, -0.6_mm, 2e-3);
  layer.hold(-0.6_mm, 3);
  // The inward displacement w at the distance r is proportional to K0(r / l), with l² = T / κ, T = E h / 27 (N/m) and κ
  // = E / h (N/m³).
  const double l = layer.surface->points()[0].thickness / std::sqrt(27.0);
  const auto inward = [&](double r) { return layer.tissue.inward(layer.nearest({r, 0.075_mm, 0})); };
  const double r1 = 0.375_mm, r2 = 0.825_mm;
  ASSERT_GT(inward(r1), 0.1_mm);
  EXPECT_NEAR(inward(r2) / inward(r1) / (std::cyl_bessel_k(0, r2 / l) / std::cyl_bessel_k(0, r1 / l)), 1, 0.15);
}

TEST(SoftTissue, SleepsUntilTouchedAndAgainAfterItsReturn) {
  Pressed layer(ball_probe(), flat_layer());
  layer.hold(4.0_mm, 0.1);
  EXPECT_EQ(layer.tissue.active(), 0u);
  layer.move(4.0_mm, -0.5_mm, 20e-3);
  layer.hold(-0.5_mm, 0.3);
  EXPECT_GT(layer.tissue.active(), 20u);
  EXPECT_GT(layer.out.force.z, 0.05);
  layer.hold(4.0_mm, 20 * layer.surface->law().return_time);
  EXPECT_EQ(layer.tissue.active(), 0u);
  for (std::uint32_t i = 0; i < layer.surface->points().size(); ++i) ASSERT_EQ(layer.tissue.inward(i), 0);
}

TEST(SoftTissue, ARotatingBurRemovesTheVolumeThatItsWorkPaysFor) {
  Tool bur = ball_probe();
  bur.cuts = true;
  Pressed layer(bur, flat_layer());
  const double cutting = 0.02;  // m/s, slow, so that the limit per tick does not apply
  double work = 0;
  for (int i = 0; i < 1500; ++i) {
    layer.hold(-std::min(0.3_mm * i / 500, 0.3_mm), 1e-3, cutting);
    work += layer.out.force.z * cutting * 1e-3;
  }
  double volume = 0;
  for (std::uint32_t i = 0; i < layer.surface->points().size(); ++i) {
    volume += layer.tissue.cut_depth(i) * layer.surface->points()[i].area;
  }
  // The force on the tool is the vertical sum of the contact forces, so the work is that of a ball's lowest part.
  EXPECT_NEAR(volume * layer.surface->law().specific_energy / work, 1, 0.15);
  const std::uint32_t middle = layer.nearest(dvec3(0));
  const double cut = layer.tissue.cut_depth(middle);
  EXPECT_GT(cut, 0);
  layer.hold(4.0_mm, 4);
  EXPECT_EQ(layer.tissue.inward(middle), cut) << "a cut stays after the return";
}

TEST(SoftTissue, BleedsOnlyFromACutThatIsDeepEnough) {
  Tool bur = ball_probe();
  bur.cuts = true;
  Pressed pressed(bur, flat_layer());
  pressed.move(0, -0.6_mm, 5e-3);
  pressed.hold(-0.6_mm, 1);
  EXPECT_TRUE(pressed.tissue.wounds().empty()) << "a dent does not bleed";
  Pressed cut(bur, flat_layer());
  cut.move(0, -0.1_mm, 5e-3, 5);
  cut.hold(-0.1_mm, 1, 5);
  EXPECT_TRUE(cut.tissue.wounds().empty()) << "a scratch does not bleed";
  cut.move(-0.1_mm, -0.6_mm, 5e-3, 5);
  ASSERT_EQ(cut.tissue.wounds().size(), 1u);
  EXPECT_LT(glm::length(cut.tissue.wounds()[0].p_W), 0.6_mm);
}

TEST(SoftTissue, SendsEveryVisibleMoveUntilThePictureShowsThePresentState) {
  Pressed layer(ball_probe(), flat_layer());
  std::vector<float> seen(layer.surface->points().size(), 0);
  int sent = 0;
  const auto send = [&](int most) {
    layer.tissue.send_moves([&](const haptics::SoftMove& move) {
      if (most-- == 0) return false;
      seen[move.point] = move.inward;
      ++sent;
      return true;
    });
  };
  layer.move(1.0_mm, -0.5_mm, 10e-3);
  send(5);  // a full channel keeps the rest for later
  EXPECT_EQ(sent, 5);
  send(100000);
  for (std::uint32_t i = 0; i < seen.size(); ++i) EXPECT_NEAR(seen[i], layer.tissue.inward(i), 1.1e-6);
  layer.hold(4.0_mm, 5);
  send(100000);
  for (const float inward : seen) EXPECT_EQ(inward, 0);
  sent = 0;
  send(100000);
  EXPECT_EQ(sent, 0) << "a sleeping layer sends nothing";
}

TEST(SoftTissue, NeverAllocatesAndMovesABoundedNumberOfPoints) {
  SoftLaw law;
  law.spacing = 0.15_mm;
  Pressed layer(wide_plate(), flat_layer(law));
  ASSERT_GT(layer.surface->points().size(), SoftTissue::kMaxActive);
  test::NoAlloc guard;
  layer.move(1.0_mm, -0.5_mm, 10e-3, 3);
  layer.tissue.send_moves([](const haptics::SoftMove&) { return true; });
  EXPECT_EQ(guard.count(), 0u);
  EXPECT_EQ(layer.tissue.active(), SoftTissue::kMaxActive);
}

TEST(SoftServo, TheSameHandFeelsTheMirroredForceOnTheMirroredSide) {
  std::array<std::vector<dvec3>, 2> force;
  for (const int side : {0, 1}) {
    const double sign = side == 0 ? 1 : -1;
    test::HapticBench bench(test::kBlockFarBelow, test::soft_settings(ball_probe()));
    for (int i = 0; i < 600; ++i) {
      const double s = i / 600.0;
      const ServoTick& tick = bench.tick({{sign * (0.3_mm + 1.2_mm * s), 0.1_mm, 0.6_mm - 0.7_mm * std::sin(kPi * s)}});
      force[static_cast<std::size_t>(side)].push_back({sign * tick.f_T_W.x, tick.f_T_W.y, tick.f_T_W.z});
    }
  }
  double strongest = 0;
  for (std::size_t i = 0; i < force[0].size(); ++i) {
    strongest = std::max(strongest, glm::length(force[0][i]));
    ASSERT_LT(glm::length(force[0][i] - force[1][i]), 0.01) << i;
  }
  EXPECT_GT(strongest, 0.2);
}

TEST(SoftServo, WorksBesideEveryContactModelOfAField) {
  for (const char* model : {"offset", "voxel_penalty", "mesh_lod", "vertex"}) {
    haptics::ServoSettings settings = test::soft_settings(ball_probe());
    settings.method = haptics::contact_method(model, "test");
    test::HapticBench bench(test::kBlockFarBelow, settings);
    for (int i = 0; i < 400; ++i) bench.tick({{0, 0, 0.7_mm - 2e-6 * i}});
    EXPECT_GT(bench.last.f_T_W.z, 0.1) << model;
  }
}

TEST(SoftServo, PublishesTheYieldedToolAsGum) {
  test::HapticBench bench(test::kBlockFarBelow, test::soft_settings(ball_probe()));
  for (int i = 0; i < 400; ++i) bench.tick({{0, 0, 0.7_mm - 2e-6 * i}});
  EXPECT_EQ(bench.last.tissue, Tissue::kGingiva);
  EXPECT_NEAR(bench.last.depth, glm::length(bench.last.X_WG.p - bench.last.X_WT.p), 1e-15);
  EXPECT_GT(bench.last.X_WG.p.z, bench.last.X_WT.p.z);
  EXPECT_NEAR(bench.last.n_C_W.z, 1, 0.01);
}

}  // namespace
}  // namespace typodont
