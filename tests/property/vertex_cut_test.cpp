// What a head removes from a mesh (contact model vertex): against analytic volumes, and by brute force.
#include <gtest/gtest.h>

#include <random>

#include "haptics/contact/vertex/mesh_cutter.h"
#include "tests/support/mesh_shapes.h"
#include "tests/support/no_alloc.h"

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

double total(const PerTissue& v) {
  double sum = 0;
  for (const double x : v) sum += x;
  return sum;
}

/// A mesh with its cutter.
struct Workpiece {
  EditableMesh mesh;
  MeshCutter cutter;
  Workpiece(const haptics::TissueMesh& tissue, double edge, std::size_t spare = 60'000)
      : mesh(tissue, CutParameters::longest * edge, spare), cutter(mesh, nullptr) {}
};

/// Volume that a ball pressed straight down into a plane removes, over the analytic cap.
double cap_error(double depth, double edge) {
  Workpiece w(square(4.0_mm, 0.4_mm), edge);
  const VertexHead head(round_head());
  const CutDone done = w.cutter.cut(w.mesh, head, {{0, 0, kRadius}}, {{0, 0, kRadius - depth}}, edge);
  const double cap = kPi * depth * depth * (3 * kRadius - depth) / 3;
  return total(done.removed) / cap - 1;
}

TEST(VertexCut, ACapsVolumeIsWithinFivePercentAtATenthOfTheRadiusAndThriceCloserAtATwentieth) {
  for (const double share : {0.3, 0.5, 0.8}) {
    const double coarse = std::abs(cap_error(share * kRadius, kRadius / 10));
    const double fine = std::abs(cap_error(share * kRadius, kRadius / 20));
    std::printf("depth %.1f R: R/10 %.4f R/20 %.4f ratio %.2f\n", share, coarse, fine, coarse / fine);
    EXPECT_LT(coarse, 0.05) << share;
    EXPECT_LT(3 * fine, coarse) << share;
  }
}

TEST(VertexCut, RandomStrokesLeaveAClosedMeshThatDoesNotCrossItself) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int shape = 0; shape < 1; ++shape) {
    Tool tool = round_head(0.5_mm);
    if (shape == 1) tool.shape = HeadShape::kCylinder, tool.length = 1.6_mm;
    if (shape == 2) tool.shape = HeadShape::kCone, tool.length = 1.6_mm;
    if (shape == 3) tool.shape = HeadShape::kRoundEndCylinder, tool.length = 1.6_mm;
    const VertexHead head(tool);
    const double edge = 0.1_mm;
    for (int seed = 0; seed < 3; ++seed) {
      Workpiece w(ball({2.0_mm, 1.5_mm, 1.0_mm}, 0.3_mm), edge);
      double removed = 0;
      const double before = test::volume(w.mesh);
      int held = 0, cuts = 0;
      for (int stroke = 0; stroke < 4; ++stroke) {
        const dvec3 d = glm::normalize(dvec3(unit(random), unit(random), unit(random)));
        const dquat R = glm::normalize(dquat(unit(random), unit(random), unit(random), unit(random)));
        Pose X{dvec3(3.5_mm * d.x, 3.0_mm * d.y, 2.5_mm * d.z), R};
        const dvec3 target = 0.5_mm * dvec3(unit(random), unit(random), unit(random));
        dvec3 way = glm::normalize(target - X.p);
        for (int k = 0; k < 60; ++k) {
          if (k == 35) way = glm::normalize(way + 1.5 * dvec3(unit(random), unit(random), unit(random)));
          const Pose next{X.p + 0.06_mm * way, X.R};
          const CutDone done = w.cutter.cut(w.mesh, head, X, next, edge);
          removed += total(done.removed), held += done.held, ++cuts;
          X = next;
        }
        ASSERT_EQ(test::broken(w.mesh), "") << shape << ' ' << seed << ' ' << stroke;
        EXPECT_EQ(test::crossings(w.mesh), 0) << shape << ' ' << seed << ' ' << stroke;
      }
      EXPECT_EQ(w.mesh.border_edges(), 0u);
      EXPECT_NEAR(removed, before - test::volume(w.mesh), 1e-6 * before);
      std::printf("shape %d seed %d: removed %.4f of %.4f mm3, %zu vertices, held in %d of %d\n", shape, seed,
                  removed * 1e9, before * 1e9, w.mesh.vertex_count(), held, cuts);
    }
  }
}

}  // namespace
}  // namespace typodont
