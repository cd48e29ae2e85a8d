// BlockGrid against OpenVDB's tree.
#include <gtest/gtest.h>
#include <openvdb/openvdb.h>

#include <random>
#include <vector>

#include "haptics/volume/block_grid.h"

namespace typodont::haptics {
namespace {

TEST(BlockGrid, AfterRandomWritesItAgreesWithOpenVdbInEveryValueAndInTheOrderOfLeaves) {
  openvdb::initialize();
  std::mt19937_64 random(11);
  const auto pick = [&](int lo, int hi) {
    return lo + static_cast<int>(random() % static_cast<unsigned>(hi - lo + 1));
  };
  for (int round = 0; round < 20; ++round) {
    const int far = round % 2 ? 60 : 5000;  // voxels; up to 5000 lie several of OpenVDB's largest nodes (4096³)
    const auto voxel = [&] { return glm::ivec3(pick(-far, far), pick(-far, far), pick(-far, far)); };
    const auto at = [](const glm::ivec3& v) { return openvdb::Coord(v.x, v.y, v.z); };
    LabelGrid grid(7);
    openvdb::Int32Grid reference(7);
    std::vector<glm::ivec3> touched;
    for (int i = 0; i < 200; ++i) {
      const glm::ivec3 v = voxel(), key = leaf_key(v);
      const int value = pick(6, 8);  // 7 is the background
      touched.push_back(v);
      switch (pick(0, 2)) {
        case 0:
          grid.set(v, value);
          reference.tree().setValue(at(v), value);
          break;
        case 1: {
          const bool on = pick(0, 1) != 0;
          grid.block(key) = LabelGrid::Block(value, on);
          reference.tree().addTile(1, at(v), value, on);
          break;
        }
        default:
          grid.block(key).touch().set_all_on();
          reference.tree().touchLeaf(at(v))->setValuesOn();
      }
      if (i % 50 == 49) grid.prune(), reference.pruneGrid();
    }
    EXPECT_EQ(grid.leaf_count(), reference.tree().leafCount());
    LabelGrid::Reader reader(grid);
    const auto tree = reference.getConstAccessor();
    for (const glm::ivec3& v : touched) {
      for (int i = 0; i < 20; ++i) {
        const glm::ivec3 near = v + glm::ivec3(pick(-9, 9), pick(-9, 9), pick(-9, 9));
        ASSERT_EQ(reader.value(near), tree.getValue(at(near)));
        ASSERT_EQ(reader.block(leaf_key(near)).is_on(LabelGrid::Leaf::index(near)), tree.isValueOn(at(near)));
      }
    }
    const openvdb::CoordBBox box = reference.evalActiveVoxelBoundingBox();
    EXPECT_EQ(at(grid.box_on().lo), box.min());
    EXPECT_EQ(at(grid.box_on().hi), box.max());
    auto leaf = std::as_const(reference).tree().cbeginLeaf();
    std::as_const(grid).for_each_block([&](const glm::ivec3& key, const LabelGrid::Block& block) {
      if (!block.leaf) return;
      ASSERT_EQ(at(key * LabelGrid::kSide), leaf->origin());
      ++leaf;
    });
    EXPECT_FALSE(leaf);
  }
}

}  // namespace
}  // namespace typodont::haptics
