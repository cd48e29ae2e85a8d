// Tests of the volume that a head removes from a mesh (contact model vertex), compared with analytic volumes and with a
// direct computation.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "haptics/contact/vertex/head_distances.h"
#include "haptics/contact/vertex/mesh_cutter.h"
#include "tests/support/heads.h"
#include "tests/support/mesh_shapes.h"

namespace typodont {
namespace {

using namespace literals;
using haptics::HeadShape;
using haptics::Tool;
using haptics::mesh::EditableMesh;
using haptics::mesh::Index;
using haptics::vertex::CutDone;
using haptics::vertex::CutParameters;
using haptics::vertex::MeshCutter;
using haptics::vertex::VertexHead;
using test::ball;
using test::square;

constexpr double kRadius = 0.6e-3;  // m

Tool round_head(double radius = kRadius) {
  Tool tool;
  tool.diameter = tool.length = 2 * radius;
  return tool;
}

/// A mesh, and the object that cuts it.
struct Workpiece {
  EditableMesh mesh;
  MeshCutter cutter;
  Workpiece(const haptics::TissueMesh& tissue, double edge, std::size_t spare = 60'000)
      : mesh(tissue, CutParameters::longest * edge, spare), cutter(mesh, nullptr) {}
};

/// Moves the head from A to B as the servo does: in steps, which are repeated where vertices held the head. Returns the
/// removed volume (m³).
double drive(Workpiece& w, const VertexHead& head, Pose X, const Pose& X_WB, double edge) {
  double removed = 0;
  const dvec3 way = X_WB.p - X.p;
  for (int k = 0; k < 400; ++k) {
    const dvec3 left = X_WB.p - X.p;
    const double step = 0.3 * edge;
    const Pose next{glm::length(left) > step ? X.p + step * glm::normalize(way) : X_WB.p, X_WB.R};
    const CutDone done = w.cutter.cut(w.mesh, head, X, next, edge);
    removed += total(done.removed);
    if (!done.held) X = next;
    if (X.p == X_WB.p) return removed;
  }
  ADD_FAILURE() << "held back at " << X.p.z;
  return removed;
}

/// Returns the relative error of the volume that a ball removes when it is pressed straight down into a plane, compared
/// with the analytic volume of the cap.
double cap_error(double depth, double edge) {
  Workpiece w(square(4.0_mm, 0.4_mm), edge);
  const VertexHead head(round_head());
  const CutDone done = w.cutter.cut(w.mesh, head, {{0, 0, kRadius}}, {{0, 0, kRadius - depth}}, edge);
  const double cap = kPi * depth * depth * (3 * kRadius - depth) / 3;
  return total(done.removed) / cap - 1;
}

TEST(VertexCut, TheVolumeOfACapIsWithinFivePercentWithEdgesOfATenthOfTheRadiusAndThreeTimesCloserWithATwentieth) {
  for (const double fraction : {0.3, 0.5, 0.8}) {
    const double coarse = std::abs(cap_error(fraction * kRadius, kRadius / 10));
    const double fine = std::abs(cap_error(fraction * kRadius, kRadius / 20));
    EXPECT_LT(coarse, 0.05) << fraction;
    EXPECT_LT(3 * fine, coarse) << fraction;
  }
}

Tool head_of(HeadShape shape, double diameter = 1.0_mm) {
  Tool tool = round_head(diameter / 2);
  tool.shape = shape;
  if (shape != HeadShape::kSphere) tool.length = 1.6 * diameter;
  return tool;
}

/// Moves a head on a random path through the workpiece, in steps of at most half an edge, as the servo does. Where a
/// wall holds the head back, it tries again, and stops trying after a few times. Returns the removed volume (m³).
double scribble(Workpiece& w, const VertexHead& head, double edge, std::mt19937& random, const dvec3& size) {
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto direction = [&] { return glm::normalize(dvec3(unit(random), unit(random), unit(random))); };
  const dquat R = glm::normalize(dquat(unit(random), unit(random), unit(random), unit(random)));
  Pose X{(size + head.reach()) * direction(), R};
  while (glm::length(X.p / (size + 0.9 * head.reach())) < 1) X.p *= 1.1;
  dvec3 way = glm::normalize(0.3 * size * direction() - X.p);
  double removed = 0;
  int tries = 0;
  for (int k = 0; k < 60 && tries < 6; ++k) {
    if (k == 35) way = glm::normalize(way + 1.5 * direction());
    const Pose next{X.p + 0.5 * edge * way, glm::normalize(X.R * dquat(1, 0.005 * unit(random), 0, 0))};
    const CutDone done = w.cutter.cut(w.mesh, head, X, next, edge);
    removed += total(done.removed);
    tries = done.held ? tries + 1 : 0;
    if (!done.held) X = next;
  }
  return removed;
}

class VertexCutHeads : public ::testing::TestWithParam<HeadShape> {};

TEST_P(VertexCutHeads, RandomStrokesLeaveAClosedMeshClosedAndFreeOfCrossings) {
  const VertexHead head(head_of(GetParam()));
  const double edge = 0.1_mm;
  const dvec3 size(2.0_mm, 1.5_mm, 1.0_mm);
  for (unsigned seed = 1; seed <= 4; ++seed) {
    std::mt19937 random(seed);
    Workpiece w(ball(size, 0.3_mm), edge);
    const double before = test::volume(w.mesh);
    double removed = 0;
    for (int stroke = 0; stroke < 4; ++stroke) {
      removed += scribble(w, head, edge, random, size);
      ASSERT_EQ(test::broken(w.mesh), "") << seed << ' ' << stroke;
      EXPECT_EQ(test::crossings(w.mesh), 0) << seed << ' ' << stroke;
    }
    EXPECT_EQ(w.mesh.border_edges(), 0u);
    EXPECT_GT(removed, 0.2e-9) << "strokes that cut nothing would prove nothing";
    EXPECT_NEAR(removed, before - test::volume(w.mesh), 1e-9 * before) << "what it says it took is what is gone";
  }
}

TEST_P(VertexCutHeads, ACutInPartsWithKnownFacesGivesTheSameMeshBitForBit) {
  const VertexHead head(head_of(GetParam()));
  const double edge = 0.1_mm;
  const haptics::TissueMesh tissue = ball(dvec3(2.0_mm, 1.5_mm, 1.0_mm), 0.3_mm);
  Workpiece whole(tissue, edge), parted(tissue, edge);
  Pose X{{0, 0, 1.0_mm + head.reach()}, glm::normalize(dquat(1, 0.1, 0.2, 0))};
  const dvec3 way = glm::normalize(dvec3(0.4, 0.2, -1));
  std::size_t parts = 0, changed = 0;
  for (int k = 0; k < 60; ++k) {
    const Pose next{X.p + 0.3 * edge * way, glm::normalize(X.R * dquat(1, 0.003, 0, 0))};
    const CutDone done = whole.cutter.cut(whole.mesh, head, X, next, edge);
    // Uses faces that were found for a pose beside the head's pose.
    const Pose seen{next.p + dvec3(0.02_mm, 0, 0), X.R};
    const double within = 0.4_mm;
    std::vector<haptics::mesh::Index> faces;
    parted.mesh.near(seen.p - head.reach() - within, seen.p + head.reach() + within,
                     [&](haptics::mesh::Index f) { faces.push_back(f); });
    parted.cutter.begin(head, X, next, edge);
    bool finished = false;
    while (!finished) {
      haptics::vertex::Effort left = 1;
      finished = parted.cutter.work(parted.mesh, {faces, seen, within}, left);
      ++parts;
    }
    ASSERT_EQ(test::mesh_hash(parted.mesh), test::mesh_hash(whole.mesh)) << k;
    EXPECT_EQ(parted.cutter.done().removed, done.removed) << k;
    EXPECT_EQ(parted.cutter.done().held, done.held) << k;
    changed += done.changed;
    if (!done.held) X = next;
  }
  EXPECT_GT(changed, 10u);
  EXPECT_GT(parts, 100 * changed) << "each part must be short";
}

TEST_P(VertexCutHeads, AnOpenMeshKeepsItsBorderBitForBit) {
  const VertexHead head(head_of(GetParam()));
  const double edge = 0.1_mm;
  Workpiece w(square(3.0_mm, 0.3_mm), edge);
  const EditableMesh before = w.mesh;
  std::mt19937 random(4);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int stroke = 0; stroke < 6; ++stroke) {  // also across the border
    Pose X{{2.0_mm * unit(random), 2.0_mm * unit(random), head.reach()},
           glm::angleAxis(0.6 * unit(random), dvec3(0, 1, 0))};
    const dvec3 along = 0.03_mm * glm::normalize(dvec3(unit(random), unit(random), 0));
    for (int k = 0; k < 50; ++k) {
      const Pose next{X.p + (k < 25 ? dvec3(0, 0, -0.03_mm) : along), X.R};
      if (!w.cutter.cut(w.mesh, head, X, next, edge).held) X = next;
    }
  }
  EXPECT_EQ(test::broken(w.mesh), "");
  EXPECT_EQ(w.mesh.border_edges(), before.border_edges());
  for (Index v = 0; v < before.vertex_range(); ++v) {
    if (before.vertex(v).on_border()) {
      ASSERT_EQ(w.mesh.vertex(v).p, before.vertex(v).p);
    }
  }
  EXPECT_EQ(test::crossings(w.mesh), 0);
}

INSTANTIATE_TEST_SUITE_P(Shapes, VertexCutHeads,
                         ::testing::Values(HeadShape::kSphere, HeadShape::kCylinder, HeadShape::kRoundEndCylinder,
                                           HeadShape::kCone, HeadShape::kPear, HeadShape::kFlame,
                                           HeadShape::kInvertedCone),
                         [](const auto& each) { return std::string(haptics::name_of(each.param)); });

TEST(VertexHead, TheQuickTestNeverExcludesANearPointAndExcludesMostFarOnes) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> spread(-1, 1);
  for (const HeadShape shape : test::head_shapes()) {
    for (const double slender : {1.6, 2.5, 6.0}) {
      Tool tool = head_of(shape, 0.6_mm + 0.5_mm * std::abs(spread(random)));
      if (shape != HeadShape::kSphere) tool.length = slender * tool.diameter;
      const VertexHead head(tool);
      const dquat R = glm::normalize(dquat(spread(random), spread(random), spread(random), spread(random)));
      const glm::vec3 axis(R * dvec3(0, 0, 1));
      int far_ones = 0, excluded = 0;
      for (int i = 0; i < 20'000; ++i) {
        dvec3 p_T = 1.3 * head.reach() * dvec3(spread(random), spread(random), spread(random));
        if (i % 4 == 0) {  // a point on the surface or very near it
          dvec3 n;
          for (int k = 0; k < 3; ++k) p_T -= head.distance(p_T, n) * n;
          p_T += 1e-9 * spread(random) * n;
        }
        const double d = head.distance(p_T), far = i % 3 == 0 ? 0 : 0.2 * head.radius() * std::abs(spread(random));
        const glm::vec3 off(R * p_T);
        const bool may = head.may_be_within(off, axis, static_cast<float>(far));
        if (d <= far) {
          ASSERT_TRUE(may) << haptics::name_of(shape) << ' ' << p_T.x << ' ' << p_T.y << ' ' << p_T.z;
        } else if (d > far + 0.15 * head.radius()) {
          ++far_ones;
          excluded += !may;
        }
      }
      ASSERT_GT(far_ones, 1000);
      EXPECT_GT(excluded, 0.97 * far_ones) << haptics::name_of(shape) << ' ' << slender;
    }
  }
}

TEST(HeadDistances, ExtrapolatedDistancesAreNeverTooLargeAndDifferLittleOnSmoothHeads) {
  constexpr double kReuse = 0.02;
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> spread(-1, 1);
  haptics::vertex::HeadDistances exact(500), extrapolated(500, kReuse);
  for (const HeadShape shape : test::head_shapes()) {
    const VertexHead head(head_of(shape));
    int pushed = 0;
    for (int run = 0; run < 40; ++run) {
      Pose X{1e-2 * dvec3(spread(random), spread(random), spread(random)),
             glm::normalize(dquat(spread(random), spread(random), spread(random), spread(random)))};
      haptics::mesh::NearPoints points(500);
      points.clear(X);
      for (int i = 0; i < 300; ++i) {
        points.add(X.p + 1.2 * head.reach() * dvec3(spread(random), spread(random), spread(random)));
      }
      const double everywhere = 1, motion = 0.5 * kReuse * head.radius();
      extrapolated.forget();
      extrapolated.find(head, points, X, everywhere);
      X.p += motion * glm::normalize(dvec3(spread(random), spread(random), spread(random)));
      X.R = glm::normalize(X.R * glm::angleAxis(0.4 * motion / head.reach(), dvec3(0, 1, 0)));
      exact.find(head, points, X, everywhere);
      extrapolated.find(head, points, X, everywhere);
      ASSERT_EQ(extrapolated.size(), points.size());
      for (std::size_t i = 0; i < points.size(); ++i) {
        ASSERT_EQ(extrapolated.point(i), i);
        EXPECT_LE(extrapolated.distance(i), exact.distance(i) + 2e-9) << haptics::name_of(shape);
        if (head.is_ball() && exact.distance(i) > -0.5 * head.radius()) {
          EXPECT_NEAR(extrapolated.distance(i), exact.distance(i), 4 * motion * motion / head.radius());
        }
      }
      // The same test of each point as in find_pushed(), which searches eight points at once.
      const dvec3 way = 0.2 * head.radius() * glm::normalize(dvec3(spread(random), spread(random), spread(random)));
      std::vector<std::uint32_t> expected;
      for (std::size_t i = 0; i < extrapolated.size(); ++i) {
        const double ahead = glm::dot(extrapolated.normal_W(i), way);
        if (extrapolated.distance(i) - std::max(ahead, 0.0) < -1e-9) expected.push_back(extrapolated.point(i));
      }
      extrapolated.find_pushed(head, points, X, way);
      const auto found = extrapolated.kept();
      EXPECT_TRUE(std::ranges::includes(found, expected)) << haptics::name_of(shape);
      pushed += static_cast<int>(expected.size());
    }
    EXPECT_GT(pushed, 40) << haptics::name_of(shape);
  }
}

TEST(VertexCut, MovedVerticesLieOnTheHead) {
  for (const HeadShape shape : test::head_shapes()) {
    if (shape == HeadShape::kInvertedCone) continue;  // its rim may be held for some ticks (README.md)
    const VertexHead head(head_of(shape));
    Workpiece w(square(4.0_mm, 0.4_mm), 0.1_mm);
    const dquat R = glm::angleAxis(0.4, glm::normalize(dvec3(1, 2, 0)));
    const Pose X_WB{{0, 0, 0.3_mm}, R};
    drive(w, head, {{0, 0, head.reach()}, R}, X_WB, 0.1_mm);
    int on = 0;
    for (Index v = 0; v < w.mesh.vertex_range(); ++v) {
      if (w.mesh.vertex(v).face == haptics::mesh::kNone) continue;
      const double d = head.distance(glm::conjugate(R) * (w.mesh.vertex(v).p - X_WB.p));
      ASSERT_GE(d, -1e-9) << haptics::name_of(shape) << ": nothing is left inside";
      on += std::abs(d) < 1e-9;
    }
    EXPECT_GT(on, 8) << haptics::name_of(shape);
  }
}

TEST(VertexCut, BelowTheSurfaceThePublishedRulePushesTissueOutAndTheCorrectedRuleDoesNot) {
  const VertexHead head(round_head());
  const double depth = 1.5 * kRadius, edge = kRadius / 10;
  const auto highest = [](const EditableMesh& mesh) {
    double z = -1;
    for (Index v = 0; v < mesh.vertex_range(); ++v) {
      if (mesh.vertex(v).face != haptics::mesh::kNone) z = std::max(z, mesh.vertex(v).p.z);
    }
    return z;
  };
  const Pose above{{0, 0, kRadius}}, below{{0, 0, kRadius - depth}};
  Workpiece printed(square(4.0_mm, edge), edge);
  const CutDone pushed = printed.cutter.cut_as_printed(printed.mesh, head, below);
  EXPECT_GT(highest(printed.mesh), 0.4 * kRadius) << "vertices above the centre go up: a dome instead of a hole";
  EXPECT_LT(total(pushed.removed), 0) << "tissue comes into being";

  Workpiece mended(square(4.0_mm, 0.4_mm), edge);
  const double cut = drive(mended, head, above, below, edge);
  EXPECT_LT(highest(mended.mesh), 1e-9);
  // First moves straight down: the volume is a cylinder and a half ball.
  const double exact = kPi * kRadius * kRadius * (depth - kRadius) + 2.0 / 3 * kPi * kRadius * kRadius * kRadius;
  EXPECT_NEAR(cut, exact, 0.05 * exact);
  EXPECT_EQ(test::crossings(mended.mesh), 0);
  // Then sideways, where the ball's upper half meets the flat surface. No vertex rises above the surface.
  Pose X = below;
  for (int k = 0; k < 60; ++k) {
    const Pose next{X.p + dvec3(0.02_mm, 0, 0)};
    if (!mended.cutter.cut(mended.mesh, head, X, next, edge).held) X = next;
  }
  EXPECT_GT(X.p.x, 0.5_mm);
  EXPECT_LT(highest(mended.mesh), 0.05 * kRadius);
  EXPECT_EQ(test::crossings(mended.mesh), 0);
}

TEST(VertexCut, AThinWallIsNotCutThrough) {
  // A plate of 0.3 mm, pressed by a ball from above. The rest of the plate neither opens nor intersects itself.
  const VertexHead head(round_head());
  Workpiece w(ball({3.0_mm, 3.0_mm, 0.15_mm}, 0.3_mm), 0.1_mm);
  Pose X{{0, 0, 0.8_mm}};
  bool held = false;
  for (int k = 0; k < 120; ++k) {
    const Pose next{X.p - dvec3(0, 0, 0.01_mm)};
    const CutDone done = w.cutter.cut(w.mesh, head, X, next, 0.1_mm);
    held |= done.held;
    if (!done.held) X = next;
  }
  EXPECT_TRUE(held);
  EXPECT_EQ(test::broken(w.mesh), "");
  EXPECT_EQ(w.mesh.border_edges(), 0u);
  EXPECT_EQ(test::crossings(w.mesh), 0);
}

}  // namespace
}  // namespace typodont
