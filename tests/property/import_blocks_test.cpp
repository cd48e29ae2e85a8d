// Tests of the operations on sparse masks (haptics/import/blocks.h) against searches that visit sample after sample.
#include <gtest/gtest.h>

#include <random>

#include "engine/base/voxels.h"
#include "haptics/import/blocks.h"

namespace typodont::haptics::importing {
namespace {

const glm::ivec3 kSize(53, 38, 41);  // no multiple of a block's edge

/// Returns a random mask in which some blocks are not stored; these lie outside or inside the body.
SparseMask random_mask(unsigned seed, double density, bool outside, bool inside) {
  std::mt19937 random(seed);
  const glm::ivec3 count = BlockSet::blocks_of(kSize);
  std::vector<std::uint8_t> wanted(voxel_count(count));
  for (std::uint8_t& w : wanted) w = random() % 4 != 0;
  auto set = std::make_shared<BlockSet>(kSize, wanted);
  for (std::int32_t& slot : set->slot) {
    if (slot == BlockSet::kOutside && random() % 2) slot = BlockSet::kInside;
  }
  std::bernoulli_distribution in(density);
  SparseMask mask(set, outside, inside);
  for (std::uint8_t& m : mask.v) m = in(random);
  return mask;
}

template <class Work>
void for_each_place(Work work) {
  for_each_voxel(kSize, [&](int x, int y, int z) { work(glm::ivec3(x, y, z)); });
}

TEST(ImportBlocks, TheSamplesReachedFromTheWallsAreThoseOfASearchFromSampleToSample) {
  const std::array<glm::ivec3, 6> faces = {glm::ivec3(1, 0, 0), {-1, 0, 0}, {0, 1, 0},
                                           {0, -1, 0},          {0, 0, 1},  {0, 0, -1}};
  for (unsigned seed = 0; seed < 12; ++seed) {
    const double density = 0.25 + 0.06 * seed;
    const SparseMask open = random_mask(seed, density, seed % 2, seed % 3 == 0);
    Mask truth(kSize, 0);
    std::vector<glm::ivec3> stack;
    const auto visit = [&](const glm::ivec3& p) {
      if (truth.holds(p) && open[p] && !truth[p]) truth[p] = 1, stack.push_back(p);
    };
    for_each_place([&](const glm::ivec3& p) {
      if (glm::any(glm::equal(p, glm::ivec3(0))) || glm::any(glm::equal(p, kSize - 1))) visit(p);
    });
    while (!stack.empty()) {
      const glm::ivec3 p = stack.back();
      stack.pop_back();
      for (const glm::ivec3& f : faces) visit(p + f);
    }
    const Reached reached = reached_from_walls(open);
    int wrong = 0;
    for_each_place([&](const glm::ivec3& p) {
      const std::ptrdiff_t i = open.index(p);
      const bool found = i >= 0 ? reached.samples.v[static_cast<std::size_t>(i)] : reached.blocks[open.set->block(p)];
      wrong += found != static_cast<bool>(truth[p]);
    });
    EXPECT_EQ(wrong, 0) << "seed " << seed;
  }
}

TEST(ImportBlocks, SquaredDistancesAreThoseToTheNearestSampleOfTheMask) {
  for (const int reach : {1, 2, 5, 13, 20, 64, 100}) {
    const SparseMask mask = random_mask(static_cast<unsigned>(reach), 0.0004, false, reach % 2);
    const Sparse<float> squared = distance_squared_to(mask, reach);
    std::vector<glm::ivec3> marked;
    for_each_place([&](const glm::ivec3& p) {
      if (mask[p]) marked.push_back(p);
    });
    std::mt19937 random(1);
    for (int k = 0; k < 3000; ++k) {
      const glm::ivec3 p(random() % 53, random() % 38, random() % 41);
      if (mask.index(p) < 0) continue;
      int nearest = std::numeric_limits<int>::max();
      for (const glm::ivec3& q : marked) {
        const glm::ivec3 off = q - p;
        if (std::max({std::abs(off.x), std::abs(off.y), std::abs(off.z)}) <= reach)
          nearest = std::min(nearest, off.x * off.x + off.y * off.y + off.z * off.z);
      }
      if (nearest < std::numeric_limits<int>::max()) {
        ASSERT_EQ(squared[p], static_cast<float>(nearest)) << "reach " << reach;
      } else {
        ASSERT_GT(squared[p], 1e6F) << "reach " << reach;
      }
    }
  }
}

}  // namespace
}  // namespace typodont::haptics::importing
