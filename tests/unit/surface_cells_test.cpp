#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "engine/base/voxels.h"
#include "engine/surface/contour/cell_shapes.h"
#include "engine/surface/contour/crossing.h"
#include "engine/surface/contour/moments.h"
#include "engine/surface/contour/plane_fit.h"
#include "engine/surface/contour/smooth_vertices.h"

namespace typodont::surface {
namespace {

TEST(CellShapes, DiagonallyOppositeSolidCornersHaveSeparatePatches) {
  const CellShapes& shapes = CellShapes::get();
  EXPECT_EQ(shapes[1 | 1 << 3].patches, 2);  // across a face
  EXPECT_EQ(shapes[1 | 1 << 7].patches, 2);  // across the cell
  EXPECT_EQ(shapes[1 | 1 << 1].patches, 1);  // along an edge
  EXPECT_EQ(shapes[0b01101001].patches, 4);  // a tetrahedron of solid corners
  EXPECT_EQ(shapes[0b10010110].patches, 4);
}

TEST(CellShapes, FlippingAnAmbiguousFaceSplitsThePatchThatTouchedItTwice) {
  const CellShapes& shapes = CellShapes::get();
  int doubtful = 0;
  for (int config = 0; config < 256; ++config) {
    for (int face = 0; face < 6; ++face) {
      if (!(shapes.flippable_faces(config) >> face & 1)) continue;
      ++doubtful;
      EXPECT_EQ(shapes[shapes.flipped(config, 1 << face)].patches, shapes[config].patches + 1) << config;
    }
  }
  EXPECT_GT(doubtful, 0);
}

/// A crossing of an edge. `t`: 0..1, position along the edge; `na`: component of the normal along the edge.
struct OneCrossing {
  float t, na, nb, nc, curvature;
};
OneCrossing cross_edge(const float* field, const int stride[3], int axis, std::uint16_t sample) {
  const GridEdge edge{sample, 0, 0, 0};
  Crossing found;
  cross_edges(field, stride, axis, {&edge, 1}, &found);
  const int b = (axis + 1) % 3, c = (axis + 2) % 3;
  return {found.point[axis], found.normal[axis], found.normal[b], found.normal[c], found.curvature};
}

// Samples of a field along and across one edge of the lattice.
struct Stencil {
  float samples[4 * 3 * 3];
  static constexpr int kA = 9, kB = 3, kC = 1;
  template <class F>
  explicit Stencil(F&& field) {
    for (int a = -1; a <= 2; ++a) {
      for (int b = -1; b <= 1; ++b) {
        for (int c = -1; c <= 1; ++c) {
          samples[(a + 1) * kA + (b + 1) * kB + (c + 1) * kC] = static_cast<float>(field(a, b, c));
        }
      }
    }
  }
  OneCrossing cross() const {
    constexpr int kStride[3] = {kA, kB, kC};
    return cross_edge(samples, kStride, 0, kA + kB + kC);
  }
};

TEST(Crossing, OfAPlaneIsExact) {
  const double n[3] = {0.6, 0.64, -0.48};
  const Stencil stencil([&](double a, double b, double c) { return n[0] * (a - 0.3) + n[1] * b + n[2] * c; });
  const OneCrossing at = stencil.cross();
  EXPECT_NEAR(at.t, 0.3, 1e-6);
  EXPECT_NEAR(at.na, n[0], 1e-6);
  EXPECT_NEAR(at.nb, n[1], 1e-6);
  EXPECT_NEAR(at.nc, n[2], 1e-6);
  EXPECT_NEAR(at.curvature, 0, 1e-6);
}

TEST(Crossing, OfAPlaneIsExactUpToTheCreaseOfABox) {
  // A solid with a crease: at the base of the edge the nearest surface is the side, and at its end it is the front.
  const Stencil stencil([](double a, double b, double) { return std::max(a - 0.3, b + 0.2); });
  const OneCrossing at = stencil.cross();
  EXPECT_NEAR(at.t, 0.3, 1e-6);
  EXPECT_NEAR(at.na, 1, 1e-6);
  EXPECT_NEAR(at.nb, 0, 1e-6);
}

TEST(Crossing, OfASphereHasAnErrorOfSecondOrder) {
  double error[2];
  for (int i = 0; i < 2; ++i) {
    const double radius = i ? 40 : 20;
    // The ball's centre is chosen so that the surface crosses the edge at a = 0.4 with the normal (0.6, 0.8, 0).
    const double ca = 0.4 - 0.6 * radius, cb = -0.8 * radius;
    const Stencil stencil([&](double a, double b, double c) { return std::hypot(a - ca, b - cb, c) - radius; });
    const OneCrossing at = stencil.cross();
    error[i] = std::abs(at.t - 0.4);
    EXPECT_NEAR(at.curvature, 1 / radius, 0.03 / radius);
  }
  EXPECT_LT(error[0], 4e-4);
  EXPECT_LT(error[1], error[0] / 3);
}

Crossing crossing(const glm::vec3& p, const glm::vec3& n, float curvature = 0) {
  return {{p.x, p.y, p.z}, {n.x, n.y, n.z}, curvature};
}

// Samples of a field in a cube, whose edges along each axis are crossed with cross_edges().
TEST(Crossing, OfManyEdgesHasTheBitsOfSingleEdges) {
  constexpr int kSide = 12, kStride[3] = {kSide * kSide, kSide, 1};
  const auto ball = [](const glm::vec3& p) { return glm::length(p - glm::vec3(5.3f, 5.6f, 5.1f)) - 3.4f; };
  const auto box = [](const glm::vec3& p) {
    const glm::vec3 d = glm::abs(p - 5.5f) - glm::vec3(2.2f, 2.7f, 3.1f);
    return std::max({d.x, d.y, d.z});
  };
  const auto furrow = [&](const glm::vec3& p) { return std::max(ball(p), 1.5f - std::abs(p.x - 0.6f * p.y - 2)); };
  std::mt19937 random(7);
  const auto noise = [&](const glm::vec3&) { return std::uniform_real_distribution<float>(-1, 1)(random); };
  int crossed = 0;
  const auto test = [&](const auto& field) {
    std::vector<float> samples;
    for (int i = 0; i < kSide * kSide * kSide; ++i)
      samples.push_back(field(glm::vec3(i / kStride[0], i / kStride[1] % kSide, i % kSide)));
    for (int axis = 0; axis < 3; ++axis) {
      std::vector<GridEdge> edges;
      for_each_voxel_between(glm::ivec3(1), glm::ivec3(kSide - 3), [&](int x, int y, int z) {
        const auto at = static_cast<std::size_t>(x * kStride[0] + y * kStride[1] + z);
        if ((samples[at] < 0) == (samples[at + static_cast<std::size_t>(kStride[axis])] < 0)) return;
        edges.push_back({static_cast<std::uint16_t>(at), static_cast<std::uint8_t>(x), static_cast<std::uint8_t>(y),
                         static_cast<std::uint8_t>(z)});
      });
      std::vector<Crossing> found(edges.size());
      cross_edges(samples.data(), kStride, axis, edges, found.data());
      const int b = (axis + 1) % 3, c = (axis + 2) % 3;
      for (std::size_t i = 0; i < edges.size(); ++i, ++crossed) {
        const OneCrossing one = cross_edge(samples.data(), kStride, axis, edges[i].sample);
        glm::vec3 point(edges[i].x, edges[i].y, edges[i].z);
        point[axis] += one.t;
        for (int k = 0; k < 3; ++k) ASSERT_EQ(found[i].point[k], point[k]);
        ASSERT_EQ(found[i].normal[axis], one.na);
        ASSERT_EQ(found[i].normal[b], one.nb);
        ASSERT_EQ(found[i].normal[c], one.nc);
        ASSERT_EQ(found[i].curvature, one.curvature);
        ASSERT_EQ(found[i].one, 1);
      }
    }
  };
  test(ball), test(box), test(furrow), test(noise);
  EXPECT_GT(crossed, 1000);
}

TEST(PlaneFit, FindsTheCornerOfThreePlanes) {
  PlaneSums sums;
  const glm::vec3 corner(0.21f, -0.34f, 0.11f), centre(1, 2, 3);
  sums.add(crossing(centre + glm::vec3(corner.x, 0.4f, 0.3f), {1, 0, 0}), centre);
  sums.add(crossing(centre + glm::vec3(-0.2f, corner.y, 0.3f), {0, 1, 0}), centre);
  sums.add(crossing(centre + glm::vec3(-0.2f, 0.4f, corner.z), {0, 0, 1}), centre);
  const PlaneFit fit = fit_planes(sums, 0.01);
  EXPECT_EQ(fit.rank, 3);
  EXPECT_LT(glm::length(fit.point - corner), 1e-6f);
  EXPECT_LT(fit.residual, 1e-6f);
  EXPECT_GT(fit_planes(sums, 0.01, 2).residual, 0.05f);  // with one direction less it cannot meet all three
}

TEST(PlaneFit, LeavesFreeDirectionsAtTheMean) {
  PlaneSums sums;
  sums.add(crossing({0.5f, 0.1f, 0}, {0, 0, 1}), glm::vec3(0));
  sums.add(crossing({0.1f, 0.3f, 0}, {0, 0, 1}), glm::vec3(0));
  const PlaneFit fit = fit_planes(sums, 0.01);
  EXPECT_EQ(fit.rank, 1);
  EXPECT_LT(glm::length(fit.point - glm::vec3(0.3f, 0.2f, 0)), 1e-6f);
}

TEST(GreatestCurvature, OfACylinderIsThatOfItsRoundDirection) {
  Moments round, strip;
  for (int i = -4; i <= 4; ++i) {
    for (int j = -4; j <= 4; ++j) {
      auto add = [&](Moments& moments, float wide) {
        const float angle = 0.1f * wide * static_cast<float>(i) / 4;  // radius 10, axis y
        moments.add(crossing({10 * std::sin(angle), static_cast<float>(j) / 4, 10 * std::cos(angle) - 10},
                             {std::sin(angle), 0, std::cos(angle)}, 0.05f),
                    glm::vec3(0));
      };
      add(round, 1);
      add(strip, 0.3f);
    }
  }
  EXPECT_NEAR(max_curvature(round, 0.016f), 0.1f, 0.01f);
  EXPECT_NEAR(max_curvature(strip, 0.016f), 0.1f, 0.03f);
}

TEST(Moments, MovedToAnotherOriginAreThoseComputedThere) {
  Moments near, far, moved;
  const glm::vec3 shift(3.5f, -2, 1);
  for (const glm::vec3 p : {glm::vec3(0.1f, 0.2f, 0.3f), glm::vec3(-0.4f, 0.1f, 0.2f), glm::vec3(0.3f, -0.3f, 0)}) {
    const glm::vec3 n = glm::normalize(p + glm::vec3(0, 0, 1));
    near.add(crossing(p, n, 0.1f), glm::vec3(0));
    far.add(crossing(p, n, 0.1f), -shift);
  }
  moved.add(near, shift);
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 8; ++j) EXPECT_NEAR(moved.at(i, j), far.at(i, j), 1e-4);
  }
  EXPECT_EQ(near.sums().count(), 3);
}

TEST(Moments, HaveTheBitsOfTheSumsThatAreComputedAlone) {
  Moments moments;
  CrossingSums alone;
  for (const glm::vec3 p : {glm::vec3(0.1f, 0.2f, 0.3f), glm::vec3(-0.4f, 0.1f, 0.2f), glm::vec3(0.3f, -0.3f, 0)}) {
    const Crossing one = crossing(p, glm::normalize(p + glm::vec3(0, 0.7f, 1)), 0.1f);
    moments.add(one, glm::vec3(0.5f));
    alone.add(one, glm::vec3(0.5f));
  }
  const CrossingSums sums = moments.sums();
  EXPECT_EQ(sums.count(), alone.count());
  EXPECT_EQ(sums.points(), alone.points());
  EXPECT_EQ(sums.normals(), alone.normals());
  EXPECT_EQ(sums.curvatures(), alone.curvatures());
  EXPECT_EQ(sums.points_by_normals(), alone.points_by_normals());
}

TEST(SmoothVertices, OfEightCellsHaveTheBitsOfSingleCells) {
  std::mt19937 random(3);
  CrossingSums sums[8];
  const CrossingSums* cells[8];
  for (int cell = 0; cell < 8; ++cell) {
    cells[cell] = &sums[cell];
    for (int i = 0; i < 3 + cell % 4; ++i) {
      const auto number = [&] { return std::uniform_real_distribution<float>(-0.5f, 0.5f)(random); };
      const glm::vec3 p(number(), number(), number()), n(number(), number(), 1);
      // the sum of the normals of cell 5 is zero
      sums[cell].add(crossing(p, cell == 5 ? glm::vec3(0) : glm::normalize(n), 0.2f * number()), glm::vec3(0));
    }
  }
  SmoothVertices eight;
  smooth_vertices(cells, eight);
  const unsigned spread = spread_of_normals(cells, 0.05f);
  for (int cell = 0; cell < 8; ++cell) {
    const glm::vec3 position = smooth_vertex(sums[cell], 1), normal = unit_normal(sums[cell]);
    const glm::vec3 mean = sums[cell].normals() / sums[cell].count();
    for (int i = 0; i < 3; ++i) {
      EXPECT_EQ(eight.position[i][cell], position[i]) << cell;
      EXPECT_EQ(eight.normal[i][cell], normal[i]) << cell;
    }
    EXPECT_EQ(spread >> cell & 1, 1 - glm::dot(mean, mean) < 0.05f ? 0u : 1u) << cell;
  }
  EXPECT_EQ(unit_normal(sums[5]), glm::vec3(0, 0, 1));
}

}  // namespace
}  // namespace typodont::surface
