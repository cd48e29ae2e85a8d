// Tests the pieces of a mesh from which pictures are made: each face occurs once, normals follow the stated rule, and
// after any changes of the mesh the pieces equal those of a new division.
#include <gtest/gtest.h>

#include <map>
#include <random>
#include <tuple>

#include "haptics/mesh/surface_pieces.h"
#include "haptics/solid.h"
#include "haptics/tissue_volume.h"
#include "tests/support/mesh_shapes.h"

namespace typodont {
namespace {

using namespace literals;
using haptics::SurfaceCorner;
using haptics::SurfacePiece;
using haptics::TissueMesh;
using haptics::mesh::EditableMesh;
using haptics::mesh::MeshRecord;
using haptics::mesh::PieceParameters;
using haptics::mesh::SurfacePieces;
using test::ball;
using test::random_edits;
using test::square;

constexpr double kEdge = 0.3e-3;                                // m
constexpr PieceParameters kCells{.least = 1e-3, .most = 1e-3};  // the same grid for every mesh

haptics::TissueVolume labels() {
  return haptics::TissueVolume(haptics::read_solids(Json::parse(
      R"({"voxel_mm": 0.2, "solids": [{"tissue": "enamel", "solid": {"sphere": {"radius_mm": 1}}}]})", "tissue")));
}

using Cell = std::tuple<int, int, int>;
using Shown = std::map<Cell, SurfacePiece>;

void show(Shown& shown, std::vector<SurfacePiece> pieces) {
  for (SurfacePiece& piece : pieces) {
    const Cell cell{piece.cell.x, piece.cell.y, piece.cell.z};
    if (piece.indices.empty()) {
      shown.erase(cell);
    } else {
      shown[cell] = std::move(piece);
    }
  }
}

bool same(const SurfaceCorner& a, const SurfaceCorner& b) {
  return a.p == b.p && a.n == b.n && a.tissue == b.tissue && a.second == b.second;
}

/// What differs; empty: nothing.
std::string difference(const Shown& a, const Shown& b) {
  if (a.size() != b.size()) return "another number of pieces";
  for (const auto& [cell, piece] : a) {
    const auto found = b.find(cell);
    if (found == b.end()) return "a piece that the other has not";
    const SurfacePiece& other = found->second;
    if (piece.indices != other.indices) return "other triangles";
    if (piece.corners.size() != other.corners.size()) return "another number of corners";
    for (std::size_t i = 0; i < piece.corners.size(); ++i)
      if (!same(piece.corners[i], other.corners[i])) return "another corner";
  }
  return "";
}

std::size_t triangles(const Shown& shown) {
  std::size_t count = 0;
  for (const auto& [cell, piece] : shown) count += piece.indices.size() / 3;
  return count;
}

TEST(SurfacePieces, AfterAnyEditsAndUndoTheyAreThePiecesOfTheCurrentMesh) {
  const haptics::TissueVolume volume = labels();
  for (const bool open : {false, true}) {
    EditableMesh mesh(open ? square(6.0_mm, kEdge) : ball(dvec3(3.0_mm), kEdge), kEdge, 5000);
    SurfacePieces pieces(mesh, volume, kCells);
    EXPECT_EQ(pieces.open(), open);
    Shown shown;
    show(shown, pieces.take_changed());
    const Shown first = shown;
    EXPECT_EQ(triangles(shown), mesh.face_count());
    const auto fresh = [&] {
      EditableMesh copy = mesh;
      SurfacePieces others(copy, volume, kCells);
      Shown all;
      show(all, others.take_changed());
      return all;
    };
    std::mt19937 random(open ? 3 : 4);
    std::vector<MeshRecord> strokes(4);
    for (MeshRecord& stroke : strokes) {
      mesh.record(&stroke);
      random_edits(mesh, random, 400);
      mesh.record(nullptr);
      show(shown, pieces.take_changed());
      ASSERT_EQ(difference(shown, fresh()), "");
      ASSERT_EQ(triangles(shown), mesh.face_count());
    }
    for (std::size_t k = strokes.size(); k-- > 0;) mesh.exchange(strokes[k]);
    show(shown, pieces.take_changed());
    EXPECT_EQ(difference(shown, first), "");
    for (MeshRecord& stroke : strokes) mesh.exchange(stroke);
    show(shown, pieces.take_changed());
    EXPECT_EQ(difference(shown, fresh()), "");
  }
}

TEST(SurfacePieces, OnlyEditedPiecesAreRebuilt) {
  const haptics::TissueVolume volume = labels();
  EditableMesh mesh(ball(dvec3(5.0_mm), kEdge), kEdge, 5000);
  SurfacePieces pieces(mesh, volume, kCells);
  const std::size_t all = pieces.take_changed().size();
  EXPECT_EQ(pieces.take_changed().size(), 0u);
  mesh.move(0, mesh.vertex(0).p * 0.99);
  mesh.settle(0);
  const std::size_t some = pieces.take_changed().size();
  EXPECT_GE(some, 1u);
  EXPECT_LE(some, 8u) << "of " << all;
}

TEST(SurfacePieces, NormalsOfABallPointAwayFromItsMiddleWithinATenthOfADegree) {
  const haptics::TissueVolume volume = labels();
  EditableMesh mesh(ball(dvec3(3.0_mm), kEdge), kEdge, 0);
  SurfacePieces pieces(mesh, volume);
  for (const SurfacePiece& piece : pieces.take_changed())
    for (const SurfaceCorner& corner : piece.corners) {
      const dvec3 out = glm::normalize(dvec3(corner.p) + volume.frame().origin);
      ASSERT_GT(glm::dot(out, dvec3(corner.n)), std::cos(0.1_deg));
    }
}

TEST(SurfacePieces, ABoxKeepsItsEdgesSharpAndItsFacesFlat) {
  const haptics::TissueVolume volume = labels();
  TissueMesh box;
  for (int i = 0; i < 8; ++i) box.vertices.push_back(2e-3 * dvec3(i & 1, i >> 1 & 1, i >> 2));
  box.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                   {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  box.tissue.assign(12, Tissue::kEnamel);
  EditableMesh mesh(box, 4e-3, 0);
  SurfacePieces pieces(mesh, volume);
  std::size_t corners = 0;
  for (const SurfacePiece& piece : pieces.take_changed())
    for (std::size_t i = 0; i < piece.indices.size(); i += 3) {
      const auto at = [&](std::size_t k) { return piece.corners[piece.indices[i + k]]; };
      const glm::vec3 flat = glm::normalize(glm::cross(at(1).p - at(0).p, at(2).p - at(0).p));
      for (std::size_t k = 0; k < 3; ++k, ++corners) ASSERT_GT(glm::dot(at(k).n, flat), 0.9999f);
    }
  EXPECT_EQ(corners, 36u);
}

TEST(SurfacePieces, TheCornersOfATriangleHaveTheSameTwoTissues) {
  const haptics::TissueVolume volume = labels();
  TissueMesh flat = square(6.0_mm, kEdge);
  for (std::size_t t = 0; t < flat.triangles.size(); ++t)
    flat.tissue[t] = flat.vertices[flat.triangles[t].x].x < 0 ? Tissue::kEnamel : Tissue::kDentin;
  EditableMesh mesh(flat, kEdge, 0);
  SurfacePieces pieces(mesh, volume);
  std::size_t mixed = 0;
  for (const SurfacePiece& piece : pieces.take_changed())
    for (std::size_t i = 0; i < piece.indices.size(); i += 3) {
      double x = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        const SurfaceCorner& corner = piece.corners[piece.indices[i + k]];
        ASSERT_EQ(corner.tissue, piece.corners[piece.indices[i]].tissue);
        ASSERT_GE(corner.second, 0);
        ASSERT_LE(corner.second, 1);
        x += (static_cast<double>(corner.p.x) + volume.frame().origin.x) / 3;
      }
      const auto& pair = piece.corners[piece.indices[i]].tissue;
      mixed += pair[0] != pair[1];
      ASSERT_TRUE(std::abs(x) < 2 * kEdge || pair[x < 0 ? 0 : 1] == (x < 0 ? Tissue::kEnamel : Tissue::kDentin)) << x;
    }
  EXPECT_GT(mixed, 10u);
  EXPECT_LT(mixed, mesh.face_count() / 5);
}

}  // namespace
}  // namespace typodont
