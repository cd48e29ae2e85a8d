// The mesh after any history of updates is the mesh of the bricks as they are.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>

#include "engine/surface/mesh_export.h"
#include "tests/support/surface_checks.h"

namespace typodont::surface {
namespace {

using test::has_surface;

// A cube of samples that spheres are cut out of, as the carver does: distance = max(distance, r − |p − c|).
class Block {
 public:
  explicit Block(int bricks) : bricks_(bricks), n_(16 * bricks + 3), samples_(static_cast<std::size_t>(n_ * n_ * n_)) {
    const double middle = 8.0 * bricks, half = middle - 3.4;
    each([&](const glm::dvec3& p, float& value) {
      const glm::dvec3 d = glm::abs(p - middle) - half;
      value = static_cast<float>(std::clamp(std::max({d.x, d.y, d.z}), -4.0, 4.0));
    });
  }

  /// Cuts, and returns the keys of the bricks whose samples may have changed.
  std::vector<glm::ivec3> cut(const glm::dvec3& centre, double radius) {
    const glm::ivec3 low = glm::max(glm::ivec3(-1), glm::ivec3(glm::floor(centre - radius - 4.0)));
    const glm::ivec3 high = glm::min(glm::ivec3(n_ - 2), glm::ivec3(glm::ceil(centre + radius + 4.0)));
    for (int x = low.x; x <= high.x; ++x) {
      for (int y = low.y; y <= high.y; ++y) {
        for (int z = low.z; z <= high.z; ++z) {
          const auto d = static_cast<float>(std::clamp(radius - glm::length(glm::dvec3(x, y, z) - centre), -4.0, 4.0));
          float& value = at(x, y, z);
          value = std::max(value, d);
        }
      }
    }
    std::vector<glm::ivec3> keys;
    for (int x = 0; x < bricks_; ++x) {
      for (int y = 0; y < bricks_; ++y) {
        for (int z = 0; z < bricks_; ++z) {
          const glm::ivec3 first = 16 * glm::ivec3(x, y, z) - 1, last = first + 18;
          if (glm::all(glm::lessThanEqual(first, high)) && glm::all(glm::greaterThanEqual(last, low))) {
            keys.push_back({x, y, z});
          }
        }
      }
    }
    return keys;
  }

  FieldBrick brick(const glm::ivec3& key) const {
    FieldBrick out;
    out.key = key;
    for (int x = 0; x < FieldBrick::kSamples; ++x) {
      for (int y = 0; y < FieldBrick::kSamples; ++y) {
        for (int z = 0; z < FieldBrick::kSamples; ++z) {
          const glm::ivec3 p = 16 * key - 1 + glm::ivec3(x, y, z);
          out.distance[FieldBrick::at(x, y, z)] = const_cast<Block*>(this)->at(p.x, p.y, p.z);
          out.tissue[FieldBrick::at(x, y, z)] = p.z * 3 > n_ + p.x ? Tissue::kEnamel : Tissue::kDentin;
        }
      }
    }
    return out;
  }

  std::vector<glm::ivec3> keys() const {
    std::vector<glm::ivec3> all;
    for (int x = 0; x < bricks_; ++x) {
      for (int y = 0; y < bricks_; ++y) {
        for (int z = 0; z < bricks_; ++z) all.push_back({x, y, z});
      }
    }
    return all;
  }
  double side() const { return 16.0 * bricks_; }

 private:
  float& at(int x, int y, int z) { return samples_[static_cast<std::size_t>(((x + 1) * n_ + y + 1) * n_ + z + 1)]; }
  template <class F>
  void each(F&& f) {
    for (int x = -1; x < n_ - 1; ++x) {
      for (int y = -1; y < n_ - 1; ++y) {
        for (int z = -1; z < n_ - 1; ++z) f(glm::dvec3(x, y, z), at(x, y, z));
      }
    }
  }
  int bricks_, n_;
  std::vector<float> samples_;
};

void put(SurfaceMesher& mesher, const FieldBrick& brick) {
  if (has_surface(brick)) {
    mesher.put(brick);
  } else {
    mesher.remove(brick.key);
  }
}

TEST(Incremental, MeshAfterRandomCutsIsThatOfAFullRemesh) {
  Block block(4);
  SurfaceMesher mesher({.tolerance = 0.1f});
  for (const glm::ivec3& key : block.keys()) put(mesher, block.brick(key));
  mesher.remesh();
  std::mt19937 random(1);
  std::uniform_real_distribution<double> place(0, block.side()), size(0.7, 4);
  int checked = 0;
  for (int cut = 1; cut <= 1000; ++cut) {
    // Near the surface for the most part, so that the block is not gone after a few hundred.
    glm::dvec3 centre(place(random), place(random), place(random));
    const int axis = cut % 3;
    centre[axis] = cut % 6 < 3 ? 3.0 + 0.0006 * cut : block.side() - 3.0 - 0.0006 * cut;
    for (const glm::ivec3& key : block.cut(centre, size(random))) put(mesher, block.brick(key));
    mesher.remesh();
    if (cut == 10 || cut == 100 || cut == 1000) {
      SurfaceMesher whole({.tolerance = 0.1f});
      for (const glm::ivec3& key : block.keys()) put(whole, block.brick(key));
      whole.remesh();
      ASSERT_EQ(mesher.hash(), whole.hash()) << "after " << cut << " cuts";
      ASSERT_EQ(mesher.keys(), whole.keys());
      const auto t = test::topology_of(weld(mesher));
      EXPECT_TRUE(t.closed && t.oriented && t.manifold) << t.complaint;
      EXPECT_GT(mesher.triangle_count(), 1000u);
      ++checked;
    }
  }
  EXPECT_EQ(checked, 3);
}

TEST(Incremental, OrderOfUpdatesDoesNotMatter) {
  Block block(3);
  block.cut({20, 22, 24}, 9);
  std::vector<glm::ivec3> keys = block.keys();
  std::uint64_t expected = 0;
  std::mt19937 random(2);
  for (int order = 0; order < 4; ++order) {
    SurfaceMesher mesher;
    for (const glm::ivec3& key : keys) {
      put(mesher, block.brick(key));
      if (order == 2) mesher.remesh();  // after every single brick
    }
    mesher.remesh();
    if (order == 0) expected = mesher.hash();
    EXPECT_EQ(mesher.hash(), expected);
    std::shuffle(keys.begin(), keys.end(), random);
  }
}

TEST(Incremental, OnlyBricksAroundTheCutAreMadeAgain) {
  Block block(4);
  SurfaceMesher mesher;
  for (const glm::ivec3& key : block.keys()) put(mesher, block.brick(key));
  mesher.remesh();
  const std::vector<glm::ivec3> touched = block.cut({8, 8, 4}, 2);
  for (const glm::ivec3& key : touched) put(mesher, block.brick(key));
  for (const glm::ivec3& key : mesher.remesh()) {
    const bool near = std::any_of(touched.begin(), touched.end(), [&](const glm::ivec3& t) {
      const glm::ivec3 d = key - t;
      return glm::all(glm::greaterThanEqual(d, glm::ivec3(0))) && glm::all(glm::lessThanEqual(d, glm::ivec3(1)));
    });
    EXPECT_TRUE(near);
  }
  EXPECT_EQ(mesher.remesh().size(), 0u);
}

TEST(Incremental, SharedVerticesAreTheSameBitsInBothBricks) {
  Block block(3);
  block.cut({24, 24, 40}, 7);
  SurfaceMesher mesher;
  for (const glm::ivec3& key : block.keys()) put(mesher, block.brick(key));
  mesher.remesh();
  // Joining by exact position closes the surface: no vertex differs by even one bit across a border.
  struct Less {
    bool operator()(const glm::vec3& a, const glm::vec3& b) const {
      return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z;
    }
  };
  std::map<glm::vec3, std::uint32_t, Less> number;
  WholeMesh mesh;
  for (const glm::ivec3& key : mesher.keys()) {
    const BrickMesh& part = *mesher.find(key);
    auto joined = [&](std::size_t i) {
      const glm::vec3& p = part.vertices[part.indices[i]].position;
      const auto [it, fresh] = number.try_emplace(p, static_cast<std::uint32_t>(mesh.vertices.size()));
      if (fresh) mesh.vertices.push_back({p, {}, Tissue::kAir});
      return it->second;
    };
    for (std::size_t i = 0; i < part.indices.size(); i += 3) {
      mesh.triangles.push_back({joined(i), joined(i + 1), joined(i + 2)});
    }
  }
  const auto t = test::topology_of(mesh);
  EXPECT_TRUE(t.closed && t.oriented) << t.complaint;
}

TEST(Incremental, BricksTheSurfaceHasLeftAreReportedOnceAndForgotten) {
  Block block(2);
  SurfaceMesher mesher;
  for (const glm::ivec3& key : block.keys()) put(mesher, block.brick(key));
  mesher.remesh();
  EXPECT_EQ(mesher.keys().size(), 8u);
  for (const glm::ivec3& key : block.cut({16, 16, 16}, 40)) put(mesher, block.brick(key));
  EXPECT_EQ(mesher.remesh().size(), 8u);
  EXPECT_TRUE(mesher.keys().empty());
  EXPECT_EQ(mesher.triangle_count(), 0u);
  EXPECT_EQ(mesher.remesh().size(), 0u);
}

}  // namespace
}  // namespace typodont::surface
